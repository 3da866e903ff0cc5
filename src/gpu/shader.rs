//! Composes shaders from WGSL files with imports (naga_oil).
//!
//! Every shader of the folder `shaders` is embedded, so that the program is one file. `build.rs` lists them: files in
//! `shaders/shared` are modules that others import, and every other file is a pass. A test parses and validates each
//! file without a GPU.
//!
//! Why: `docs/decisions/shaders-and-passes.md`.

use std::borrow::Cow;
use std::sync::{Mutex, MutexGuard, PoisonError};

use naga_oil::compose::{ComposableModuleDescriptor, Composer, NagaModuleDescriptor, ShaderDefValue};
use wgpu::naga;

use super::reflection::{Reflection, Variable};
use super::texts::Texts;

// `MODULES` and `SHADERS`: every file of the folder `shaders`.
include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

/// Variants of shaders, each with the symbols that it defines for `#ifdef`.
#[cfg(test)]
pub(crate) const VARIANTS: &[(&str, &[&str])] = &[
    ("lines/lsa", &["ANTIALIASED"]),
    ("lines/lsa", &["EIGHT"]),
    ("lines/lsa", &["ANTIALIASED", "EIGHT"]),
    ("lines/threshold", &["EIGHT"]),
    ("lines/curvature", &["TEXTURED"]),
    ("lines/ridges", &["APPARENT"]),
    ("lines/tone/search", &["SPECULAR"]),
    ("tones/toon", &["HORIZON_MAPS"]),
    ("tones/toon", &["MARKED_TREES"]),
    ("tones/toon", &["TREE_SHADOWS"]),
    ("tones/toon", &["HORIZON_MAPS", "MARKED_TREES", "TREE_SHADOWS"]),
    ("tones/toon", &["LOCAL_COLOR"]),
    ("tones/toon", &["HORIZON_MAPS", "LOCAL_COLOR", "MARKED_TREES", "TREE_SHADOWS"]),
    ("tones/toon", &["FITTED"]),
    ("tones/toon", &["FITTED", "HORIZON_MAPS", "LOCAL_COLOR", "MARKED_TREES", "TREE_SHADOWS"]),
    ("tones/toon", &["DRAPED_IMAGE"]),
    (
        "tones/toon",
        &["DRAPED_IMAGE", "EDITED", "FITTED", "HORIZON_MAPS", "LOCAL_COLOR", "MARKED_TREES", "TREE_SHADOWS"],
    ),
    ("tones/fit/measure", &["DRAPED_IMAGE"]),
    ("tones/masses/sample", &["DRAPED_IMAGE", "FITTED"]),
    ("tones/fit/measure", &["WATER"]),
    ("tones/fit/measure", &["CRESTS", "HORIZON_MAPS", "RELIEF", "TREE_SHADOWS", "WATER"]),
    ("tones/relief/radiance", &["WARPED"]),
    ("tones/relief/radiance", &["HORIZON_MAPS", "TREE_SHADOWS"]),
    ("tones/relief/radiance", &["HORIZON_MAPS", "TREE_SHADOWS", "WARPED"]),
    ("tones/relief/scaling", &["HORIZON_MAPS"]),
    ("tones/relief/scaling", &["HORIZON_MAPS", "TREE_SHADOWS"]),
    ("tones/plain", &["LOCAL_COLOR"]),
    ("tones/plain", &["DRAPED_IMAGE"]),
    ("tones/plain", &["DRAPED_IMAGE", "LOCAL_COLOR"]),
    ("surface/meshes/resolve", &["LOCAL_COLOR"]),
    ("surface/trees/raster", &["LOCAL_COLOR"]),
    ("surface/trees/raster", &["LOCAL_COLOR", "WIND"]),
    ("surface/trees/impostor", &["LOCAL_COLOR"]),
    ("surface/trees/impostor", &["LOCAL_COLOR", "WIND"]),
    ("surface/trees/place", &["COVER"]),
    ("tones/hatching", &["SWELLING"]),
    ("tones/fractal_hatching", &["ENDED"]),
    ("surface/trees/raster", &["WIND"]),
    ("surface/trees/impostor", &["WIND"]),
    ("surface/trees/shadow", &["WIND"]),
    ("surface/trees/edges", &["WIND", "COUNTS"]),
    ("surface/trees/edges", &["WIND", "WRITES"]),
    ("gpu/scan", &["COUNTED"]),
    ("lines/strokes/chain_rank_begin", &["LOOPS"]),
    ("surface/motion", &["WIND"]),
    ("composite/composite", &["SKY"]),
    ("composite/composite", &["SKY", "LINES", "GRAIN", "BORDERED", "INK_0", "INK_1"]),
    ("surface/lakes/blocks", &["GIVEN"]),
    ("tones/water", &["MIRROR"]),
];

/// An error in the text of a shader, with its position.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{name}.wgsl{}: {cause}", place.map(|[line, column]| format!(":{line}:{column}")).unwrap_or_default())]
pub struct ShaderError {
    /// Name of the shader or module, a path in `shaders` without extension.
    pub name: String,
    /// Line and column from 1, if they are known.
    pub place: Option<[u32; 2]>,
    /// The message of naga or of the driver, in one line.
    pub cause: String,
}

impl ShaderError {
    /// Creates an error without a position.
    pub fn new(name: &str, cause: &str) -> Self {
        Self { name: name.to_owned(), place: None, cause: cause.split_whitespace().collect::<Vec<_>>().join(" ") }
    }

    /// Parses the lines that naga and naga_oil write: `error: cause`, `┌─ name:line:column`, the text, and `= notes`.
    pub(super) fn of_lines(name: &str, lines: &str) -> Self {
        let mut error = Self::new(name, "");
        let mut causes: Vec<&str> = Vec::new();
        for line in lines.lines().map(str::trim) {
            let cause = line.strip_prefix("error: ").or_else(|| line.strip_prefix("= "));
            if let Some(place) = line.strip_prefix("┌─ ") {
                let mut parts = place.rsplitn(3, ':');
                let (column, row) = (parts.next(), parts.next());
                let number = |part: Option<&str>| part.and_then(|part| part.trim().parse::<u32>().ok());
                error.place = number(row).zip(number(column)).map(|(row, column)| [row, column]);
                if let (Some(_), Some(path)) = (error.place, parts.next().filter(|path| !path.is_empty())) {
                    path.clone_into(&mut error.name);
                }
            } else if let Some(cause) = cause.filter(|cause| !causes.contains(cause)) {
                causes.push(cause);
            }
        }
        let cause = if causes.is_empty() { lines.to_owned() } else { causes.join(": ") };
        Self { cause: Self::new(name, &cause).cause, ..error }
    }
}

/// Composes a shader of [`SHADERS`] with its imports.
///
/// # Errors
/// [`ShaderError`] if the text does not compose, or if the shader is not in the table.
#[cfg(test)]
pub(crate) fn compose(name: &str) -> Result<naga::Module, ShaderError> {
    compose_variant(name, &[])
}

/// Composes a shader like [`compose`], with `definitions` for `#ifdef`.
///
/// # Errors
/// The errors of [`compose`].
#[cfg(test)]
pub(crate) fn compose_variant(name: &str, definitions: &[&str]) -> Result<naga::Module, ShaderError> {
    compose_of(&Texts::of_environment(), name, definitions)
}

/// Composes a shader like [`compose_variant`], from the given texts.
///
/// # Errors
/// The errors of [`compose`].
pub(crate) fn compose_of(texts: &Texts, name: &str, definitions: &[&str]) -> Result<naga::Module, ShaderError> {
    let (_, embedded) = SHADERS
        .iter()
        .find(|(known, _)| *known == name)
        .ok_or_else(|| ShaderError::new(name, "hachure has no shader of this name"))?;
    compose_defined(texts, name, &texts.text(name, embedded), definitions)
}

/// Composes a shader from `source`, which may import the same modules as other shaders. It serves to run a shared
/// function by itself. `name` appears in errors.
///
/// # Errors
/// [`ShaderError`] if `source` does not compose.
#[cfg(test)]
pub(crate) fn compose_text(name: &str, source: &str) -> Result<naga::Module, ShaderError> {
    compose_defined(&Texts::of_environment(), name, source, &[])
}

fn compose_defined(texts: &Texts, name: &str, source: &str, definitions: &[&str]) -> Result<naga::Module, ShaderError> {
    let shader_defs =
        definitions.iter().map(|definition| ((*definition).to_owned(), ShaderDefValue::Bool(true))).collect();
    let mut composer = composer(texts)?;
    let module =
        composer.make_naga_module(NagaModuleDescriptor { source, file_path: name, shader_defs, ..Default::default() });
    match module {
        Ok(module) => {
            if !texts.are_files() {
                composers().push(composer);
            }
            Ok(module)
        }
        Err(error) => Err(ShaderError::of_lines(name, &error.emit_to_string(&composer))),
    }
}

/// Composers that have parsed all embedded modules. Parsing the modules takes longer than composing most shaders, so
/// composers are reused. There are as many as threads that compose at the same time.
static COMPOSERS: Mutex<Vec<Composer>> = Mutex::new(Vec::new());

fn composers() -> MutexGuard<'static, Vec<Composer>> {
    // A panic while the lock is held cannot leave a composer half changed.
    COMPOSERS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns a composer that has parsed all modules.
fn composer(texts: &Texts) -> Result<Composer, ShaderError> {
    let known = if texts.are_files() { None } else { composers().pop() };
    if let Some(composer) = known {
        return Ok(composer);
    }
    let mut composer = Composer::default();
    for (path, embedded) in MODULES {
        let source = texts.text(path, embedded);
        let module = ComposableModuleDescriptor { source: &source, file_path: path, ..Default::default() };
        if let Err(error) = composer.add_composable_module(module) {
            return Err(ShaderError::of_lines(path, &error.emit_to_string(&composer)));
        }
    }
    Ok(composer)
}

/// A compiled shader.
pub(crate) struct Shader {
    pub module: wgpu::ShaderModule,
    reflection: Reflection,
}

impl Shader {
    /// Composes and compiles the variant of `name` with `definitions`.
    ///
    /// # Errors
    /// [`ShaderError`] if the text does not compose. Errors of wgpu go to the open error scope.
    pub(crate) fn new(
        device: &wgpu::Device,
        texts: &Texts,
        name: &str,
        definitions: &[&str],
    ) -> Result<Self, ShaderError> {
        Self::with_early_depth(device, texts, (name, definitions), None)
    }

    /// Composes and compiles a variant like [`Shader::new`]. The fragment shader `farther`, if any, writes depths that
    /// are at most those of its triangles, so the GPU may test those first.
    ///
    /// # Errors
    /// The errors of [`Shader::new`].
    pub(crate) fn with_early_depth(
        device: &wgpu::Device,
        texts: &Texts,
        (name, definitions): (&str, &[&str]),
        farther: Option<&str>,
    ) -> Result<Self, ShaderError> {
        let mut module = compose_of(texts, name, definitions)?;
        let reflection = Reflection::new(name, &module)?;
        for entry_point in module.entry_points.iter_mut().filter(|entry| Some(entry.name.as_str()) == farther) {
            let conservative = naga::ConservativeDepth::LessEqual;
            entry_point.early_depth_test = Some(naga::EarlyDepthTest::Allow { conservative });
        }
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(name),
            source: wgpu::ShaderSource::Naga(Cow::Owned(module)),
        });
        Ok(Self { module, reflection })
    }

    /// Returns the variables that a pipeline of these entry points binds, sorted by binding.
    ///
    /// # Errors
    /// [`ShaderError`] if the shader lacks one of the entry points.
    pub(crate) fn variables(&self, entry_points: &[&str]) -> Result<Vec<Variable>, ShaderError> {
        self.reflection.variables(entry_points)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mistake_is_one_line_with_its_place() {
        let text = "#import hachure::view::View\n@group(0) @binding(0) var<uniform> view: View;\n\
                    fn f() -> f32 {\n    return viw.focal_px;\n}\n";
        let error = compose_text("some/pass", text).map(|_| ()).unwrap_err();
        assert!(error.to_string().starts_with("some/pass.wgsl:4:12: "), "{error}");
        assert!(error.cause.contains("viw") && !error.to_string().contains('\n'), "{error}");
        // An error of validation.
        let text = "fn f() -> f32 {\n    return 1u;\n}\n";
        let error = compose_text("some/pass", text).map(|_| ()).unwrap_err();
        assert!(error.to_string().starts_with("some/pass.wgsl:"), "{error}");
        assert!(!error.cause.is_empty() && !error.to_string().contains('\n'), "{error}");
        // A message without such lines is kept whole.
        assert_eq!(ShaderError::of_lines("a", "x:\n  y").to_string(), "a.wgsl: x: y");
    }
}
