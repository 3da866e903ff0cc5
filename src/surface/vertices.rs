//! The vertices of the selected patches, morphed. See `shaders/surface/vertices.wgsl`.

use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{ComputePass, Named};
use crate::gpu::timer::Recorder;
use crate::pyramid::PATCH_QUADS;
use crate::tiles::selection::{PatchInstance, Selection};

/// Vertices of a patch.
const VERTICES: u32 = (PATCH_QUADS + 1) * (PATCH_QUADS + 1);
/// Threads of a workgroup; the shader says `@workgroup_size(64)`.
const WORKGROUP: u32 = 64;
/// Bytes of a position.
const POSITION_BYTES: u64 = 16;

/// The pass, and the mesh that it makes.
pub struct VerticesPass {
    pass: ComputePass,
    patches: GrowingBuffer,
    positions: GrowingBuffer,
}

impl VerticesPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        use wgpu::BufferUsages as Usage;
        Self {
            pass: ComputePass::new(gpu, "surface/vertices"),
            patches: GrowingBuffer::new(gpu, "patches", Usage::STORAGE),
            positions: GrowingBuffer::new(gpu, "vertices", Usage::STORAGE),
        }
    }

    /// Reads the patches of `selection` and `terrain`; writes `positions`.
    pub fn run(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, selection: &Selection, terrain: &[Named<'_>]) {
        // A dispatch has no more groups in y than this; a selection within its error bound stays far below.
        let most = gpu.device.limits().max_compute_workgroups_per_dimension as usize;
        let instances: Vec<PatchInstance> =
            selection.solid.iter().chain(&selection.with_holes).take(most).copied().collect();
        self.patches.write(gpu, &instances);
        self.positions.reserve(gpu, instances.len() as u64 * u64::from(VERTICES) * POSITION_BYTES);
        let mut resources = vec![("patches", self.patches.binding()), ("positions", self.positions.binding())];
        resources.extend(terrain.iter().cloned());
        let groups = [VERTICES.div_ceil(WORKGROUP), instances.len() as u32];
        self.pass.run_groups(gpu, recorder, groups, &resources);
    }

    /// The patches of the last run: `Patch` in `shaders/shared/patch.wgsl`.
    pub fn patches(&self) -> &wgpu::Buffer {
        self.patches.buffer()
    }

    /// Their vertices, 17 × 17 each, row by row: camera-relative metres.
    pub fn positions(&self) -> &wgpu::Buffer {
        self.positions.buffer()
    }
}
