//! Environment lighting, warped by curvature. See `shaders/tones/relief/radiance.wgsl`.

use super::surroundings::SkyParts;
use super::{Inputs, Shared, lit_surface, shadows};
use crate::gpu::buffer::BufferKind;
use crate::gpu::pipelines::{Compute, defined};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::gpu::wgsl::tones::relief::radiance::{SkyLight, Surroundings};

const SURROUNDINGS: BufferKind = BufferKind::storage("surroundings");
/// The parts of the sky around the scene that shed light: `SkyLight`s.
const SKY_LIGHTS: BufferKind = BufferKind::storage("sky lights");

/// Lights the visible surface. `slopes` is the blurred gradient of depth; without it light is not warped.
pub(super) fn run(
    recorder: &mut Recorder<'_>,
    inputs: &Inputs<'_>,
    shared: &Shared,
    slopes: Option<&Target>,
    relief_light: &Target,
) {
    let (relief, to_sun) = (inputs.relief, inputs.light.to_sun);
    let made = recorder.cached(
        |parts: &SkyParts| parts.is_of(relief, to_sun),
        |_| Ok::<_, std::convert::Infallible>(SkyParts::new(relief, to_sun)),
    );
    let Ok(parts) = made;
    let (right, down) = (inputs.pose.right, -inputs.pose.up);
    let on_picture = |direction: glam::DVec3| {
        glam::DVec3::new(right.dot(direction), down.dot(direction), -inputs.pose.forward.dot(direction))
            .as_vec3()
            .to_array()
    };
    let lights: Vec<SkyLight> = (parts.parts.iter())
        .map(|light| SkyLight {
            direction: on_picture(light.direction),
            radiance: light.radiance.map(|channel| channel as f32),
            ..SkyLight::default()
        })
        .collect();
    let uniform = Surroundings {
        right: right.as_vec3().to_array(),
        gamma: relief.gamma,
        down: down.as_vec3().to_array(),
        gloss: relief.gloss,
        to_sun: on_picture(to_sun),
        shininess: relief.shininess,
        sun: parts.sun.map(|channel| channel as f32),
        count: lights.len() as u32,
    };
    let mut resources = lit_surface(inputs, shared);
    resources.extend([
        ("surroundings", recorder.upload(&SURROUNDINGS, &[uniform]).binding()),
        ("sky_lights", recorder.upload(&SKY_LIGHTS, &lights).binding()),
        ("relief_light", relief_light.into()),
    ]);
    if let Some(slopes) = slopes {
        resources.push(("relief_rules", shared.rules.clone()));
        resources.push(("depth_gradient", slopes.into()));
    }
    let [land, trees] = shadows(inputs);
    let definitions = defined([land, trees, ("WARPED", slopes.is_some())]);
    recorder.pixels(Compute { name: "tones/relief/radiance", definitions }, relief_light.size_px(), &resources);
}
