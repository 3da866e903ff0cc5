//! Still water on the land, and the distance to its shore. See `shaders/surface/water.wgsl`.
//!
//! Why: `docs/decisions/water.md`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Group, Target, TargetKind};
use crate::gpu::wgsl::surface::water::WaterRules;
use crate::style::Water;
use crate::surface::lakes;

/// Metres to the shore on water, at most as far as the style needs; below 0 on land near water; 0 elsewhere.
pub(crate) const WATER: TargetKind = TargetKind::storage(
    "water",
    wgpu::TextureFormat::R32Float,
    Group::Surface.shows("Distance to the shore on water, in metres; negative on land near the shore"),
);

/// Inputs and output of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// Bindings of the page table and the water maps.
    pub terrain: &'a [Named],
    /// The style, which limits how far from the shore distances are needed.
    pub style: &'a Water,
    /// Surface ids, which separate the land from the objects on it.
    pub surface_id: &'a Target,
    pub distance: &'a Target,
    pub water: &'a Target,
}

/// Computes the water of the visible land.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let rules = WaterRules { reach_px: inputs.style.reach_px(), pad_a: 0.0, pad_b: 0.0, pad_c: 0.0 };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("water_rules", recorder.uniform("water rules", &rules)),
        ("surface_id", inputs.surface_id.into()),
        ("distance_m", inputs.distance.into()),
        ("water", inputs.water.into()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    let arguments = lakes::seen::run(recorder, inputs.terrain, inputs.water.size_px());
    recorder.indirect("surface/water", &arguments, 0, &resources);
    recorder.indirect("surface/dry", &arguments, lakes::seen::DRY, &[("water", inputs.water.into())]);
}
