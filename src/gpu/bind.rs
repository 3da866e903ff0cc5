//! The resources that shader variables are bound to, and a cache of bind groups.

use std::num::NonZeroU64;

use rustc_hash::FxHashMap;

use super::Gpu;
use super::buffer::Buffer;
use super::cache_counts::CacheCounts;
use super::pools::KEEP_FRAMES;
use super::reflection::Variable;
use super::shader::ShaderError;
use super::target::Target;

/// A resource that a shader variable can be bound to.
#[derive(Clone, Debug)]
pub enum Resource {
    /// A buffer or a part of it.
    Buffer(Buffer),
    /// A render or storage target of an eye.
    Target(Target),
    /// Any other texture, with its name in a trace.
    Texture(&'static str, wgpu::TextureView),
    Sampler(wgpu::Sampler),
}

/// The name of a shader variable, and the resource that is bound to it.
pub(crate) type Named = (&'static str, Resource);

impl From<&Target> for Resource {
    fn from(target: &Target) -> Self {
        Self::Target(target.clone())
    }
}

/// A bind group with the dynamic offsets of its uniforms.
#[derive(Clone, Debug)]
pub struct Bound {
    /// Bind group 0.
    pub group: wgpu::BindGroup,
    /// The dynamic offsets in bytes, one per uniform in the order of their bindings.
    pub offsets: Vec<u32>,
}

/// A resource as it appears in a bind group, without dynamic offsets. Groups with equal entries are interchangeable.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Entry {
    Buffer(wgpu::Buffer, u64, Option<NonZeroU64>),
    View(wgpu::TextureView),
    Sampler(wgpu::Sampler),
}

impl Entry {
    fn resource(&self) -> wgpu::BindingResource<'_> {
        match self {
            Self::Buffer(buffer, offset, size) => {
                wgpu::BindingResource::Buffer(wgpu::BufferBinding { buffer, offset: *offset, size: *size })
            }
            Self::View(view) => wgpu::BindingResource::TextureView(view),
            Self::Sampler(sampler) => wgpu::BindingResource::Sampler(sampler),
        }
    }
}

/// The number of a layout, which is that of its pipeline's build, and the resource at each binding.
type Key = (u64, Vec<(u32, Entry)>);

/// A cache of bind groups, by the resources that they bind.
#[derive(Default)]
pub struct BindGroups {
    /// Each group with the frame that last used it.
    groups: FxHashMap<Key, (wgpu::BindGroup, u64)>,
    frame: u64,
    counts: CacheCounts,
}

impl BindGroups {
    /// Returns how often a bind group was available.
    pub(crate) fn counts(&self) -> CacheCounts {
        self.counts
    }

    /// Binds named resources to the variables of group 0. Resources that the entry points do not use are ignored.
    /// `number` identifies `layout`.
    ///
    /// # Errors
    /// [`ShaderError`] if a variable has no resource. This is a bug, which the first run of the pass reveals.
    pub fn bind(
        &mut self,
        gpu: &Gpu,
        label: &str,
        (number, layout): (u64, &wgpu::BindGroupLayout),
        variables: &[Variable],
        resources: &[Named],
    ) -> Result<Bound, ShaderError> {
        let mut offsets = Vec::new();
        let mut entries = Vec::with_capacity(variables.len());
        // Variables are sorted by their bindings.
        for variable in variables {
            let Some((_, resource)) = resources.iter().find(|(name, _)| *name == variable.name) else {
                return Err(ShaderError::new(label, &format!("nothing is bound to {}", variable.name)));
            };
            let entry = match resource {
                Resource::Buffer(buffer) if variable.is_uniform() => {
                    offsets.push(buffer.offset as u32);
                    let rest = NonZeroU64::new(buffer.raw.size() - buffer.offset);
                    Entry::Buffer(buffer.raw.clone(), 0, buffer.size.or(rest))
                }
                Resource::Buffer(buffer) => Entry::Buffer(buffer.raw.clone(), buffer.offset, buffer.size),
                Resource::Target(target) => Entry::View(target.view.clone()),
                Resource::Texture(_, view) => Entry::View(view.clone()),
                Resource::Sampler(sampler) => Entry::Sampler(sampler.clone()),
            };
            entries.push((variable.entry.binding, entry));
        }
        let frame = self.frame;
        let key = (number, entries);
        if let Some((group, used_in)) = self.groups.get_mut(&key) {
            *used_in = frame;
            self.counts.count(true);
            return Ok(Bound { group: group.clone(), offsets });
        }
        self.counts.count(false);
        gpu.count_object();
        let entries: Vec<_> = key
            .1
            .iter()
            .map(|(binding, entry)| wgpu::BindGroupEntry { binding: *binding, resource: entry.resource() })
            .collect();
        let group =
            gpu.device.create_bind_group(&wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &entries });
        self.groups.insert(key, (group.clone(), frame));
        Ok(Bound { group, offsets })
    }

    /// Drops all bind groups, and with them the last references to resources that have been replaced.
    pub fn clear(&mut self) {
        self.groups.clear();
    }

    /// Drops the bind groups that the last [`KEEP_FRAMES`] frames did not use.
    pub fn end_frame(&mut self) {
        self.frame += 1;
        let frame = self.frame;
        // There are hundreds of groups, too many to check all of them in every frame.
        if frame.is_multiple_of(KEEP_FRAMES / 4) {
            self.groups.retain(|_, (_, used_in)| *used_in + KEEP_FRAMES > frame);
        }
    }
}
