//! Position and normal of the meshes, over those of the land. See `shaders/surface/mesh_resolve.wgsl`.

use super::mesh_vertices::MeshVerticesPass;
use crate::gpu::Gpu;
use crate::gpu::pass::{ComputePass, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;

/// The pass.
pub struct MeshResolvePass(ComputePass);

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: wgpu::BindingResource<'a>,
    /// The meshes and their vertices.
    pub meshes: &'a MeshVerticesPass,
    /// Which triangle.
    pub surface_id: &'a Target,
    /// As it was rasterised.
    pub depth: &'a Target,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
}

impl MeshResolvePass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self(ComputePass::new(gpu, "surface/mesh_resolve"))
    }

    /// Writes `position` and `normal` where a mesh is seen.
    pub fn run(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, size_px: [u32; 2], inputs: &Inputs<'_>) {
        if inputs.meshes.seen().is_empty() {
            return;
        }
        let mut resources = vec![
            ("view", inputs.view.clone()),
            ("surface_id", texture(&inputs.surface_id.view)),
            ("depth", texture(&inputs.depth.view)),
            ("position", texture(&inputs.position.view)),
            ("normal", texture(&inputs.normal.view)),
        ];
        resources.extend(inputs.meshes.resources());
        self.0.run(gpu, recorder, size_px, &resources);
    }
}
