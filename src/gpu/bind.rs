//! The resources that shader variables are bound to, and a cache of bind groups.

use std::num::NonZeroU64;

use rustc_hash::FxHashMap;

use super::Gpu;
use super::buffer::Buffer;
use super::cache_counts::CacheCounts;
use super::pools::KEEP_FRAMES;
use super::reflection::Variable;
use super::shader::ShaderError;
use super::target::{Target, TextureName};

/// A resource that a shader variable can be bound to.
#[derive(Clone, Debug)]
pub enum Resource {
    /// A buffer or a part of it.
    Buffer(Buffer),
    /// A render or storage target of an eye.
    Target(Target),
    /// Any other texture.
    Texture(TextureName, wgpu::TextureView),
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
#[derive(Clone, Debug)]
enum Entry {
    Buffer(wgpu::Buffer, u64, Option<NonZeroU64>),
    View(wgpu::TextureView),
    Sampler(wgpu::Sampler),
}

impl Entry {
    fn new(variable: &Variable, resource: &Resource) -> Self {
        match resource {
            Resource::Buffer(buffer) => {
                let (offset, size) = range(variable, buffer);
                Self::Buffer(buffer.raw.clone(), offset, size)
            }
            Resource::Target(target) => Self::View(target.view.clone()),
            Resource::Texture(_, view) => Self::View(view.clone()),
            Resource::Sampler(sampler) => Self::Sampler(sampler.clone()),
        }
    }

    /// Returns whether this is the entry of a resource.
    fn is_of(&self, variable: &Variable, resource: &Resource) -> bool {
        match (self, resource) {
            (Self::Buffer(raw, offset, size), Resource::Buffer(buffer)) => {
                *raw == buffer.raw && (*offset, *size) == range(variable, buffer)
            }
            (Self::View(view), Resource::Target(target)) => *view == target.view,
            (Self::View(view), Resource::Texture(_, other)) => view == other,
            (Self::Sampler(sampler), Resource::Sampler(other)) => sampler == other,
            _ => false,
        }
    }

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

/// Returns the offset and the size with which a buffer is bound. The offset of a uniform is dynamic.
fn range(variable: &Variable, buffer: &Buffer) -> (u64, Option<NonZeroU64>) {
    if variable.is_uniform() {
        let rest = NonZeroU64::new(buffer.raw.size() - buffer.offset);
        (0, buffer.size.or(rest))
    } else {
        (buffer.offset, buffer.size)
    }
}

/// A bind group, with the resource of each variable and the frame that last used it.
struct Known {
    entries: Vec<Entry>,
    group: wgpu::BindGroup,
    used_in: u64,
}

/// The bind groups of a pipeline.
#[derive(Default)]
struct OfPipeline {
    groups: Vec<Known>,
    /// Index of each variable's resource in the last list of resources, since a pass lists them in one order.
    last_indices: Vec<usize>,
}

/// A cache of bind groups, by the resources that they bind.
///
/// A pipeline has few groups: one for each eye, and for each half of the lists that alternate from frame to frame. So
/// they are compared one after the other, which needs neither a copy of the resources nor a hash.
#[derive(Default)]
pub struct BindGroups {
    /// By the number of the layout, which is that of its pipeline's build.
    pipelines: FxHashMap<u64, OfPipeline>,
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
        let frame = self.frame;
        let OfPipeline { groups, last_indices } = self.pipelines.entry(number).or_default();
        last_indices.resize(variables.len(), 0);
        let mut offsets = Vec::with_capacity(4);
        // Variables are sorted by their bindings.
        for (variable, index) in variables.iter().zip(last_indices.iter_mut()) {
            let is_of = |(name, _): &Named| *name == variable.name;
            if !resources.get(*index).is_some_and(is_of) {
                *index = resources
                    .iter()
                    .position(is_of)
                    .ok_or_else(|| ShaderError::new(label, &format!("nothing is bound to {}", variable.name)))?;
            }
            if let (true, Resource::Buffer(buffer)) = (variable.is_uniform(), &resources[*index].1) {
                offsets.push(buffer.offset as u32);
            }
        }
        let bound = || variables.iter().zip(last_indices.iter().map(|index| &resources[*index].1));
        let is_same = |known: &&mut Known| {
            known.entries.iter().zip(bound()).all(|(entry, (variable, resource))| entry.is_of(variable, resource))
        };
        if let Some(known) = groups.iter_mut().find(is_same) {
            known.used_in = frame;
            self.counts.count(true);
            return Ok(Bound { group: known.group.clone(), offsets });
        }
        self.counts.count(false);
        gpu.count_object();
        let entries: Vec<Entry> = bound().map(|(variable, resource)| Entry::new(variable, resource)).collect();
        let numbered = entries.iter().zip(variables);
        let descriptors: Vec<_> = numbered
            .map(|(entry, variable)| wgpu::BindGroupEntry {
                binding: variable.entry.binding,
                resource: entry.resource(),
            })
            .collect();
        let descriptor = wgpu::BindGroupDescriptor { label: Some(label), layout, entries: &descriptors };
        let group = gpu.device.create_bind_group(&descriptor);
        groups.push(Known { entries, group: group.clone(), used_in: frame });
        Ok(Bound { group, offsets })
    }

    /// Drops all bind groups, and with them the last references to resources that have been replaced.
    pub fn clear(&mut self) {
        self.pipelines.clear();
    }

    /// Drops the bind groups that the last [`KEEP_FRAMES`] frames did not use.
    pub fn end_frame(&mut self) {
        self.frame += 1;
        let frame = self.frame;
        // There are hundreds of groups, too many to check all of them in every frame.
        if frame.is_multiple_of(KEEP_FRAMES / 4) {
            self.pipelines.retain(|_, pipeline| {
                pipeline.groups.retain(|known| known.used_in + KEEP_FRAMES > frame);
                !pipeline.groups.is_empty()
            });
        }
    }
}
