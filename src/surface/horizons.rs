//! Heights → what the land sees of the sun and of the sky. See `shaders/surface/horizons.wgsl`.

use bytemuck::{Pod, Zeroable};

use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{ComputePass, Named, WORKGROUP_PX, texture};
use crate::gpu::timer::Recorder;
use crate::tiles::horizon_maps::{HORIZON_MAP_SIDE, HorizonMaps};

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct HorizonsUniform {
    to_sun: [f32; 2],
    pad_a: f32,
    pad_b: f32,
}

crate::gpu::shared::describe!(HorizonsUniform as "Horizons" in "surface/horizons": to_sun, pad_a, pad_b);

/// The pass.
pub struct HorizonsPass {
    pass: ComputePass,
    uniform: GrowingBuffer,
    jobs: GrowingBuffer,
}

impl HorizonsPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            pass: ComputePass::new(gpu, "surface/horizons"),
            uniform: GrowingBuffer::new(gpu, "horizons", wgpu::BufferUsages::UNIFORM),
            jobs: GrowingBuffer::new(gpu, "seen jobs", wgpu::BufferUsages::STORAGE),
        }
    }

    /// Makes the tiles that `seen` has planned for this frame; none most of the time. Reads `terrain`.
    pub fn run(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, terrain: &[Named<'_>], seen: &HorizonMaps) {
        let jobs = seen.jobs();
        if jobs.is_empty() {
            return;
        }
        self.uniform.write(gpu, &[HorizonsUniform { to_sun: seen.to_sun().to_array(), pad_a: 0.0, pad_b: 0.0 }]);
        self.jobs.write(gpu, jobs);
        let mut resources = vec![
            ("horizons", self.uniform.binding()),
            ("jobs", self.jobs.binding()),
            ("seen_tiles", texture(seen.view())),
        ];
        resources.extend(terrain.iter().cloned());
        // Tiles stand below each other.
        let side = HORIZON_MAP_SIDE.div_ceil(WORKGROUP_PX);
        self.pass.run_groups(gpu, recorder, [side, side * jobs.len() as u32], &resources);
    }
}
