//! Chains of line pieces: the GPU's are the twin's, to the bit, and they are what chains must be.
//!
//! 10,000 inputs: 9,400 small scenes (none to some 40 pieces; 21 kinds) that lie 1024 px apart in planes of 470, and 600
//! that have the GPU to themselves. Each scene of a plane is compared with the twin of that scene alone: chains stand in
//! the order of their first pieces, so a scene's chains are a stretch of the plane's.
#![allow(clippy::unwrap_used, reason = "a test fails by it")]

#[path = "../common/mod.rs"]
mod common;

mod must;
mod scenes;
mod sums;
mod twin;

use hachure::gpu::Gpu;
use hachure::gpu::buffer::{Buffer, BufferKind};
use hachure::gpu::pools::Pools;
use hachure::gpu::readback::read_buffer;
use hachure::gpu::recorder::{Cx, Submits};
use hachure::gpu::timer::Timer;
use hachure::lines::strokes::chain;
use hachure::lines::strokes::twin::Chained;
use hachure::lines::strokes::{ChainRules, Piece, PieceInOrder, Place, StrokeCounts};

/// A GPU and what chaining needs there.
struct Bench {
    gpu: Gpu,
    timer: Timer,
    pools: Pools,
    capacity: u32,
    rules: ChainRules,
    pieces: Buffer,
    counts: Buffer,
}

impl Bench {
    fn new(capacity: u32, rules: ChainRules) -> Option<Self> {
        let gpu = common::gpu()?;
        chain::check(&gpu, capacity).unwrap();
        let buffer = |size| Buffer::new(&gpu, &BufferKind::storage("test"), size as u64);
        let (pieces, counts) = (buffer(capacity as usize * size_of::<Piece>()), buffer(size_of::<StrokeCounts>()));
        let (timer, pools) = (Timer::new(&gpu).unwrap(), Pools::new(&gpu));
        Some(Self { timer, pools, gpu, capacity, rules, pieces, counts })
    }

    fn upload(&self, pieces: &[Piece], said: u32) {
        self.gpu.queue.write_buffer(&self.pieces.raw, 0, bytemuck::cast_slice(pieces));
        // What a frame before left must not matter.
        let counts = StrokeCounts { pieces: said, chains: 77, points: 5, ..StrokeCounts::default() };
        self.gpu.queue.write_buffer(&self.counts.raw, 0, bytemuck::bytes_of(&counts));
    }

    fn run(&mut self) {
        let Self { gpu, timer, pools, capacity, rules, pieces, counts } = self;
        let mut cx = Cx::new(gpu, pools, timer, Submits::default(), false);
        chain::run(&mut cx, &chain::Inputs { rules: *rules, capacity: *capacity, pieces, counts });
        cx.submit();
        self.gpu.wait();
    }

    fn chain(&mut self, pieces: &[Piece]) -> Chained {
        self.upload(pieces, pieces.len() as u32);
        self.run();
        self.read(pieces.len())
    }

    fn read(&self, pieces: usize) -> Chained {
        self.gpu.check().unwrap();
        let counts = read_buffer::<StrokeCounts>(&self.gpu, &self.counts.raw, 1).unwrap()[0];
        let raw = |kind| self.pools.buffers.get(kind).unwrap().raw;
        assert_eq!(counts.points, 5, "only the number of chains is ours");
        let pieces: Vec<PieceInOrder> = read_buffer(&self.gpu, &raw(&chain::PLACES), pieces).unwrap();
        Chained {
            ordered: pieces.iter().map(|piece| piece.state).collect(),
            chains: read_buffer(&self.gpu, &raw(&chain::CHAINS), counts.chains as usize).unwrap(),
            places: pieces
                .iter()
                .map(|&PieceInOrder { chain, begin_units, .. }| Place { chain, begin_units })
                .collect(),
        }
    }
}
