//! Finds the contour edges of the patches. See `shaders/lines/strokes/contour_edges.wgsl`.

use super::Lists;
use crate::gpu::Gpu;
use crate::gpu::pass::{ComputePass, Named};
use crate::gpu::timer::Recorder;
use crate::surface::vertices::VerticesPass;

/// The pass.
pub struct ContourEdgesPass {
    pass: ComputePass,
}

/// What it reads.
pub struct Inputs<'a> {
    /// `View`.
    pub view: wgpu::BindingResource<'a>,
    /// What `shaders/shared/terrain.wgsl` and `shared/surface.wgsl` declare.
    pub terrain: &'a [Named<'a>],
    /// First patch and number of patches of the batch.
    pub batch: [u32; 2],
    /// The patches and their vertices.
    pub mesh: &'a VerticesPass,
}

impl ContourEdgesPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self { pass: ComputePass::new(gpu, "lines/strokes/contour_edges") }
    }

    /// Adds the edges of a batch to the list.
    pub fn run(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, lists: &Lists) {
        if inputs.batch[1] == 0 {
            return;
        }
        let mut resources = vec![
            ("view", inputs.view.clone()),
            ("patches", inputs.mesh.patches(inputs.batch)),
            ("positions", inputs.mesh.positions().as_entire_binding()),
            ("strokes", lists.uniform.binding()),
            ("edges", lists.edges.binding()),
            ("edge_draw", lists.edge_draw.binding()),
        ];
        resources.extend(inputs.terrain.iter().cloned());
        self.pass.run_groups(gpu, recorder, [inputs.batch[1], 1], &resources);
    }
}
