//! The ID reference image → the list of visible pieces. See `shaders/lines/strokes/extract.wgsl`.

use super::Lists;
use crate::gpu::Gpu;
use crate::gpu::pass::{ComputePass, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;

/// The pass.
pub struct ExtractPass {
    pass: ComputePass,
}

impl ExtractPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self { pass: ComputePass::new(gpu, "lines/strokes/extract") }
    }

    /// Reads `view`, `edges`, `ids`; writes `pieces` and their number.
    pub fn run(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        view: wgpu::BindingResource<'_>,
        ids: &Target,
        lists: &Lists,
    ) {
        let resources = [
            ("view", view),
            lists.strokes(),
            ("edges", lists.edges.binding()),
            ("ids", texture(&ids.view)),
            ("pieces", lists.pieces.binding()),
            lists.counts(),
        ];
        self.pass.run(gpu, recorder, [ids.texture.width(), ids.texture.height()], &resources);
    }
}
