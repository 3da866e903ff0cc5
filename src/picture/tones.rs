//! The curve that fits the tones to a picture: measured once, on a small picture of the whole, so that all parts of a large
//! picture, all samples and both eyes have the same curve, and a picture of another size has it too.

use super::PictureRequest;
use crate::frame::Renderer;
use crate::gpu::{Gpu, GpuError};
use crate::scene::tone_curve::ToneCurve;
use crate::scene::view::{Rig, View};
use crate::world::Surfaces;

/// Longest side of the picture that is measured.
const LONGEST_PX: u32 = 480;

/// Returns the curve of a picture: the given one, or a measured one; `None` if its tones are not fitted or if it shows no
/// land.
///
/// # Errors
/// The errors of [`Renderer::render`].
pub(crate) fn curve(
    gpu: &Gpu,
    world: &mut Surfaces,
    request: &PictureRequest<'_>,
) -> Result<Option<ToneCurve>, GpuError> {
    if !request.style.fits_tones() || request.tone_curve.is_some() {
        return Ok(request.tone_curve);
    }
    let longest = request.size_px.into_iter().max().unwrap_or(1).max(1);
    let factor = (f64::from(LONGEST_PX) / f64::from(longest)).min(1.0);
    let size_px = request.size_px.map(|side| ((f64::from(side) * factor).round() as u32).max(1));
    let style = request.style.of_tones().scaled(factor);
    let view = View { clock: request.clock, ..View::whole(request.pose, request.pose, size_px) };
    // The caller's renderer has strokes and a mean that this picture must not end.
    let mut renderer = Renderer::new(gpu)?;
    renderer.render_eyes(gpu, world, &Rig::mono(view), &style, &request.light)?;
    renderer.tone_curve(gpu)
}
