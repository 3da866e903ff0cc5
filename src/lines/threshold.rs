//! Errors → lines: density filter and ramp. See `shaders/lines/threshold.wgsl`.

use bytemuck::{Pod, Zeroable};

use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{ComputePass, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;
use crate::style::{Detector, Lines};

/// Lines: 0 none, 1 full.
pub const LINE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Float;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct ThresholdUniform {
    ramp: [f32; 2],
    density: f32,
    scalar: u32,
}

crate::gpu::shared::describe!(ThresholdUniform as "Threshold" in "lines/threshold": ramp, density, scalar);

/// The pass.
pub struct ThresholdPass {
    pass: ComputePass,
    uniform: GrowingBuffer,
}

impl ThresholdPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        let pass = ComputePass::new(gpu, "lines/threshold");
        Self { pass, uniform: GrowingBuffer::new(gpu, "threshold", wgpu::BufferUsages::UNIFORM) }
    }

    /// Reads `view`, `errors`; writes `line`.
    #[expect(clippy::too_many_arguments, reason = "a pass lists what it reads and writes")]
    pub fn run(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        lines: &Lines,
        view: wgpu::BindingResource<'_>,
        errors: &Target,
        line: &Target,
    ) {
        let scalar = u32::from(lines.detector != Detector::Lsa);
        self.uniform.write(gpu, &[ThresholdUniform { ramp: lines.ramp, density: lines.density, scalar }]);
        let resources = [
            ("view", view),
            ("threshold", self.uniform.binding()),
            ("errors", texture(&errors.view)),
            ("line", texture(&line.view)),
        ];
        self.pass.run(gpu, recorder, size_px, &resources);
    }
}
