//! Buffers: those that grow with what is written, and those that frames share by name.
//!
//! A pass owns no buffer. It asks the recorder for one by its [`BufferKind`]; the same kind is the same buffer until it
//! has to grow, and it goes when nobody has asked for a while ([`Buffers::end_frame`]). What the CPU writes for a pass
//! ([`Buffers::upload`]) gets a fresh buffer for each use within a frame, since a write takes effect before anything
//! that the frame has recorded.

use std::num::NonZeroU64;

use rustc_hash::FxHashMap;

use super::Gpu;
use super::bind::Resource;
use super::pools::KEEP_FRAMES;

/// A part of a buffer on the GPU.
#[derive(Clone, Debug)]
pub struct Buffer {
    /// What a trace calls it.
    pub name: &'static str,
    /// All of it.
    pub raw: wgpu::Buffer,
    /// First byte.
    pub offset: u64,
    /// Bytes; none is all from the offset on.
    pub size: Option<NonZeroU64>,
}

impl Buffer {
    /// Makes one of `bytes` that the GPU writes and that can be read back.
    pub fn new(gpu: &Gpu, kind: &BufferKind, bytes: u64) -> Self {
        let usage = kind.usage | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        Self { name: kind.name, raw: create(gpu, kind.name, usage, bytes.max(16)), offset: 0, size: None }
    }

    /// Makes one that holds `content`.
    pub fn with<T: bytemuck::NoUninit>(gpu: &Gpu, kind: &BufferKind, content: &[T]) -> Self {
        let buffer = Self::new(gpu, kind, size_of_val(content) as u64);
        gpu.queue.write_buffer(&buffer.raw, 0, bytemuck::cast_slice(content));
        buffer
    }

    /// `size` bytes from `offset` on.
    #[must_use]
    pub fn slice(&self, offset: u64, size: u64) -> Self {
        Self { offset: self.offset + offset, size: NonZeroU64::new(size), ..self.clone() }
    }

    /// As a resource of a shader.
    pub fn binding(&self) -> Resource {
        Resource::Buffer(self.clone())
    }
}

/// A buffer that passes ask for by name.
#[derive(Debug)]
pub struct BufferKind {
    /// Unique among the kinds.
    pub name: &'static str,
    /// It gains `COPY_SRC` and `COPY_DST`.
    pub usage: wgpu::BufferUsages,
}

impl BufferKind {
    /// A storage buffer.
    pub const fn storage(name: &'static str) -> Self {
        Self { name, usage: wgpu::BufferUsages::STORAGE }
    }

    /// A storage buffer that dispatches or draws take their numbers from.
    pub const fn indirect(name: &'static str) -> Self {
        Self { name, usage: wgpu::BufferUsages::STORAGE.union(wgpu::BufferUsages::INDIRECT) }
    }
}

/// The buffers of a kind.
#[derive(Default)]
struct Shelf {
    scratch: Option<Buffer>,
    /// One for each use in a frame.
    uploads: Vec<Buffer>,
    uploads_used: usize,
    used_in: u64,
}

/// Buffers by name.
#[derive(Default)]
pub struct Buffers {
    shelves: FxHashMap<&'static str, Shelf>,
    frame: u64,
    has_replaced: bool,
}

impl Buffers {
    /// The buffer of a kind, of at least `bytes`. What it holds is lost when it has to grow.
    pub fn scratch(&mut self, gpu: &Gpu, kind: &BufferKind, bytes: u64) -> Buffer {
        let shelf = self.shelf(kind);
        match &shelf.scratch {
            Some(buffer) if buffer.raw.size() >= bytes => buffer.clone(),
            known => {
                let replaces = known.is_some();
                let buffer = shelf.scratch.insert(Buffer::new(gpu, kind, bytes)).clone();
                self.has_replaced |= replaces;
                buffer
            }
        }
    }

    /// Whether a buffer had to grow since the last time: bind groups still hold the smaller one.
    pub fn take_replaced(&mut self) -> bool {
        std::mem::take(&mut self.has_replaced)
    }

    /// What was last asked for of a kind, for measurements.
    pub fn get(&self, kind: &BufferKind) -> Option<Buffer> {
        self.shelves.get(kind.name)?.scratch.clone()
    }

    /// A buffer with `content`, which no other use in this frame changes.
    pub fn upload<T: bytemuck::NoUninit>(&mut self, gpu: &Gpu, kind: &BufferKind, content: &[T]) -> Buffer {
        let bytes: &[u8] = bytemuck::cast_slice(content);
        let shelf = self.shelf(kind);
        let at = shelf.uploads_used;
        shelf.uploads_used += 1;
        let size = (bytes.len() as u64).next_power_of_two().max(256);
        let make = || Buffer::new(gpu, kind, size);
        if at == shelf.uploads.len() {
            shelf.uploads.push(make());
        } else if shelf.uploads[at].raw.size() < bytes.len() as u64 {
            shelf.uploads[at] = make();
        }
        let buffer = shelf.uploads[at].clone();
        if !bytes.is_empty() {
            gpu.queue.write_buffer(&buffer.raw, 0, bytes);
        }
        buffer
    }

    /// Drops what was not asked for in the last frames.
    pub fn end_frame(&mut self) {
        self.frame += 1;
        let frame = self.frame;
        self.shelves.retain(|_, shelf| shelf.used_in + KEEP_FRAMES > frame);
        for shelf in self.shelves.values_mut() {
            shelf.uploads_used = 0;
        }
    }

    fn shelf(&mut self, kind: &BufferKind) -> &mut Shelf {
        let shelf = self.shelves.entry(kind.name).or_default();
        shelf.used_in = self.frame;
        shelf
    }
}

/// A buffer that is replaced by a larger one when its content outgrows it, for what belongs to a world or a window and
/// not to a frame.
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
        if bytes.len() as u64 > self.buffer.size() {
            self.buffer = create(gpu, self.label, self.usage, (bytes.len() as u64).next_power_of_two());
        }
        gpu.queue.write_buffer(&self.buffer, 0, bytes);
    }

    /// The buffer as it is now.
    pub fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// The whole buffer as a resource.
    pub fn binding(&self) -> Resource {
        Resource::Buffer(Buffer { name: self.label, raw: self.buffer.clone(), offset: 0, size: None })
    }
}

fn create(gpu: &Gpu, label: &str, usage: wgpu::BufferUsages, size: u64) -> wgpu::Buffer {
    gpu.count_object();
    gpu.device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
}
