//! Reads from a shader module what it binds, so that layouts need not be written a second time in Rust.
//!
//! wgpu can derive layouts too, but never with dynamic offsets, which uniforms of an [`Arena`](super::arena) need, and
//! it does not report what a pass reads and writes.

mod float_words;

use wgpu::naga;
use wgpu::naga::valid::{Capabilities, GlobalUse, ValidationFlags, Validator};

pub(crate) use self::float_words::FloatWords;
use super::shader::ShaderError;

/// A resource variable of a shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variable {
    /// Name in the WGSL source.
    pub name: String,
    /// Entry in the layout of bind group 0.
    pub entry: wgpu::BindGroupLayoutEntry,
    /// Whether the shader may write to the resource.
    pub is_written: bool,
    /// Whether the shader may read the resource's earlier content.
    pub is_read: bool,
    /// The floats of a storage buffer that the shader may write; empty for other resources.
    pub(crate) floats: FloatWords,
}

impl Variable {
    /// Returns whether the variable is a uniform, which is bound with a dynamic offset.
    pub fn is_uniform(&self) -> bool {
        matches!(self.entry.ty, wgpu::BindingType::Buffer { ty: wgpu::BufferBindingType::Uniform, .. })
    }
}

/// The resource variables of each entry point of a shader.
pub(super) struct Reflection {
    /// Name of the shader, for errors.
    name: String,
    entry_points: Vec<(String, Vec<Variable>)>,
}

impl Reflection {
    /// Validates a module and reads its variables.
    ///
    /// # Errors
    /// [`ShaderError`] if the module is invalid, or if a variable has a type that is not supported here.
    pub(super) fn new(name: &str, module: &naga::Module) -> Result<Self, ShaderError> {
        let error = |cause: String| ShaderError::of_lines(name, &cause);
        let info = Validator::new(ValidationFlags::all(), Capabilities::all())
            .validate(module)
            .map_err(|cause| error(cause.emit_to_string("")))?;
        let mut entry_points = Vec::new();
        for (i, entry_point) in module.entry_points.iter().enumerate() {
            let function = info.get_entry_point(i);
            let mut variables = Vec::new();
            for (handle, variable) in module.global_variables.iter() {
                let (Some(binding), false) = (&variable.binding, function[handle].is_empty()) else { continue };
                // For a texture: whether it is read through a sampler. For a sampler: whether every texture that it
                // reads can be filtered.
                let mut pairs = function.sampling_set.iter();
                let filters = match module.types[variable.ty].inner {
                    naga::TypeInner::Sampler { .. } => {
                        pairs.all(|pair| pair.sampler != handle || is_float(module, pair.image))
                    }
                    _ => pairs.any(|pair| pair.image == handle),
                };
                let ty = binding_type(module, variable, filters).ok_or_else(|| {
                    error(format!("the variable {:?} has a type that hachure cannot bind", variable.name))
                })?;
                // naga_oil decorates the names of imported variables: `nameX_naga_oil_mod_X…X`.
                let decorated = variable.name.as_deref().unwrap_or_default();
                let (is_read, is_written) = access(&ty, function[handle]);
                variables.push(Variable {
                    name: decorated.split("X_naga_oil_mod_").next().unwrap_or(decorated).to_owned(),
                    entry: wgpu::BindGroupLayoutEntry {
                        binding: binding.binding,
                        visibility: visibility(entry_point.stage),
                        ty,
                        count: None,
                    },
                    is_written,
                    is_read,
                    floats: match variable.space {
                        naga::AddressSpace::Storage { .. } if is_written => FloatWords::of(module, variable.ty),
                        _ => FloatWords::default(),
                    },
                });
            }
            entry_points.push((entry_point.name.clone(), variables));
        }
        Ok(Self { name: name.to_owned(), entry_points })
    }

    /// Returns the variables that any of the entry points uses, sorted by binding.
    ///
    /// # Errors
    /// [`ShaderError`] if the shader lacks one of the entry points.
    pub(super) fn variables(&self, entry_points: &[&str]) -> Result<Vec<Variable>, ShaderError> {
        let mut all: Vec<Variable> = Vec::new();
        for wanted in entry_points {
            let Some((_, variables)) = self.entry_points.iter().find(|(name, _)| name == wanted) else {
                return Err(ShaderError::new(&self.name, &format!("has no entry point {wanted}")));
            };
            for variable in variables {
                match all.iter_mut().find(|known| known.name == variable.name) {
                    Some(known) => {
                        known.entry.visibility |= variable.entry.visibility;
                        known.is_read |= variable.is_read;
                        known.is_written |= variable.is_written;
                        if !known.floats.has_any() {
                            known.floats.clone_from(&variable.floats);
                        }
                        // A texture that is sampled in one stage has to be filterable in both.
                        if is_filterable(&variable.entry.ty) {
                            known.entry.ty = variable.entry.ty;
                        }
                    }
                    None => all.push(variable.clone()),
                }
            }
        }
        all.sort_by_key(|variable| variable.entry.binding);
        Ok(all)
    }
}

fn is_filterable(ty: &wgpu::BindingType) -> bool {
    let filterable = wgpu::TextureSampleType::Float { filterable: true };
    matches!(ty, wgpu::BindingType::Texture { sample_type, .. } if *sample_type == filterable)
}

fn visibility(stage: naga::ShaderStage) -> wgpu::ShaderStages {
    match stage {
        naga::ShaderStage::Vertex => wgpu::ShaderStages::VERTEX,
        naga::ShaderStage::Fragment => wgpu::ShaderStages::FRAGMENT,
        _ => wgpu::ShaderStages::COMPUTE,
    }
}

/// Returns whether an entry point may read and whether it may write such a binding, which it uses in this way. WGSL has
/// no storage buffers that are only written, so of a buffer that may be written the use decides.
fn access(ty: &wgpu::BindingType, used: GlobalUse) -> (bool, bool) {
    match ty {
        wgpu::BindingType::Buffer { ty: wgpu::BufferBindingType::Storage { read_only: false }, .. } => (
            used.intersects(GlobalUse::READ | GlobalUse::ATOMIC),
            used.intersects(GlobalUse::WRITE | GlobalUse::ATOMIC),
        ),
        wgpu::BindingType::StorageTexture { access, .. } => match access {
            wgpu::StorageTextureAccess::WriteOnly => (false, true),
            wgpu::StorageTextureAccess::ReadOnly => (true, false),
            _ => (true, true),
        },
        _ => (true, false),
    }
}

/// Returns the binding type of a variable, or `None` if it is not supported. `filters` applies to textures and
/// samplers.
fn binding_type(module: &naga::Module, variable: &naga::GlobalVariable, filters: bool) -> Option<wgpu::BindingType> {
    // With a minimum size, wgpu rejects a buffer that is too small when it is bound, not when the frame is submitted.
    let least = std::num::NonZeroU64::new(u64::from(module.types[variable.ty].inner.size(module.to_ctx())));
    let buffer = |ty, has_dynamic_offset| wgpu::BindingType::Buffer { ty, has_dynamic_offset, min_binding_size: least };
    match variable.space {
        naga::AddressSpace::Uniform => return Some(buffer(wgpu::BufferBindingType::Uniform, true)),
        naga::AddressSpace::Storage { access } => {
            let read_only = !access.contains(naga::StorageAccess::STORE);
            return Some(buffer(wgpu::BufferBindingType::Storage { read_only }, false));
        }
        _ => {}
    }
    match module.types[variable.ty].inner {
        naga::TypeInner::Sampler { comparison } => Some(wgpu::BindingType::Sampler(match (comparison, filters) {
            (true, _) => wgpu::SamplerBindingType::Comparison,
            (false, true) => wgpu::SamplerBindingType::Filtering,
            (false, false) => wgpu::SamplerBindingType::NonFiltering,
        })),
        naga::TypeInner::Image { dim, arrayed, class } => {
            let view_dimension = match (dim, arrayed) {
                (naga::ImageDimension::D2, false) => wgpu::TextureViewDimension::D2,
                (naga::ImageDimension::D2, true) => wgpu::TextureViewDimension::D2Array,
                _ => return None,
            };
            match class {
                naga::ImageClass::Sampled { kind, multi } => {
                    let sample_type = match kind {
                        naga::ScalarKind::Float => wgpu::TextureSampleType::Float { filterable: filters },
                        naga::ScalarKind::Sint => wgpu::TextureSampleType::Sint,
                        naga::ScalarKind::Uint => wgpu::TextureSampleType::Uint,
                        _ => return None,
                    };
                    Some(wgpu::BindingType::Texture { sample_type, view_dimension, multisampled: multi })
                }
                naga::ImageClass::Depth { multi } => Some(wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Depth,
                    view_dimension,
                    multisampled: multi,
                }),
                naga::ImageClass::Storage { format, access } => {
                    let reads = access.contains(naga::StorageAccess::LOAD);
                    let writes = access.contains(naga::StorageAccess::STORE);
                    let access = match (reads, writes) {
                        (true, true) => wgpu::StorageTextureAccess::ReadWrite,
                        (true, false) => wgpu::StorageTextureAccess::ReadOnly,
                        _ => wgpu::StorageTextureAccess::WriteOnly,
                    };
                    let format = storage_format(format)?;
                    Some(wgpu::BindingType::StorageTexture { access, format, view_dimension })
                }
                naga::ImageClass::External => None,
            }
        }
        _ => None,
    }
}

fn is_float(module: &naga::Module, image: naga::Handle<naga::GlobalVariable>) -> bool {
    let float = naga::ScalarKind::Float;
    matches!(
        module.types[module.global_variables[image].ty].inner,
        naga::TypeInner::Image { class: naga::ImageClass::Sampled { kind, .. }, .. } if kind == float
    )
}

/// Returns a storage format that WebGPU supports without optional features.
fn storage_format(format: naga::StorageFormat) -> Option<wgpu::TextureFormat> {
    use naga::StorageFormat as Naga;
    use wgpu::TextureFormat as Wgpu;
    Some(match format {
        Naga::R32Uint => Wgpu::R32Uint,
        Naga::R32Sint => Wgpu::R32Sint,
        Naga::R32Float => Wgpu::R32Float,
        Naga::Rg32Uint => Wgpu::Rg32Uint,
        Naga::Rg32Sint => Wgpu::Rg32Sint,
        Naga::Rg32Float => Wgpu::Rg32Float,
        Naga::Rgba8Unorm => Wgpu::Rgba8Unorm,
        Naga::Rgba16Float => Wgpu::Rgba16Float,
        Naga::Rgba32Uint => Wgpu::Rgba32Uint,
        Naga::Rgba32Float => Wgpu::Rgba32Float,
        _ => return None,
    })
}
