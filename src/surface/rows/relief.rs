//! The relief of blocks of rows: heights and slopes of the land's form. See `shaders/surface/rows/relief.wgsl`.

use crate::gpu::bind::Named;
use crate::gpu::recorder::Recorder;
use crate::gpu::wgsl::shared::rows::{NODES, SLOPE_NODES};

/// Computes the relief of the blocks, and clears their candidates.
pub(crate) fn run(recorder: &mut Recorder<'_>, blocks: u32, resources: &[Named]) {
    let nodes = (NODES * NODES + SLOPE_NODES * SLOPE_NODES) as u32;
    recorder.groups("surface/rows/relief", [nodes.div_ceil(64), blocks], resources);
}
