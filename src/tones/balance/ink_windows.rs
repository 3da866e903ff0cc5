//! How much darker marks have to be drawn. See `shaders/tones/balance/ink_windows.wgsl`.

use super::BalanceTargets;
use crate::gpu::Gpu;
use crate::gpu::pass::{ComputePass, texture};
use crate::gpu::timer::Recorder;

/// The pass.
pub struct InkWindowsPass(ComputePass);

impl InkWindowsPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self(ComputePass::new(gpu, "tones/balance/ink_windows"))
    }

    /// From `targets.sums` into `targets.more`.
    pub fn run(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, targets: &BalanceTargets) {
        let cells = [targets.sums.texture.width(), targets.sums.texture.height()];
        let resources = [("sums", texture(&targets.sums.view)), ("more", texture(&targets.more.view))];
        self.0.run(gpu, recorder, cells, &resources);
    }
}
