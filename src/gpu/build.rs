//! How a pipeline is built, on any thread: from the text of a shader to what wgpu runs.

use super::Gpu;
use super::pipelines::{Compute, Draw};
use super::reflection::Variable;
use super::shader::{Shader, ShaderError};
use super::texts::Texts;

/// What a pipeline is made of.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[expect(
    clippy::large_enum_variant,
    reason = "there are some two hundred, and a box would be one more object for each"
)]
pub enum Key {
    /// A compute shader.
    Compute(Compute),
    /// Shaders and what they draw on.
    Draw(Draw),
}

impl Key {
    /// Of the shader.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Compute(key) => key.name,
            Self::Draw(key) => key.name,
        }
    }
}

/// What wgpu runs.
#[derive(Clone, Debug)]
pub enum Raw {
    /// Dispatches.
    Compute(wgpu::ComputePipeline),
    /// Draws.
    Draw(wgpu::RenderPipeline),
}

/// A pipeline with its layout.
pub struct Pipeline {
    /// What runs.
    pub raw: Raw,
    /// Unique to the layout.
    pub number: u64,
    /// Of group 0.
    pub layout: wgpu::BindGroupLayout,
    /// What it binds.
    pub variables: Vec<Variable>,
}

/// Builds a pipeline. It waits for the driver's compiler.
///
/// # Errors
/// [`ShaderError`] when the text does not hold, or wgpu does not take it.
pub fn build(gpu: &Gpu, texts: &Texts, key: &Key, number: u64) -> Result<Pipeline, ShaderError> {
    in_scope(gpu, key.name(), || match key {
        Key::Compute(key) => compute(gpu, texts, *key, number),
        Key::Draw(key) => draw(gpu, texts, key, number),
    })
}

/// Does something of which wgpu may say that it is wrong; that is then an error of the shader `name`.
///
/// # Errors
/// Those of `make`, and wgpu's.
pub fn in_scope<T>(gpu: &Gpu, name: &str, make: impl FnOnce() -> Result<T, ShaderError>) -> Result<T, ShaderError> {
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let made = make();
    match (made, pollster::block_on(scope.pop())) {
        (Ok(_), Some(error)) => Err(ShaderError::new(name, &error.to_string())),
        (made, _) => made,
    }
}

/// The layout of group 0 and of a pipeline that has no other.
fn layouts(gpu: &Gpu, name: &str, variables: &[Variable]) -> (wgpu::BindGroupLayout, wgpu::PipelineLayout) {
    let entries: Vec<_> = variables.iter().map(|variable| variable.entry).collect();
    let group =
        gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(name), entries: &entries });
    let layout = gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(name),
        bind_group_layouts: &[Some(&group)],
        immediate_size: 0,
    });
    (group, layout)
}

fn compute(gpu: &Gpu, texts: &Texts, key: Compute, number: u64) -> Result<Pipeline, ShaderError> {
    let shader = Shader::new(gpu, texts, key.name, key.definitions)?;
    let variables = shader.variables(&["main"])?;
    let (layout, whole) = layouts(gpu, key.name, &variables);
    gpu.count_object();
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(key.name),
        layout: Some(&whole),
        module: &shader.module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions {
            zero_initialize_workgroup_memory: false,
            ..Default::default()
        },
        cache: None,
    });
    Ok(Pipeline { raw: Raw::Compute(pipeline), number, layout, variables })
}

fn draw(gpu: &Gpu, texts: &Texts, key: &Draw, number: u64) -> Result<Pipeline, ShaderError> {
    let shader = Shader::new(gpu, texts, key.name, key.definitions)?;
    let variables = shader.variables(&["vertex", key.fragment])?;
    let (layout, whole) = layouts(gpu, key.name, &variables);
    let count = key.colors.iter().flatten().count();
    gpu.count_object();
    let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(key.name),
        layout: Some(&whole),
        vertex: wgpu::VertexState {
            module: &shader.module,
            entry_point: Some("vertex"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        fragment: Some(wgpu::FragmentState {
            module: &shader.module,
            entry_point: Some(key.fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &key.colors[..count],
        }),
        primitive: wgpu::PrimitiveState { topology: key.topology, ..Default::default() },
        depth_stencil: key.depth.map(|format| wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(key.writes_depth),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        multiview_mask: None,
        cache: None,
    });
    Ok(Pipeline { raw: Raw::Draw(pipeline), number, layout, variables })
}
