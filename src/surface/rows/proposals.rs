//! The candidates that may be drawn. See `shaders/surface/rows/proposals.wgsl`.

use super::{BLOCKS, RowPlan};
use crate::gpu::Gpu;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::gpu::wgsl::shared::rows::{MAX_CANDIDATES, PROPOSAL};

/// Number of proposals.
pub(crate) const PROPOSED: BufferKind = BufferKind::storage("row proposed");
const PROPOSALS: BufferKind = BufferKind::storage("row proposals");
/// Bytes of a proposal.
pub(crate) const BYTES: u64 = 16 * PROPOSAL as u64;

/// Returns how many proposals a binding can hold.
pub(crate) fn max_marks(gpu: &Gpu) -> u32 {
    let limits = gpu.device.limits();
    let bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    u32::try_from(bytes / (16 * PROPOSAL as u64)).unwrap_or(u32::MAX)
}

/// Inputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// Bindings of the terrain: height atlas and page table.
    pub terrain: &'a [Named],
    /// The blocks, and the rules of the marks.
    pub plan: &'a RowPlan,
    /// Position of the visible surface.
    pub distance: &'a Target,
}

/// The marks that may be drawn.
pub(crate) struct Proposals {
    /// Number of proposals, then three unused words.
    pub count: Buffer,
    /// The proposals, of `PROPOSAL` vectors each.
    pub all: Buffer,
}

/// Selects the candidates that may be drawn, and computes their room.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) -> Proposals {
    let plan = inputs.plan;
    let count = recorder.buffer(&PROPOSED, 16);
    let all = recorder.buffer(&PROPOSALS, u64::from(plan.rules.max_marks) * BYTES);
    recorder.reset(&count, &[0_u32; 4]);
    let prewarms = recorder.prewarms();
    for pool in plan.pools.iter().filter(|pool| !pool.seen.is_empty() || prewarms) {
        let mut resources = vec![
            ("view", inputs.view.clone()),
            ("rules", recorder.uniform("row rules", &plan.rules)),
            ("blocks", recorder.upload(&BLOCKS, &pool.seen).binding()),
            ("counts", pool.counts.binding()),
            ("candidates", pool.candidates.binding()),
            ("proposed", count.binding()),
            ("proposals", all.binding()),
            ("distance_m", inputs.distance.into()),
        ];
        resources.extend(inputs.terrain.iter().cloned());
        recorder.groups("surface/rows/proposals", [MAX_CANDIDATES / 64, pool.seen.len() as u32], &resources);
    }
    Proposals { count, all }
}
