//! Runs a shader that calls shared functions, to compare what they return with their twins.

use hachure::gpu::Gpu;
use hachure::gpu::shader::compose_text;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

/// Threads of a workgroup of a probe.
pub(crate) const THREADS: usize = 64;

/// Creates a storage buffer that can be read back.
pub(crate) fn storage(gpu: &Gpu, contents: &[u8]) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
    gpu.device.create_buffer_init(&BufferInitDescriptor { label: None, contents, usage })
}

/// Runs the entry point `main` of `text` with its resources, in the order of their bindings; `threads` must be a
/// multiple of [`THREADS`].
pub(crate) fn run<'a>(
    gpu: &Gpu,
    text: &str,
    resources: impl IntoIterator<Item = wgpu::BindingResource<'a>>,
    threads: usize,
) {
    assert_eq!(threads % THREADS, 0);
    let module = compose_text("probe", text).unwrap_or_else(|error| panic!("{error}"));
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: None,
        source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(module)),
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: None,
        layout: None,
        module: &module,
        entry_point: Some("main"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let entries = (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource });
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: None,
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries.collect::<Vec<_>>(),
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups((threads / THREADS) as u32, 1, 1);
    }
    gpu.queue.submit([encoder.finish()]);
}
