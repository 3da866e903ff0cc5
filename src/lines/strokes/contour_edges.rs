//! Finds the contour edges of the patches. See `shaders/lines/strokes/contour_edges.wgsl`.

use super::Lists;
use super::scan::{Ordered, ScanPass};
use crate::gpu::Gpu;
use crate::gpu::pass::{ComputePass, Named};
use crate::gpu::timer::Recorder;
use crate::pyramid::tile::PATCH_QUADS;
use crate::surface::vertices::VerticesPass;

/// The pass.
pub struct ContourEdgesPass {
    pass: ComputePass,
    ordered: Ordered,
}

/// Quads of a patch: what each has found is kept from stage to stage.
const KEPT: u64 = (PATCH_QUADS * PATCH_QUADS) as u64;

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
        Self { pass: ComputePass::new(gpu, "lines/strokes/contour_edges"), ordered: Ordered::new(gpu, 3) }
    }

    /// Adds the edges of a batch to the list.
    pub fn run(&mut self, gpu: &Gpu, recorder: &mut Recorder<'_>, inputs: &Inputs<'_>, lists: &Lists, scan: &ScanPass) {
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
        self.ordered.run(gpu, recorder, &self.pass, scan, [inputs.batch[1], 1], KEPT, &resources);
    }
}
