//! Anti-aliasing of lines. See `shaders/lines/smooth.wgsl`.
//!
//! Why: `docs/decisions/line-smoothing.md`.

use crate::gpu::Gpu;
use crate::gpu::pass::{ComputePass, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;

/// The pass.
pub struct SmoothPass(ComputePass);

impl SmoothPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self(ComputePass::new(gpu, "lines/smooth"))
    }

    /// Reads `view`, `line`; writes `smoothed`.
    pub fn run(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        view: wgpu::BindingResource<'_>,
        line: &Target,
        smoothed: &Target,
    ) {
        let resources = [("view", view), ("line", texture(&line.view)), ("smoothed", texture(&smoothed.view))];
        self.0.run(gpu, recorder, size_px, &resources);
    }
}
