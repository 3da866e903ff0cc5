//! Reads pictures and buffers back from the GPU, and waits for them. It is meant for files and measurements, never for
//! interactive frames.

use super::target::Target;
use super::{Gpu, GpuError};

/// Reads a window of `target` (origin and size in pixels) as rows without padding, in the target's own texel format.
///
/// # Errors
/// [`GpuError::Readback`] if the device is lost or out of memory.
pub fn read(gpu: &Gpu, target: &Target, origin_px: [u32; 2], size_px: [u32; 2]) -> Result<Vec<u8>, GpuError> {
    read_layer(gpu, &target.texture, 0, origin_px, size_px)
}

/// Returns the aspect of a texture that is read: depth if it has depth, otherwise all.
pub(crate) fn aspect(texture: &wgpu::Texture) -> wgpu::TextureAspect {
    if texture.format().is_depth_stencil_format() { wgpu::TextureAspect::DepthOnly } else { wgpu::TextureAspect::All }
}

/// Reads a window of one layer of a texture, from its first mip level. The result is like that of [`read`].
///
/// # Errors
/// The errors of [`read`].
pub(crate) fn read_layer(
    gpu: &Gpu,
    texture: &wgpu::Texture,
    layer: u32,
    origin_px: [u32; 2],
    size_px: [u32; 2],
) -> Result<Vec<u8>, GpuError> {
    let aspect = aspect(texture);
    let texel = texture.format().block_copy_size(Some(aspect)).unwrap_or(4);
    let row_bytes = size_px[0] * texel;
    let padded_row_bytes = row_bytes.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size: u64::from(padded_row_bytes) * u64::from(size_px[1]),
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("readback") });
    encoder.copy_texture_to_buffer(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: wgpu::Origin3d { x: origin_px[0], y: origin_px[1], z: layer },
            aspect,
        },
        wgpu::TexelCopyBufferInfo {
            buffer: &buffer,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(padded_row_bytes),
                rows_per_image: Some(size_px[1]),
            },
        },
        wgpu::Extent3d { width: size_px[0], height: size_px[1], depth_or_array_layers: 1 },
    );
    gpu.queue.submit([encoder.finish()]);
    map(gpu, &buffer)?;
    let padded = buffer.get_mapped_range(..).map_err(|error| GpuError::Readback(error.to_string()))?;
    let mut rows = Vec::new();
    let needed_bytes = row_bytes as usize * size_px[1] as usize;
    rows.try_reserve_exact(needed_bytes)
        .map_err(|_| GpuError::Readback(format!("not enough memory: {needed_bytes} bytes are needed")))?;
    for row in padded.chunks_exact(padded_row_bytes as usize) {
        rows.extend_from_slice(&row[..row_bytes as usize]);
    }
    Ok(rows)
}

/// Reads the first `count` elements of type `T` of a buffer.
///
/// # Errors
/// The errors of [`read`].
pub(crate) fn read_buffer<T: bytemuck::Pod>(
    gpu: &Gpu,
    source: &wgpu::Buffer,
    count: usize,
) -> Result<Vec<T>, GpuError> {
    if count == 0 {
        return Ok(Vec::new());
    }
    let size = (count * size_of::<T>()) as u64;
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("readback") });
    encoder.copy_buffer_to_buffer(source, 0, &buffer, 0, size);
    gpu.queue.submit([encoder.finish()]);
    map(gpu, &buffer)?;
    let bytes = buffer.get_mapped_range(..).map_err(|error| GpuError::Readback(error.to_string()))?;
    Ok(bytemuck::pod_collect_to_vec(&bytes))
}

/// Maps a buffer for reading, and waits until it is mapped.
fn map(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<(), GpuError> {
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |result| {
        // The receiver waits below, so sending can fail only if that thread has ended.
        let _ = sender.send(result);
    });
    gpu.wait();
    receiver
        .recv()
        .map_err(|error| GpuError::Readback(error.to_string()))?
        .map_err(|error| GpuError::Readback(error.to_string()))
}

/// Reads a window of `target` like [`read`], and returns the bytes as elements of type `T`.
///
/// # Errors
/// The errors of [`read`].
pub(crate) fn read_as<T: bytemuck::Pod>(
    gpu: &Gpu,
    target: &Target,
    origin_px: [u32; 2],
    size_px: [u32; 2],
) -> Result<Vec<T>, GpuError> {
    Ok(bytemuck::pod_collect_to_vec(&read(gpu, target, origin_px, size_px)?))
}
