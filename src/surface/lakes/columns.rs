//! Shores → the nearest one in the column of each sample. See `shaders/surface/lakes/columns.wgsl`.

use super::Inputs;
use crate::gpu::recorder::Cx;
use crate::gpu::wgsl::surface::lakes::columns::GROUPS;

/// Looks up and down the columns.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
    let resources = [("found", inputs.found.binding()), ("shores", inputs.shores.binding())];
    // Tiles stand below each other.
    let tiles = inputs.jobs.len() as u32;
    cx.groups("surface/lakes/columns", [GROUPS, tiles], &resources);
}
