//! Rows of hachures: marks down the slope of the land's form, in rows between heights, anchored in the world.
//!
//! [`blocks`] says which blocks of land a view needs, and keeps those that are made. A block is made once: its
//! [`relief`], how high its rows are ([`octaves`]), the [`seeds`] of its candidates, and the marks that these may be
//! ([`trace`]). For each frame [`proposals`] says which of them may be drawn, [`choice`] which are, [`rooms`] how much room
//! they have, and [`balance`] how much ink is wanting; [`marks`] gives them their widths, and [`ribbons`] draws these.
//! Models and trees have marks of a texture, where the style has any ([`beside`]).
//!
//! Why: `docs/decisions/rows.md`.

pub mod balance;
pub mod beside;
pub mod blocks;
pub mod choice;
pub mod marks;
pub mod octaves;
pub mod proposals;
pub mod relief;
pub mod ribbons;
pub mod rooms;
pub mod seeds;
pub mod trace;

use crate::gpu::Gpu;
use crate::gpu::bind::Named;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::wgsl::shared::rows::{RELIEF, RowBlock, RowRules};

/// The blocks that are made.
const JOBS: BufferKind = BufferKind::storage("row jobs");
/// The blocks that are seen.
const BLOCKS: BufferKind = BufferKind::storage("row blocks");
/// Of the blocks of one submit.
const RELIEFS: BufferKind = BufferKind::storage("row relief");

/// Blocks that are kept in one pair of buffers, as far as a frame asks for them.
#[derive(Clone)]
pub struct PlannedPool {
    /// Blocks that are made, as many at once as a submit has.
    pub jobs: Vec<RowBlock>,
    /// Blocks that are seen.
    pub seen: Vec<RowBlock>,
    /// Numbers of candidates, by slot.
    pub counts: Buffer,
    /// Candidates, by slot.
    pub candidates: Buffer,
}

impl PlannedPool {
    /// Of no blocks yet.
    pub fn new(counts: Buffer, candidates: Buffer) -> Self {
        Self { jobs: Vec::new(), seen: Vec::new(), counts, candidates }
    }
}

/// What a frame makes and draws of rows.
#[derive(Clone)]
pub struct RowPlan {
    /// For the shaders.
    pub rules: RowRules,
    /// No binding holds all blocks of a large picture.
    pub pools: Vec<PlannedPool>,
    /// Whether blocks are left for the next frame.
    pub is_late: bool,
}

impl RowPlan {
    /// Of a frame that is only prewarmed.
    pub fn prewarm(gpu: &Gpu) -> Self {
        let nothing = Buffer::new(gpu, &JOBS, 16);
        let pools = vec![PlannedPool::new(nothing.clone(), nothing)];
        Self { rules: RowRules::default(), pools, is_late: false }
    }
}

/// Makes the blocks that are planned. No submit has more than a frame of a window.
pub fn make(recorder: &mut Recorder<'_>, plan: &RowPlan, terrain: &[Named]) {
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
