//! The vertices of the selected patches, morphed. See `shaders/surface/vertices.wgsl`.

use std::num::NonZeroU64;

use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{ComputePass, Named};
use crate::gpu::readback;
use crate::gpu::timer::Recorder;
use crate::gpu::{Gpu, GpuError};
use crate::pyramid::tile::PATCH_QUADS;
use crate::tiles::selection::{PatchInstance, Selection};

/// Vertices of a patch.
const VERTICES: u32 = (PATCH_QUADS + 1) * (PATCH_QUADS + 1);
/// Threads of a workgroup; the shader says `@workgroup_size(64)`.
const WORKGROUP: u32 = 64;
/// Bytes of a position.
const POSITION_BYTES: u64 = 16;
/// Patches of a batch come in multiples of this: 16 × 48 bytes are three times the largest alignment of offsets.
const BATCH_STEP: u32 = 16;

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
            // Measurements read it back.
            positions: GrowingBuffer::new(gpu, "vertices", Usage::STORAGE | Usage::COPY_SRC),
        }
    }

    /// Uploads the patches of a selection. They are placed and drawn in batches, which this returns: first patch and
    /// number of patches. One is enough for pictures of usual size and error.
    pub fn upload(&mut self, gpu: &Gpu, selection: &Selection) -> Vec<[u32; 2]> {
        let instances: Vec<PatchInstance> = [selection.solid.as_slice(), &selection.with_holes].concat();
        self.patches.write(gpu, &instances);
        let count = instances.len() as u32;
        let limits = gpu.device.limits();
        let room = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let most =
            (room / (u64::from(VERTICES) * POSITION_BYTES)).min(u64::from(limits.max_compute_workgroups_per_dimension));
        // A batch's part of the patches is bound by its offset, which has to be aligned.
        let most = (most as u32 / BATCH_STEP).max(1) * BATCH_STEP;
        self.positions.reserve_exactly(gpu, u64::from(count.min(most)) * u64::from(VERTICES) * POSITION_BYTES);
        // A selection of nothing still clears the targets.
        (0..count.max(1)).step_by(most as usize).map(|first| [first, most.min(count - first)]).collect()
    }

    /// Places the vertices of a batch. Reads its patches and `terrain`; writes `positions`.
    pub fn run(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, batch: [u32; 2], terrain: &[Named<'_>]) {
        let mut resources = vec![("patches", self.patches(batch)), ("positions", self.positions.binding())];
        resources.extend(terrain.iter().cloned());
        let groups = [VERTICES.div_ceil(WORKGROUP), batch[1]];
        self.pass.run_groups(gpu, recorder, groups, &resources);
    }

    /// The patches of a batch: `Patch` in `shaders/shared/patch.wgsl`.
    pub fn patches(&self, batch: [u32; 2]) -> wgpu::BindingResource<'_> {
        let size = size_of::<PatchInstance>() as u64;
        let bytes = NonZeroU64::new(u64::from(batch[1].max(1)) * size);
        wgpu::BindingResource::Buffer(wgpu::BufferBinding {
            buffer: self.patches.buffer(),
            offset: u64::from(batch[0]) * size,
            size: bytes,
        })
    }

    /// The vertices of the last batch, 17 × 17 for each patch, row by row: camera-relative metres.
    pub fn positions(&self) -> &wgpu::Buffer {
        self.positions.buffer()
    }

    /// Reads [`VerticesPass::positions`] of a selection of so many patches back; none when it was drawn in several
    /// batches, since only the last of them is left.
    ///
    /// # Errors
    /// As [`readback::read_buffer`].
    pub fn read(&self, gpu: &Gpu, patches: usize) -> Result<Option<Vec<[f32; 4]>>, GpuError> {
        let count = patches * VERTICES as usize;
        if count as u64 * POSITION_BYTES > self.positions.buffer().size() {
            return Ok(None);
        }
        readback::read_buffer(gpu, self.positions.buffer(), count).map(Some)
    }
}
