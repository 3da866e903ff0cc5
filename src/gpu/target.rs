//! Pictures on the GPU that passes write and read.

use super::Gpu;

/// A 2D picture of one mip level.
pub struct Target {
    /// For copies.
    pub texture: wgpu::Texture,
    /// For bindings.
    pub view: wgpu::TextureView,
}

impl Target {
    /// A picture that compute passes write (storage) and read (texture), and that can be read back.
    pub fn storage(gpu: &Gpu, label: &str, size_px: [u32; 2], format: wgpu::TextureFormat) -> Self {
        use wgpu::TextureUsages as Usage;
        Self::new(gpu, label, size_px, format, Usage::STORAGE_BINDING | Usage::TEXTURE_BINDING | Usage::COPY_SRC)
    }

    /// A picture that is rendered to and then read.
    pub fn attachment(gpu: &Gpu, label: &str, size_px: [u32; 2], format: wgpu::TextureFormat) -> Self {
        use wgpu::TextureUsages as Usage;
        Self::new(gpu, label, size_px, format, Usage::RENDER_ATTACHMENT | Usage::TEXTURE_BINDING | Usage::COPY_SRC)
    }

    fn new(gpu: &Gpu, label: &str, size_px: [u32; 2], format: wgpu::TextureFormat, usage: wgpu::TextureUsages) -> Self {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width: size_px[0], height: size_px[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Self { texture, view }
    }

    /// As the colour of a render pass that begins with zeros.
    pub fn cleared(&self) -> Option<wgpu::RenderPassColorAttachment<'_>> {
        Some(wgpu::RenderPassColorAttachment {
            view: &self.view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store },
        })
    }

    /// As the colour of a render pass that draws onto what is there.
    pub fn kept(&self) -> Option<wgpu::RenderPassColorAttachment<'_>> {
        Some(wgpu::RenderPassColorAttachment {
            view: &self.view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
        })
    }

    /// Bytes on the GPU.
    pub fn bytes(&self) -> u64 {
        let texel = u64::from(self.texture.format().block_copy_size(None).unwrap_or(4));
        u64::from(self.texture.width()) * u64::from(self.texture.height()) * texel
    }
}
