//! How a pipeline is built, on any thread: from the text of a shader to what wgpu runs.

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
pub fn build(device: &wgpu::Device, texts: &Texts, key: &Key, number: u64) -> Result<Pipeline, ShaderError> {
    in_scope(device, key.name(), || match key {
        Key::Compute(key) => compute(device, texts, *key, number),
        Key::Draw(key) => draw(device, texts, key, number),
    })
}

/// Does something of which wgpu may say that it is wrong; that is then an error of the shader `name`.
///
/// # Errors
/// Those of `make`, and wgpu's.
pub fn in_scope<T>(
    device: &wgpu::Device,
    name: &str,
    make: impl FnOnce() -> Result<T, ShaderError>,
) -> Result<T, ShaderError> {
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let made = make();
    match (made, pollster::block_on(scope.pop())) {
        (Ok(_), Some(error)) => Err(ShaderError::new(name, &error.to_string())),
        (made, _) => made,
    }
}

/// The layout of group 0 and of a pipeline that has no other.
fn layouts(device: &wgpu::Device, name: &str, variables: &[Variable]) -> (wgpu::BindGroupLayout, wgpu::PipelineLayout) {
    let entries: Vec<_> = variables.iter().map(|variable| variable.entry).collect();
    let group =
        device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(name), entries: &entries });
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(name),
        bind_group_layouts: &[Some(&group)],
        immediate_size: 0,
    });
    (group, layout)
}

fn compute(device: &wgpu::Device, texts: &Texts, key: Compute, number: u64) -> Result<Pipeline, ShaderError> {
    let shader = Shader::new(device, texts, key.name, key.definitions)?;
    let variables = shader.variables(&["main"])?;
    let (layout, whole) = layouts(device, key.name, &variables);
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
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

fn draw(device: &wgpu::Device, texts: &Texts, key: &Draw, number: u64) -> Result<Pipeline, ShaderError> {
    let shader = Shader::new(device, texts, key.name, key.definitions)?;
    let variables = shader.variables(&["vertex", key.fragment])?;
    let (layout, whole) = layouts(device, key.name, &variables);
    let count = key.colors.iter().flatten().count();
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
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
