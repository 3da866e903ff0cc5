//! Ink that is wanting, in cells. See `shaders/tones/balance/ink_sums.wgsl`.

use super::BalanceTargets;
use crate::gpu::Gpu;
use crate::gpu::pass::{ComputePass, texture};
use crate::gpu::timer::Recorder;

/// Of a workgroup.
const CELLS: u32 = 8;

/// The pass.
pub struct InkSumsPass(ComputePass);

impl InkSumsPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self(ComputePass::new(gpu, "tones/balance/ink_sums"))
    }

    /// From `targets.cover` into `targets.sums`.
    pub fn run(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        view: wgpu::BindingResource<'_>,
        targets: &BalanceTargets,
    ) {
        let [columns, rows] = [targets.sums.texture.width(), targets.sums.texture.height()];
        let resources = [
            ("view", view),
            ("balance", targets.uniform()),
            ("cover", texture(&targets.cover.view)),
            ("sums", texture(&targets.sums.view)),
        ];
        self.0.run_groups(gpu, recorder, [columns.div_ceil(CELLS), rows], &resources);
    }
}
