//! The strokes and marks of a picture as vector lines, for SVG and GeoJSON.
//!
//! Marks from textures exist only as pixels. They are traced in a picture that is [`FINER`] times as large, if the
//! limits allow it.
//!
//! The picture is drawn in one part, because each part has its own strokes, and a stroke across a seam would be split.
//! This limits its size. Little is lost: vector lines have no resolution, and the size only determines how precisely
//! they are found.

use crate::frame::{Renderer, seen_light};
use crate::gpu::{Gpu, GpuError};
use crate::lines::strokes::polylines::Polyline;
use crate::scene::stereo::Pair;
use crate::scene::view::{Rig, View};
use crate::style::layers::Trace;
use crate::style::{Layer, Style, StyleInk};
use crate::surface::rims::RIM;
use crate::vector::Group;
use crate::world::Surfaces;

use super::in_view::shows_surface;
use super::ink_lines::InkLines;
use super::{PictureReport, PictureRequest, ink_lines};

/// Largest number of pixels of a picture: about 2.5 GiB on the GPU.
pub(crate) const MAX_PX: u64 = 32 << 20;
/// Factor by which each side of the picture is enlarged to trace marks.
pub(crate) const FINER: u32 = 2;

/// Why strokes cannot be rendered.
#[derive(Debug, thiserror::Error)]
pub(crate) enum StrokesError {
    /// The GPU failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The picture would need several parts.
    #[error(
        "{}x{} is too large for vector output: the limit is {side_px} pixels per side and {MAX_PX} pixels in total; \
        use a smaller --size, which costs little precision",
        size_px[0], size_px[1]
    )]
    TooLarge {
        /// Requested size in pixels.
        size_px: [u32; 2],
        /// Longest side that this GPU supports, in pixels.
        side_px: u32,
    },
}

/// The vector lines of a picture.
#[derive(Clone, Debug, Default)]
pub(crate) struct Drawn {
    /// Strokes of each eye; the left eye of a stereo pair comes first.
    pub strokes: Vec<Vec<Polyline>>,
    /// Marks below the strokes, from the bottom to the top: one group for each ink, or for each of its families or
    /// sets. Empty for a stereo pair.
    pub marks: Vec<Group>,
    /// Marks above the strokes.
    pub marks_above: Vec<Group>,
    /// Statistics of the rendering.
    pub report: PictureReport,
}

/// Returns whether a style has marks that can become vector lines. Rims do not count: every style
/// has them.
pub(crate) fn has_marks(style: &Style) -> bool {
    let is_mark = |ink: &StyleInk| match ink.ink.trace {
        Trace::LeftOut(_) | Trace::Strokes => false,
        Trace::Picture | Trace::Sets(_) | Trace::Rows { .. } => {
            !ink.layer.is_some_and(|index| matches!(style.layers[index], Layer::Rims(_)))
        }
    };
    style.inks().iter().any(is_mark)
}

/// Renders a picture and reads back its marks and the strokes of each eye; the pixels stay on the GPU. `request.planes`
/// and `request.samples` are ignored.
///
/// # Errors
/// [`StrokesError`].
pub(crate) fn render_strokes(
    gpu: &Gpu,
    renderer: &mut Option<Renderer>,
    world: &mut Surfaces,
    request: &PictureRequest<'_>,
    pair: Option<&Pair>,
) -> Result<Drawn, StrokesError> {
    let start = std::time::Instant::now();
    let side_px = gpu.device.limits().max_texture_dimension_2d;
    let is_possible = |size_px: [u32; 2]| {
        size_px[0].max(size_px[1]) <= side_px && u64::from(size_px[0]) * u64::from(size_px[1]) <= MAX_PX
    };
    if !is_possible(request.size_px) {
        return Err(StrokesError::TooLarge { size_px: request.size_px, side_px });
    }
    let wants_marks = has_marks(request.style) && pair.is_none();
    let finer = request.size_px.map(|side| side.saturating_mul(FINER));
    let scale = if wants_marks && is_possible(finer) { FINER } else { 1 };
    let size_px = request.size_px.map(|side| side * scale);
    let style = &request.style.scaled(scale.into());

    let tone_curve = super::tones::curve(gpu, world, request)?;
    let renderer = Renderer::or_new(renderer, gpu)?;
    renderer.set_tone_curve(tone_curve);
    renderer.set_line_gaps(request.line_gaps.iter().map(|gap| gap.scaled(scale.into())).collect());
    renderer.set_wants_motion(false);
    renderer.set_wants_mark_sets(wants_marks);
    let view = View::whole(request.previous, request.pose, size_px).at(request.clock);
    let rig = pair.map_or_else(|| Rig::mono(view), |pair| pair.rig(&view));
    let prepared = renderer.render_eyes(gpu, world, &rig, style, &request.light)?;
    let read = |eye| renderer.eye_strokes(eye).map_or_else(|| Ok(Vec::new()), |strokes| strokes.read_polylines(gpu));
    let mut strokes = (0..rig.eyes.len()).map(read).collect::<Result<Vec<_>, GpuError>>()?;
    let light = seen_light(world, &rig, style, &request.light);
    // No-data areas have outlines in every style.
    let reads_marks = pair.is_none() && (wants_marks || renderer.target(&RIM).is_some());
    let mut marks =
        if reads_marks { ink_lines::read(gpu, renderer, style, &view, &light)? } else { InkLines::default() };
    renderer.set_wants_mark_sets(false);
    renderer.set_tone_curve(None);
    renderer.set_line_gaps(Vec::new());
    gpu.check()?;
    let groups = marks.below.iter_mut().chain(&mut marks.above);
    let all = strokes.iter_mut().flatten().chain(groups.flat_map(|group| &mut group.lines));
    for point in all.flat_map(|line| &mut line.points) {
        point.px = point.px.map(|px| px / scale as f32);
        point.half_width_px /= scale as f32;
    }
    let mut report = PictureReport::default();
    report.add(&prepared, renderer);
    if let Some(drawn) = renderer.strokes() {
        report.left_out = drawn.left_out(gpu)?;
    }
    let is_bare = strokes.iter().all(Vec::is_empty) && marks.below.is_empty() && marks.above.is_empty();
    report.count(shows_surface(gpu, renderer)?, is_bare);
    report.wall_ms = start.elapsed().as_secs_f64() * 1000.0;
    Ok(Drawn { strokes, marks: marks.below, marks_above: marks.above, report })
}
