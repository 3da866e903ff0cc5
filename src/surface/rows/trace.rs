//! Candidates' marks, up and down the slope. See `shaders/surface/rows/trace.wgsl`.

use super::Making;
use crate::gpu::bind::Named;
use crate::gpu::recorder::Cx;
use crate::gpu::wgsl::shared::rows::MOST_CANDIDATES;

/// Traces the candidates of the blocks.
pub fn run(cx: &mut Cx<'_>, making: &Making, terrain: &[Named]) {
    let mut resources = vec![
        ("rules", making.rules.clone()),
        ("jobs", making.jobs.clone()),
        ("relief", making.relief.clone()),
        ("counts", making.counts.clone()),
        ("candidates", making.candidates.clone()),
    ];
    resources.extend(terrain.iter().cloned());
    cx.groups("surface/rows/trace", [MOST_CANDIDATES / 64, making.blocks], &resources);
}
