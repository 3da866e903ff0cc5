//! Tones, lines, paper and haze → the picture. See `shaders/composite/composite.wgsl`.

pub mod present;

use bytemuck::{Pod, Zeroable};

use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{ComputePass, texture};
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;
use crate::scene::Light;
use crate::style::Style;
use crate::style::color::linear_from_srgb;

/// Linear colour, opaque.
pub const PICTURE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct CompositeUniform {
    paper: [f32; 3],
    haze_m: f32,
    ink: [f32; 3],
    grain: f32,
    sky_zenith: [f32; 3],
    faintest_line: f32,
    sky_horizon: [f32; 3],
    line_strength: f32,
    haze: [f32; 3],
    faintest_tone: f32,
    stroke_ink: [f32; 3],
    line_reach: f32,
    mark_ink: [f32; 3],
    pad: f32,
}

crate::gpu::shared::describe!(CompositeUniform as "Composite" in "composite/composite": paper, haze_m, ink, grain, sky_zenith, faintest_line, sky_horizon, line_strength, haze, faintest_tone, stroke_ink, line_reach, mark_ink, pad);

/// The pass.
pub struct CompositePass {
    pass: ComputePass,
    uniform: GrowingBuffer,
}

/// What the pass reads and writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: wgpu::BindingResource<'a>,
    /// For haze.
    pub position: &'a Target,
    /// Colour and tone.
    pub tone: &'a Target,
    /// Lines; a style without lines hands any picture that holds zeros.
    pub line: &'a Target,
    /// Ink of strokes; a style without them hands any picture of one pixel that holds zeros.
    pub ink: &'a Target,
    /// Ink of hatching; a style without it hands any picture of one pixel that holds zeros.
    pub marks: &'a Target,
    /// Out.
    pub picture: &'a Target,
}

impl CompositePass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        let pass = ComputePass::new(gpu, "composite/composite");
        Self { pass, uniform: GrowingBuffer::new(gpu, "composite", wgpu::BufferUsages::UNIFORM) }
    }

    /// Composites.
    pub fn run(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        size_px: [u32; 2],
        style: &Style,
        light: &Light,
        inputs: Inputs<'_>,
    ) {
        let lines = style.lines.as_ref();
        let uniform = CompositeUniform {
            paper: style.paper.color.linear(),
            haze_m: light.haze_m as f32,
            ink: lines.map_or([0.0; 3], |lines| lines.ink.linear()),
            grain: style.paper.grain,
            sky_zenith: style.sky.zenith.linear(),
            faintest_line: lines.map_or(0.0, |lines| lines.faintest),
            sky_horizon: style.sky.horizon.linear(),
            line_strength: f32::from(u8::from(lines.is_some())),
            haze: light.haze_srgb.map_or(style.haze.color.linear(), |color| color.map(linear_from_srgb)),
            faintest_tone: style.haze.faintest_tone,
            line_reach: lines.map_or(1.0, |lines| lines.reach),
            stroke_ink: style.strokes.as_ref().map_or([0.0; 3], |strokes| strokes.ink.linear()),
            mark_ink: style.hatching.as_ref().map_or([0.0; 3], |hatching| hatching.ink.linear()),
            pad: 0.0,
        };
        self.uniform.write(gpu, &[uniform]);
        let resources = [
            ("view", inputs.view),
            ("composite", self.uniform.binding()),
            ("position", texture(&inputs.position.view)),
            ("tone", texture(&inputs.tone.view)),
            ("line", texture(&inputs.line.view)),
            ("ink", texture(&inputs.ink.view)),
            ("marks", texture(&inputs.marks.view)),
            ("picture", texture(&inputs.picture.view)),
        ];
        self.pass.run(gpu, recorder, size_px, &resources);
    }
}
