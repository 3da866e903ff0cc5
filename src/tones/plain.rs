//! Blinn-Phong over an elevation tint. See `shaders/tones/plain.wgsl`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Cx;
use crate::gpu::target::Target;
pub(crate) use crate::gpu::wgsl::tones::plain::Plain as PlainUniform;

/// What the tint needs to know of the scene.
#[derive(Clone, Copy, Debug)]
pub struct PlainLight {
    /// Unit, in the world.
    pub to_sun: [f32; 3],
    /// The camera's height in the world.
    pub camera_z_m: f32,
    /// Heights at which the tint begins and ends.
    pub range_m: [f32; 2],
}

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// `Terrain`, for the earth's curvature.
    pub terrain: Named,
    /// Sun and heights.
    pub light: PlainLight,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
    /// Out: colour, and the tone that is asked for.
    pub tone: &'a Target,
}

/// Tones what the inputs show.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
    let [low_m, high_m] = inputs.light.range_m;
    let uniform = PlainUniform {
        to_sun: inputs.light.to_sun,
        camera_z_m: inputs.light.camera_z_m,
        low_m,
        high_m: high_m.max(low_m + 1.0),
        shininess: 24.0,
        specular: 0.06,
    };
    let resources = [
        ("view", inputs.view.clone()),
        inputs.terrain.clone(),
        ("plain", cx.uniform("plain", &uniform)),
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
        ("tone", inputs.tone.into()),
    ];
    cx.pixels("tones/plain", inputs.tone.size_px(), &resources);
}
