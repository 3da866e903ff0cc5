//! Chains of line segments on the GPU: they equal those of the CPU twin bit for bit, and satisfy the definition of
//! chains.
//!
//! There are 10,000 inputs: 9,400 small scenes (0 to about 40 segments, of 21 kinds), placed 1024 px apart in planes of
//! 470, and 600 that each use the GPU alone. Each scene of a plane is compared with the twin's result for that scene
//! alone: chains are ordered by their first segments, so the chains of a scene are a contiguous range of the plane's.
//! The fast tier has one plane for each of the rules, and 40 inputs that use the GPU alone.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use crate::tests::common;

mod must;
mod scenes;
mod sums;
mod twin;

use hachure::gpu::Gpu;
use hachure::gpu::buffer::{Buffer, BufferKind};
use hachure::gpu::pools::Pools;
use hachure::gpu::readback::read_buffer;
use hachure::gpu::recorder::{Recorder, Submits};
use hachure::gpu::timer::Timer;
use hachure::lines::strokes::chain;
use hachure::lines::strokes::twin::Chained;
use hachure::lines::strokes::{ChainPosition, ChainRules, Segment, SegmentInOrder, StrokeCounts};

/// A GPU with the buffers that chaining needs.
struct Bench {
    gpu: Gpu,
    timer: Timer,
    pools: Pools,
    capacity: u32,
    rules: ChainRules,
    segments: Buffer,
    counts: Buffer,
}

impl Bench {
    fn new(capacity: u32, rules: ChainRules) -> Option<Self> {
        let gpu = common::gpu()?;
        chain::check(&gpu, capacity).unwrap();
        let buffer = |size| Buffer::new(&gpu, &BufferKind::storage("test"), size as u64);
        let (segments, counts) = (buffer(capacity as usize * size_of::<Segment>()), buffer(size_of::<StrokeCounts>()));
        let (timer, pools) = (Timer::new(&gpu).unwrap(), Pools::new(&gpu));
        Some(Self { timer, pools, gpu, capacity, rules, segments, counts })
    }

    fn upload(&self, segments: &[Segment], said: u32) {
        self.gpu.queue.write_buffer(&self.segments.raw, 0, bytemuck::cast_slice(segments));
        // Counts that remain from an earlier frame must have no effect.
        let counts = StrokeCounts { segments: said, chains: 77, points: 5, ..StrokeCounts::default() };
        self.gpu.queue.write_buffer(&self.counts.raw, 0, bytemuck::bytes_of(&counts));
    }

    fn run(&mut self) {
        let Self { gpu, timer, pools, capacity, rules, segments, counts } = self;
        let mut recorder = Recorder::new(gpu, pools, timer, Submits::default(), false);
        chain::run(&mut recorder, &chain::Inputs { rules: *rules, capacity: *capacity, segments, counts });
        recorder.submit().unwrap();
        self.gpu.wait();
    }

    fn chain(&mut self, segments: &[Segment]) -> Chained {
        self.upload(segments, segments.len() as u32);
        self.run();
        self.read(segments.len())
    }

    fn read(&self, segments: usize) -> Chained {
        self.gpu.check().unwrap();
        let counts = read_buffer::<StrokeCounts>(&self.gpu, &self.counts.raw, 1).unwrap()[0];
        let raw = |kind| self.pools.buffers.get(kind).unwrap().raw;
        assert_eq!(counts.points, 5, "chaining may write only the number of chains");
        let segments: Vec<SegmentInOrder> = read_buffer(&self.gpu, &raw(&chain::PLACES), segments).unwrap();
        Chained {
            ordered: segments.iter().map(|segment| segment.state).collect(),
            chains: read_buffer(&self.gpu, &raw(&chain::CHAINS), counts.chains as usize).unwrap(),
            places: segments
                .iter()
                .map(|&SegmentInOrder { chain, begin_units, .. }| ChainPosition { chain, begin_units })
                .collect(),
        }
    }
}
