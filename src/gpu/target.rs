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
    /// The picture is its upper left part of [`Target::size_px`] texels.
    pub texture: wgpu::Texture,
    /// View of the whole texture.
    pub view: wgpu::TextureView,
    /// Width and height of the picture, in pixels.
    used_px: [u32; 2],
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

    /// Describes the content of a picture of this group.
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
        Self { name: kind.name, content: kind.content, texture, view, used_px: size_px }
    }

    /// Returns a target for a texture, all of which is the picture.
    #[cfg(test)]
    pub(crate) fn of_texture(name: &'static str, content: Content, texture: wgpu::Texture) -> Self {
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let used_px = [texture.width(), texture.height()];
        Self { name, content, texture, view, used_px }
    }

    /// Returns width and height of the picture, in pixels. The texture may be larger ([`Targets::begin_frame`]).
    pub fn size_px(&self) -> [u32; 2] {
        self.used_px
    }

    /// Returns whether the picture is only a part of its texture.
    pub(crate) fn is_part(&self) -> bool {
        self.used_px != [self.texture.width(), self.texture.height()]
    }

    /// Returns the size of the texture on the GPU, in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.texel_bytes() * u64::from(self.texture.width()) * u64::from(self.texture.height())
    }

    /// Returns the size of the picture, which may be a part of the texture, in bytes.
    pub(super) fn used_bytes(&self) -> u64 {
        self.used_px.iter().map(|side| u64::from(*side)).product::<u64>() * self.texel_bytes()
    }

    fn texel_bytes(&self) -> u64 {
        u64::from(self.texture.format().block_copy_size(None).unwrap_or(4))
    }
}

/// Number of texels that are added to the share of the room of a reduced picture, whose size is rounded up, and may have
/// one more block at each end.
const SLACK_PX: u32 = 2;
/// Number of texels by which a texture may be wider than a new one would be, and still be taken.
const WASTE_PX: u32 = 16;

/// A pool with the pictures of an eye.
#[derive(Default)]
pub(crate) struct Targets {
    /// Size of a whole picture, in pixels.
    size_px: [u32; 2],
    /// Size of the textures of whole pictures, if it is not that of the pictures.
    room_px: Option<[u32; 2]>,
    /// Each target with the last frame that requested it, by name, number and size of the texture: alternating styles may
    /// need the same picture in two sizes, and a style may have several layers of a kind.
    targets: FxHashMap<(&'static str, usize, [u32; 2]), (Target, u64)>,
    frame: u64,
}

impl Targets {
    /// Begins a frame with pictures of `size_px` pixels, and releases pictures that have not been requested for a
    /// while. If the size differs from that of the previous frame, releases all pictures.
    ///
    /// With `room_px`, textures have room for whole pictures of that size, and smaller pictures are a part of them: then
    /// pictures are released only if the room changes. Returns whether pictures of the previous frame stay.
    ///
    /// # Errors
    /// [`GpuError::Limit`] if the pictures are larger than the device allows.
    pub(crate) fn begin_frame(
        &mut self,
        gpu: &Gpu,
        size_px: [u32; 2],
        room_px: Option<[u32; 2]>,
    ) -> Result<bool, GpuError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        let room_px = room_px.map(|room| [0, 1].map(|axis| room[axis].max(size_px[axis]).max(1)));
        if let Some(side) = room_px.unwrap_or(size_px).into_iter().find(|side| *side > limit) {
            return Err(GpuError::Limit {
                what: "the side of a picture in pixels",
                wanted: side.into(),
                limit: limit.into(),
            });
        }
        let size_px = size_px.map(|side| side.max(1));
        let stays = self.room_px == room_px && (self.size_px == size_px || (room_px.is_some() && self.frame > 0));
        if !stays {
            self.targets.clear();
        }
        (self.size_px, self.room_px) = (size_px, room_px);
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
        let texture_px = self.texture_px(kind, number, size_px);
        let make = || (Target::new(gpu, kind, texture_px), 0);
        let (target, used_in) = self.targets.entry((kind.name, number, texture_px)).or_insert_with(make);
        *used_in = self.frame;
        target.used_px = size_px;
        target.clone()
    }

    /// Returns the size of the texture for a picture of `size_px`: that of an existing texture that is not much too
    /// large, or else one with the proportionate room of whole pictures of the largest size.
    fn texture_px(&self, kind: &TargetKind, number: usize, size_px: [u32; 2]) -> [u32; 2] {
        // A picture of one texel is a placeholder for one that the style lacks.
        let Some(room_px) = self.room_px.filter(|_| size_px != [1, 1]) else { return size_px };
        if size_px == self.size_px {
            return room_px;
        }
        let grown = |axis: usize| {
            let [side, room, whole] = [size_px, room_px, self.size_px].map(|size| u64::from(size[axis]));
            u32::try_from((side * room).div_ceil(whole)).unwrap_or(u32::MAX).saturating_add(SLACK_PX)
        };
        let wanted_px = [0, 1].map(grown);
        let fits = |texture_px: &[u32; 2]| {
            (0..2).all(|axis| {
                let most_px = wanted_px[axis].saturating_add(WASTE_PX);
                (size_px[axis]..=most_px).contains(&texture_px[axis]) && texture_px[axis] != 1
            })
        };
        let known = self.targets.keys().filter(|(name, of, _)| (*name, *of) == (kind.name, number));
        known.map(|(_, _, texture_px)| *texture_px).find(fits).unwrap_or(wanted_px)
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
