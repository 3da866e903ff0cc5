//! Buffers and uniforms of the passes of a frame, and the commands between passes that write, clear and copy them.

use super::{Recorder, encoder};
use crate::gpu::bind::Resource;
use crate::gpu::buffer::{Buffer, BufferKind};

impl Recorder<'_> {
    /// Returns a uniform with `value`, which any number of passes of this frame may bind.
    pub fn uniform<T: bytemuck::NoUninit>(&mut self, name: &'static str, value: &T) -> Resource {
        match self.stand_in(name, size_of::<T>() as u64) {
            Some(blank) => Resource::Buffer(blank),
            None => self.pools.arena.uniform(self.gpu, name, value),
        }
    }

    /// Returns a uniform with these bytes, which must have the layout of the shader's struct.
    pub fn uniform_bytes(&mut self, name: &'static str, bytes: &[u8]) -> Resource {
        match self.stand_in(name, bytes.len() as u64) {
            Some(blank) => Resource::Buffer(blank),
            None => Resource::Buffer(self.pools.arena.push(self.gpu, name, bytes)),
        }
    }

    /// Returns the buffer of a kind that only the GPU writes, with at least `bytes` bytes. All passes and eyes share
    /// it, one after the other.
    pub fn buffer(&mut self, kind: &BufferKind, bytes: u64) -> Buffer {
        if let Some(blank) = self.stand_in(kind.name, bytes) {
            return blank;
        }
        let buffer = self.pools.buffers.scratch(self.gpu, kind, bytes);
        if self.pools.buffers.take_replaced() {
            self.pools.groups.clear();
        }
        buffer
    }

    /// Returns a buffer with `content`, which any number of passes of this frame may bind.
    pub fn upload<T: bytemuck::NoUninit>(&mut self, kind: &BufferKind, content: &[T]) -> Buffer {
        match self.stand_in(kind.name, size_of_val(content) as u64) {
            Some(blank) => blank,
            None => self.pools.buffers.upload(self.gpu, kind, content),
        }
    }

    /// Returns the stand-in for a buffer if this is a prewarming run.
    fn stand_in(&self, name: &'static str, bytes: u64) -> Option<Buffer> {
        let raw = self.blank.clone()?;
        Some(Buffer { name, raw, offset: 0, size: std::num::NonZeroU64::new(bytes) })
    }

    /// Writes the first bytes of a buffer, between the passes recorded so far and those that follow.
    pub fn write<T: bytemuck::NoUninit>(&mut self, buffer: &Buffer, content: &[T]) {
        if self.prewarms() {
            return;
        }
        let from = self.pools.arena.push(self.gpu, buffer.name, content);
        let bytes = size_of_val(content) as u64;
        self.begin_copy(buffer);
        self.encoder.copy_buffer_to_buffer(&from.raw, from.offset, &buffer.raw, buffer.offset, bytes);
    }

    /// Clears a buffer to 0, between the passes recorded so far and those that follow.
    pub fn clear(&mut self, buffer: &Buffer) {
        if !self.prewarms() {
            self.begin_copy(buffer);
            self.encoder.clear_buffer(&buffer.raw, buffer.offset, buffer.size.map(std::num::NonZeroU64::get));
        }
    }

    /// Copies bytes from one buffer to another, between the passes recorded so far and those that follow. Each buffer
    /// comes with an offset in bytes.
    pub fn copy(&mut self, from: (&Buffer, u64), to: (&Buffer, u64), bytes: u64) {
        if self.prewarms() {
            return;
        }
        let at = |(buffer, offset): (&Buffer, u64)| buffer.offset + offset;
        self.begin_copy(to.0);
        self.encoder.copy_buffer_to_buffer(&from.0.raw, at(from), &to.0.raw, at(to), bytes);
    }

    /// Writes the first bytes of a buffer that no pass of this frame has used since it was last reset. The first reset of
    /// a frame is submitted before all passes, so it closes no compute pass.
    pub fn reset<T: bytemuck::NoUninit>(&mut self, buffer: &Buffer, content: &[T]) {
        if self.prewarms() {
            return;
        }
        let from = self.pools.arena.push(self.gpu, buffer.name, content);
        let bytes = size_of_val(content) as u64;
        self.for_reset(buffer).copy_buffer_to_buffer(&from.raw, from.offset, &buffer.raw, buffer.offset, bytes);
    }

    /// Clears a buffer to 0 like [`Recorder::reset`].
    pub fn reset_to_zero(&mut self, buffer: &Buffer) {
        if !self.prewarms() {
            let bytes = buffer.size.map(std::num::NonZeroU64::get);
            self.for_reset(buffer).clear_buffer(&buffer.raw, buffer.offset, bytes);
        }
    }

    /// Returns the encoder for a reset of a buffer.
    fn for_reset(&mut self, buffer: &Buffer) -> &mut wgpu::CommandEncoder {
        if self.reset.iter().any(|(raw, offset)| *raw == buffer.raw && *offset == buffer.offset) {
            self.begin_copy(buffer);
            return &mut self.encoder;
        }
        self.reset.push((buffer.raw.clone(), buffer.offset));
        if let Some(trace) = &mut self.trace {
            trace.first_mut().map_or(&mut self.copied, |first| &mut first.copied).push(buffer.name);
        }
        self.resets.get_or_insert_with(|| encoder(self.gpu))
    }

    /// Closes the open compute pass, because what follows is recorded outside of passes and writes to `buffer`.
    fn begin_copy(&mut self, buffer: &Buffer) {
        self.open = None;
        if self.trace.is_some() {
            self.copied.push(buffer.name);
        }
    }
}
