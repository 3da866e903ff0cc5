//! Buffers that grow: uniforms and lists that are rewritten as the view changes.

use super::Gpu;

/// A buffer that is replaced by a larger one when its content outgrows it.
pub struct GrowingBuffer {
    label: &'static str,
    usage: wgpu::BufferUsages,
    buffer: wgpu::Buffer,
}

impl GrowingBuffer {
    /// An empty one; `usage` gains `COPY_DST`.
    pub fn new(gpu: &Gpu, label: &'static str, usage: wgpu::BufferUsages) -> Self {
        let usage = usage | wgpu::BufferUsages::COPY_DST;
        Self { label, usage, buffer: create(gpu, label, usage, 256) }
    }

    /// Replaces the content. An empty slice leaves the old bytes: nothing reads past a count of zero.
    pub fn write<T: bytemuck::NoUninit>(&mut self, gpu: &Gpu, content: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(content);
        self.reserve(gpu, bytes.len() as u64);
        gpu.queue.write_buffer(&self.buffer, 0, bytes);
    }

    /// Makes room for `bytes`; what was there may be lost.
    pub fn reserve(&mut self, gpu: &Gpu, bytes: u64) {
        if bytes > self.buffer.size() {
            self.buffer = create(gpu, self.label, self.usage, bytes.next_power_of_two());
        }
    }

    /// As [`GrowingBuffer::reserve`], and no more than that: for buffers near the device's limit.
    pub fn reserve_exactly(&mut self, gpu: &Gpu, bytes: u64) {
        if bytes > self.buffer.size() {
            self.buffer = create(gpu, self.label, self.usage, bytes);
        }
    }

    /// The buffer as it is now.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// The whole buffer as a resource.
    pub fn binding(&self) -> wgpu::BindingResource<'_> {
        self.buffer.as_entire_binding()
    }
}

fn create(gpu: &Gpu, label: &str, usage: wgpu::BufferUsages, size: u64) -> wgpu::Buffer {
    gpu.device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
}
