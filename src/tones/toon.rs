//! Light in a few steps. See `shaders/tones/toon.wgsl`.

use bytemuck::{Pod, Zeroable};

use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{ComputePass, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;
use crate::style::Toon;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct ToonUniform {
    to_sun: [f32; 3],
    steps: f32,
    darkest: f32,
    softness: f32,
    lightest: f32,
    wash: f32,
}

crate::gpu::shared::describe!(ToonUniform as "Toon" in "tones/toon": to_sun, steps, darkest, softness, lightest, wash);

/// The pass.
pub struct ToonPass {
    pass: ComputePass,
    uniform: GrowingBuffer,
}

impl ToonPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        let pass = ComputePass::new(gpu, "tones/toon");
        Self { pass, uniform: GrowingBuffer::new(gpu, "toon", wgpu::BufferUsages::UNIFORM) }
    }

    /// Reads `view`, `normal`; writes `tone`. `to_sun` is a unit vector in the world.
    #[expect(clippy::too_many_arguments, reason = "a pass lists what it reads and writes")]
    pub fn run(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        toon: &Toon,
        to_sun: [f32; 3],
        view: wgpu::BindingResource<'_>,
        normal: &Target,
        tone: &Target,
    ) {
        let steps = toon.steps as f32;
        let &Toon { darkest, lightest, wash, .. } = toon;
        let uniform = ToonUniform { to_sun, steps, darkest, softness: toon.softness.max(1e-3), lightest, wash };
        self.uniform.write(gpu, &[uniform]);
        let resources = [
            ("view", view),
            ("toon", self.uniform.binding()),
            ("normal", texture(&normal.view)),
            ("tone", texture(&tone.view)),
        ];
        self.pass.run(gpu, recorder, size_px, &resources);
    }
}
