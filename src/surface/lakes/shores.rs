//! Finds the shore next to each sample. See `shaders/surface/lakes/shores.wgsl`.

use super::{Inputs, SHORES_OFFSET};
use crate::gpu::recorder::Recorder;

/// Finds the shores.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut resources = vec![
        ("jobs", inputs.job_list.binding()),
        ("classes", inputs.classes.binding()),
        ("found", inputs.found.binding()),
        ("shores", inputs.shores.binding()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    recorder.indirect("surface/lakes/shores", &inputs.arguments, SHORES_OFFSET, &resources);
}
