//! Heights → the water that each sample belongs to. See `shaders/surface/lakes/classes.wgsl`.

use super::Inputs;
use crate::gpu::recorder::Cx;
use crate::gpu::wgsl::surface::lakes::classes::{GROUPS, Sea};

/// Tells lakes and the sea from land.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
    let sea = Sea { sea_m: inputs.sea_m, pad_a: 0.0, pad_b: 0.0, pad_c: 0.0 };
    let mut resources = vec![
        ("sea", cx.uniform("sea", &sea)),
        ("jobs", inputs.job_list.binding()),
        ("classes", inputs.classes.binding()),
        ("found", inputs.found.binding()),
    ];
    resources.extend(inputs.terrain.iter().cloned());
    // Tiles stand below each other.
    let tiles = inputs.jobs.len() as u32;
    cx.groups("surface/lakes/classes", [GROUPS, GROUPS * tiles], &resources);
}
