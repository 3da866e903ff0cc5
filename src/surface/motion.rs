//! Exact screen motion of every pixel. See `shaders/surface/motion.wgsl`.

use crate::gpu::Gpu;
use crate::gpu::pass::{ComputePass, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;

/// Pixels from the previous frame to this one: x right, y down.
pub const MOTION_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rg32Float;

/// The pass.
pub struct MotionPass(ComputePass);

impl MotionPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self(ComputePass::new(gpu, "surface/motion"))
    }

    /// Reads `view`, `position`; writes `motion`.
    pub fn run(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        view: wgpu::BindingResource<'_>,
        position: &Target,
        motion: &Target,
    ) {
        let resources = [("view", view), ("position", texture(&position.view)), ("motion", texture(&motion.view))];
        self.0.run(gpu, recorder, size_px, &resources);
    }
}
