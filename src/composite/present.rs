//! The picture onto a window. See `shaders/composite/present.wgsl`.

use bytemuck::{Pod, Zeroable};

use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{bind_group, texture};
use crate::gpu::shader::Shader;
use crate::gpu::target::Target;

#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct PresentUniform {
    encode: u32,
    pad: u32,
    window_px: [f32; 2],
}

crate::gpu::shared::describe!(PresentUniform as "Present" in "composite/present": encode, pad, window_px);

/// The pass.
pub struct PresentPass {
    pipeline: wgpu::RenderPipeline,
    shader: Shader,
    uniform: GrowingBuffer,
    encode: bool,
}

impl PresentPass {
    /// Builds the pipeline for a window's format.
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let shader = Shader::new(&gpu.device, "composite/present");
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("composite/present"),
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
                targets: &[Some(format.into())],
            }),
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            multiview_mask: None,
            cache: None,
        });
        let uniform = GrowingBuffer::new(gpu, "present", wgpu::BufferUsages::UNIFORM);
        Self { pipeline, shader, uniform, encode: !format.is_srgb() }
    }

    /// Draws `picture` over all of `window`, whose size is `window_px`.
    pub fn run(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        picture: &Target,
        window: &wgpu::TextureView,
        window_px: [u32; 2],
    ) {
        let window_px = window_px.map(|side| side as f32);
        self.uniform.write(gpu, &[PresentUniform { encode: u32::from(self.encode), pad: 0, window_px }]);
        let resources = [("present", self.uniform.binding()), ("picture", texture(&picture.view))];
        let layout = |i| self.pipeline.get_bind_group_layout(i);
        let group = bind_group(gpu, "composite/present", &self.shader, layout, &resources);
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("composite/present"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: window,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.draw(0..3, 0..1);
    }
}
