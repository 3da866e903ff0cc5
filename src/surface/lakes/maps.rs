//! The nearest shores of columns → how far each sample is from the shore. See `shaders/surface/lakes/maps.wgsl`.

use super::Inputs;
use crate::gpu::recorder::{Cx, WORKGROUP_PX};
use crate::gpu::wgsl::surface::lakes::maps::GROUPS;
use crate::tiles::water_maps::WATER_MAP_SIZE;

/// Writes the maps.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
    let mut resources = vec![
        ("jobs", inputs.job_list.binding()),
        ("found", inputs.found.binding()),
        ("shores", inputs.shores.binding()),
        ("water_maps", inputs.water_maps.clone()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    // Tiles stand below each other.
    let tiles = inputs.jobs.len() as u32;
    cx.groups("surface/lakes/maps", [WATER_MAP_SIZE[0].div_ceil(WORKGROUP_PX), GROUPS * tiles], &resources);
}
