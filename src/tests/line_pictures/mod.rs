//! Tests the passes that draw line pictures, and those that composite and present the picture, against CPU twins in
//! f64, which are written from the descriptions in the shaders. For each twin a wrong constant is planted, which must
//! be detected.
#![allow(clippy::unwrap_used, reason = "a test may panic")]

use crate::tests::common;

mod composite;
mod detectors;
mod present;
mod smooth;

use glam::DVec3;
use hachure::gpu::Gpu;
use hachure::gpu::pools::Pools;
use hachure::gpu::recorder::{Recorder, Submits};
use hachure::gpu::target::{Target, TargetKind};
use hachure::gpu::timer::Timer;
use hachure::scene::view::{Pose, View};

use crate::tests::common::draw;

/// Size of the pictures; not a multiple of a workgroup's side.
const SIZE_PX: [u32; 2] = [61, 43];

/// A GPU and everything that recording passes needs.
struct Bench {
    gpu: Gpu,
    pools: Pools,
    timer: Timer,
}

impl Bench {
    fn new() -> Option<Self> {
        let gpu = common::gpu()?;
        Some(Self { pools: Pools::new(&gpu), timer: Timer::new(&gpu).unwrap(), gpu })
    }

    /// Records passes, submits them and waits.
    fn run(&mut self, record: impl FnOnce(&mut Recorder<'_>)) {
        let mut recorder = Recorder::new(&self.gpu, &mut self.pools, &mut self.timer, Submits::default(), false);
        record(&mut recorder);
        let is_complete = recorder.is_complete();
        recorder.submit().unwrap();
        assert!(is_complete, "{:?}", self.gpu.pipelines().shader_errors());
        self.gpu.wait();
        self.gpu.check().unwrap();
    }

    /// Returns a target of a kind that a pass accepts, filled with texels.
    fn picture<T: bytemuck::Pod>(&self, kind: &TargetKind, size_px: [u32; 2], texels: &[T]) -> Target {
        let kind = TargetKind {
            usage: kind.usage | wgpu::TextureUsages::COPY_DST,
            ..TargetKind::storage(kind.name, kind.format, kind.content)
        };
        let target = Target::new(&self.gpu, &kind, size_px);
        let [width, height] = size_px;
        self.gpu.queue.write_texture(
            target.texture.as_image_copy(),
            bytemuck::cast_slice(texels),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * size_of::<T>() as u32),
                rows_per_image: Some(height),
            },
            wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        );
        target
    }

    /// Returns an empty target.
    fn out(&self, kind: &TargetKind) -> Target {
        Target::new(&self.gpu, kind, SIZE_PX)
    }

    fn halves(&self, target: &Target) -> Vec<[f64; 4]> {
        draw::halves(&self.gpu, target)
    }

    fn floats(&self, target: &Target) -> Vec<f64> {
        draw::floats(&self.gpu, target).into_iter().map(|[value]| value.into()).collect()
    }
}

/// Returns a view to the north and a little down; at distance d a pixel is d / 100 wide.
fn view() -> View {
    let forward = DVec3::new(0.1, 1.0, -0.2).normalize();
    let right = forward.cross(DVec3::Z).normalize();
    let fov_rad = 2.0 * (f64::from(SIZE_PX[1]) / 200.0).atan();
    let pose = Pose { position_m: DVec3::ZERO, forward, right, up: right.cross(forward), fov_rad };
    View::whole(pose, pose, SIZE_PX)
}

/// Returns the texels as the GPU stores them.
fn bits<const CHANNELS: usize>(texels: &[[half::f16; CHANNELS]]) -> Vec<[u16; CHANNELS]> {
    texels.iter().map(|texel| texel.map(half::f16::to_bits)).collect()
}

/// Returns a pseudorandom number of 0 to 1, determined by a pixel and a seed.
fn chance(x: i64, y: i64, turn: i64) -> f64 {
    let mut bits = (x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b) ^ turn.wrapping_mul(0xc2b2_ae35)) as u64;
    for _ in 0..3 {
        bits ^= bits >> 31;
        bits = bits.wrapping_mul(0x7fb5_d329_728e_a185);
    }
    (bits >> 40) as f64 / f64::from(1 << 24)
}

/// Returns column and row of every pixel, row by row.
fn places() -> impl Iterator<Item = (i64, i64)> {
    let [width, height] = SIZE_PX.map(i64::from);
    (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}

/// Returns the index of the nearest pixel in the picture.
fn inside(x: i64, y: i64) -> usize {
    let [width, height] = SIZE_PX.map(i64::from);
    (y.clamp(0, height - 1) * width + x.clamp(0, width - 1)) as usize
}

/// Counts pixels that differ by more than `most`.
fn off(found: &[f64], expected: &[f64], most: f64) -> usize {
    assert_eq!(found.len(), expected.len());
    found.iter().zip(expected).filter(|(a, b)| (*a - *b).abs() > most || a.is_nan()).count()
}
