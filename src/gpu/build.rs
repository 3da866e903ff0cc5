//! Builds a pipeline, on any thread: from the name of a shader to a pipeline of wgpu.

use super::pipelines::{Compute, Draw};
use super::reflection::Variable;
use super::shader::{Shader, ShaderError};
use super::texts::Texts;

/// The description of a pipeline, by which it is cached.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[expect(
    clippy::large_enum_variant,
    reason = "there are about two hundred keys, and boxes would be two hundred more allocations"
)]
pub(crate) enum Key {
    Compute(Compute),
    Draw(Draw),
}

impl Key {
    /// Returns the name of the shader.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::Compute(key) => key.name,
            Self::Draw(key) => key.name,
        }
    }
}

/// A pipeline of wgpu.
#[derive(Clone, Debug)]
pub(crate) enum Raw {
    Compute(wgpu::ComputePipeline),
    Draw(wgpu::RenderPipeline),
}

/// A compiled pipeline with its layout.
pub(crate) struct Pipeline {
    /// The pipeline as wgpu has it.
    pub raw: Raw,
    /// Number of the build, which identifies the layout.
    pub number: u64,
    /// Layout of bind group 0, the only one.
    pub layout: wgpu::BindGroupLayout,
    /// The variables of bind group 0, sorted by binding.
    pub variables: Vec<Variable>,
}

/// The device and the shader texts with which pipelines are built.
pub(super) struct On<'a> {
    pub device: &'a wgpu::Device,
    pub texts: &'a Texts,
    /// Compiled pipelines of earlier runs.
    pub stored: Option<&'a wgpu::PipelineCache>,
}

/// Builds a pipeline, and waits for the driver's compiler.
///
/// # Errors
/// [`ShaderError`] if the shader does not compile, or if wgpu rejects the pipeline.
pub(super) fn build(on: &On<'_>, key: &Key, number: u64) -> Result<Pipeline, ShaderError> {
    in_scope(on.device, key.name(), || match key {
        Key::Compute(key) => compute(on, *key, number),
        Key::Draw(key) => draw(on, key, number),
    })
}

/// Calls `make` in an error scope, and turns a validation error of wgpu into an error of the shader `name`.
///
/// # Errors
/// The error of `make`, or wgpu's validation error.
pub(super) fn in_scope<T>(
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

/// Creates the layout of bind group 0, and the layout of a pipeline that has no other group.
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

fn compute(on: &On<'_>, key: Compute, number: u64) -> Result<Pipeline, ShaderError> {
    let &On { device, texts, stored } = on;
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
        cache: stored,
    });
    Ok(Pipeline { raw: Raw::Compute(pipeline), number, layout, variables })
}

fn draw(on: &On<'_>, key: &Draw, number: u64) -> Result<Pipeline, ShaderError> {
    let &On { device, texts, stored } = on;
    let fragment = (!key.fragment.is_empty()).then_some(key.fragment);
    let tests_early = key.writes_farther && device.features().contains(wgpu::Features::SHADER_EARLY_DEPTH_TEST);
    let farther = fragment.filter(|_| tests_early);
    let shader = Shader::with_early_depth(device, texts, (key.name, key.definitions), farther)?;
    let variables = match fragment {
        Some(fragment) => shader.variables(&["vertex", fragment])?,
        None => shader.variables(&["vertex"])?,
    };
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
        fragment: fragment.map(|fragment| wgpu::FragmentState {
            module: &shader.module,
            entry_point: Some(fragment),
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
        cache: stored,
    });
    Ok(Pipeline { raw: Raw::Draw(pipeline), number, layout, variables })
}
