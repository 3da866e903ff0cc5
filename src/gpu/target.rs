//! Pictures on the GPU that passes write and read, and the pools of them that belong to an eye.
//!
//! A pass requests a picture by its [`TargetKind`]. The first request creates it, later requests return the same one,
//! and a picture that has not been requested for a while is released.

use rustc_hash::FxHashMap;

use super::pools::KEEP_FRAMES;
use super::{Gpu, GpuError};

/// Number of frames whose pictures [`Targets::of_latest_frames`] returns.
#[cfg(feature = "window")]
const LATEST: u64 = 12;

/// A 2D picture with one mip level.
#[derive(Clone, Debug)]
pub struct Target {
    /// Name in a trace.
    pub name: &'static str,
    /// Group and sentence of the list of pictures.
    pub content: Content,
    pub texture: wgpu::Texture,
    /// View of the whole texture.
    pub view: wgpu::TextureView,
}

/// The content of a picture of a frame, in words for people who look at it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Content {
    /// Heading under which it is listed.
    pub group: Group,
    /// One sentence that says what the picture shows.
    pub sentence: &'static str,
    /// Channels of an integer format that hold the bits of 32-bit floats, as a mask.
    pub(crate) float_words: u32,
}

impl Content {
    /// Returns the content of a picture of words, of which these channels, as a mask, hold the bits of 32-bit floats.
    pub(crate) const fn with_float_words(self, float_words: u32) -> Self {
        Self { float_words, ..self }
    }
}

/// A heading of the list of pictures, in the order of that list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Group {
    /// The ink of layers.
    Ink,
    /// The land or object at each pixel: depth, position, normal, identity.
    Surface,
    /// The smoothed land and its curvature.
    Form,
    /// Detected lines, and lines from shading.
    Lines,
    /// Edges and strokes.
    Strokes,
    /// Light and tones.
    Tones,
    /// Impostors of trees and their light.
    Trees,
    /// The picture, its samples and the sky.
    Whole,
}

impl Group {
    /// Returns the heading.
    pub fn heading(self) -> &'static str {
        match self {
            Self::Whole => "The drawing and its samples",
            Self::Ink => "Layers of ink",
            Self::Surface => "Surface",
            Self::Form => "Shape of the land",
            Self::Lines => "Lines",
            Self::Strokes => "Strokes",
            Self::Tones => "Tones",
            Self::Trees => "Trees",
        }
    }

    /// Returns what a picture of this group shows.
    pub(crate) const fn shows(self, sentence: &'static str) -> Content {
        Content { group: self, sentence, float_words: 0 }
    }
}

/// The name and the content of a texture that passes only read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureName {
    /// Name in a trace.
    pub name: &'static str,
    pub content: Content,
}

/// The description of a picture that passes request by name.
#[derive(Debug)]
pub struct TargetKind {
    /// Unique name, which is also the label and the name in a trace.
    pub name: &'static str,
    /// Group and sentence of the list of pictures.
    pub content: Content,
    pub format: wgpu::TextureFormat,
    /// Usages besides `TEXTURE_BINDING` and `COPY_SRC`, which every target has.
    pub usage: wgpu::TextureUsages,
}

impl TargetKind {
    /// Describes a picture that compute passes write.
    pub(crate) const fn storage(name: &'static str, format: wgpu::TextureFormat, content: Content) -> Self {
        Self { name, content, format, usage: wgpu::TextureUsages::STORAGE_BINDING }
    }

    /// Describes a picture that render passes draw on.
    pub(crate) const fn attachment(name: &'static str, format: wgpu::TextureFormat, content: Content) -> Self {
        Self { name, content, format, usage: wgpu::TextureUsages::RENDER_ATTACHMENT }
    }
}

impl Target {
    /// Creates a target whose texels are 0.
    pub(crate) fn new(gpu: &Gpu, kind: &TargetKind, size_px: [u32; 2]) -> Self {
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
        Self { name: kind.name, content: kind.content, texture, view }
    }

    /// Returns width and height, in pixels.
    pub fn size_px(&self) -> [u32; 2] {
        [self.texture.width(), self.texture.height()]
    }

    /// Returns the size on the GPU, in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let texel = u64::from(self.texture.format().block_copy_size(None).unwrap_or(4));
        u64::from(self.texture.width()) * u64::from(self.texture.height()) * texel
    }
}

/// A pool with the pictures of an eye.
#[derive(Default)]
pub(crate) struct Targets {
    /// Size of a whole picture, in pixels.
    size_px: [u32; 2],
    /// Each target with the last frame that requested it, by name, number and size: alternating styles may need the
    /// same picture in two sizes, and a style may have several layers of a kind.
    targets: FxHashMap<(&'static str, usize, [u32; 2]), (Target, u64)>,
    frame: u64,
}

impl Targets {
    /// Begins a frame with pictures of `size_px` pixels, and releases pictures that have not been requested for a
    /// while. If the size differs from that of the previous frame, releases all pictures. Returns whether it is the
    /// same.
    ///
    /// # Errors
    /// [`GpuError::Limit`] if the pictures are larger than the device allows.
    pub(crate) fn begin_frame(&mut self, gpu: &Gpu, size_px: [u32; 2]) -> Result<bool, GpuError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        if let Some(side) = size_px.into_iter().find(|side| *side > limit) {
            return Err(GpuError::Limit {
                what: "the side of a picture in pixels",
                wanted: side.into(),
                limit: limit.into(),
            });
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

    /// Returns the picture of a kind, in the size of a whole picture.
    pub(crate) fn whole(&mut self, gpu: &Gpu, kind: &TargetKind) -> Target {
        self.sized(gpu, kind, self.size_px)
    }

    /// Returns the picture of a kind in the given size, in pixels.
    pub(crate) fn sized(&mut self, gpu: &Gpu, kind: &TargetKind, size_px: [u32; 2]) -> Target {
        self.entry(gpu, kind, 0, size_px)
    }

    /// Returns one of several pictures of a kind, in the size of a whole picture. Number 0 is that of
    /// [`whole`](Self::whole).
    pub(crate) fn numbered(&mut self, gpu: &Gpu, kind: &TargetKind, number: usize) -> Target {
        self.entry(gpu, kind, number, self.size_px)
    }

    fn entry(&mut self, gpu: &Gpu, kind: &TargetKind, number: usize, size_px: [u32; 2]) -> Target {
        let make = || (Target::new(gpu, kind, size_px), 0);
        let (target, used_in) = self.targets.entry((kind.name, number, size_px)).or_insert_with(make);
        *used_in = self.frame;
        target.clone()
    }

    /// Returns the picture of a kind, if the latest frame requested it; of several pictures that with number 0.
    pub(crate) fn get(&self, kind: &TargetKind) -> Option<&Target> {
        let mut used = self.targets.iter().filter(|(_, (_, used_in))| *used_in == self.frame);
        used.find(|((name, number, _), _)| *name == kind.name && *number == 0).map(|(_, (target, _))| target)
    }

    /// Returns the pictures that one of the latest frames requested, each with its number among those of its kind, by name.
    /// Not every frame rebuilds its strokes.
    #[cfg(feature = "window")]
    pub(crate) fn of_latest_frames(&self) -> Vec<(usize, &Target)> {
        let used = self.targets.iter().filter(|(_, (_, used_in))| used_in + LATEST > self.frame);
        let mut used: Vec<(usize, &Target)> = used.map(|((_, number, _), (target, _))| (*number, target)).collect();
        used.sort_by_key(|(number, target)| (target.name, *number, target.size_px()));
        used
    }

    /// Returns width and height of a whole picture, in pixels.
    pub(crate) fn size_px(&self) -> [u32; 2] {
        self.size_px
    }

    /// Returns the total size on the GPU, in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.targets.values().map(|(target, _)| target.bytes()).sum()
    }
}
