//! Draws strokes, solid or through a stroke texture. See `shaders/lines/strokes/stroke.wgsl`.

use super::Lists;
use super::samples::SamplesPass;
use super::scan::numbers;
use super::texture::StrokeTexture;
use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::bind_group;
use crate::gpu::shader::Shader;
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;
use crate::style::texture::Recipe;
use crate::surface::terrain::ID_FORMAT;

/// Ink: 0 none, 1 full. It is blended, which 32 bits are not everywhere.
pub const INK_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;

/// The pictures of the pass.
pub struct InkTargets {
    /// How much ink.
    pub ink: Target,
    /// Whose: the number of the sample where the piece begins, plus 1.
    pub ids: Target,
}

impl InkTargets {
    /// For a picture of `size_px`.
    pub fn new(gpu: &Gpu, size_px: [u32; 2]) -> Self {
        Self {
            ink: Target::attachment(gpu, "stroke ink", size_px, INK_FORMAT),
            ids: Target::attachment(gpu, "stroke ids", size_px, ID_FORMAT),
        }
    }
}

/// Which strokes are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Which {
    /// Of this frame's chains. The pictures are cleared first.
    Fresh,
    /// Those that are not seen any more.
    Fading,
}

/// The pass.
pub struct StrokePass {
    shader: Shader,
    stages: Vec<GrowingBuffer>,
    solid: wgpu::RenderPipeline,
    textured: Option<Textured>,
}

/// What a style with a stroke texture has more.
struct Textured {
    pipeline: wgpu::RenderPipeline,
    texture: StrokeTexture,
}

impl StrokePass {
    /// Builds the pipeline of solid strokes.
    pub fn new(gpu: &Gpu) -> Self {
        let shader = Shader::new(&gpu.device, "lines/strokes/stroke");
        let solid = Self::pipeline(gpu, &shader, "fragment");
        Self { shader, stages: numbers(gpu, 2), solid, textured: None }
    }

    /// Strokes are drawn through `recipe`'s texture, or solid. What is there already is kept.
    pub fn set_texture(&mut self, gpu: &Gpu, recipe: Option<&Recipe>) {
        match (recipe, &mut self.textured) {
            (None, textured) => *textured = None,
            (Some(recipe), Some(textured)) if textured.texture.is_of(recipe) => {}
            (Some(recipe), Some(textured)) => textured.texture = StrokeTexture::new(gpu, recipe),
            (Some(recipe), None) => {
                let pipeline = Self::pipeline(gpu, &self.shader, "textured");
                self.textured = Some(Textured { pipeline, texture: StrokeTexture::new(gpu, recipe) });
            }
        }
    }

    /// The texture of the last frame, for measurements.
    pub fn texture(&self) -> Option<&StrokeTexture> {
        self.textured.as_ref().map(|textured| &textured.texture)
    }

    fn pipeline(gpu: &Gpu, shader: &Shader, fragment: &str) -> wgpu::RenderPipeline {
        let darker = wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::One,
            dst_factor: wgpu::BlendFactor::One,
            operation: wgpu::BlendOperation::Max,
        };
        let ink = wgpu::ColorTargetState {
            format: INK_FORMAT,
            blend: Some(wgpu::BlendState { color: darker, alpha: darker }),
            write_mask: wgpu::ColorWrites::ALL,
        };
        gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("lines/strokes/stroke"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &shader.module,
                entry_point: Some("vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module: &shader.module,
                entry_point: Some(fragment),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(ink), Some(ID_FORMAT.into())],
            }),
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            multiview_mask: None,
            cache: None,
        })
    }

    /// Draws strokes into the pictures: those of this frame's chains, on cleared pictures, or those that fade.
    #[expect(clippy::too_many_arguments, reason = "a pass lists what it reads and writes")]
    pub fn run(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        view: wgpu::BindingResource<'_>,
        lists: &Lists,
        samples: &SamplesPass,
        drawn: &InkTargets,
        which: Which,
    ) {
        let stage = which as usize;
        let mut resources = vec![
            ("stage", self.stages[stage].binding()),
            ("view", view),
            lists.strokes(),
            samples.list(),
            samples.samples(),
        ];
        let mut pipeline = &self.solid;
        if let Some(textured) = &self.textured {
            pipeline = &textured.pipeline;
            resources.extend(textured.texture.resources());
        }
        let layout = |i| pipeline.get_bind_group_layout(i);
        let group = bind_group(gpu, "lines/strokes/stroke", &self.shader, layout, &resources);
        let attachments = match which {
            Which::Fresh => [drawn.ink.cleared(), drawn.ids.cleared()],
            Which::Fading => [drawn.ink.kept(), drawn.ids.kept()],
        };
        let descriptor = wgpu::RenderPassDescriptor {
            label: Some("lines/strokes/stroke"),
            color_attachments: &attachments,
            ..Default::default()
        };
        recorder.render("lines/strokes/stroke", &descriptor, |pass| {
            pass.set_pipeline(pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.draw_indirect(samples.draw_arguments(), 16 * stage as u64);
        });
    }
}
