//! The ink of marks. See `shaders/tones/balance/balanced_ink.wgsl`.

use super::BalanceTargets;
use crate::gpu::Gpu;
use crate::gpu::pass::{ComputePass, texture};
use crate::gpu::timer::Recorder;

/// The pass.
pub struct BalancedInkPass(ComputePass);

impl BalancedInkPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self(ComputePass::new(gpu, "tones/balance/balanced_ink"))
    }

    /// From `targets.cover` and `targets.more` into `targets.marks`.
    pub fn run(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        view: wgpu::BindingResource<'_>,
        targets: &BalanceTargets,
    ) {
        let resources = [
            ("view", view),
            ("balance", targets.uniform()),
            ("cover", texture(&targets.cover.view)),
            ("more", texture(&targets.more.view)),
            ("marks", texture(&targets.marks.view)),
        ];
        self.0.run(gpu, recorder, size_px, &resources);
    }
}
