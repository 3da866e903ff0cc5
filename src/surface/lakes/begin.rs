//! Computes the workgroup counts of the later passes from the water that was found. See
//! `shaders/surface/lakes/begin.wgsl`.

use super::Inputs;
use crate::gpu::recorder::Recorder;

/// Writes the arguments of the indirect dispatches.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let resources = [
        ("jobs", inputs.job_list.binding()),
        ("found", inputs.found.binding()),
        ("arguments", inputs.arguments.binding()),
        ("water_maps", inputs.water_maps.clone()),
    ];
    recorder.groups("surface/lakes/begin", [1, 1], &resources);
}
