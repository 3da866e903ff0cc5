//! Which triangles of the meshes face the eye. See `shaders/lines/strokes/mesh_sides.wgsl`.

use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::ComputePass;
use crate::gpu::timer::Recorder;
use crate::surface::mesh_vertices::{MeshVerticesPass, groups};

/// Bytes for each triangle: its normal and its side.
const SIDE_BYTES: u64 = 16;

/// The pass, and what it writes.
pub struct MeshSidesPass {
    pass: ComputePass,
    sides: GrowingBuffer,
}

impl MeshSidesPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            pass: ComputePass::new(gpu, "lines/strokes/mesh_sides"),
            sides: GrowingBuffer::new(gpu, "mesh sides", wgpu::BufferUsages::STORAGE),
        }
    }

    /// Decides for each triangle that is near enough.
    pub fn run(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, meshes: &MeshVerticesPass) {
        self.sides.reserve_exactly(gpu, u64::from(meshes.near_triangles()) * SIDE_BYTES);
        let mut resources = vec![("mesh_sides", self.sides.binding())];
        resources.extend(meshes.resources());
        self.pass.run_groups(gpu, recorder, groups(meshes.near_triangles()), &resources);
    }

    /// What it wrote.
    pub fn sides(&self) -> wgpu::BindingResource<'_> {
        self.sides.binding()
    }
}
