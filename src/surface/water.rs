//! Still water on the land, and how far its shore is. See `shaders/surface/water.wgsl`.
//!
//! Why: `docs/decisions/water.md`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::surface::water::WaterRules;
use crate::style::Water;
use crate::surface::lakes;

/// Metres to the shore on water, at most as many as are asked for; on land beside it below 0; 0 elsewhere.
pub const WATER: TargetKind = TargetKind::storage("water", wgpu::TextureFormat::R32Float);

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Tables of tiles, and the water maps.
    pub terrain: &'a [Named],
    /// How far from the shore it is asked.
    pub style: &'a Water,
    /// Tells the land from what stands on it.
    pub surface_id: &'a Target,
    /// Of the surface.
    pub position: &'a Target,
    /// Out.
    pub water: &'a Target,
}

/// Finds the water of the land that the inputs show.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let rules = WaterRules { reach_px: inputs.style.reach_px(), pad_a: 0.0, pad_b: 0.0, pad_c: 0.0 };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("water_rules", recorder.uniform("water rules", &rules)),
        ("surface_id", inputs.surface_id.into()),
        ("position", inputs.position.into()),
        ("water", inputs.water.into()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    let arguments = lakes::seen::run(recorder, inputs.terrain, inputs.water.size_px());
    recorder.indirect("surface/water", &arguments, 0, &resources);
    recorder.indirect("surface/dry", &arguments, lakes::seen::DRY, &[("water", inputs.water.into())]);
}
