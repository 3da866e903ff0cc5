//! Pipelines by what they are made of: each is built at its first use and goes when nobody has used it for a while.

use rustc_hash::FxHashMap;

use super::Gpu;
use super::bind::{BindGroups, Bound, Named};
use super::pools::KEEP_FRAMES;
use super::reflection::Variable;
use super::shader::{Shader, ShaderError};

/// A variant of a compute shader, whose entry point is `main`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Compute {
    /// Of the shader, and of the pass.
    pub name: &'static str,
    /// What is turned on by `#ifdef`.
    pub definitions: &'static [&'static str],
}

impl From<&'static str> for Compute {
    fn from(name: &'static str) -> Self {
        Self { name, definitions: &[] }
    }
}

/// A render pipeline: its vertex entry point is `vertex`, vertices come from buffers that the shader reads itself.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Draw {
    /// Of the shader, and of the pass.
    pub name: &'static str,
    /// The entry point of fragments.
    pub fragment: &'static str,
    /// What it draws on.
    pub colors: [Option<wgpu::ColorTargetState>; 2],
    /// The format of a depth picture that is tested (nearer wins: depth is reversed) and written.
    pub depth: Option<wgpu::TextureFormat>,
    /// Triangles or lines.
    pub topology: wgpu::PrimitiveTopology,
}

/// A colour that is replaced.
pub const fn replaced(format: wgpu::TextureFormat) -> Option<wgpu::ColorTargetState> {
    Some(wgpu::ColorTargetState { format, blend: None, write_mask: wgpu::ColorWrites::ALL })
}

/// A pipeline with its layout.
struct Pipeline<P> {
    pipeline: P,
    number: u64,
    layout: wgpu::BindGroupLayout,
    variables: Vec<Variable>,
    used_in: u64,
}

/// The pipelines.
#[derive(Default)]
pub struct Pipelines {
    compute: FxHashMap<Compute, Pipeline<wgpu::ComputePipeline>>,
    draw: FxHashMap<Draw, Pipeline<wgpu::RenderPipeline>>,
    made: u64,
    frame: u64,
}

/// A pipeline and what it binds, ready to run.
#[derive(Clone, Debug)]
pub struct Ready<P> {
    /// Compute or render.
    pub pipeline: P,
    /// Group 0.
    pub bound: Bound,
}

impl Pipelines {
    /// A compute pipeline with its resources.
    ///
    /// # Panics
    /// When the shader's text is wrong or the resources are not its variables: shaders are part of the program, and a
    /// test validates each of them.
    pub fn compute(
        &mut self,
        gpu: &Gpu,
        groups: &mut BindGroups,
        key: Compute,
        resources: &[Named],
    ) -> (Ready<wgpu::ComputePipeline>, &[Variable]) {
        if !self.compute.contains_key(&key) {
            self.made += 1;
            let made = make_compute(gpu, key, self.made).unwrap_or_else(|error| panic!("{error}"));
            self.compute.insert(key, made);
        }
        let Some(known) = self.compute.get_mut(&key) else { unreachable!("it was just made") };
        known.ready(gpu, groups, key.name, resources, self.frame)
    }

    /// A render pipeline with its resources.
    ///
    /// # Panics
    /// As [`Pipelines::compute`].
    pub fn draw(
        &mut self,
        gpu: &Gpu,
        groups: &mut BindGroups,
        key: &Draw,
        resources: &[Named],
    ) -> (Ready<wgpu::RenderPipeline>, &[Variable]) {
        if !self.draw.contains_key(key) {
            self.made += 1;
            let made = make_draw(gpu, key, self.made).unwrap_or_else(|error| panic!("{error}"));
            self.draw.insert(key.clone(), made);
        }
        let Some(known) = self.draw.get_mut(key) else { unreachable!("it was just made") };
        known.ready(gpu, groups, key.name, resources, self.frame)
    }

    /// Drops what was not used in the last frames.
    pub fn end_frame(&mut self) {
        self.frame += 1;
        let frame = self.frame;
        self.compute.retain(|_, pipeline| pipeline.used_in + KEEP_FRAMES > frame);
        self.draw.retain(|_, pipeline| pipeline.used_in + KEEP_FRAMES > frame);
    }
}

impl<P: Clone> Pipeline<P> {
    fn ready(
        &mut self,
        gpu: &Gpu,
        groups: &mut BindGroups,
        name: &str,
        resources: &[Named],
        frame: u64,
    ) -> (Ready<P>, &[Variable]) {
        self.used_in = frame;
        let bound = groups.bind(gpu, name, (self.number, &self.layout), &self.variables, resources);
        (Ready { pipeline: self.pipeline.clone(), bound }, &self.variables)
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

fn make_compute(gpu: &Gpu, key: Compute, number: u64) -> Result<Pipeline<wgpu::ComputePipeline>, ShaderError> {
    let shader = Shader::new(gpu, key.name, key.definitions)?;
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
    Ok(Pipeline { pipeline, number, layout, variables, used_in: 0 })
}

fn make_draw(gpu: &Gpu, key: &Draw, number: u64) -> Result<Pipeline<wgpu::RenderPipeline>, ShaderError> {
    let shader = Shader::new(gpu, key.name, &[])?;
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
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        multiview_mask: None,
        cache: None,
    });
    Ok(Pipeline { pipeline, number, layout, variables, used_in: 0 })
}
