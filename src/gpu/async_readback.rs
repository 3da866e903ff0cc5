//! Reads a few numbers back from the GPU without waiting: they arrive some frames later. Code that may wait uses
//! [`readback`](super::readback).

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use super::Gpu;
use super::target::Target;

/// Largest number of requests in flight; further requests are dropped.
const MAX_OPEN: usize = 8;

/// Rows of copied pictures begin at multiples of this, as WebGPU requires.
pub(crate) const ROW_BYTES: u64 = wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as u64;

type Mapped = Result<(), wgpu::BufferAsyncError>;

/// A queue of asynchronous readbacks.
pub(crate) struct AsyncReadback {
    /// Unmapped staging buffers.
    spare: Vec<wgpu::Buffer>,
    /// Requests in flight, oldest first.
    open: VecDeque<(wgpu::Buffer, Receiver<Mapped>)>,
    bytes: u64,
}

impl AsyncReadback {
    /// Creates a queue for answers of `bytes` bytes, which must be a multiple of 4.
    pub(crate) fn new(bytes: u64) -> Self {
        Self { spare: Vec::new(), open: VecDeque::new(), bytes }
    }

    /// Requests the first bytes of some buffers, as they are after everything submitted so far. All parts together make
    /// one answer. Returns `false` if too many requests are in flight.
    pub(crate) fn request(&mut self, gpu: &Gpu, parts: &[(&wgpu::Buffer, u64)]) -> bool {
        self.submit(gpu, |encoder, buffer| {
            let mut at = 0;
            for (part, bytes) in parts {
                encoder.copy_buffer_to_buffer(part, 0, buffer, at, *bytes);
                at += bytes;
            }
        })
    }

    /// Requests one texel of a picture, as it is after everything submitted so far. Returns `false` if too many requests
    /// are in flight.
    pub(crate) fn request_texel(&mut self, gpu: &Gpu, picture: &Target, at_px: [u32; 2]) -> bool {
        let [x, y] = at_px;
        self.submit(gpu, |encoder, buffer| {
            encoder.copy_texture_to_buffer(
                wgpu::TexelCopyTextureInfo {
                    texture: &picture.texture,
                    mip_level: 0,
                    origin: wgpu::Origin3d { x, y, z: 0 },
                    aspect: wgpu::TextureAspect::All,
                },
                wgpu::TexelCopyBufferInfo { buffer, layout: wgpu::TexelCopyBufferLayout::default() },
                wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
            );
        })
    }

    /// Requests the same rectangle of several pictures, as they are after everything submitted so far. The answer has the
    /// rows of the first picture, then those of the second, and so on; each row takes [`ROW_BYTES`], so that it may have at
    /// most 16 texels. Returns `false` if too many requests are in flight, or if the answer has more bytes than the queue's.
    pub(crate) fn request_patches(
        &mut self,
        gpu: &Gpu,
        pictures: &[&Target],
        [x, y]: [u32; 2],
        [width, height]: [u32; 2],
    ) -> bool {
        let bytes = pictures.len() as u64 * u64::from(height) * ROW_BYTES;
        if bytes > self.bytes || width > 16 {
            return false;
        }
        self.submit(gpu, |encoder, buffer| {
            for (number, picture) in pictures.iter().enumerate() {
                let offset = number as u64 * u64::from(height) * ROW_BYTES;
                encoder.copy_texture_to_buffer(
                    wgpu::TexelCopyTextureInfo {
                        texture: &picture.texture,
                        mip_level: 0,
                        origin: wgpu::Origin3d { x, y, z: 0 },
                        aspect: wgpu::TextureAspect::All,
                    },
                    wgpu::TexelCopyBufferInfo {
                        buffer,
                        layout: wgpu::TexelCopyBufferLayout {
                            offset,
                            bytes_per_row: Some(ROW_BYTES as u32),
                            rows_per_image: None,
                        },
                    },
                    wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                );
            }
        })
    }

    /// Requests all texels of a picture, as they are after everything submitted so far. Rows are padded to a multiple of
    /// [`ROW_BYTES`]. Returns `false` if too many requests are in flight, or if the picture has more bytes than the
    /// queue's answers.
    pub(crate) fn request_picture(&mut self, gpu: &Gpu, texture: &wgpu::Texture) -> bool {
        let aspect = super::readback::aspect(texture);
        let texel = texture.format().block_copy_size(Some(aspect)).unwrap_or(4);
        let [width, height] = [texture.width(), texture.height()];
        let row_bytes = u64::from(width * texel).next_multiple_of(ROW_BYTES);
        if row_bytes * u64::from(height) > self.bytes {
            return false;
        }
        self.submit(gpu, |encoder, buffer| {
            let layout =
                wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes as u32), rows_per_image: None };
            encoder.copy_texture_to_buffer(
                wgpu::TexelCopyTextureInfo { texture, mip_level: 0, origin: wgpu::Origin3d::ZERO, aspect },
                wgpu::TexelCopyBufferInfo { buffer, layout },
                wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            );
        })
    }

    fn submit(&mut self, gpu: &Gpu, copy: impl FnOnce(&mut wgpu::CommandEncoder, &wgpu::Buffer)) -> bool {
        if self.open.len() == MAX_OPEN {
            return false;
        }
        let buffer = self.spare.pop().unwrap_or_else(|| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("async readback"),
                size: self.bytes,
                usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
                mapped_at_creation: false,
            })
        });
        let mut encoder =
            gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("async readback") });
        copy(&mut encoder, &buffer);
        gpu.queue.submit([encoder.finish()]);
        let (sender, receiver) = channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |mapped| {
            // The receiver is gone if the request was dropped.
            let _ = sender.send(mapped);
        });
        self.open.push_back((buffer, receiver));
        true
    }

    /// Returns whether requests are in flight.
    pub(crate) fn is_waiting(&self) -> bool {
        !self.open.is_empty()
    }

    /// Returns the oldest answer that has arrived and has not been taken. Answers arrive while the device is polled.
    pub(crate) fn take(&mut self) -> Option<Vec<u8>> {
        let mapped = match self.open.front()?.1.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Ok(mapped) => mapped.is_ok(),
            Err(TryRecvError::Disconnected) => false,
        };
        let (buffer, _) = self.open.pop_front()?;
        if !mapped {
            // The device is lost; the next draw reports that.
            return None;
        }
        let bytes = buffer.get_mapped_range(..).ok().map(|bytes| bytes.to_vec());
        buffer.unmap();
        self.spare.push(buffer);
        bytes
    }

    /// Drops all requests in flight.
    pub(crate) fn forget(&mut self) {
        self.open.clear();
    }
}
