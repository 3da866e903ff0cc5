//! Counts the tones and the distances of the land in view. See `shaders/tones/fit/measure.wgsl`.

use crate::gpu::buffer::Buffer;
use crate::gpu::pipelines::{Compute, defined};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::gpu::wgsl::tones::fit::measure::STEP_PX;
use crate::scene::focus::FocusUniform;
use crate::tones::Inputs;
use crate::tones::light::LightUniform;

/// Adds the land in view to `counts`.
pub(super) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, water: Option<&Target>, counts: &Buffer) {
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("light", recorder.uniform("light", &LightUniform::new(inputs.style, inputs.light))),
        ("focus", FocusUniform::on_gpu(recorder, inputs.light.focus.as_ref())),
        ("tone_counts", counts.binding()),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
        ("form_normal", inputs.form_normal.into()),
        ("crest_light", inputs.crest_light.unwrap_or(inputs.nothing).into()),
        ("relief_light", inputs.relief_light.unwrap_or(inputs.nothing).into()),
    ];
    let definitions = defined([
        ("CRESTS", inputs.crest_light.is_some()),
        ("RELIEF", inputs.relief_light.is_some()),
        ("HORIZON_MAPS", inputs.horizon_maps.is_some()),
        ("TREE_SHADOWS", inputs.tree_shadow.is_some()),
        ("WATER", water.is_some()),
    ]);
    resources.extend(water.map(|water| ("water", water.into())));
    resources.extend(inputs.tree_shadow.map(|tree_shadow| ("tree_shadow", tree_shadow.into())));
    if let Some(maps) = inputs.horizon_maps.clone() {
        resources.push(inputs.terrain.clone());
        resources.extend(maps);
    }
    let size_px = inputs.tone.size_px().map(|side| side.div_ceil(STEP_PX));
    recorder.pixels(Compute { name: "tones/fit/measure", definitions }, size_px, &resources);
}
