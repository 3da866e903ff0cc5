//! Pictures on the GPU that passes write and read, and the sets of them that belong to an eye.
//!
//! A pass asks for a picture by its [`TargetKind`]. It is made at the first call, stays the same while somebody asks,
//! and goes when nobody has for a while.

use rustc_hash::FxHashMap;

use super::pools::KEEP_FRAMES;
use super::{Gpu, GpuError};

/// A 2D picture of one mip level.
#[derive(Clone, Debug)]
pub struct Target {
    /// What a trace calls it.
    pub name: &'static str,
    /// For copies.
    pub texture: wgpu::Texture,
    /// For bindings.
    pub view: wgpu::TextureView,
}

/// A picture that passes ask for by name.
#[derive(Debug)]
pub struct TargetKind {
    /// Unique among the kinds.
    pub name: &'static str,
    /// Of a texel.
    pub format: wgpu::TextureFormat,
    /// It gains `TEXTURE_BINDING` and `COPY_SRC`.
    pub usage: wgpu::TextureUsages,
}

impl TargetKind {
    /// A picture that compute passes write.
    pub const fn storage(name: &'static str, format: wgpu::TextureFormat) -> Self {
        Self { name, format, usage: wgpu::TextureUsages::STORAGE_BINDING }
    }

    /// A picture that is rendered to.
    pub const fn attachment(name: &'static str, format: wgpu::TextureFormat) -> Self {
        Self { name, format, usage: wgpu::TextureUsages::RENDER_ATTACHMENT }
    }
}

impl Target {
    /// Makes one; its texels are 0.
    pub fn new(gpu: &Gpu, kind: &TargetKind, size_px: [u32; 2]) -> Self {
        gpu.count_object();
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(kind.name),
            size: wgpu::Extent3d { width: size_px[0], height: size_px[1], depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: kind.format,
            usage: kind.usage | wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Self { name: kind.name, texture, view }
    }

    /// Width and height.
    pub fn size_px(&self) -> [u32; 2] {
        [self.texture.width(), self.texture.height()]
    }

    /// Bytes on the GPU.
    pub fn bytes(&self) -> u64 {
        let texel = u64::from(self.texture.format().block_copy_size(None).unwrap_or(4));
        u64::from(self.texture.width()) * u64::from(self.texture.height()) * texel
    }
}

/// The pictures of an eye, by name.
#[derive(Default)]
pub struct Targets {
    size_px: [u32; 2],
    /// By name and size: styles that take turns may want the same picture in two sizes.
    targets: FxHashMap<(&'static str, [u32; 2]), (Target, u64)>,
    frame: u64,
}

impl Targets {
    /// Begins a frame of pictures of `size_px`; those of another size go. Whether they are as large as before.
    ///
    /// # Errors
    /// [`GpuError::Limit`] when they are larger than the device can hold.
    pub fn begin_frame(&mut self, gpu: &Gpu, size_px: [u32; 2]) -> Result<bool, GpuError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if let Some(side) = size_px.into_iter().find(|side| *side > limit) {
            return Err(GpuError::Limit { what: "a picture", wanted: side.into(), limit: limit.into() });
        }
        let size_px = size_px.map(|side| side.max(1));
        let stays = self.size_px == size_px;
        if !stays {
            self.targets.clear();
            self.size_px = size_px;
        }
        self.frame += 1;
        let frame = self.frame;
        self.targets.retain(|_, (_, used_in)| *used_in + KEEP_FRAMES > frame);
        Ok(stays)
    }

    /// The picture of a kind, as large as all.
    pub fn whole(&mut self, gpu: &Gpu, kind: &TargetKind) -> Target {
        self.sized(gpu, kind, self.size_px)
    }

    /// The picture of a kind, of another size.
    pub fn sized(&mut self, gpu: &Gpu, kind: &TargetKind, size_px: [u32; 2]) -> Target {
        let make = || (Target::new(gpu, kind, size_px), 0);
        let (target, used_in) = self.targets.entry((kind.name, size_px)).or_insert_with(make);
        *used_in = self.frame;
        target.clone()
    }

    /// The picture of a kind, if the last frame had it.
    pub fn get(&self, kind: &TargetKind) -> Option<&Target> {
        let mut used = self.targets.values().filter(|(_, used_in)| *used_in == self.frame);
        used.find(|(target, _)| target.name == kind.name).map(|(target, _)| target)
    }

    /// Width and height of a whole picture.
    pub fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// Bytes on the GPU.
    pub fn bytes(&self) -> u64 {
        self.targets.values().map(|(target, _)| target.bytes()).sum()
    }
}
