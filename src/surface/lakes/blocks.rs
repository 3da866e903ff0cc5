//! Finds the sea, and candidates for lakes, in the heights. See `shaders/surface/lakes/blocks.wgsl`.

use super::Inputs;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::wgsl::surface::lakes::blocks::{GROUPS, Sea};

/// Classifies samples as sea or land, and lists the level squares, in which there may be a lake.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let sea = Sea { sea_m: inputs.sea_m, pad_a: 0.0, pad_b: 0.0, pad_c: 0.0 };
    let mut resources = vec![
        ("sea", recorder.uniform("sea", &sea)),
        ("jobs", inputs.job_list.binding()),
        ("classes", inputs.classes.binding()),
        ("found", inputs.found.binding()),
        ("squares", inputs.squares.binding()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    resources.extend(inputs.given.as_ref().map(|given| ("given", given.binding())));
    let definitions: &[&str] = if inputs.given.is_some() { &["GIVEN"] } else { &[] };
    let kind = Compute { name: "surface/lakes/blocks", definitions };
    // The tiles are stacked along y.
    recorder.groups(kind, [GROUPS, GROUPS * inputs.jobs.len() as u32], &resources);
}
