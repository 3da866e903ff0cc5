//! Shaders: WGSL files with imports (naga_oil).
//!
//! Every shader is embedded, so that the program is one file. The table [`SHADERS`] is the only list of them; a test
//! parses and validates each without a GPU.
//!
//! Why: `docs/decisions/shaders-and-passes.md`.

use std::borrow::Cow;

use naga_oil::compose::{ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue};
use wgpu::naga;

use super::Gpu;
use super::reflection::{Reflection, Variable};

macro_rules! shader {
    ($path:literal) => {
        ($path, include_str!(concat!("../../shaders/", $path, ".wgsl")))
    };
}

/// What other shaders import, in the order in which they import each other.
const MODULES: &[(&str, &str)] = &[
    shader!("shared/view"),
    shader!("shared/surface_id"),
    shader!("shared/terrain"),
    shader!("shared/surface"),
    shader!("shared/earth"),
    shader!("shared/patch"),
    shader!("shared/pcg"),
    shader!("shared/mark_normal"),
    shader!("shared/hatch"),
    shader!("shared/cover"),
    shader!("shared/color"),
    shader!("shared/light"),
    shader!("shared/seen"),
    shader!("shared/strokes"),
    shader!("shared/edges"),
    shader!("shared/stroke_style"),
    shader!("shared/ordered"),
    shader!("shared/chain_lengths"),
    shader!("shared/stroke_samples"),
    shader!("shared/wobble"),
    shader!("shared/brush"),
    shader!("shared/meshes"),
];

/// The shaders that become pipelines: one for each pass.
pub const SHADERS: &[(&str, &str)] = &[
    shader!("surface/land/vertices"),
    shader!("surface/land/raster"),
    shader!("surface/meshes/cull"),
    shader!("surface/meshes/vertices"),
    shader!("surface/meshes/raster"),
    shader!("surface/land/resolve"),
    shader!("surface/mark_normal"),
    shader!("surface/meshes/resolve"),
    shader!("surface/motion"),
    shader!("surface/land/horizons"),
    shader!("lines/lsa"),
    shader!("lines/sobel"),
    shader!("lines/roystan"),
    shader!("lines/threshold"),
    shader!("lines/smooth"),
    shader!("surface/land/edges"),
    shader!("surface/meshes/sides"),
    shader!("surface/meshes/edges"),
    shader!("lines/strokes/id_image"),
    shader!("lines/strokes/extract"),
    shader!("gpu/scan_begin"),
    shader!("gpu/scan"),
    shader!("lines/strokes/chain_begin"),
    shader!("lines/strokes/chain_clear"),
    shader!("lines/strokes/chain_bin"),
    shader!("lines/strokes/chain_choose"),
    shader!("lines/strokes/chain_link"),
    shader!("lines/strokes/chain_rank_begin"),
    shader!("lines/strokes/chain_rank"),
    shader!("lines/strokes/chain_heads"),
    shader!("lines/strokes/chain_order"),
    shader!("lines/strokes/arguments"),
    shader!("lines/strokes/points"),
    shader!("lines/strokes/lengths"),
    shader!("lines/strokes/budget"),
    shader!("lines/strokes/budget_choose"),
    shader!("lines/strokes/sizes"),
    shader!("lines/strokes/samples"),
    shader!("lines/strokes/vote"),
    shader!("lines/strokes/carry"),
    shader!("lines/strokes/stroke"),
    shader!("lines/strokes/fading"),
    shader!("lines/strokes/keep"),
    shader!("lines/strokes/advance"),
    shader!("tones/toon"),
    shader!("tones/plain"),
    shader!("tones/watercolor"),
    shader!("tones/hatching"),
    shader!("tones/fractal_hatching"),
    shader!("tones/balance/ink_sums"),
    shader!("tones/balance/ink_windows"),
    shader!("tones/balance/balanced_ink"),
    shader!("composite/composite"),
    shader!("composite/present"),
];

/// Shaders with a variant that definitions turn on (`#ifdef`).
pub const VARIANTS: &[(&str, &[&str])] =
    &[("tones/toon", &["SEEN"]), ("tones/hatching", &["SWELLING"]), ("tones/fractal_hatching", &["ENDED"])];

/// A mistake in a shader's text, with its place.
#[derive(Debug, thiserror::Error)]
#[error("{name}.wgsl: {cause}")]
pub struct ShaderError {
    /// Which one.
    pub name: String,
    /// What naga says.
    pub cause: String,
}

/// The text of a shader: the embedded one, or that of a folder of shaders that is being worked on.
fn text(name: &str, embedded: &'static str) -> Cow<'static, str> {
    let worked_on = std::env::var_os("HACHURE_SHADERS")
        .and_then(|folder| std::fs::read_to_string(std::path::Path::new(&folder).join(format!("{name}.wgsl"))).ok());
    worked_on.map_or(Cow::Borrowed(embedded), Cow::Owned)
}

/// Composes a shader of [`SHADERS`] with its imports.
///
/// # Errors
/// [`ShaderError`] when the text does not parse or validate, or is not in the table.
pub fn compose(name: &str) -> Result<naga::Module, ShaderError> {
    compose_variant(name, &[])
}

/// As [`compose`], with definitions turned on.
///
/// # Errors
/// As [`compose`].
pub fn compose_variant(name: &str, definitions: &[&str]) -> Result<naga::Module, ShaderError> {
    let source = SHADERS
        .iter()
        .find(|(known, _)| *known == name)
        .map(|(_, source)| text(name, source))
        .ok_or_else(|| ShaderError { name: name.to_owned(), cause: "not in the table of shaders".to_owned() })?;
    compose_defined(name, &source, definitions)
}

/// Composes a shader that is in no table, with the imports that the others have: to run a shared function by itself.
///
/// # Errors
/// [`ShaderError`] when `source` does not parse or validate; `name` is for errors.
pub fn compose_text(name: &str, source: &str) -> Result<naga::Module, ShaderError> {
    compose_defined(name, source, &[])
}

fn compose_defined(name: &str, source: &str, definitions: &[&str]) -> Result<naga::Module, ShaderError> {
    let shader_defs =
        definitions.iter().map(|definition| ((*definition).to_owned(), ShaderDefValue::Bool(true))).collect();
    let mut composer = Composer::default();
    for (path, source) in MODULES {
        composer
            .add_composable_module(ComposableModuleDescriptor {
                source: &text(path, source),
                file_path: path,
                ..Default::default()
            })
            .map_err(|error| ShaderError { name: (*path).to_owned(), cause: error.to_string() })?;
    }
    match composer.make_naga_module(NagaModuleDescriptor { source, file_path: name, shader_defs, ..Default::default() })
    {
        Ok(module) => Ok(module),
        Err(error) => Err(ShaderError { name: name.to_owned(), cause: error.emit_to_string(&composer) }),
    }
}

/// A composed shader.
pub struct Shader {
    /// For pipelines.
    pub module: wgpu::ShaderModule,
    reflection: Reflection,
}

impl Shader {
    /// Composes and compiles the variant of `name` with `definitions` turned on.
    ///
    /// # Errors
    /// [`ShaderError`] when the text is wrong; what the driver says of it comes through [`Gpu::check`].
    pub fn new(gpu: &Gpu, name: &str, definitions: &[&str]) -> Result<Self, ShaderError> {
        let module = compose_variant(name, definitions)?;
        let reflection = Reflection::new(name, &module)?;
        gpu.count_object();
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Naga(Cow::Owned(module)),
        });
        Ok(Self { module, reflection })
    }

    /// What a pipeline of these entry points binds, by binding.
    ///
    /// # Errors
    /// [`ShaderError`] when the shader lacks one of them.
    pub fn variables(&self, entry_points: &[&str]) -> Result<Vec<Variable>, ShaderError> {
        self.reflection.variables(entry_points)
    }
}
