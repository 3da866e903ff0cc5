//! Computes the distance of each sample from the shore, from the nearest shores in columns. See
//! `shaders/surface/lakes/maps.wgsl`.

use super::{Inputs, MAPS_OFFSET};
use crate::gpu::recorder::Recorder;

/// Writes the water maps.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut resources = vec![
        ("jobs", inputs.job_list.binding()),
        ("found", inputs.found.binding()),
        ("shores", inputs.shores.binding()),
        ("water_maps", inputs.water_maps.clone()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    recorder.indirect("surface/lakes/maps", &inputs.arguments, MAPS_OFFSET, &resources);
}
