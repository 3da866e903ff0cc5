//! Finds the edges of the meshes that are near enough. See `shaders/lines/strokes/mesh_edges.wgsl`, and
//! `mesh_sides.wgsl` for what each triangle knows of itself before.

use super::Lists;
use super::mesh_sides::MeshSidesPass;
use super::scan::{Ordered, ScanPass};
use crate::gpu::Gpu;
use crate::gpu::pass::ComputePass;
use crate::gpu::timer::Recorder;
use crate::surface::mesh_vertices::{MeshVerticesPass, groups};

/// The pass.
pub struct MeshEdgesPass {
    sides: MeshSidesPass,
    pass: ComputePass,
    ordered: Ordered,
}

impl MeshEdgesPass {
    /// Builds the pipelines.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            sides: MeshSidesPass::new(gpu),
            pass: ComputePass::new(gpu, "lines/strokes/mesh_edges"),
            ordered: Ordered::new(gpu, 3),
        }
    }

    /// Adds the edges to the list.
    pub fn run(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        view: wgpu::BindingResource<'_>,
        meshes: &MeshVerticesPass,
        lists: &Lists,
        scan: &ScanPass,
    ) {
        if meshes.near_triangles() == 0 {
            return;
        }
        self.sides.run(gpu, recorder, meshes);
        let mut resources = vec![
            ("view", view),
            ("mesh_sides", self.sides.sides()),
            ("strokes", lists.uniform.binding()),
            ("edges", lists.edges.binding()),
            ("edge_draw", lists.edge_draw.binding()),
        ];
        resources.extend(meshes.resources());
        let groups = groups(meshes.near_triangles());
        self.ordered.run(gpu, recorder, &self.pass, scan, groups, 0, &resources);
    }
}
