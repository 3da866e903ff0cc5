//! Blinn-Phong shading over an elevation tint. See `shaders/tones/plain.wgsl`.

use super::{Inputs, Local};
use crate::gpu::pipelines::{Compute, defined};
use crate::gpu::recorder::Recorder;
pub(crate) use crate::gpu::wgsl::tones::plain::Plain as PlainUniform;

/// Shades the visible surface.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let [low_m, high_m] = inputs.range_m;
    let uniform = PlainUniform {
        to_sun: inputs.light.to_sun.as_vec3().to_array(),
        camera_z_m: inputs.camera_z_m,
        low_m,
        high_m,
        shininess: 24.0,
        specular: 0.06,
        local: inputs.local.map_or(0.0, |local| local.amount),
        pad_a: 0.0,
        pad_b: 0.0,
        pad_c: 0.0,
    };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        inputs.terrain.clone(),
        ("plain", recorder.uniform("plain", &uniform)),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
        ("tone", inputs.tone.into()),
    ];
    resources.extend(inputs.local.into_iter().flat_map(Local::resources));
    resources.extend(inputs.image.map(|image| ("draped_image", image.into())));
    let definitions = defined([("LOCAL_COLOR", inputs.local.is_some()), ("DRAPED_IMAGE", inputs.image.is_some())]);
    recorder.pixels(Compute { name: "tones/plain", definitions }, inputs.tone.size_px(), &resources);
}
