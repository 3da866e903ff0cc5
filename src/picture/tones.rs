//! What a picture measures once, on a small picture of the whole: the curve that fits its tones and, if it is drawn in
//! parts, its masses. So all parts of a large picture, all samples and both eyes agree, and so do pictures of other sizes.

use super::PictureRequest;
use crate::frame::Renderer;
use crate::gpu::{Gpu, GpuError};
use crate::scene::tone_curve::ToneCurve;
use crate::scene::view::{Rig, View};
use crate::tones::masses::Masses;
use crate::world::Surfaces;

/// Longest sides of the pictures on which the curve and the masses are measured. Planes of slopes need more pixels.
const CURVE_PX: u32 = 480;
const MASSES_PX: u32 = 960;

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
    // The caller's renderer has strokes and a mean that this picture must not end.
    let mut renderer = Renderer::new(gpu)?;
    draw(gpu, &mut renderer, world, request, CURVE_PX)?;
    renderer.tone_curve(gpu)
}

/// Returns the masses of a picture that is drawn in parts, whose tones have `curve`; `None` if its style does not edit
/// them.
///
/// # Errors
/// The errors of [`Renderer::render`].
pub(crate) fn masses(
    gpu: &Gpu,
    world: &mut Surfaces,
    request: &PictureRequest<'_>,
    curve: Option<ToneCurve>,
) -> Result<Option<Masses>, GpuError> {
    if request.style.edited_masses().is_none() {
        return Ok(None);
    }
    let mut renderer = Renderer::new(gpu)?;
    renderer.set_tone_curve(curve);
    let size_px = draw(gpu, &mut renderer, world, request, MASSES_PX)?;
    renderer.masses(gpu, size_px)
}

/// Draws a picture of the whole without lines and marks, at most `longest_px` long, and returns its size.
fn draw(
    gpu: &Gpu,
    renderer: &mut Renderer,
    world: &mut Surfaces,
    request: &PictureRequest<'_>,
    longest_px: u32,
) -> Result<[u32; 2], GpuError> {
    let longest = request.size_px.into_iter().max().unwrap_or(1).max(1);
    let factor = (f64::from(longest_px) / f64::from(longest)).min(1.0);
    let size_px = request.size_px.map(|side| ((f64::from(side) * factor).round() as u32).max(1));
    let style = request.style.of_tones().scaled(factor);
    let view = View { clock: request.clock, ..View::whole(request.pose, request.pose, size_px) };
    renderer.render_eyes(gpu, world, &Rig::mono(view), &style, &request.light)?;
    Ok(size_px)
}
