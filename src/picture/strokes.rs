//! The strokes and marks of a picture as lines, for files that hold lines.
//!
//! Marks are found in a picture that is [`FINER`] times as large, where that is allowed: what a texture draws is known
//! by its pixels alone.
//!
//! A picture of strokes is drawn in one part: parts have strokes of their own, and a stroke across a seam would be two.
//! That bounds its size, which is no loss: lines have no pixels, and the size only says how finely they are found.

use crate::frame::{Renderer, seen_light};
use crate::gpu::{Gpu, GpuError};
use crate::lines::strokes::polylines::Polyline;
use crate::scene::stereo::Pair;
use crate::scene::view::{Rig, View};
use crate::style::Style;
use crate::surface::rims::RIM;
use crate::vector::Group;
use crate::world::Surfaces;

use super::{PictureReport, PictureRequest, marks};

/// Pixels of a picture, at most: some 2.5 GiB on the GPU.
pub const MOST_PX: u64 = 32 << 20;
/// How many pixels to a side of a picture's pixel marks are found by.
pub const FINER: u32 = 2;

/// Why there are no strokes.
#[derive(Debug, thiserror::Error)]
pub enum StrokesError {
    /// The GPU failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// It would need several parts.
    #[error(
        "{}x{} is too large: the strokes of a picture are found in one part, of {side_px} pixels a side and \
         {MOST_PX} pixels in all at most; a smaller --size loses little, for lines have no pixels",
        size_px[0], size_px[1]
    )]
    TooLarge {
        /// Of the picture.
        size_px: [u32; 2],
        /// The longest side that this GPU holds.
        side_px: u32,
    },
}

/// What a picture has of lines.
#[derive(Clone, Debug, Default)]
pub struct Drawn {
    /// The strokes of each eye, of a pair the left one's first.
    pub strokes: Vec<Vec<Polyline>>,
    /// Hachures, hatching, lines of water, of equal height, of the sky and around holes, a group for each kind; of a
    /// pair none.
    pub marks: Vec<Group>,
    /// What rendering did.
    pub report: PictureReport,
}

/// Whether a style has marks that can be lines.
pub fn has_marks(style: &Style) -> bool {
    let has_marks = style.hatching.is_some() || style.rows.is_some() || style.water.is_some();
    has_marks
        || style.tone_lines.is_some()
        || style.cuts.is_some()
        || style.height_lines.is_some()
        || style.sky.has_lines()
}

/// Renders a picture and reads the strokes of each eye and its marks; the pixels stay on the GPU. `request.planes` and
/// its samples are not looked at.
///
/// # Errors
/// [`StrokesError`].
pub fn render_strokes(
    gpu: &Gpu,
    renderer: &mut Option<Renderer>,
    world: &mut Surfaces,
    request: &PictureRequest<'_>,
    pair: Option<&Pair>,
) -> Result<Drawn, StrokesError> {
    let start = std::time::Instant::now();
    let side_px = gpu.device.limits().max_texture_dimension_2d;
    let is_possible = |size_px: [u32; 2]| {
        size_px[0].max(size_px[1]) <= side_px && u64::from(size_px[0]) * u64::from(size_px[1]) <= MOST_PX
    };
    if !is_possible(request.size_px) {
        return Err(StrokesError::TooLarge { size_px: request.size_px, side_px });
    }
    let wants_marks = has_marks(request.style) && pair.is_none();
    let finer = request.size_px.map(|side| side.saturating_mul(FINER));
    let scale = if wants_marks && is_possible(finer) { FINER } else { 1 };
    let size_px = request.size_px.map(|side| side * scale);
    let style = &request.style.scaled(scale.into());

    let renderer = Renderer::or_new(renderer, gpu)?;
    renderer.set_wants_motion(false);
    renderer.set_wants_mark_layers(wants_marks);
    let view = View::whole(request.previous, request.pose, size_px).at(request.clock);
    let rig = pair.map_or_else(|| Rig::mono(view), |pair| pair.rig(&view));
    let prepared = renderer.render_eyes(gpu, world, &rig, style, &request.light)?;
    let read = |eye| renderer.eye_strokes(eye).map_or_else(|| Ok(Vec::new()), |strokes| strokes.read_polylines(gpu));
    let mut strokes = (0..rig.eyes.len()).map(read).collect::<Result<Vec<_>, GpuError>>()?;
    let light = seen_light(world, &rig, style, &request.light);
    // Land with holes has rims in any style.
    let reads_marks = pair.is_none() && (wants_marks || renderer.target(&RIM).is_some());
    let mut marks = if reads_marks { marks::read(gpu, renderer, style, &view, &light)? } else { Vec::new() };
    renderer.set_wants_mark_layers(false);
    gpu.check()?;
    let all = strokes.iter_mut().flatten().chain(marks.iter_mut().flat_map(|group| &mut group.lines));
    for point in all.flat_map(|line| &mut line.points) {
        point.px = point.px.map(|px| px / scale as f32);
        point.half_width_px /= scale as f32;
    }
    let mut report = PictureReport::default();
    report.add(&prepared, renderer);
    report.wall_ms = start.elapsed().as_secs_f64() * 1000.0;
    Ok(Drawn { strokes, marks, report })
}
