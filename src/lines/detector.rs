//! The baselines that LSA contours are compared with: Sobel on depth and Roystan's outline. See
//! `shaders/lines/sobel.wgsl` and `shaders/lines/roystan.wgsl`.

use crate::gpu::Gpu;
use crate::gpu::pass::{ComputePass, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;

/// Errors of four axes, from 0; detectors that know no axes write the same four times.
pub const ERRORS_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// Sobel's operator on the distance along the view axis.
pub struct SobelPass(ComputePass);

impl SobelPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self(ComputePass::new(gpu, "lines/sobel"))
    }

    /// Reads `view`, `position`; writes `errors`.
    pub fn run(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        view: wgpu::BindingResource<'_>,
        position: &Target,
        errors: &Target,
    ) {
        let resources = [("view", view), ("position", texture(&position.view)), ("errors", texture(&errors.view))];
        self.0.run(gpu, recorder, size_px, &resources);
    }
}

/// Roystan's Roberts crosses on depth and normals.
pub struct RoystanPass(ComputePass);

impl RoystanPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self(ComputePass::new(gpu, "lines/roystan"))
    }

    /// Reads `view`, `position`, `normal`; writes `errors`.
    #[expect(clippy::too_many_arguments, reason = "a pass lists what it reads and writes")]
    pub fn run(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        view: wgpu::BindingResource<'_>,
        position: &Target,
        normal: &Target,
        errors: &Target,
    ) {
        let resources = [
            ("view", view),
            ("position", texture(&position.view)),
            ("normal", texture(&normal.view)),
            ("errors", texture(&errors.view)),
        ];
        self.0.run(gpu, recorder, size_px, &resources);
    }
}
