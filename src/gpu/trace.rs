//! A trace of what the passes of a frame read and write. The list of passes in `src/frame_passes.md`, the memory
//! traffic by pass, and the pictures that `--show` can draw come from it.
//!
//! Terms, here and in the reports of `bench`:
//!
//! - A **pass** is a named shader (`lines/lsa`) with all its runs in a frame. A *run* is one dispatch, or one render pass.
//! - A **wgpu pass** is a compute pass or a render pass of the API. Consecutive dispatches share one.
//! - **Bytes** are the sizes of what passes declare to read and write ([`PassBytes`]).
//! - **Memory** is what the pictures and buffers that passes bind occupy on the GPU, with the maps of tiles that the style
//!   requires ([`Renderer::drawing_bytes`](crate::frame::Renderer::drawing_bytes)).
//! - A **barrier** is a place where work has to wait for earlier work of the frame ([`FrameCounts`]).

use rustc_hash::{FxHashMap, FxHashSet};

use super::bind::{Named, Resource};
use super::reflection::Variable;
use super::target::{Content, Target, TextureName};

/// One recorded run of a pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassTrace {
    /// Name of the pass, which is that of its shader.
    pub name: &'static str,
    /// Index of its submit in the frame, from 0.
    pub submit: u32,
    /// Its work on the GPU.
    pub work: Work,
    /// Names of the buffers that were copied to or cleared between the pass before it and this one.
    pub copied: Vec<&'static str>,
    /// Resources that it reads, in the order of its bindings.
    pub reads: Vec<Traced>,
    /// Resources that it writes.
    pub writes: Vec<Traced>,
}

/// The work of a pass on the GPU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Work {
    /// A dispatch of compute workgroups.
    Dispatch,
    /// A dispatch whose number of workgroups is in the buffer of this name.
    Indirect(&'static str),
    /// A render pass with this many draws.
    Draws(u32),
}

/// A picture, buffer or uniform that a pass reads or writes.
#[derive(Clone, Debug)]
pub struct Traced {
    /// Name of the picture, buffer or uniform.
    pub name: &'static str,
    /// Group and sentence of a picture; `None` for a buffer.
    pub content: Option<Content>,
    /// The texture of a picture; `None` for a buffer.
    pub texture: Option<wgpu::Texture>,
    /// The buffer that holds it; `None` for a picture.
    pub buffer: Option<wgpu::Buffer>,
    /// Size on the GPU, in bytes. When a frame is finished, that of a list is the size that the frame filled, and that of
    /// an atlas the size of the tiles that the view needs (`src/frame/in_use.rs`).
    pub bytes: u64,
}

/// Buffers of one name and size are one list, such as the pools of a list that has several, and are equal.
impl PartialEq for Traced {
    fn eq(&self, other: &Self) -> bool {
        let of = |used: &Self| (used.name, used.content, used.texture.clone(), used.bytes);
        of(self) == of(other)
    }
}

impl Eq for Traced {}

/// Atlases, which have a layer for each tile of the land.
pub(crate) const ATLASES: [&str; 3] = ["height tiles", "horizon maps", "water maps"];

/// Buffers of which a frame binds only some.
const POOLED: [&str; 2] = ["row counts", "row candidates"];

/// Returns the memory of the pictures and buffers that the passes of a frame bind, in bytes. Each counts once and as it
/// is allocated: with all mip levels and layers, and the whole of a list, however far it is filled. Atlases and the pools
/// of rows do not count ([`Renderer::drawing_bytes`](crate::frame::Renderer::drawing_bytes)).
pub(crate) fn memory_bytes(trace: &[PassTrace]) -> u64 {
    let (mut textures, mut buffers) = (FxHashSet::default(), FxHashSet::default());
    for used in trace.iter().flat_map(|pass| pass.reads.iter().chain(&pass.writes)) {
        textures.extend(used.texture.as_ref().filter(|_| !ATLASES.contains(&used.name)));
        buffers.extend(used.buffer.as_ref().filter(|_| !POOLED.contains(&used.name)));
    }
    textures.into_iter().map(texture_bytes).chain(buffers.into_iter().map(wgpu::Buffer::size)).sum()
}

/// Returns the size of a texture with all its mip levels and layers, in bytes.
fn texture_bytes(texture: &wgpu::Texture) -> u64 {
    let texel = u64::from(texture.format().block_copy_size(None).unwrap_or(4));
    let level = |level: u32| [texture.width(), texture.height()].map(|side| u64::from((side >> level).max(1)));
    let texels = (0..texture.mip_level_count()).map(|number| level(number).iter().product::<u64>()).sum::<u64>();
    texel * texels * u64::from(texture.depth_or_array_layers())
}

/// Sizes of the pictures and buffers that a pass reads and writes in a frame, in bytes. Each resource counts once for a
/// pass, however often the pass runs: a picture whole, whatever part of it the pass accesses, a list as far as the frame
/// filled it, and an atlas with the tiles that the view needs.
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

/// The work of a frame on the GPU, when its passes are not timed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct FrameCounts {
    /// Compute and render passes of wgpu. Consecutive dispatches share one.
    pub wgpu_passes: u32,
    /// Compute dispatches, with a number of workgroups from the CPU or from the GPU.
    pub dispatches: u32,
    /// Draws in render passes.
    pub draws: u32,
    /// Copies between buffers, and clears of buffers.
    pub copies: u32,
    /// How often a dispatch, a render pass or a copy has to wait for earlier ones, because it reads or writes what they
    /// wrote, or writes what they read. Everything that a shader may write counts as written.
    pub barriers: u32,
}

impl FrameCounts {
    /// Counts the passes of a frame, however they were submitted.
    pub(crate) fn of(trace: &[PassTrace]) -> Self {
        let mut counts = Self::default();
        let mut states = States::default();
        let mut is_open = false;
        for pass in trace {
            for &buffer in &pass.copied {
                counts.copies += 1;
                counts.barriers += u32::from(states.write((buffer, None)));
                is_open = false;
            }
            let mut waits = false;
            match pass.work {
                Work::Draws(draws) => {
                    counts.draws += draws;
                    counts.wgpu_passes += 1;
                    is_open = false;
                }
                Work::Dispatch | Work::Indirect(_) => {
                    counts.dispatches += 1;
                    counts.wgpu_passes += u32::from(!is_open);
                    is_open = true;
                }
            }
            if let Work::Indirect(arguments) = pass.work {
                waits |= states.read((arguments, None));
            }
            for used in pass.reads.iter().filter(|used| !pass.writes.contains(used)) {
                waits |= states.read((used.name, used.texture.as_ref()));
            }
            for used in &pass.writes {
                waits |= states.write((used.name, used.texture.as_ref()));
            }
            counts.barriers += u32::from(waits);
        }
        counts
    }
}

/// How each resource was last used in a frame. A buffer is known by its name.
#[derive(Default)]
struct States<'a> {
    is_written: FxHashMap<(&'static str, Option<&'a wgpu::Texture>), bool>,
}

impl<'a> States<'a> {
    /// Notes that a resource is read, and returns whether the reader has to wait.
    fn read(&mut self, used: (&'static str, Option<&'a wgpu::Texture>)) -> bool {
        self.is_written.insert(used, false) == Some(true)
    }

    /// Notes that a resource is written, and returns whether the writer has to wait.
    fn write(&mut self, used: (&'static str, Option<&'a wgpu::Texture>)) -> bool {
        self.is_written.insert(used, true).is_some()
    }
}

impl Traced {
    pub(super) fn of(target: &Target) -> Self {
        Self {
            name: target.name,
            content: Some(target.content),
            texture: Some(target.texture.clone()),
            buffer: None,
            bytes: target.used_bytes(),
        }
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
                let raw = Some(buffer.raw.clone());
                Traced { name: buffer.name, content: None, texture: None, buffer: raw, bytes }
            }
            Some((_, Resource::Texture(TextureName { name, content }, view))) => {
                let texture = view.texture();
                let texel = u64::from(texture.format().block_copy_size(None).unwrap_or(4));
                let [width, height, layers] =
                    [texture.width(), texture.height(), texture.depth_or_array_layers()].map(u64::from);
                Traced {
                    name,
                    content: Some(*content),
                    texture: Some(texture.clone()),
                    buffer: None,
                    bytes: texel * width * height * layers,
                }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn pass(work: Work, reads: &[&'static str], writes: &[&'static str]) -> PassTrace {
        let traced = |names: &[&'static str]| {
            let traced = |name| Traced { name, content: None, texture: None, buffer: None, bytes: 4 };
            names.iter().copied().map(traced).collect::<Vec<_>>()
        };
        let (copied, reads, writes) = (Vec::new(), traced(reads), traced(writes));
        PassTrace { name: "pass", submit: 0, work, copied, reads, writes }
    }

    #[test]
    fn dispatches_share_a_pass_until_something_comes_between() {
        let mut trace = vec![
            pass(Work::Dispatch, &["uniform"], &["a"]),
            pass(Work::Dispatch, &["uniform"], &["b"]),
            pass(Work::Indirect("a"), &["b"], &["c"]),
            pass(Work::Draws(3), &["c"], &["picture"]),
            pass(Work::Dispatch, &["uniform"], &["d"]),
        ];
        let expected = FrameCounts { wgpu_passes: 3, dispatches: 4, draws: 3, copies: 0, barriers: 2 };
        assert_eq!(FrameCounts::of(&trace), expected);
        // Planted: a copy between two dispatches closes their pass, and waits for the one that wrote its buffer.
        trace[1].copied.push("a");
        assert_eq!(FrameCounts::of(&trace), FrameCounts { wgpu_passes: 4, copies: 1, barriers: 3, ..expected });
        // Planted: a write to what was read before.
        trace[4].writes[0].name = "c";
        assert_eq!(FrameCounts::of(&trace).barriers, 4);
    }
}
