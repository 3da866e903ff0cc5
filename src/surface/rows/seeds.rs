//! Seeds of hachures along the middles of rows. See `shaders/surface/rows/seeds.wgsl`.

use super::Making;
use crate::gpu::bind::Named;
use crate::gpu::recorder::Cx;
use crate::gpu::wgsl::shared::rows::CELLS;

/// Sows candidates in the blocks.
pub fn run(cx: &mut Cx<'_>, making: &Making, terrain: &[Named]) {
    let mut resources = vec![
        ("rules", making.rules.clone()),
        ("jobs", making.jobs.clone()),
        ("relief", making.relief.clone()),
        ("counts", making.counts.clone()),
        ("candidates", making.candidates.clone()),
    ];
    resources.extend(terrain.iter().cloned());
    cx.groups("surface/rows/seeds", [(CELLS * CELLS) as u32 / 64, making.blocks], &resources);
}
