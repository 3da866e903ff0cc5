//! A ring of staging buffers, through which layers of a texture array are uploaded to the GPU.
//!
//! `Queue::write_texture` allocates a staging buffer for every call, without a bound. Here a frame may upload what one
//! buffer holds, and more if frames take long anyway, so that uploads take the same share of the time. While the GPU
//! still reads all buffers, nothing is uploaded: the frame thread never waits.

use std::sync::mpsc::{Receiver, Sender, channel};

use super::Gpu;

/// Size of a buffer in bytes, which is what a short frame may upload.
const BUFFER_BYTES: u64 = 8 << 20;
/// Largest number of buffers: one is filled while the GPU reads others.
const BUFFERS: usize = 4;
/// A frame may upload one buffer for every 0.03 s that it takes; filling a buffer takes about 3 ms.
const BUFFER_S: f64 = 0.03;

/// A ring of up to four staging buffers of 8 MiB.
pub(crate) struct UploadRing {
    /// Number of existing buffers.
    made: usize,
    /// Mapped buffers, ready to be written.
    ready: Vec<wgpu::Buffer>,
    /// Receives the buffers that the GPU has read and that are mapped again.
    back: Receiver<wgpu::Buffer>,
    give_back: Sender<wgpu::Buffer>,
}

impl Default for UploadRing {
    fn default() -> Self {
        let (give_back, back) = channel();
        Self { made: 0, ready: Vec::new(), back, give_back }
    }
}

impl UploadRing {
    /// Returns the size of all staging buffers, in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.made as u64 * BUFFER_BYTES
    }

    /// Returns whether a buffer can be written, after creating one if there are fewer than four.
    pub(crate) fn is_ready(&mut self, gpu: &Gpu) -> bool {
        self.ready.extend(self.back.try_iter());
        if self.ready.is_empty() && self.made < BUFFERS {
            self.made += 1;
            self.ready.push(gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("upload ring"),
                size: BUFFER_BYTES,
                usage: wgpu::BufferUsages::MAP_WRITE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: true,
            }));
        }
        !self.ready.is_empty()
    }

    /// Uploads square layers of `side` × `side` texels of four bytes to `texture`, each with the index of its layer: as
    /// many as a frame of `frame_s` seconds may upload. Returns how many were uploaded, which is 0 while the GPU still
    /// reads all buffers.
    pub(crate) fn send(
        &mut self,
        gpu: &Gpu,
        texture: &wgpu::Texture,
        side: u32,
        layers: &[(u32, &[f32])],
        frame_s: f64,
    ) -> usize {
        let most = (frame_s / BUFFER_S).clamp(1.0, BUFFERS as f64) as usize;
        let mut sent = 0;
        for _ in 0..most {
            match self.send_buffer(gpu, texture, side, &layers[sent..]) {
                0 => break,
                count => sent += count,
            }
        }
        sent
    }

    /// Uploads as many layers as one buffer holds, and returns how many.
    fn send_buffer(&mut self, gpu: &Gpu, texture: &wgpu::Texture, side: u32, layers: &[(u32, &[f32])]) -> usize {
        if layers.is_empty() || !self.is_ready(gpu) {
            return 0;
        }
        let Some(buffer) = self.ready.pop() else { return 0 };
        let pitch = (side * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let layer_bytes = u64::from(pitch) * u64::from(side);
        let count = layers.len().min((BUFFER_BYTES / layer_bytes) as usize);
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("upload") });
        {
            let Ok(mut view) = buffer.get_mapped_range_mut(..layer_bytes * count as u64) else { return 0 };
            let rows = layers[..count].iter().flat_map(|(_, texels)| texels.chunks_exact(side as usize));
            for (row, texels) in rows.enumerate() {
                let start = row * pitch as usize;
                view.slice(start..start + 4 * side as usize).copy_from_slice(bytemuck::cast_slice(texels));
            }
        }
        buffer.unmap();
        for (i, (layer, _)) in layers[..count].iter().enumerate() {
            encoder.copy_buffer_to_texture(
                wgpu::TexelCopyBufferInfo {
                    buffer: &buffer,
                    layout: wgpu::TexelCopyBufferLayout {
                        offset: layer_bytes * i as u64,
                        bytes_per_row: Some(pitch),
                        rows_per_image: Some(side),
                    },
                },
                wgpu::TexelCopyTextureInfo {
                    texture,
                    mip_level: 0,
                    origin: wgpu::Origin3d { x: 0, y: 0, z: *layer },
                    aspect: wgpu::TextureAspect::All,
                },
                wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 },
            );
        }
        gpu.queue.submit([encoder.finish()]);
        let give_back = self.give_back.clone();
        let again = buffer.clone();
        buffer.map_async(wgpu::MapMode::Write, .., move |mapped| {
            // Sending fails only if the ring has been dropped, and mapping only if the device is lost: the buffer is no
            // longer needed.
            if mapped.is_ok() {
                let _ = give_back.send(again);
            }
        });
        count
    }
}
