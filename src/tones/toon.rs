//! Light in a few steps. See `shaders/tones/toon.wgsl`.

mod ramp;

use std::convert::Infallible;

use self::ramp::RampTable;
use super::light::LightUniform;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Cx;
use crate::gpu::target::Target;
pub(crate) use crate::gpu::wgsl::tones::toon::Toon as ToonUniform;
use crate::style::Toon;

/// What colours need to know of the land.
#[derive(Clone, Copy, Debug)]
pub struct Land {
    /// The camera's height in the world.
    pub camera_z_m: f32,
    /// The lowest and the highest place.
    pub range_m: [f32; 2],
}

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// `Terrain`, for the earth's curvature.
    pub terrain: Named,
    /// What the land sees of the sun and the sky, for a style that asks; without it the cheaper variant runs.
    pub seen: Option<[Named; 5]>,
    /// The style's steps and colours.
    pub toon: &'a Toon,
    /// The style's shading in the scene's light.
    pub light: LightUniform,
    /// For colours by height.
    pub land: Land,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
    /// Out: colour, and the tone that is asked for.
    pub tone: &'a Target,
}

/// Tones what the inputs show.
pub fn run(cx: &mut Cx<'_>, inputs: Inputs<'_>) {
    let toon = inputs.toon;
    let made = cx.kept(
        |ramp: &RampTable| ramp.is_of(toon.ramp.as_ref()),
        |gpu| Ok::<_, Infallible>(RampTable::new(gpu, toon.ramp.as_ref())),
    );
    let Ok(ramp) = made;
    let [row_first, row_scale] = ramp.row_px;
    let [low_m, high_m] = inputs.land.range_m;
    let uniform = ToonUniform {
        steps: toon.steps as f32,
        darkest: toon.darkest,
        lightest: toon.lightest,
        softness: toon.softness.max(1e-3),
        wash: toon.wash,
        row_first,
        row_scale,
        by: ramp.by,
        camera_z_m: inputs.land.camera_z_m,
        low_m,
        high_m: high_m.max(low_m + 1.0),
        pad: 0.0,
    };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("light", cx.uniform("light", &inputs.light)),
        ("toon", cx.uniform("toon", &uniform)),
        ("ramp", Resource::Texture("ramp", ramp.view.clone())),
        inputs.terrain,
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
        ("tone", inputs.tone.into()),
    ];
    let definitions: &[&str] = if inputs.seen.is_some() { &["HORIZON_MAPS"] } else { &[] };
    resources.extend(inputs.seen.into_iter().flatten());
    cx.pixels(Compute { name: "tones/toon", definitions }, inputs.tone.size_px(), &resources);
}
