//! What the passes of a frame read and wrote: the list of passes, the memory by pass and the pictures that can be shown
//! all come from it.

use super::bind::{Named, Resource};
use super::reflection::Variable;
use super::target::Target;

/// A pass as it was recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassTrace {
    /// Of its shader.
    pub name: &'static str,
    /// In which submit of the frame it was recorded, from 0.
    pub submit: u32,
    /// What it reads, in the order of its bindings.
    pub reads: Vec<Traced>,
    /// What it writes.
    pub writes: Vec<Traced>,
}

/// A resource of a pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Traced {
    /// Of the picture, the buffer or the uniform.
    pub name: &'static str,
    /// Of a picture; none of a buffer.
    pub texture: Option<wgpu::Texture>,
    /// What it takes on the GPU.
    pub bytes: u64,
}

/// Bytes of the pictures and buffers that the passes of a name read, and of those that they write: each whole and once,
/// whatever part of it they touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PassBytes {
    /// Of what it reads.
    pub read: u64,
    /// Of what it writes.
    pub written: u64,
}

impl PassBytes {
    /// Of the passes of that name in a frame.
    pub fn of(trace: &[PassTrace], name: &str) -> Self {
        let bytes = |uses: fn(&PassTrace) -> &[Traced]| {
            let mut known: Vec<&Traced> = Vec::new();
            for used in trace.iter().filter(|pass| pass.name == name).flat_map(uses) {
                if !known.contains(&used) {
                    known.push(used);
                }
            }
            known.iter().map(|used| used.bytes).sum()
        };
        Self { read: bytes(|pass| &pass.reads), written: bytes(|pass| &pass.writes) }
    }
}

impl Traced {
    pub(super) fn of(target: &Target) -> Self {
        Self { name: target.name, texture: Some(target.texture.clone()), bytes: target.bytes() }
    }

    /// Of a picture's texels; none of a buffer.
    pub fn format(&self) -> Option<wgpu::TextureFormat> {
        self.texture.as_ref().map(wgpu::Texture::format)
    }
}

/// What a pass reads and what it writes.
pub(super) fn uses(variables: &[Variable], resources: &[Named]) -> (Vec<Traced>, Vec<Traced>) {
    let (mut reads, mut writes) = (Vec::new(), Vec::new());
    for variable in variables {
        let bound = resources.iter().find(|(name, _)| *name == variable.name);
        let traced = match bound {
            Some((_, Resource::Target(target))) => Traced::of(target),
            Some((_, Resource::Buffer(buffer))) => {
                let bytes = buffer.size.map_or(buffer.raw.size() - buffer.offset, u64::from);
                Traced { name: buffer.name, texture: None, bytes }
            }
            Some((_, Resource::Texture(name, view))) => {
                let texture = view.texture();
                let texel = u64::from(texture.format().block_copy_size(None).unwrap_or(4));
                let [width, height, layers] =
                    [texture.width(), texture.height(), texture.depth_or_array_layers()].map(u64::from);
                Traced { name, texture: Some(texture.clone()), bytes: texel * width * height * layers }
            }
            Some((_, Resource::Sampler(_))) | None => continue,
        };
        if variable.is_written {
            writes.push(traced.clone());
        }
        if variable.is_read {
            reads.push(traced);
        }
    }
    (reads, writes)
}
