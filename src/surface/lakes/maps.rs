//! The nearest shores of columns → how far each sample is from the shore. See `shaders/surface/lakes/maps.wgsl`.

use super::Inputs;
use crate::gpu::recorder::Cx;

/// Writes the maps.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
    let mut resources = vec![
        ("jobs", inputs.job_list.binding()),
        ("found", inputs.found.binding()),
        ("shores", inputs.shores.binding()),
        ("water_maps", inputs.water_maps.clone()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    cx.indirect("surface/lakes/maps", &inputs.arguments, 36, &resources);
}
