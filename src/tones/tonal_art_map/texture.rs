//! A tonal art map on the GPU.

use super::TonalArtMap;
use crate::gpu::Gpu;

/// Thresholds.
pub const MARK_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R8Unorm;

/// The thresholds as a texture of one level: an average of thresholds is the threshold of nothing, so hatching is
/// scaled by steps of its own.
pub struct MarkTexture {
    texture: wgpu::Texture,
    view: wgpu::TextureView,
}

impl MarkTexture {
    /// Sends a map.
    pub fn new(gpu: &Gpu, map: &TonalArtMap) -> Self {
        let side = map.side_px;
        let size = wgpu::Extent3d { width: side, height: side, depth_or_array_layers: 1 };
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("tonal art map"),
            size,
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: MARK_FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        gpu.queue.write_texture(
            texture.as_image_copy(),
            &map.thresholds,
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(side), rows_per_image: Some(side) },
            size,
        );
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Self { texture, view }
    }

    /// What the shader binds.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// For measurements.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }
}
