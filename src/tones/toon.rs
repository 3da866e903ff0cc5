//! Light in a few steps. See `shaders/tones/toon.wgsl`.

use bytemuck::{Pod, Zeroable};

use super::light::LightUniform;
use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{ComputePass, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;
use crate::style::Toon;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct ToonUniform {
    steps: f32,
    darkest: f32,
    lightest: f32,
    softness: f32,
    wash: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

crate::gpu::shared::describe!(ToonUniform as "Toon" in "tones/toon": steps, darkest, lightest, softness, wash, pad_a, pad_b, pad_c);

/// The pass.
pub struct ToonPass {
    pass: ComputePass,
    light: GrowingBuffer,
    uniform: GrowingBuffer,
}

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: wgpu::BindingResource<'a>,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
    /// Out: colour, and the tone that is asked for.
    pub tone: &'a Target,
}

impl ToonPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            pass: ComputePass::new(gpu, "tones/toon"),
            light: GrowingBuffer::new(gpu, "light", wgpu::BufferUsages::UNIFORM),
            uniform: GrowingBuffer::new(gpu, "toon", wgpu::BufferUsages::UNIFORM),
        }
    }

    /// Tones what the inputs show.
    pub fn run(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        toon: &Toon,
        light: LightUniform,
        inputs: Inputs<'_>,
    ) {
        let &Toon { darkest, lightest, softness, wash, .. } = toon;
        let (steps, softness) = (toon.steps as f32, softness.max(1e-3));
        let uniform = ToonUniform { steps, darkest, lightest, softness, wash, pad_a: 0.0, pad_b: 0.0, pad_c: 0.0 };
        self.uniform.write(gpu, &[uniform]);
        self.light.write(gpu, &[light]);
        let resources = [
            ("view", inputs.view),
            ("light", self.light.binding()),
            ("toon", self.uniform.binding()),
            ("position", texture(&inputs.position.view)),
            ("normal", texture(&inputs.normal.view)),
            ("tone", texture(&inputs.tone.view)),
        ];
        self.pass.run(gpu, recorder, size_px, &resources);
    }
}
