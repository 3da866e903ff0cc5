//! The strokes of a picture as lines, for files that hold lines.
//!
//! A picture of strokes is drawn in one part: parts have strokes of their own, and a stroke across a seam would be two.
//! That bounds its size, which is no loss: lines have no pixels, and the size only says how finely they are found.

use crate::frame::Frame;
use crate::gpu::{Gpu, GpuError};
use crate::lines::strokes::polylines::Polyline;
use crate::scene::stereo::Pair;
use crate::scene::view::{Rig, View};
use crate::world::Surfaces;

use super::{PictureReport, PictureRequest};

/// Pixels of a picture, at most: some 2.5 GiB on the GPU.
pub const MOST_PX: u64 = 32 << 20;

/// Why there are no strokes.
#[derive(Debug, thiserror::Error)]
pub enum StrokesError {
    /// The GPU failed.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The style draws none.
    #[error("the style {style} has no strokes")]
    NoStrokes {
        /// Its name.
        style: String,
    },
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

/// Renders a picture and reads the strokes of each eye, of a pair the left one's first; the pixels stay on the GPU.
/// `request.planes` and its samples are not looked at.
///
/// # Errors
/// [`StrokesError`].
pub fn render_strokes(
    gpu: &Gpu,
    frame: &mut Option<Frame>,
    world: &mut Surfaces,
    request: &PictureRequest<'_>,
    pair: Option<&Pair>,
) -> Result<(Vec<Vec<Polyline>>, PictureReport), StrokesError> {
    let start = std::time::Instant::now();
    let size_px = request.size_px;
    let side_px = gpu.device.limits().max_texture_dimension_2d;
    if size_px[0].max(size_px[1]) > side_px || u64::from(size_px[0]) * u64::from(size_px[1]) > MOST_PX {
        return Err(StrokesError::TooLarge { size_px, side_px });
    }
    let frame = Frame::or_new(frame, gpu)?;
    frame.set_wants_motion(false);
    let view = View::whole(request.previous, request.pose, size_px).at(request.clock);
    let rig = pair.map_or_else(|| Rig::mono(view), |pair| pair.rig(&view));
    let prepared = frame.render_eyes(gpu, world, &rig, request.style, &request.light)?;
    let of_eye = |eye| {
        let strokes = frame.eye_strokes(eye);
        let strokes = strokes.ok_or_else(|| StrokesError::NoStrokes { style: request.style.name.clone() })?;
        Ok(strokes.read_polylines(gpu)?)
    };
    let polylines = (0..rig.eyes.len()).map(of_eye).collect::<Result<Vec<_>, StrokesError>>()?;
    gpu.check()?;
    let mut report = PictureReport::default();
    report.add(&prepared, frame);
    report.wall_ms = start.elapsed().as_secs_f64() * 1000.0;
    Ok((polylines, report))
}
