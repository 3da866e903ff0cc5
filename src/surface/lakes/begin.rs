//! What was found → how many workgroups the passes to come have. See `shaders/surface/lakes/begin.wgsl`.

use super::Inputs;
use crate::gpu::recorder::Cx;

/// Counts workgroups.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
    let resources = [
        ("jobs", inputs.job_list.binding()),
        ("found", inputs.found.binding()),
        ("arguments", inputs.arguments.binding()),
        ("water_maps", inputs.water_maps.clone()),
    ];
    cx.groups("surface/lakes/begin", [1, 1], &resources);
}
