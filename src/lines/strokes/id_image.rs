//! The ID reference image: edges as lines one pixel wide. See `shaders/lines/strokes/id_image.wgsl`.
//!
//! Why: `docs/decisions/edge-visibility.md`.

use super::{Lists, image_px};
use crate::gpu::Gpu;
use crate::gpu::pass::{bind_group, texture};
use crate::gpu::shader::Shader;
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;
use crate::surface::terrain::{DEPTH_FORMAT, ID_FORMAT};

/// The pictures of the pass.
pub struct IdTargets {
    /// An edge's number plus 1; 0 is none.
    pub ids: Target,
    /// Of the edges, among themselves.
    pub depth: Target,
}

impl IdTargets {
    /// For a picture of `size_px`; `resolution` is 1 to 1/4.
    pub fn new(gpu: &Gpu, size_px: [u32; 2], resolution: f32) -> Self {
        let size_px = image_px(size_px, resolution);
        Self {
            ids: Target::attachment(gpu, "edge ids", size_px, ID_FORMAT),
            depth: Target::attachment(gpu, "edge depth", size_px, DEPTH_FORMAT),
        }
    }
}

/// The pass.
pub struct IdImagePass {
    pipeline: wgpu::RenderPipeline,
    shader: Shader,
}

impl IdImagePass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        let shader = Shader::new(&gpu.device, "lines/strokes/id_image");
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("lines/strokes/id_image"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &shader.module,
                entry_point: Some("vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            fragment: Some(wgpu::FragmentState {
                module: &shader.module,
                entry_point: Some("fragment"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(ID_FORMAT.into())],
            }),
            primitive: wgpu::PrimitiveState {
                topology: wgpu::PrimitiveTopology::LineList,
                ..wgpu::PrimitiveState::default()
            },
            depth_stencil: Some(wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(true),
                depth_compare: Some(wgpu::CompareFunction::Greater),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState::default(),
            multiview_mask: None,
            cache: None,
        });
        Self { pipeline, shader }
    }

    /// Reads `view`, `edges` and the surface's `depth`; draws as many edges as were counted.
    pub fn run(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        view: wgpu::BindingResource<'_>,
        depth: &Target,
        drawn: &IdTargets,
        lists: &Lists,
    ) {
        let resources =
            [("view", view), lists.strokes(), ("edges", lists.edges.binding()), ("depth", texture(&depth.view))];
        let layout = |i| self.pipeline.get_bind_group_layout(i);
        let group = bind_group(gpu, "lines/strokes/id_image", &self.shader, layout, &resources);
        let descriptor = wgpu::RenderPassDescriptor {
            label: Some("lines/strokes/id_image"),
            color_attachments: &[drawn.ids.cleared()],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &drawn.depth.view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(0.0), store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        };
        recorder.render("lines/strokes/id_image", &descriptor, |pass| {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &group, &[]);
            pass.draw_indirect(lists.edge_draw.buffer(), 0);
        });
    }
}
