//! Still water on the land, and how far its shore is. See `shaders/surface/water.wgsl`.
//!
//! Why: `docs/decisions/water.md`.

use crate::gpu::bind::{Named, Resource};
use crate::gpu::recorder::Cx;
use crate::gpu::target::{Target, TargetKind};
use crate::gpu::wgsl::surface::water::WaterRules;
use crate::style::Water;

/// Metres to the shore on water, at most as many as are asked for; on land beside it below 0; 0 elsewhere.
pub const WATER: TargetKind = TargetKind::storage("water", wgpu::TextureFormat::R32Float);

/// In place of a sea where the scene has none: lower than any land.
const NO_SEA_M: f32 = -1e30;

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// Heights and tables.
    pub terrain: &'a [Named],
    /// How far from the shore it is asked.
    pub style: &'a Water,
    /// What is no higher is the sea.
    pub sea_level_m: Option<f64>,
    /// Tells the land from what stands on it.
    pub surface_id: &'a Target,
    /// Of the surface.
    pub position: &'a Target,
    /// Out.
    pub water: &'a Target,
}

/// Finds the water of the land that the inputs show.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
    let rules = WaterRules {
        sea_m: inputs.sea_level_m.map_or(NO_SEA_M, |level_m| level_m as f32),
        reach_px: inputs.style.reach_px(),
        pad_a: 0.0,
        pad_b: 0.0,
    };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("water_rules", cx.uniform("water rules", &rules)),
        ("surface_id", inputs.surface_id.into()),
        ("position", inputs.position.into()),
        ("water", inputs.water.into()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    cx.pixels("surface/water", inputs.water.size_px(), &resources);
}
