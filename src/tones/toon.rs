//! Toon tones: light in a few steps, coloured by a ramp. See `shaders/tones/toon.wgsl`.

mod ramp;

use std::convert::Infallible;

use self::ramp::RampTable;
use super::light::LightUniform;
use super::{Inputs, Local};
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::{Compute, defined};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, TextureName};
pub(crate) use crate::gpu::wgsl::tones::toon::Toon as ToonUniform;
use crate::scene::focus::FocusUniform;
use crate::style::Toon;

/// The colours of a ramp.
const RAMP: TextureName = TextureName {
    name: "ramp",
    content: Group::Tones.shows("Colours of the tones of the style, by tone and attribute"),
};

/// Shades the visible surface.
pub(crate) fn run(recorder: &mut Recorder<'_>, toon: &Toon, inputs: &Inputs<'_>) {
    let made = recorder.cached(
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
        high_m,
        local: inputs.local.map_or(0.0, |local| local.amount),
        relief: if inputs.relief_light.is_some() { 1.0 } else { 0.0 },
        crests: if inputs.crest_light.is_some() { 1.0 } else { 0.0 },
        light_color: inputs.style.drawn_relief().map_or(0.0, |relief| relief.color),
        foreground_ink: {
            let [red, green, blue] = toon.foreground_color.linear();
            [red, green, blue, toon.foreground_tint]
        },
        mass_cells: inputs.masses.map_or([0, 0], |masses| masses.counts),
        ..ToonUniform::default()
    };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("light", recorder.uniform("light", &LightUniform::new(inputs.style, inputs.light))),
        ("focus", FocusUniform::on_gpu(recorder, inputs.light.focus.as_ref())),
        ("toon", recorder.uniform("toon", &uniform)),
        ("ramp", Resource::Texture(RAMP, ramp.view.clone())),
        inputs.terrain.clone(),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
        ("form_normal", inputs.form_normal.into()),
        ("crest_light", inputs.crest_light.unwrap_or(inputs.nothing).into()),
        ("relief_light", inputs.relief_light.unwrap_or(inputs.nothing).into()),
        ("tone", inputs.tone.into()),
    ];
    let definitions = defined([
        ("HORIZON_MAPS", inputs.horizon_maps.is_some()),
        ("LOCAL_COLOR", inputs.local.is_some()),
        ("MARKED_TREES", inputs.mark_surface.is_some()),
        ("TREE_SHADOWS", inputs.tree_shadow.is_some()),
        ("FITTED", inputs.fit.is_some()),
        ("EDITED", inputs.masses.is_some()),
        ("DRAPED_IMAGE", inputs.image.is_some()),
    ]);
    resources.extend(inputs.fit.into_iter().flat_map(|fit| toon.fit_resources(recorder, &fit.curve)));
    resources.extend(inputs.masses.map(|masses| ("mass_cells", masses.buffer.binding())));
    resources.extend(inputs.image.map(|image| ("draped_image", image.into())));
    resources.extend(inputs.mark_surface.map(|mark_surface| ("mark_surface", mark_surface.into())));
    resources.extend(inputs.tree_shadow.map(|tree_shadow| ("tree_shadow", tree_shadow.into())));
    resources.extend(inputs.local.into_iter().flat_map(Local::resources));
    resources.extend(inputs.horizon_maps.clone().into_iter().flatten());
    recorder.pixels(Compute { name: "tones/toon", definitions }, inputs.tone.size_px(), &resources);
}
