//! The uniforms of a frame. Every use gets a slice of its own.
//!
//! `Queue::write_buffer` takes effect before everything that is submitted after it. A uniform buffer that is written
//! twice while a frame is recorded would therefore hold the second value for both uses. A slice of the arena is written
//! only once per frame. Slices are bound with a dynamic offset, so a slice that moves between frames needs no new bind
//! group.

use super::Gpu;
use super::bind::Resource;
use super::buffer::Buffer;

/// Size of a chunk in bytes, enough for about 200 uniforms.
const CHUNK_BYTES: u64 = 64 << 10;

/// A bump allocator for the uniforms of a frame, in chunks of 64 KiB.
pub struct Arena {
    alignment: u64,
    chunks: Vec<Chunk>,
    /// Index of the chunk that is being filled.
    current: usize,
}

struct Chunk {
    buffer: wgpu::Buffer,
    content: Vec<u8>,
    /// Number of bytes of `content` that have been uploaded.
    uploaded_bytes: usize,
}

impl Arena {
    pub fn new(gpu: &Gpu) -> Self {
        let limits = gpu.device.limits();
        let alignment = u64::from(limits.min_uniform_buffer_offset_alignment.max(16));
        Self { alignment, chunks: Vec::new(), current: 0 }
    }

    /// Returns a slice that holds `values` until the end of the frame. They must fit into one chunk.
    pub fn push<T: bytemuck::NoUninit>(&mut self, gpu: &Gpu, name: &'static str, values: &[T]) -> Buffer {
        let bytes: &[u8] = bytemuck::cast_slice(values);
        debug_assert!(bytes.len() as u64 <= CHUNK_BYTES, "{name} is larger than a chunk");
        let fits = |chunk: &Chunk| {
            (chunk.content.len() as u64).next_multiple_of(self.alignment) + bytes.len() as u64 <= CHUNK_BYTES
        };
        while self.chunks.get(self.current).is_some_and(|chunk| !fits(chunk)) {
            self.current += 1;
        }
        if self.current == self.chunks.len() {
            self.chunks.push(Chunk::new(gpu));
        }
        let chunk = &mut self.chunks[self.current];
        let offset = (chunk.content.len() as u64).next_multiple_of(self.alignment);
        chunk.content.resize(offset as usize, 0);
        chunk.content.extend_from_slice(bytes);
        Buffer { name, raw: chunk.buffer.clone(), offset: 0, size: None }.slice(offset, bytes.len() as u64)
    }

    /// Returns a slice that holds `value` until the end of the frame, as a resource to bind.
    pub fn uniform<T: bytemuck::NoUninit>(&mut self, gpu: &Gpu, name: &'static str, value: &T) -> Resource {
        Resource::Buffer(self.push(gpu, name, std::slice::from_ref(value)))
    }

    /// Uploads what has been pushed since the last call. Must be called before each submit.
    pub fn flush(&mut self, gpu: &Gpu) {
        for chunk in &mut self.chunks {
            if chunk.uploaded_bytes < chunk.content.len() {
                gpu.queue.write_buffer(
                    &chunk.buffer,
                    chunk.uploaded_bytes as u64,
                    &chunk.content[chunk.uploaded_bytes..],
                );
                chunk.uploaded_bytes = chunk.content.len();
            }
        }
    }

    /// Begins a frame: all slices are free again. Submitted passes still see the old values.
    pub fn begin_frame(&mut self) {
        for chunk in &mut self.chunks {
            chunk.content.clear();
            chunk.uploaded_bytes = 0;
        }
        self.current = 0;
    }
}

impl Chunk {
    fn new(gpu: &Gpu) -> Self {
        use wgpu::BufferUsages as Usage;
        gpu.count_object();
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("uniforms"),
            size: CHUNK_BYTES,
            usage: Usage::UNIFORM | Usage::COPY_SRC | Usage::COPY_DST,
            mapped_at_creation: false,
        });
        Self { buffer, content: Vec::new(), uploaded_bytes: 0 }
    }
}
