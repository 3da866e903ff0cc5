//! Draws the selected patches: depth and surface id. See `shaders/surface/terrain.wgsl`.

use crate::gpu::Gpu;
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pass::{Named, bind_group};
use crate::gpu::shader::Shader;
use crate::gpu::target::Target;
use crate::gpu::timer::Recorder;
use crate::pyramid::tile::PATCH_QUADS;
use crate::surface::vertices::VerticesPass;

/// Reversed depth: near / distance along the view axis; 0 is the sky.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;
/// Which patch; 0 is the sky.
pub const ID_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;

/// The pass.
pub struct TerrainPass {
    solid: wgpu::RenderPipeline,
    with_holes: wgpu::RenderPipeline,
    shader: Shader,
    indices: GrowingBuffer,
}

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: wgpu::BindingResource<'a>,
    /// What `shaders/shared/terrain.wgsl` and `shared/surface.wgsl` declare.
    pub terrain: &'a [Named<'a>],
    /// How many patches the selection has without holes; those with holes follow.
    pub solid: u32,
    /// First patch and number of patches of this batch. The first batch clears the targets.
    pub batch: [u32; 2],
    /// The patches and their vertices.
    pub mesh: &'a VerticesPass,
    /// [`DEPTH_FORMAT`].
    pub depth: &'a Target,
    /// [`ID_FORMAT`].
    pub surface_id: &'a Target,
}

impl TerrainPass {
    /// Builds the pipelines.
    pub fn new(gpu: &Gpu) -> Self {
        let shader = Shader::new(&gpu.device, "surface/terrain");
        let layout = layout(gpu);
        let mut indices = GrowingBuffer::new(gpu, "patch indices", wgpu::BufferUsages::INDEX);
        indices.write(gpu, &patch_indices());
        Self {
            solid: pipeline(gpu, &shader, &layout, "solid"),
            with_holes: pipeline(gpu, &shader, &layout, "with_holes"),
            shader,
            indices,
        }
    }

    /// Clears the targets and draws the patches.
    pub fn run(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, inputs: &Inputs) {
        let mut resources = vec![
            ("view", inputs.view.clone()),
            ("patches", inputs.mesh.patches(inputs.batch)),
            ("positions", inputs.mesh.positions().as_entire_binding()),
        ];
        resources.extend(inputs.terrain.iter().cloned());
        let layout = |i| self.solid.get_bind_group_layout(i);
        let group = bind_group(gpu, "surface/terrain", &self.shader, layout, &resources);

        let is_first = inputs.batch[0] == 0;
        let descriptor = wgpu::RenderPassDescriptor {
            label: Some("surface/terrain"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &inputs.surface_id.view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: if is_first { wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT) } else { wgpu::LoadOp::Load },
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &inputs.depth.view,
                depth_ops: Some(wgpu::Operations {
                    load: if is_first { wgpu::LoadOp::Clear(0.0) } else { wgpu::LoadOp::Load },
                    store: wgpu::StoreOp::Store,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        };
        recorder.render("surface/terrain", &descriptor, |pass| {
            pass.set_bind_group(0, &group, &[]);
            pass.set_index_buffer(self.indices.buffer().slice(..), wgpu::IndexFormat::Uint16);
            let index_count = 6 * PATCH_QUADS * PATCH_QUADS;
            let [first, count] = inputs.batch;
            let solid = inputs.solid.saturating_sub(first).min(count);
            pass.set_pipeline(&self.solid);
            pass.draw_indexed(0..index_count, 0, 0..solid);
            pass.set_pipeline(&self.with_holes);
            pass.draw_indexed(0..index_count, 0, solid..count);
        });
    }
}

/// Both triangles of each quad, split along its (0, 0) to (1, 1) diagonal: the one that mesh errors are measured with.
fn patch_indices() -> Vec<u16> {
    let side = PATCH_QUADS as u16 + 1;
    let mut indices = Vec::with_capacity(6 * PATCH_QUADS as usize * PATCH_QUADS as usize);
    for y in 0..PATCH_QUADS as u16 {
        for x in 0..PATCH_QUADS as u16 {
            let here = y * side + x;
            indices.extend([here, here + 1, here + side + 1, here, here + side + 1, here + side]);
        }
    }
    indices
}

/// One layout for both pipelines, so that one bind group serves both: the solid one reads less.
fn layout(gpu: &Gpu) -> wgpu::PipelineLayout {
    let both = wgpu::ShaderStages::VERTEX_FRAGMENT;
    let buffer = |binding, ty| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: both,
        ty: wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    };
    let storage = wgpu::BufferBindingType::Storage { read_only: true };
    let group = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("surface/terrain"),
        entries: &[
            buffer(0, wgpu::BufferBindingType::Uniform),
            buffer(1, storage),
            buffer(2, storage),
            buffer(10, wgpu::BufferBindingType::Uniform),
            buffer(11, storage),
            buffer(12, storage),
            buffer(13, storage),
            wgpu::BindGroupLayoutEntry {
                binding: 14,
                visibility: both,
                ty: wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: false },
                    view_dimension: wgpu::TextureViewDimension::D2Array,
                    multisampled: false,
                },
                count: None,
            },
        ],
    });
    gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some("surface/terrain"),
        bind_group_layouts: &[Some(&group)],
        immediate_size: 0,
    })
}

fn pipeline(gpu: &Gpu, shader: &Shader, layout: &wgpu::PipelineLayout, fragment: &str) -> wgpu::RenderPipeline {
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(fragment),
        layout: Some(layout),
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
    })
}
