//! What shaders' variables are bound to, and bind groups that are kept while their resources are the same.

use std::num::NonZeroU64;

use rustc_hash::FxHashMap;

use super::Gpu;
use super::buffer::Buffer;
use super::pools::KEEP_FRAMES;
use super::reflection::Variable;
use super::shader::ShaderError;
use super::target::Target;

/// What a variable is bound to.
#[derive(Clone, Debug)]
pub enum Resource {
    /// A part of a buffer.
    Buffer(Buffer),
    /// A picture that frames share.
    Target(Target),
    /// Any other texture, by its name in a trace.
    Texture(&'static str, wgpu::TextureView),
    /// A sampler.
    Sampler(wgpu::Sampler),
}

/// A resource and the name of the shader variable that it is bound to.
pub type Named = (&'static str, Resource);

impl From<&Target> for Resource {
    fn from(target: &Target) -> Self {
        Self::Target(target.clone())
    }
}

/// A bind group and the offsets of its uniforms, in the order of their bindings.
#[derive(Clone, Debug)]
pub struct Bound {
    /// For group 0.
    pub group: wgpu::BindGroup,
    /// One for each uniform.
    pub offsets: Vec<u32>,
}

/// A resource as it lies in a bind group: two that are equal need no other group.
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

/// The layout, by its place in the list of pipelines, and what is bound.
type Key = (u64, Vec<(u32, Entry)>);

/// Bind groups by what they bind.
#[derive(Default)]
pub struct BindGroups {
    groups: FxHashMap<Key, (wgpu::BindGroup, u64)>,
    frame: u64,
}

impl BindGroups {
    /// Binds named resources to the variables of group 0; what the entry points do not use is passed over. `number` is
    /// unique to `layout`.
    ///
    /// # Errors
    /// [`ShaderError`] when a variable has no resource: a mistake that the first run of a pass shows.
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
            return Ok(Bound { group: group.clone(), offsets });
        }
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

    /// Drops all: what they bind is held by nobody else any more.
    pub fn clear(&mut self) {
        self.groups.clear();
    }

    /// Drops what was not bound in the last frames.
    pub fn end_frame(&mut self) {
        self.frame += 1;
        let frame = self.frame;
        // There are hundreds: looking at all of them is not every frame's work.
        if frame.is_multiple_of(KEEP_FRAMES / 4) {
            self.groups.retain(|_, (_, used_in)| *used_in + KEEP_FRAMES > frame);
        }
    }
}
