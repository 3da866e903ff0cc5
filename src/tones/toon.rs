//! Light in a few steps. See `shaders/tones/toon.wgsl`.

mod ramp;

use std::convert::Infallible;

use self::ramp::RampTable;
use super::Inputs;
use super::light::LightUniform;
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Cx;
pub(crate) use crate::gpu::wgsl::tones::toon::Toon as ToonUniform;
use crate::style::Toon;

/// Tones what the inputs show.
pub fn run(cx: &mut Cx<'_>, toon: &Toon, inputs: &Inputs<'_>) {
    let made = cx.kept(
        |ramp: &RampTable| ramp.is_of(toon.ramp.as_ref()),
        |gpu| Ok::<_, Infallible>(RampTable::new(gpu, toon.ramp.as_ref())),
    );
    let Ok(ramp) = made;
    let [row_first, row_scale] = ramp.row_px;
    let [low_m, high_m] = inputs.range_m;
    let uniform = ToonUniform {
        steps: toon.steps as f32,
        darkest: toon.darkest,
        lightest: toon.lightest,
        softness: toon.softness.max(1e-3),
        wash: toon.wash,
        row_first,
        row_scale,
        by: ramp.by,
        camera_z_m: inputs.camera_z_m,
        low_m,
        high_m: high_m.max(low_m + 1.0),
        pad: 0.0,
    };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("light", cx.uniform("light", &LightUniform::new(inputs.style, inputs.light))),
        ("toon", cx.uniform("toon", &uniform)),
        ("ramp", Resource::Texture("ramp", ramp.view.clone())),
        inputs.terrain.clone(),
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
        ("tone", inputs.tone.into()),
    ];
    let has = (inputs.horizon_maps.is_some(), inputs.mark_surface.is_some(), inputs.tree_shadow.is_some());
    let definitions: &[&str] = match has {
        (false, false, false) => &[],
        (true, false, false) => &["HORIZON_MAPS"],
        (false, true, false) => &["MARKED_TREES"],
        (false, false, true) => &["TREE_SHADOWS"],
        (true, true, false) => &["HORIZON_MAPS", "MARKED_TREES"],
        (true, false, true) => &["HORIZON_MAPS", "TREE_SHADOWS"],
        (false, true, true) => &["MARKED_TREES", "TREE_SHADOWS"],
        (true, true, true) => &["HORIZON_MAPS", "MARKED_TREES", "TREE_SHADOWS"],
    };
    resources.extend(inputs.mark_surface.map(|mark_surface| ("mark_surface", mark_surface.into())));
    resources.extend(inputs.tree_shadow.map(|tree_shadow| ("tree_shadow", tree_shadow.into())));
    resources.extend(inputs.horizon_maps.clone().into_iter().flatten());
    cx.pixels(Compute { name: "tones/toon", definitions }, inputs.tone.size_px(), &resources);
}
