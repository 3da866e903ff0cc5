//! Buffers on the GPU: a pool of buffers by name, and buffers that grow with their content.
//!
//! A pass owns no buffer. It requests one from the recorder by its [`BufferKind`]. The same kind returns the same
//! buffer until the buffer has to grow, and a buffer that has not been requested for a while is released
//! ([`Buffers::end_frame`]). Data that the CPU writes for a pass ([`Buffers::upload`]) gets a separate buffer for each
//! use within a frame, because a write takes effect before everything that the frame has recorded.

use std::num::NonZeroU64;

use rustc_hash::FxHashMap;

use super::Gpu;
use super::bind::Resource;
use super::cache_counts::CacheCounts;
use super::pools::KEEP_FRAMES;

/// Least size of a buffer, in bytes.
const LEAST_BYTES: u64 = 16;

/// A buffer on the GPU, or a part of one.
#[derive(Clone, Debug)]
pub struct Buffer {
    /// Name in a trace.
    pub name: &'static str,
    /// The whole buffer.
    pub raw: wgpu::Buffer,
    /// Offset of the part, in bytes.
    pub offset: u64,
    /// Size of the part in bytes; `None` means up to the end of the buffer.
    pub size: Option<NonZeroU64>,
}

impl Buffer {
    /// Creates a buffer of `bytes` bytes that can be copied to and from, and so read back.
    pub fn new(gpu: &Gpu, kind: &BufferKind, bytes: u64) -> Self {
        let usage = kind.usage | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
        Self { name: kind.name, raw: create(gpu, kind.name, usage, bytes.max(LEAST_BYTES)), offset: 0, size: None }
    }

    /// Creates a buffer that holds `content`.
    pub fn with<T: bytemuck::NoUninit>(gpu: &Gpu, kind: &BufferKind, content: &[T]) -> Self {
        let buffer = Self::new(gpu, kind, size_of_val(content) as u64);
        gpu.queue.write_buffer(&buffer.raw, 0, bytemuck::cast_slice(content));
        buffer
    }

    /// Returns the part of `size` bytes that begins at byte `offset`.
    #[must_use]
    pub fn slice(&self, offset: u64, size: u64) -> Self {
        Self { offset: self.offset + offset, size: NonZeroU64::new(size), ..self.clone() }
    }

    /// Returns the buffer as a resource to bind.
    pub fn binding(&self) -> Resource {
        Resource::Buffer(self.clone())
    }
}

/// The description of a buffer that passes request by name.
#[derive(Debug)]
pub struct BufferKind {
    /// Unique name, which is also the label and the name in a trace.
    pub name: &'static str,
    /// Usages besides `COPY_SRC` and `COPY_DST`, which every buffer has.
    pub usage: wgpu::BufferUsages,
}

impl BufferKind {
    /// Describes a storage buffer.
    pub const fn storage(name: &'static str) -> Self {
        Self { name, usage: wgpu::BufferUsages::STORAGE }
    }

    /// Describes a buffer of indices of vertices.
    pub const fn index(name: &'static str) -> Self {
        Self { name, usage: wgpu::BufferUsages::INDEX }
    }

    /// Describes a storage buffer that can hold the arguments of indirect dispatches and draws.
    pub const fn indirect(name: &'static str) -> Self {
        Self { name, usage: wgpu::BufferUsages::STORAGE.union(wgpu::BufferUsages::INDIRECT) }
    }
}

/// The buffers of one kind.
#[derive(Default)]
struct Shelf {
    scratch: Option<Buffer>,
    /// Largest size that was requested of `scratch` since the frame `measured_since`, in bytes.
    largest_bytes: u64,
    measured_since: u64,
    /// Whether `scratch` is larger than all that has been requested for a while: the next request replaces it.
    is_too_large: bool,
    /// A buffer for each upload of a frame.
    uploads: Vec<Upload>,
    /// Number of `uploads` that the current frame has used.
    uploads_used: usize,
    /// The last frame that requested the kind.
    used_in: u64,
}

/// A buffer for data from the CPU.
struct Upload {
    buffer: Buffer,
    /// The last frame that used it, and the last one that needed its size.
    used_in: u64,
    filled_in: u64,
}

/// A pool of buffers, by name.
#[derive(Default)]
pub struct Buffers {
    shelves: FxHashMap<&'static str, Shelf>,
    frame: u64,
    has_replaced: bool,
    counts: CacheCounts,
}

impl Buffers {
    /// Returns the buffer of a kind, with at least `bytes` bytes. Its content is lost when it has to grow, and when it is
    /// replaced by a smaller one, because the last [`KEEP_FRAMES`] frames or more did not need all of it.
    pub fn scratch(&mut self, gpu: &Gpu, kind: &BufferKind, bytes: u64) -> Buffer {
        let shelf = self.shelf(kind);
        shelf.largest_bytes = shelf.largest_bytes.max(bytes);
        let is_large_enough = shelf.scratch.as_ref().is_some_and(|buffer| buffer.raw.size() >= bytes);
        // The mark is also taken from a buffer that grows: the next request must find the buffer of this request.
        let is_too_large = std::mem::take(&mut shelf.is_too_large);
        let is_hit = is_large_enough && !is_too_large;
        let replaces = !is_hit && shelf.scratch.is_some();
        if !is_hit {
            shelf.scratch = None;
        }
        let buffer = shelf.scratch.get_or_insert_with(|| Buffer::new(gpu, kind, bytes)).clone();
        self.has_replaced |= replaces;
        self.counts.count(is_hit);
        buffer
    }

    /// Returns how often a buffer was available.
    pub(crate) fn counts(&self) -> CacheCounts {
        self.counts
    }

    /// Returns whether a buffer has been replaced since the last call. Cached bind groups still hold the one before
    /// then.
    pub fn take_replaced(&mut self) -> bool {
        std::mem::take(&mut self.has_replaced)
    }

    /// Returns the buffer that was last requested of a kind, for measurements.
    pub fn get(&self, kind: &BufferKind) -> Option<Buffer> {
        self.shelves.get(kind.name)?.scratch.clone()
    }

    /// Returns a buffer that holds `content`, which no other upload of this frame overwrites.
    pub fn upload<T: bytemuck::NoUninit>(&mut self, gpu: &Gpu, kind: &BufferKind, content: &[T]) -> Buffer {
        let bytes: &[u8] = bytemuck::cast_slice(content);
        let shelf = self.shelf(kind);
        let at = shelf.uploads_used;
        shelf.uploads_used += 1;
        let size = (bytes.len() as u64).next_power_of_two().max(256);
        let used_in = shelf.used_in;
        let fits = |upload: &&mut Upload| {
            let known = upload.buffer.raw.size();
            known == size || known > size && upload.filled_in + KEEP_FRAMES > used_in
        };
        let known = shelf.uploads.get_mut(at).filter(fits);
        let is_hit = known.is_some();
        if let Some(upload) = known {
            upload.used_in = used_in;
            upload.filled_in = if upload.buffer.raw.size() == size { used_in } else { upload.filled_in };
        } else {
            let made = Upload { buffer: Buffer::new(gpu, kind, size), used_in, filled_in: used_in };
            match shelf.uploads.get_mut(at) {
                Some(upload) => *upload = made,
                None => shelf.uploads.push(made),
            }
        }
        let buffer = shelf.uploads[at].buffer.clone();
        self.counts.count(is_hit);
        if !bytes.is_empty() {
            gpu.queue.write_buffer(&buffer.raw, 0, bytes);
        }
        buffer
    }

    /// Drops the buffers that the last [`KEEP_FRAMES`] frames did not request, and finds those that are larger than
    /// these frames needed.
    pub fn end_frame(&mut self) {
        self.frame += 1;
        let frame = self.frame;
        self.shelves.retain(|_, shelf| shelf.used_in + KEEP_FRAMES > frame);
        for shelf in self.shelves.values_mut() {
            shelf.uploads_used = 0;
            shelf.uploads.retain(|upload| upload.used_in + KEEP_FRAMES > frame);
            if shelf.measured_since + KEEP_FRAMES <= frame {
                let is_larger = |buffer: &Buffer| buffer.raw.size() > shelf.largest_bytes.max(LEAST_BYTES);
                shelf.is_too_large = shelf.largest_bytes > 0 && shelf.scratch.as_ref().is_some_and(is_larger);
                (shelf.largest_bytes, shelf.measured_since) = (0, frame);
            }
        }
    }

    fn shelf(&mut self, kind: &BufferKind) -> &mut Shelf {
        let frame = self.frame;
        let shelf =
            self.shelves.entry(kind.name).or_insert_with(|| Shelf { measured_since: frame, ..Shelf::default() });
        shelf.used_in = frame;
        shelf
    }
}

/// A buffer that is replaced by a larger one when its content outgrows it. It is for data that belongs to a world or a
/// window rather than to a frame.
pub(crate) struct GrowingBuffer {
    label: &'static str,
    usage: wgpu::BufferUsages,
    buffer: wgpu::Buffer,
}

impl GrowingBuffer {
    /// Creates an empty buffer of 256 bytes with `usage` and `COPY_DST`.
    pub(crate) fn new(gpu: &Gpu, label: &'static str, usage: wgpu::BufferUsages) -> Self {
        let usage = usage | wgpu::BufferUsages::COPY_DST;
        Self { label, usage, buffer: create(gpu, label, usage, 256) }
    }

    /// Replaces the content. An empty slice leaves the old bytes in place; shaders do not read them, because their
    /// count is zero.
    pub(crate) fn write<T: bytemuck::NoUninit>(&mut self, gpu: &Gpu, content: &[T]) {
        let bytes: &[u8] = bytemuck::cast_slice(content);
        if bytes.len() as u64 > self.buffer.size() {
            self.buffer = create(gpu, self.label, self.usage, (bytes.len() as u64).next_power_of_two());
        }
        gpu.queue.write_buffer(&self.buffer, 0, bytes);
    }

    /// Returns the buffer; the next [`write`](Self::write) may replace it.
    pub(crate) fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    /// Returns the whole buffer as a resource to bind.
    pub(crate) fn binding(&self) -> Resource {
        Resource::Buffer(Buffer { name: self.label, raw: self.buffer.clone(), offset: 0, size: None })
    }
}

fn create(gpu: &Gpu, label: &str, usage: wgpu::BufferUsages, size: u64) -> wgpu::Buffer {
    gpu.count_object();
    gpu.device.create_buffer(&wgpu::BufferDescriptor { label: Some(label), size, usage, mapped_at_creation: false })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::common;

    #[test]
    fn buffers_that_are_too_large_are_replaced() {
        let Some(gpu) = common::gpu() else { return };
        let kind = BufferKind::storage("test");
        let mut buffers = Buffers::default();
        let mut frames = |count: u64, requests: &[u64], uploads: usize| {
            let mut largest = 0;
            for _ in 0..count {
                for bytes in requests {
                    largest = buffers.scratch(&gpu, &kind, *bytes).raw.size();
                }
                (0..uploads).for_each(|_| _ = buffers.upload(&gpu, &kind, &[0_u32; 8]));
                buffers.end_frame();
            }
            (largest, buffers.shelves[kind.name].uploads.len())
        };
        assert_eq!(frames(1, &[1 << 16], 3), (1 << 16, 3));
        assert_eq!(frames(KEEP_FRAMES - 2, &[1 << 8], 1), (1 << 16, 3));
        assert_eq!(frames(KEEP_FRAMES + 4, &[1 << 8], 1), (1 << 8, 1));
        // Planted: a frame that needs both sizes retains the larger one.
        assert_eq!(frames(2 * KEEP_FRAMES + 4, &[1 << 16, 1 << 8], 2), (1 << 16, 2));
        // A buffer that was too large, and now has to grow, is the same one for the whole frame.
        for _ in 0..3 * KEEP_FRAMES {
            if buffers.shelves[kind.name].is_too_large {
                break;
            }
            buffers.scratch(&gpu, &kind, 1 << 8);
            buffers.end_frame();
        }
        assert!(buffers.shelves[kind.name].is_too_large);
        let [written, read] = [(); 2].map(|()| buffers.scratch(&gpu, &kind, 1 << 18).raw);
        assert!(written == read);
    }
}
