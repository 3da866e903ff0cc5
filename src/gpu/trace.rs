//! A trace of what the passes of a frame read and write. The list of passes in `src/frame_passes.md`, the memory
//! traffic by pass, and the pictures that `--show` can draw come from it.

use super::bind::{Named, Resource};
use super::reflection::Variable;
use super::target::Target;

/// One recorded run of a pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassTrace {
    /// Name of the pass, which is that of its shader.
    pub name: &'static str,
    /// Index of its submit in the frame, from 0.
    pub submit: u32,
    /// Resources that it reads, in the order of its bindings.
    pub reads: Vec<Traced>,
    /// Resources that it writes.
    pub writes: Vec<Traced>,
}

/// A picture, buffer or uniform that a pass reads or writes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Traced {
    /// Name of the picture, buffer or uniform.
    pub name: &'static str,
    /// The texture of a picture; `None` for a buffer.
    pub texture: Option<wgpu::Texture>,
    /// Size on the GPU, in bytes.
    pub bytes: u64,
}

/// Sizes of the pictures and buffers that a pass reads and writes in a frame, in bytes. Each resource counts once and
/// whole, whatever part of it the pass accesses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct PassBytes {
    /// Total size of the resources that it reads.
    pub read: u64,
    /// Total size of the resources that it writes.
    pub written: u64,
}

impl PassBytes {
    /// Sums over all runs of the pass `name` in a frame.
    pub(crate) fn of(trace: &[PassTrace], name: &str) -> Self {
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

    /// Returns the texel format of a picture; `None` for a buffer.
    pub fn format(&self) -> Option<wgpu::TextureFormat> {
        self.texture.as_ref().map(wgpu::Texture::format)
    }
}

/// Returns the resources that a pass reads and those that it writes.
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
