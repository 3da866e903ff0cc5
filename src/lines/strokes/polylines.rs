//! The strokes of the last frame, read back as polylines: for files that hold lines, never inside an interactive frame.
//!
//! A stroke is a run of samples. Its kind is that of the edges that make up most of its length. `Pen` computes for each
//! sample the width and ink that `shaders/lines/strokes/stroke.wgsl` computes for each pixel of a stroke; stroke
//! textures, and the paling near the ends of a stroke, are left out. Parts that are not shown, because they fade or
//! have not grown yet, are not part of a polyline.

use super::samples::Sample;
use super::{DrawnStrokes, StrokesUniform};
use crate::gpu::{Gpu, GpuError};
use crate::scene::focus::Focus;
use crate::scene::view::ViewUniform;

/// The kind of edge that a stroke follows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum EdgeKind {
    /// An occluding contour: the surface turns away from the eye.
    #[default]
    Contour,
    /// The border of the land.
    Border,
    /// A sharp bend of the surface.
    Crease,
    /// A suggestive contour: the surface would turn away from an eye nearby.
    Suggestive,
    /// A ridge of the land.
    Ridge,
    /// A valley: a ridge of the land seen from below.
    Valley,
}

impl EdgeKind {
    /// All kinds, in the order in which they are drawn.
    pub(crate) const ALL: [Self; 6] =
        [Self::Contour, Self::Border, Self::Crease, Self::Suggestive, Self::Ridge, Self::Valley];

    /// Returns the kind of a number of `Edge::kind`.
    fn of(number: u32) -> Self {
        match number {
            1 => Self::Border,
            2 => Self::Crease,
            3 => Self::Suggestive,
            4 => Self::Ridge,
            5 => Self::Valley,
            _ => Self::Contour,
        }
    }
}

/// A visible stroke as it is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Polyline {
    /// At least two points. A closed polyline continues from the last to the first point, which is not repeated.
    pub points: Vec<PolylinePoint>,
    pub kind: EdgeKind,
    /// The identity of the stroke, as in the picture of stroke ids.
    pub stroke: u32,
    /// Whether the end of the stroke continues into its beginning.
    pub is_closed: bool,
}

/// A point of a [`Polyline`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct PolylinePoint {
    /// Position on the picture, x to the right and y down, from its upper left corner.
    pub px: [f32; 2],
    /// Half of the stroke's width.
    pub half_width_px: f32,
    /// Amount of ink: 0 none, 1 full.
    pub ink: f32,
}

impl DrawnStrokes<'_> {
    /// Reads back the strokes of the last frame, without those that are fading. Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Readback`] when the device is lost or out of memory.
    pub(crate) fn read_polylines(&self, gpu: &Gpu) -> Result<Vec<Polyline>, GpuError> {
        let (_, samples) = self.samples().read(gpu)?;
        self.left_out(gpu)?.warn();
        let pen = Pen::new(&self.memory.uniform, self.memory.focus);
        let strokes = samples.split_inclusive(|sample| sample.flags & Sample::LAST != 0);
        let shown = strokes.flat_map(|stroke| stroke.split(|sample| !is_shown(sample)));
        Ok(shown.filter(|run| run.len() > 1).map(|run| polyline(run, &pen)).collect())
    }
}

/// Returns whether a sample is drawn. A pressure of exactly 0 marks a stroke that the other eye should have and does
/// not.
fn is_shown(sample: &Sample) -> bool {
    sample.shown_px > 0.0
        && sample.pressure > 0.0
        && sample.flags & Sample::FADING == 0
        && sample.px.iter().all(|px| px.is_finite())
}

/// Returns the polyline of consecutive samples, of which there are at least two.
fn polyline(run: &[Sample], pen: &Pen) -> Polyline {
    let (first, last) = (&run[0], &run[run.len() - 1]);
    let is_closed = first.flags & last.flags & Sample::IS_CLOSED != 0
        && first.flags & Sample::FIRST != 0
        && last.flags & Sample::LAST != 0
        && run.len() > 3;
    let mut counts = EdgeKind::ALL.map(|kind| (0, kind));
    for sample in run {
        counts[EdgeKind::of(sample.kind()) as usize].0 += 1;
    }
    // Of equal counts the first kind wins.
    let most = counts.into_iter().rev().max_by_key(|(count, _)| *count);
    // The last sample of a loop is the first one again.
    let drawn = if is_closed { &run[..run.len() - 1] } else { run };
    Polyline {
        points: drawn.iter().map(|sample| pen.point(sample)).collect(),
        kind: most.map_or(EdgeKind::Contour, |(_, kind)| kind),
        stroke: first.stroke,
        is_closed,
    }
}

/// Returns the position of a sample, relative to the rig's origin: `place_at` of `shaders/shared/view.wgsl`.
fn place_m(view: &ViewUniform, at: &Sample) -> [f32; 3] {
    let p = [0, 1].map(|axis| at.px[axis] + view.origin_px[axis] as f32);
    std::array::from_fn(|axis| {
        let ray = view.ray_corner[axis] + p[0] * view.ray_dx[axis] + p[1] * view.ray_dy[axis];
        ray * at.depth_m + view.eye_m[axis]
    })
}

/// Width and ink, as in `shaders/lines/strokes/stroke.wgsl`.
struct Pen {
    haze_m: f32,
    faintest: f32,
    focus: Option<(Focus, ViewUniform)>,
}

impl Pen {
    fn new(uniform: &StrokesUniform, focus: Option<(Focus, ViewUniform)>) -> Self {
        Self { haze_m: uniform.haze_m, faintest: uniform.faintest, focus }
    }

    fn point(&self, at: &Sample) -> PolylinePoint {
        let pressure = at.pressure.clamp(0.0, 1.0);
        let t = at.depth_m / self.haze_m;
        let seen = self.focus.map_or(1.0, |(focus, view)| focus.left(&view, place_m(&view, at), at.px));
        PolylinePoint {
            px: at.px,
            half_width_px: (Focus::width(seen) * at.half_width_px * (0.35 + 0.65 * pressure.sqrt())).max(0.4),
            ink: seen / Focus::width(seen) * (self.faintest + (1.0 - self.faintest) * (-t * t).exp()),
        }
    }
}
