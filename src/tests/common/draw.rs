//! Draws a frame of a world and reads it back, for all tests of pictures.

use std::convert::Infallible;

use glam::DVec3;
use hachure::file::exr::Samples;
use hachure::frame::{DISTANCE, Prepared};
use hachure::frame::{Light, Renderer};
use hachure::gpu::Gpu;
use hachure::gpu::Target;
use hachure::internals::read;
use hachure::picture::{self, PartRule, PictureRequest, aov};
use hachure::scene::view::{Pose, View};
use hachure::style::Style;
use hachure::world::Surfaces;

use super::World;

/// The sun overhead, for lines, which do not depend on it.
pub(crate) const NOON: Light = Light { to_sun: DVec3::Z, haze_m: 30_000.0, haze_srgb: None, focus: None };

/// Returns light with the sun in the north-west, as on maps.
pub(crate) fn north_west() -> Light {
    Light { to_sun: DVec3::new(-0.5, 0.5, 0.7).normalize(), ..NOON }
}

/// Returns the view of a camera at rest.
pub(crate) fn still(pose: Pose, size_px: [u32; 2]) -> View {
    View::whole(pose, pose, size_px)
}

/// Draws a frame and waits for the GPU.
pub(crate) fn draw(
    gpu: &Gpu,
    surfaces: &mut Surfaces,
    renderer: &mut Renderer,
    view: &View,
    style: &Style,
    light: &Light,
) -> Prepared {
    let prepared = renderer.render(gpu, surfaces, view, style, light).unwrap();
    gpu.wait();
    gpu.check().unwrap_or_else(|error| panic!("{}: {error}", style.name));
    prepared
}

/// Reads a picture of four 16-bit floats per pixel.
pub(crate) fn halves(gpu: &Gpu, target: &Target) -> Vec<[f64; 4]> {
    let half = |texel: &[u8], i: usize| half::f16::from_le_bytes([texel[2 * i], texel[2 * i + 1]]).to_f64();
    let bytes = read(gpu, target, [0, 0], target.size_px()).unwrap();
    bytes.chunks_exact(8).map(|texel| std::array::from_fn(|i| half(texel, i))).collect()
}

/// Reads a picture of `N` 32-bit floats per pixel.
pub(crate) fn floats<const N: usize>(gpu: &Gpu, target: &Target) -> Vec<[f32; N]> {
    let float = |texel: &[u8], i: usize| f32::from_le_bytes(std::array::from_fn(|byte| texel[4 * i + byte]));
    let bytes = read(gpu, target, [0, 0], target.size_px()).unwrap();
    bytes.chunks_exact(4 * N).map(|texel| std::array::from_fn(|i| float(texel, i))).collect()
}

/// Returns the position in the world of the surface in each pixel, in metres; `None` for the sky.
pub(crate) fn places_m(gpu: &Gpu, renderer: &Renderer, eye_m: DVec3) -> Vec<Option<DVec3>> {
    let place_m = |[x, y, z, w]: [f32; 4]| (w > 0.0).then(|| DVec3::new(x.into(), y.into(), z.into()) + eye_m);
    places(gpu, renderer, 0).into_iter().map(place_m).collect()
}

/// Reads the position that each pixel of an eye sees, relative to the rig's origin, and its distance along the axis.
pub(crate) fn places(gpu: &Gpu, renderer: &Renderer, eye: usize) -> Vec<[f32; 4]> {
    let size_px = renderer.eye_target(eye, &DISTANCE).unwrap().size_px();
    renderer.places(gpu, eye, [0, 0], size_px).unwrap().unwrap()
}

/// Reads the normal and the lightness of each pixel of the first eye.
pub(crate) fn normals(gpu: &Gpu, renderer: &Renderer) -> Vec<[f32; 4]> {
    let size_px = renderer.target(&DISTANCE).unwrap().size_px();
    renderer.normals(gpu, 0, [0, 0], size_px).unwrap().unwrap()
}

/// Draws a picture by parts as `parts` says, and returns the tone of each pixel.
pub(crate) fn tones_in_parts(world: &mut World, still: PictureRequest<'_>, parts: &PartRule) -> Vec<f32> {
    let planes = aov::planes("tone", still.style).unwrap();
    let request = PictureRequest { planes: &planes, ..still };
    let mut tones: Vec<f32> = Vec::new();
    let take = |band: picture::Band| {
        if let Samples::F32(values) = &band.planes[0] {
            tones.extend(values);
        }
        Ok::<_, Infallible>(())
    };
    picture::render_in_parts(&world.gpu, &mut None, &mut world.surfaces, &request, parts, take).unwrap();
    tones
}
