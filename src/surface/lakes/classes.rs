//! Finds the lakes that squares of samples belong to. See `shaders/surface/lakes/classes.wgsl`.

use super::{CLASSES_OFFSET, Inputs};
use crate::gpu::recorder::Recorder;

/// Assigns samples to lakes or land.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut resources = vec![
        ("jobs", inputs.job_list.binding()),
        ("squares", inputs.squares.binding()),
        ("classes", inputs.classes.binding()),
        ("found", inputs.found.binding()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    recorder.indirect("surface/lakes/classes", &inputs.arguments, CLASSES_OFFSET, &resources);
}
