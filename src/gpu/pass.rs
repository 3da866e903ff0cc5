//! Compute passes over a picture: pipeline, named bindings, dispatch.

use super::Gpu;
use super::shader::Shader;
use super::timer::Recorder;

/// Side of a workgroup of a picture pass, in pixels; the shaders say `@workgroup_size(8, 8)`.
pub const WORKGROUP_PX: u32 = 8;

/// A compute pipeline whose resources are bound by the names in its shader.
pub struct ComputePass {
    name: &'static str,
    pipeline: wgpu::ComputePipeline,
    shader: Shader,
}

/// A resource and the name of the shader variable that it is bound to.
pub type Named<'a> = (&'a str, wgpu::BindingResource<'a>);

impl ComputePass {
    /// The pass of the shader `name`, whose entry point is `main`.
    pub fn new(gpu: &Gpu, name: &'static str) -> Self {
        Self::variant(gpu, name, &[])
    }

    /// As [`ComputePass::new`], of the shader's variant with `definitions` turned on.
    pub fn variant(gpu: &Gpu, name: &'static str, definitions: &[&str]) -> Self {
        let shader = Shader::variant(&gpu.device, name, definitions);
        let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: None,
            module: &shader.module,
            entry_point: Some("main"),
            compilation_options: wgpu::PipelineCompilationOptions {
                zero_initialize_workgroup_memory: false,
                ..Default::default()
            },
            cache: None,
        });
        Self { name, pipeline, shader }
    }

    /// Runs once for each pixel of a `size_px` picture, timed under the name of the pass.
    pub fn run(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, size_px: [u32; 2], resources: &[Named]) {
        self.run_groups(gpu, recorder, size_px.map(|side| side.div_ceil(WORKGROUP_PX)), resources);
    }

    /// Runs a number of workgroups in x and y.
    pub fn run_groups(&self, gpu: &Gpu, recorder: &mut Recorder<'_>, groups: [u32; 2], resources: &[Named]) {
        self.dispatch(gpu, recorder, resources, |pass| pass.dispatch_workgroups(groups[0], groups[1], 1));
    }

    /// Runs as many workgroups as three numbers in `arguments` say, from byte `offset` on; the buffer is not one of the
    /// resources.
    pub fn run_indirect(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        arguments: &wgpu::Buffer,
        offset: u64,
        resources: &[Named],
    ) {
        self.dispatch(gpu, recorder, resources, |pass| pass.dispatch_workgroups_indirect(arguments, offset));
    }

    fn dispatch(
        &self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        resources: &[Named],
        run: impl FnOnce(&mut wgpu::ComputePass<'_>),
    ) {
        let group =
            bind_group(gpu, self.name, &self.shader, |group| self.pipeline.get_bind_group_layout(group), resources);
        recorder.compute(self.name, |pass| {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &group, &[]);
            run(pass);
        });
    }
}

/// Binds named resources to group 0 of a shader.
///
/// # Panics
/// When a name is not a variable of the shader: a mistake in the program that the first run of a pass shows.
pub fn bind_group(
    gpu: &Gpu,
    label: &str,
    shader: &Shader,
    layout: impl Fn(u32) -> wgpu::BindGroupLayout,
    resources: &[Named],
) -> wgpu::BindGroup {
    let entries: Vec<_> = resources
        .iter()
        .map(|(name, resource)| {
            let Some(&(_, binding)) = shader.bindings.get(*name) else {
                panic!("{label}.wgsl has no variable {name}; it has {:?}", shader.bindings.keys());
            };
            wgpu::BindGroupEntry { binding, resource: resource.clone() }
        })
        .collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some(label),
        layout: &layout(0),
        entries: &entries,
    })
}

/// A texture view as a resource.
pub fn texture(view: &wgpu::TextureView) -> wgpu::BindingResource<'_> {
    wgpu::BindingResource::TextureView(view)
}
