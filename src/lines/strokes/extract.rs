//! The ID reference image → the list of visible pieces. See `shaders/lines/strokes/extract.wgsl`.

use super::Lists;
use super::scan::{Ordered, ScanPass};
use crate::gpu::Gpu;
use crate::gpu::pass::{ComputePass, WORKGROUP_PX, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;

/// The pass.
pub struct ExtractPass {
    pass: ComputePass,
    ordered: Ordered,
}

impl ExtractPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self { pass: ComputePass::new(gpu, "lines/strokes/extract"), ordered: Ordered::new(gpu, 2) }
    }

    /// Reads `view`, `edges`, `ids`; writes `pieces` and their number.
    pub fn run(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        view: wgpu::BindingResource<'_>,
        ids: &Target,
        lists: &Lists,
        scan: &ScanPass,
    ) {
        let resources = [
            ("view", view),
            lists.strokes(),
            ("edges", lists.edges.binding()),
            ("ids", texture(&ids.view)),
            ("pieces", lists.pieces.binding()),
            lists.counts(),
        ];
        let groups = [ids.texture.width(), ids.texture.height()].map(|side| side.div_ceil(WORKGROUP_PX));
        self.ordered.run(gpu, recorder, &self.pass, scan, groups, 0, &resources);
    }
}
