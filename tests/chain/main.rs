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
use hachure::gpu::readback::read_buffer;
use hachure::gpu::timer::Timer;
use hachure::lines::strokes::chain::ChainPass;
use hachure::lines::strokes::twin::Chained;
use hachure::lines::strokes::{ChainRules, Piece, StrokeCounts};

/// A GPU and what chaining needs there.
struct Bench {
    gpu: Gpu,
    timer: Timer,
    pass: ChainPass,
    pieces: wgpu::Buffer,
    counts: wgpu::Buffer,
}

impl Bench {
    fn new(capacity: u32, rules: ChainRules) -> Option<Self> {
        let gpu = common::gpu()?;
        let pass = ChainPass::new(&gpu, capacity, rules).unwrap();
        let buffer = |size| {
            let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
            gpu.device.create_buffer(&wgpu::BufferDescriptor { label: None, size, usage, mapped_at_creation: false })
        };
        let (pieces, counts) = (buffer(pass.pieces_bytes()), buffer(size_of::<StrokeCounts>() as u64));
        Some(Self { timer: Timer::new(&gpu).unwrap(), gpu, pass, pieces, counts })
    }

    fn upload(&self, pieces: &[Piece], said: u32) {
        self.gpu.queue.write_buffer(&self.pieces, 0, bytemuck::cast_slice(pieces));
        // What a frame before left must not matter.
        let counts = StrokeCounts { pieces: said, chains: 77, points: 5, ..StrokeCounts::default() };
        self.gpu.queue.write_buffer(&self.counts, 0, bytemuck::bytes_of(&counts));
    }

    fn run(&mut self) {
        let mut recorder = self.timer.record(&self.gpu);
        self.pass.run(&self.gpu, &mut recorder, &self.pieces, &self.counts);
        recorder.submit();
        self.gpu.wait();
    }

    fn chain(&mut self, pieces: &[Piece]) -> Chained {
        self.upload(pieces, pieces.len() as u32);
        self.run();
        self.read(pieces.len())
    }

    fn read(&self, pieces: usize) -> Chained {
        self.gpu.check().unwrap();
        let counts = read_buffer::<StrokeCounts>(&self.gpu, &self.counts, 1).unwrap()[0];
        assert_eq!(counts.points, 5, "only the number of chains is ours");
        Chained {
            ordered: read_buffer(&self.gpu, self.pass.ordered(), pieces).unwrap(),
            chains: read_buffer(&self.gpu, self.pass.chains(), counts.chains as usize).unwrap(),
            places: read_buffer(&self.gpu, self.pass.places(), pieces).unwrap(),
        }
    }
}
