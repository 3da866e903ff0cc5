//! Distance of the nearest surface that a camera sees; the distance between two eyes may be set as a fraction of it.

use glam::DVec3;

use crate::frame::{Light, Renderer};
use crate::gpu::{Gpu, GpuError};
use crate::scene::view::{Pose, View};
use crate::style::Style;
use crate::world::Surfaces;

/// Size of the picture that is searched. A thumbnail suffices, because distance varies little between neighbouring
/// pixels.
const SIZE_PX: [u32; 2] = [96, 54];

/// Returns the distance of the nearest surface in a camera's picture, in metres; `None` if there is only sky. Any
/// `style` will do; its drawing is discarded.
///
/// # Errors
/// The errors of [`Renderer::render`].
pub(crate) fn nearest_m(
    gpu: &Gpu,
    renderer: &mut Renderer,
    world: &mut Surfaces,
    pose: Pose,
    style: &Style,
) -> Result<Option<f64>, GpuError> {
    let light = Light { to_sun: DVec3::Z, haze_m: 1e6, haze_srgb: None, focus: None };
    renderer.render(gpu, world, &View::whole(pose, pose, SIZE_PX), style, &light)?;
    let Some(places) = renderer.places(gpu, 0, [0, 0], SIZE_PX)? else { return Ok(None) };
    let surface = places.iter().filter(|at| at[3] > 0.0);
    let distances_m = surface.map(|at| DVec3::new(at[0].into(), at[1].into(), at[2].into()).length());
    Ok(distances_m.min_by(f64::total_cmp))
}
