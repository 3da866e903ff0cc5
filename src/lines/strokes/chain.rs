//! Chains segments on the GPU. [`twin`](super::twin) is the specification in plain Rust, bit for bit.
//!
//! | shader of `shaders/lines/strokes/` | runs | does |
//! | --- | --- | --- |
//! | `chain_begin` | once | computes the sizes of the later passes, empties the cells |
//! | `chain_bin`, `scan` | count, sum, scatter | sorts ends by cells |
//! | `chain_choose` | 3 times | lets ends choose each other |
//! | `chain_rank_begin`, `chain_rank` | once and 4 times | chain, number and arc length of each segment |
//! | the same for loops | once and 3 times | the same |
//! | `chain_heads`, `scan`, `chain_order` | once each | puts chains and segments in order |
//!
//! There are 21 dispatches. Nothing is read back: sizes are on the GPU. Rounds of ranking that have nothing to do
//! return at once, so short chains take few rounds. The work grows with the number of segments, and not with the size
//! of the picture. It also grows with the square of the number of ends in one neighbourhood: it is slow if all segments
//! are in one place.

use super::records::{Chain, ChainRules, ChainRulesUniform, SegmentInOrder};
use crate::gpu::bind::Named;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::scan::{self, Count, MAX_VALUES};
use crate::gpu::wgsl::shared::ranking::{JUMPS, LOOP_ROUNDS};
use crate::gpu::{Gpu, GpuError};

/// Largest number of segments: they have two ends each, which are scanned at once.
pub(crate) const MAX_SEGMENTS: u32 = MAX_VALUES / 2;

/// Rounds of ranking of open chains: 32⁴ is [`MAX_SEGMENTS`]. Those of loops are one fewer.
const RANK_ROUNDS: u32 = MAX_SEGMENTS.ilog(JUMPS);
const _: () = assert!(JUMPS.pow(RANK_ROUNDS) == MAX_SEGMENTS && RANK_ROUNDS < LOOP_ROUNDS);
// The last round of choosing writes the half that `chain_rank_begin` reads.
const _: () = assert!(ChainRules::ROUNDS % 2 == 1);

/// Offsets in `arguments`, in bytes, of the workgroup counts per segment (at least one) and per end.
const PER_SEGMENT: u64 = 0;
const PER_END: u64 = 12;
/// Workgroups that empty the cells.
const BEGIN_GROUPS: u32 = 32;

/// A buffer that is bound both as storage and as a uniform.
const PLAN: BufferKind =
    BufferKind { name: "chain plan", usage: wgpu::BufferUsages::STORAGE.union(wgpu::BufferUsages::UNIFORM) };
const ARGUMENTS: BufferKind = BufferKind::indirect("chain arguments");
const BUCKETS: BufferKind = BufferKind::storage("chain buckets");
const SLOTS: BufferKind = BufferKind::storage("chain slots");
const CHOICES: BufferKind = BufferKind::storage("chain choices");
const LINKS: BufferKind = BufferKind::storage("chain links");
const RANKS: BufferKind = BufferKind::storage("chain ranks");
const HEADS: BufferKind = BufferKind::storage("chain heads");
/// [`SegmentInOrder`]s. The segments of a chain are consecutive; chains are in the order of their first segments.
pub(crate) const PLACES: BufferKind = BufferKind::storage("places");
/// The [`Chain`]s; their number is stored in the counts.
pub(crate) const CHAINS: BufferKind = BufferKind::storage("chains");

/// Inputs of chaining.
pub(crate) struct Inputs<'a> {
    /// The rules; numbers out of range are clamped.
    pub rules: ChainRules,
    /// Capacity in segments, at most [`MAX_SEGMENTS`]; excess segments are ignored. A segment takes some 180 bytes.
    pub capacity: u32,
    /// An array of [`Segment`](super::Segment); [`StrokeCounts::segments`](super::StrokeCounts) is its length.
    pub segments: &'a Buffer,
    /// [`StrokeCounts`](super::StrokeCounts); the number of chains is written.
    pub counts: &'a Buffer,
}

/// The result of chaining.
pub(crate) struct Chains {
    pub places: Buffer,
    pub chains: Buffer,
    plan: Buffer,
    arguments: Buffer,
}

impl Chains {
    /// Returns the binding of the chains.
    pub(crate) fn named(&self) -> Named {
        ("chains", self.chains.binding())
    }

    /// Returns the binding of `ChainPlan`, with the number of segments that were chained.
    pub(super) fn plan(&self) -> Named {
        ("plan", self.plan.binding())
    }

    /// Returns the workgroup counts, as buffer and offset, for 256 threads per workgroup and one thread per segment,
    /// and so per chain. There is at least one workgroup, whose first thread may write counters.
    pub(super) fn per_segment(&self) -> (&Buffer, u64) {
        (&self.arguments, PER_SEGMENT)
    }
}

/// Checks that the device can chain `capacity` segments.
///
/// # Errors
/// [`GpuError::Limit`] when a buffer is larger than the device can bind.
pub(crate) fn check(gpu: &Gpu, capacity: u32) -> Result<(), GpuError> {
    let limits = gpu.device.limits();
    let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    // The size of the ranks, the largest buffer.
    let wanted = 64 * u64::from(capacity);
    if wanted > limit {
        Err(GpuError::Limit { what: "the buffer for chaining lines, in bytes,", wanted, limit })
    } else {
        Ok(())
    }
}

/// Chains the segments.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) -> Chains {
    let capacity = inputs.capacity.clamp(1, MAX_SEGMENTS);
    let most = u64::from(capacity);
    let ends = 2 * most;
    let plan = recorder.buffer(&PLAN, 16);
    let arguments = recorder.buffer(&ARGUMENTS, 24);
    let buckets = recorder.buffer(&BUCKETS, 4 * ends.next_power_of_two().max(256));
    let slots = named(recorder, "slots", &SLOTS, 16 * ends);
    let choices = recorder.buffer(&CHOICES, 2 * 4 * ends);
    let links = named(recorder, "links", &LINKS, 4 * ends);
    let ranks = named(recorder, "ranks", &RANKS, 2 * 16 * ends);
    let heads = recorder.buffer(&HEADS, 4 * ends);
    let chains = Chains {
        places: recorder.buffer(&PLACES, size_of::<SegmentInOrder>() as u64 * most),
        chains: recorder.buffer(&CHAINS, size_of::<Chain>() as u64 * most),
        plan: plan.clone(),
        arguments: arguments.clone(),
    };
    let rules = inputs.rules.in_range();
    let uniform = ChainRulesUniform {
        capacity,
        reach_units: rules.reach_units,
        min_cos_squared: rules.min_cos_squared,
        overlap_units: ChainRules::OVERLAP_UNITS,
    };
    let rules = ("rules", recorder.uniform("chain rules", &uniform));
    let named_plan = ("plan", plan.binding());
    let segments = ("segments", inputs.segments.binding());
    let counts = ("counts", inputs.counts.binding());
    let named_buckets = ("buckets", buckets.binding());
    let named_choices = ("choices", choices.binding());

    let resources =
        [rules.clone(), counts.clone(), named_plan.clone(), ("arguments", arguments.binding()), named_buckets.clone()];
    recorder.groups("lines/strokes/chain_begin", [BEGIN_GROUPS, 1], &resources);

    // Sort the ends by cells.
    for step in 0_u32..2 {
        let stage = ("stage", recorder.uniform("stage", &step));
        let resources =
            [stage, rules.clone(), named_plan.clone(), segments.clone(), named_buckets.clone(), slots.clone()];
        recorder.indirect("lines/strokes/chain_bin", &arguments, PER_END, &resources);
        if step == 0 {
            scan::run(recorder, Count::Counted { numbers: &plan, index: 2, capacity: MAX_VALUES }, &buckets);
        }
    }

    // Let ends choose each other.
    for round in 0..ChainRules::ROUNDS as u32 {
        let resources = [
            ("turn", recorder.uniform("turn", &round)),
            rules.clone(),
            named_plan.clone(),
            segments.clone(),
            named_buckets.clone(),
            slots.clone(),
            named_choices.clone(),
        ];
        recorder.indirect("lines/strokes/chain_choose", &arguments, PER_END, &resources);
    }

    // Rank the segments of open chains, then of loops.
    for (definitions, rounds) in
        [(&[] as &[&str], 0..RANK_ROUNDS), (&["LOOPS"], LOOP_ROUNDS..LOOP_ROUNDS + RANK_ROUNDS - 1)]
    {
        let resources =
            [named_plan.clone(), segments.clone(), links.clone(), ranks.clone(), counts.clone(), named_choices.clone()];
        let begin = Compute { name: "lines/strokes/chain_rank_begin", definitions };
        recorder.indirect(begin, &arguments, PER_END, &resources);
        for round in rounds {
            let turn = ("turn", recorder.uniform("turn", &round));
            let resources = [turn, named_plan.clone(), ranks.clone(), counts.clone()];
            recorder.indirect("lines/strokes/chain_rank", &arguments, PER_END, &resources);
        }
    }

    // Put chains and segments in order. The choices are no longer needed; the states take their place.
    let states = ("states", choices.binding());
    let named_heads = ("heads", heads.binding());
    let resources =
        [named_plan.clone(), segments.clone(), ranks.clone(), counts.clone(), states.clone(), named_heads.clone()];
    recorder.indirect("lines/strokes/chain_heads", &arguments, PER_SEGMENT, &resources);
    scan::run(recorder, Count::Counted { numbers: &plan, index: 1, capacity: MAX_VALUES }, &heads);
    let resources = [
        named_plan,
        segments,
        links,
        ranks,
        states,
        named_heads,
        ("places", chains.places.binding()),
        chains.named(),
        counts,
    ];
    recorder.indirect("lines/strokes/chain_order", &arguments, PER_SEGMENT, &resources);
    chains
}

fn named(recorder: &mut Recorder<'_>, name: &'static str, kind: &BufferKind, bytes: u64) -> Named {
    (name, recorder.buffer(kind, bytes).binding())
}
