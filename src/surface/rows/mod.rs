//! Rows of hachures: marks down the slope of the land's form, arranged in rows between heights and anchored in the
//! world.
//!
//! [`needed`] lists the blocks of land that a view needs ([`reach`]: no mark beyond it comes into view), and [`blocks`]
//! caches them. A block is built once: [`relief`] samples
//! its heights, [`octaves`] chooses the heights of its rows, [`seeds`] places candidates, and [`trace`] traces their
//! marks. For each frame [`proposals`] selects the candidates that may be drawn, [`choice`] those that are drawn,
//! [`rooms`] measures the space around each, and [`balance`] the missing ink; [`marks`] computes widths, and
//! [`ribbons`] draws the marks. Models and trees have the marks of a hatching texture, if the style has one
//! ([`off_land`]).
//!
//! Why: `docs/decisions/rows.md`.

pub(crate) mod balance;
pub(crate) mod off_land;
pub(crate) mod blocks;
pub(crate) mod choice;
pub(crate) mod marks;
mod needed;
pub(crate) mod octaves;
pub(crate) mod proposals;
pub(crate) mod reach;
pub(crate) mod relief;
pub(crate) mod ribbons;
pub(crate) mod rooms;
pub(crate) mod seeds;
pub(crate) mod trace;

use crate::gpu::Gpu;
use crate::gpu::bind::Named;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::wgsl::shared::rows::{RELIEF, RowBlock, RowRules};

/// The blocks that are built.
const JOBS: BufferKind = BufferKind::storage("row jobs");
/// The blocks that are visible.
const BLOCKS: BufferKind = BufferKind::storage("row blocks");
/// Heights, slopes and octaves of the blocks of one submit.
const RELIEFS: BufferKind = BufferKind::storage("row relief");

/// The blocks in one pair of buffers that a frame needs.
#[derive(Clone)]
pub(crate) struct PlannedPool {
    /// Blocks that this frame builds.
    pub jobs: Vec<RowBlock>,
    /// Blocks that are visible.
    pub seen: Vec<RowBlock>,
    /// Number of candidates of each slot.
    pub counts: Buffer,
    /// Candidates of each slot.
    pub candidates: Buffer,
}

impl PlannedPool {
    /// Creates a plan without blocks.
    pub(crate) fn new(counts: Buffer, candidates: Buffer) -> Self {
        Self { jobs: Vec::new(), seen: Vec::new(), counts, candidates }
    }
}

/// The rows that a frame builds and draws.
#[derive(Clone)]
pub(crate) struct RowPlan {
    /// The rules uniform of the shaders.
    pub rules: RowRules,
    /// The pools: no single binding holds all blocks of a large picture.
    pub pools: Vec<PlannedPool>,
}

impl RowPlan {
    /// Returns the plan of a frame that is only prewarmed.
    pub(crate) fn prewarm(gpu: &Gpu) -> Self {
        let nothing = Buffer::new(gpu, &JOBS, 16);
        let pools = vec![PlannedPool::new(nothing.clone(), nothing)];
        Self { rules: RowRules::default(), pools }
    }
}

/// Builds the planned blocks. No submit builds more than one frame of a window does.
pub(crate) fn make(recorder: &mut Recorder<'_>, plan: &RowPlan, terrain: &[Named]) {
    let nothing: &[&[_]] = if recorder.prewarms() { &[&[]] } else { &[] };
    let of_pool = |pool| nothing.iter().copied().map(move |jobs| (pool, jobs));
    let parts = plan.pools.iter().flat_map(|pool: &PlannedPool| {
        pool.jobs.chunks(blocks::JOBS_AT_ONCE).map(move |jobs| (pool, jobs)).chain(of_pool(pool))
    });
    for (part, (pool, jobs)) in parts.enumerate() {
        if part > 0 {
            recorder.submit_so_far();
        }
        let mut resources = vec![
            ("rules", recorder.uniform("row rules", &plan.rules)),
            ("jobs", recorder.upload(&JOBS, jobs).binding()),
            ("relief", recorder.buffer(&RELIEFS, 4 * RELIEF as u64 * blocks::JOBS_AT_ONCE as u64).binding()),
            ("counts", pool.counts.binding()),
            ("candidates", pool.candidates.binding()),
        ];
        resources.extend_from_slice(terrain);
        let blocks = jobs.len() as u32;
        relief::run(recorder, blocks, &resources);
        octaves::run(recorder, blocks, &resources);
        seeds::run(recorder, blocks, &resources);
        trace::run(recorder, blocks, &resources);
    }
}
