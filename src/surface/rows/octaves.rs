//! How high rows are, cell by cell. See `shaders/surface/rows/octaves.wgsl`.

use super::Making;
use crate::gpu::bind::Named;
use crate::gpu::recorder::Cx;
use crate::gpu::wgsl::shared::rows::OCTAVES;

/// Finds the octaves of the blocks' cells.
pub fn run(cx: &mut Cx<'_>, making: &Making, terrain: &[Named]) {
    let mut resources =
        vec![("rules", making.rules.clone()), ("jobs", making.jobs.clone()), ("relief", making.relief.clone())];
    resources.extend(terrain.iter().cloned());
    cx.groups("surface/rows/octaves", [(OCTAVES * OCTAVES) as u32 / 64, making.blocks], &resources);
}
