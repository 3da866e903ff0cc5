//! Draws the meshes in view: depth and surface id, over those of the land. See `shaders/surface/meshes.wgsl`.

use super::mesh_vertices::MeshVerticesPass;
use super::terrain::{DEPTH_FORMAT, ID_FORMAT};
use crate::gpu::Gpu;
use crate::gpu::pass::bind_group;
use crate::gpu::shader::Shader;
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;

/// Of a surface id: a mesh. The rest is the triangle's number among those of all that stands in the world.
pub const IS_MESH: u32 = 1 << 31;

/// The pass.
pub struct MeshesPass {
    pipeline: wgpu::RenderPipeline,
    shader: Shader,
}

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: wgpu::BindingResource<'a>,
    /// The meshes and their vertices.
    pub meshes: &'a MeshVerticesPass,
    /// [`DEPTH_FORMAT`].
    pub depth: &'a Target,
    /// [`ID_FORMAT`].
    pub surface_id: &'a Target,
}

impl MeshesPass {
    /// Builds the pipeline.
    pub fn new(gpu: &Gpu) -> Self {
        let shader = Shader::new(&gpu.device, "surface/meshes");
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("surface/meshes"),
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
            primitive: wgpu::PrimitiveState::default(),
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

    /// Draws them.
    pub fn run(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
        let seen = inputs.meshes.seen();
        if seen.is_empty() {
            return;
        }
        let mut resources = vec![("view", inputs.view.clone())];
        resources.extend(inputs.meshes.resources());
        let layout = |i| self.pipeline.get_bind_group_layout(i);
        let group = bind_group(gpu, "surface/meshes", &self.shader, layout, &resources);
        let descriptor = wgpu::RenderPassDescriptor {
            label: Some("surface/meshes"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &inputs.surface_id.view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &inputs.depth.view,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store }),
                stencil_ops: None,
            }),
            ..Default::default()
        };
        recorder.render("surface/meshes", &descriptor, |pass| {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &group, &[]);
            for (instance, triangles) in (0_u32..).zip(seen) {
                pass.draw(0..3 * triangles, instance..instance + 1);
            }
        });
    }
}
