//! Pieces become chains, on the GPU. [`twin`](super::twin) says in plain Rust what comes out, to the bit.
//!
//! | shader of `shaders/lines/strokes/` | runs | does |
//! | --- | --- | --- |
//! | `chain_begin` | once | how much there is to do |
//! | `chain_clear`, `chain_bin`, `scan` | clear, count, sum, scatter | ends sorted by cells |
//! | `chain_choose`, `chain_link` | 3 times each | ends that choose each other are joined |
//! | `chain_rank_begin`, `chain_rank` | once and 10 times, twice | which chain, which piece of it, how far along |
//! | `chain_heads`, `scan`, `chain_order` | once each | chains and pieces in their order |
//!
//! 42 dispatches. Nothing is read back: sizes are on the GPU. Rounds of ranking that have nothing to do return at once,
//! so short chains take few. The work grows with the number of pieces, and not with the picture. It also grows with the
//! square of the ends in one neighbourhood: pieces all in one place are slow.

use super::records::{Chain, ChainRules, ChainRulesUniform, Piece, Place};
use super::scan::{MAX_VALUES, ScanPass, ScanSize, buffer, numbers};
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{ComputePass, Named};
use crate::gpu::timer::Recorder;
use crate::gpu::{Gpu, GpuError};

/// The most pieces: they have two ends each, which are scanned at once.
pub const MAX_PIECES: u32 = MAX_VALUES / 2;

/// Rounds of ranking: 4¹⁰ is [`MAX_PIECES`].
const RANK_ROUNDS: usize = 10;
/// Where the rounds for loops begin; between them stands a bit that the last round sets for nobody.
const LOOP_ROUNDS: usize = RANK_ROUNDS + 1;

/// Bytes of `arguments` at which the workgroups for each piece, end and bucket stand.
const PER_PIECE: u64 = 0;
const PER_END: u64 = 12;
const PER_BUCKET: u64 = 24;

/// The passes and their buffers: some 180 bytes for each piece that there is room for.
pub struct ChainPass {
    begin: ComputePass,
    clear: ComputePass,
    bin: ComputePass,
    choose: ComputePass,
    link: ComputePass,
    rank_begin: ComputePass,
    rank: ComputePass,
    heads: ComputePass,
    order: ComputePass,
    scan: ScanPass,
    buckets_size: ScanSize,
    heads_size: ScanSize,
    turns: Vec<GrowingBuffer>,
    rules: GrowingBuffer,
    capacity: u32,
    buffers: Buffers,
}

struct Buffers {
    plan: wgpu::Buffer,
    arguments: wgpu::Buffer,
    progress: wgpu::Buffer,
    buckets: wgpu::Buffer,
    slots: wgpu::Buffer,
    choices: wgpu::Buffer,
    links: wgpu::Buffer,
    ranks: wgpu::Buffer,
    heads: wgpu::Buffer,
    ordered: wgpu::Buffer,
    places: wgpu::Buffer,
    chains: wgpu::Buffer,
}

impl Buffers {
    fn new(gpu: &Gpu, capacity: u32) -> Self {
        let storage = wgpu::BufferUsages::STORAGE;
        let pieces = u64::from(capacity);
        let ends = 2 * pieces;
        let make = |label, bytes| buffer(gpu, label, bytes, storage);
        Self {
            plan: buffer(gpu, "chain plan", 16, storage | wgpu::BufferUsages::UNIFORM),
            arguments: buffer(gpu, "chain arguments", 36, storage | wgpu::BufferUsages::INDIRECT),
            progress: make("chain progress", 4),
            buckets: make("chain buckets", 4 * ends.next_power_of_two().max(256)),
            slots: make("chain slots", 16 * ends),
            choices: make("chain choices", 4 * ends),
            links: make("chain links", 4 * ends),
            ranks: make("chain ranks", 2 * 16 * ends),
            heads: make("chain heads", 4 * ends),
            ordered: make("ordered pieces", 4 * pieces),
            places: make("places", size_of::<Place>() as u64 * pieces),
            chains: make("chains", size_of::<Chain>() as u64 * pieces),
        }
    }
}

impl ChainPass {
    /// Builds the pipelines, and buffers for `capacity` pieces, [`MAX_PIECES`] at most; more than that are passed over.
    ///
    /// # Errors
    /// [`GpuError::Limit`] when a buffer is larger than the device can bind.
    pub fn new(gpu: &Gpu, capacity: u32, rules: ChainRules) -> Result<Self, GpuError> {
        let capacity = capacity.clamp(1, MAX_PIECES);
        let limits = gpu.device.limits();
        let limit = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        // Of the ranks, the largest.
        let wanted = 64 * u64::from(capacity);
        if wanted > limit {
            return Err(GpuError::Limit { what: "chaining lines", wanted, limit });
        }
        let mut pass = Self {
            begin: ComputePass::new(gpu, "lines/strokes/chain_begin"),
            clear: ComputePass::new(gpu, "lines/strokes/chain_clear"),
            bin: ComputePass::new(gpu, "lines/strokes/chain_bin"),
            choose: ComputePass::new(gpu, "lines/strokes/chain_choose"),
            link: ComputePass::new(gpu, "lines/strokes/chain_link"),
            rank_begin: ComputePass::new(gpu, "lines/strokes/chain_rank_begin"),
            rank: ComputePass::new(gpu, "lines/strokes/chain_rank"),
            heads: ComputePass::new(gpu, "lines/strokes/chain_heads"),
            order: ComputePass::new(gpu, "lines/strokes/chain_order"),
            scan: ScanPass::new(gpu),
            buckets_size: ScanSize::new(gpu, 2, MAX_VALUES),
            heads_size: ScanSize::new(gpu, 1, MAX_VALUES),
            turns: numbers(gpu, (LOOP_ROUNDS + RANK_ROUNDS) as u32),
            rules: GrowingBuffer::new(gpu, "chain rules", wgpu::BufferUsages::UNIFORM),
            capacity,
            buffers: Buffers::new(gpu, capacity),
        };
        pass.set_rules(gpu, rules);
        Ok(pass)
    }

    /// Rules for the frames that follow; numbers out of range are taken as the nearest in it.
    pub fn set_rules(&mut self, gpu: &Gpu, rules: ChainRules) {
        let rules = rules.in_range();
        self.rules.write(
            gpu,
            &[ChainRulesUniform {
                capacity: self.capacity,
                reach_units: rules.reach_units,
                least_cos_squared: rules.least_cos_squared,
                overlap_units: ChainRules::OVERLAP_UNITS,
            }],
        );
    }

    /// Reads `pieces`, an array of [`Piece`], as many as [`StrokeCounts::pieces`](super::StrokeCounts) in `counts` says;
    /// writes [`ChainPass::ordered`], [`ChainPass::places`], [`ChainPass::chains`] and the number of chains in `counts`.
    /// Both have the usage `STORAGE`.
    pub fn run(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, pieces: &wgpu::Buffer, counts: &wgpu::Buffer) {
        let own = &self.buffers;
        let rules = || ("rules", self.rules.binding());
        let plan = || bind("plan", &own.plan);
        let pieces = || bind("pieces", pieces);
        let progress = || bind("progress", &own.progress);
        let counts = || bind("counts", counts);
        let turn = |turn: usize| ("turn", self.turns[turn].binding());
        let stage = |stage: usize| ("stage", self.turns[stage].binding());

        let resources = [rules(), counts(), plan(), bind("arguments", &own.arguments), progress()];
        self.begin.run_groups(gpu, recorder, [1, 1], &resources);

        // Sort the ends by cells.
        let resources = [plan(), bind("buckets", &own.buckets)];
        self.clear.run_indirect(gpu, recorder, &own.arguments, PER_BUCKET, &resources);
        for step in 0..2 {
            let (buckets, slots) = (bind("buckets", &own.buckets), bind("slots", &own.slots));
            let resources = [stage(step), rules(), plan(), pieces(), buckets, slots];
            self.bin.run_indirect(gpu, recorder, &own.arguments, PER_END, &resources);
            if step == 0 {
                self.scan.run(gpu, recorder, &self.buckets_size, &own.plan, &own.buckets);
            }
        }

        // Join ends that choose each other.
        let links = || bind("links", &own.links);
        for round in 0..ChainRules::ROUNDS {
            let (buckets, slots) = (bind("buckets", &own.buckets), bind("slots", &own.slots));
            let choices = || bind("choices", &own.choices);
            let resources = [turn(round), rules(), plan(), pieces(), buckets, slots, links(), choices()];
            self.choose.run_indirect(gpu, recorder, &own.arguments, PER_END, &resources);
            let resources = [turn(round), plan(), choices(), links()];
            self.link.run_indirect(gpu, recorder, &own.arguments, PER_END, &resources);
        }

        // Rank the pieces of open chains, then of loops.
        let ranks = || bind("ranks", &own.ranks);
        for first in [0, LOOP_ROUNDS] {
            let resources = [stage(first), plan(), pieces(), links(), ranks(), progress()];
            self.rank_begin.run_indirect(gpu, recorder, &own.arguments, PER_END, &resources);
            for round in first..first + RANK_ROUNDS {
                let resources = [turn(round), plan(), ranks(), progress()];
                self.rank.run_indirect(gpu, recorder, &own.arguments, PER_END, &resources);
            }
        }

        // Put chains and pieces in order. Nobody asks for the choices any more: the states take their place.
        let states = || bind("states", &own.choices);
        let heads = || bind("heads", &own.heads);
        let resources = [plan(), pieces(), ranks(), progress(), states(), heads()];
        self.heads.run_indirect(gpu, recorder, &own.arguments, PER_PIECE, &resources);
        self.scan.run(gpu, recorder, &self.heads_size, &own.plan, &own.heads);
        let (ordered, places) = (bind("ordered", &own.ordered), bind("places", &own.places));
        let chains = bind("chains", &own.chains);
        let read = [plan(), pieces(), links(), ranks(), progress(), states(), heads()];
        let resources: Vec<Named> = read.into_iter().chain([ordered, places, chains, counts()]).collect();
        self.order.run_indirect(gpu, recorder, &own.arguments, PER_PIECE, &resources);
    }

    /// For each place the number of a piece, times two, plus 1 if it runs from b to a: `u32`, `STORAGE | COPY_SRC`. The
    /// pieces of a chain follow each other; chains stand in the order of the pieces that begin them.
    pub fn ordered(&self) -> &wgpu::Buffer {
        &self.buffers.ordered
    }

    /// For each place a [`Place`]: `STORAGE | COPY_SRC`.
    pub fn places(&self) -> &wgpu::Buffer {
        &self.buffers.places
    }

    /// The [`Chain`]s: `STORAGE | COPY_SRC`. How many there are stands in `counts`.
    pub fn chains(&self) -> &wgpu::Buffer {
        &self.buffers.chains
    }

    pub(super) fn named_chains(&self) -> Named<'_> {
        ("chains", self.buffers.chains.as_entire_binding())
    }

    /// Pieces that there is room for.
    pub fn capacity(&self) -> u32 {
        self.capacity
    }

    /// Bytes of `pieces` for that capacity.
    pub fn pieces_bytes(&self) -> u64 {
        size_of::<Piece>() as u64 * u64::from(self.capacity)
    }
}

fn bind<'a>(name: &'a str, buffer: &'a wgpu::Buffer) -> Named<'a> {
    (name, buffer.as_entire_binding())
}
