//! Shaders: WGSL files with imports (naga_oil).
//!
//! Every shader of the folder `shaders` is embedded, so that the program is one file. `build.rs` lists them: what lies in
//! `shaders/shared` is imported by others, and what lies elsewhere is a pass. A test parses and validates each without a
//! GPU.
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

/// Shaders with a variant that definitions turn on (`#ifdef`).
pub const VARIANTS: &[(&str, &[&str])] = &[
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
    ("tones/relief/radiance", &["WARPED"]),
    ("tones/relief/radiance", &["HORIZON_MAPS", "TREE_SHADOWS"]),
    ("tones/relief/radiance", &["HORIZON_MAPS", "TREE_SHADOWS", "WARPED"]),
    ("tones/relief/scaling", &["HORIZON_MAPS"]),
    ("tones/relief/scaling", &["HORIZON_MAPS", "TREE_SHADOWS"]),
    ("tones/plain", &["LOCAL_COLOR"]),
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
    ("surface/trees/edges", &["WIND"]),
    ("surface/motion", &["WIND"]),
    ("composite/composite", &["SKY"]),
    ("surface/lakes/blocks", &["GIVEN"]),
    ("tones/water", &["MIRROR"]),
];

/// A mistake in a shader's text, with its place.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{name}.wgsl{}: {cause}", place.map(|[line, column]| format!(":{line}:{column}")).unwrap_or_default())]
pub struct ShaderError {
    /// Which one.
    pub name: String,
    /// Line and column, if they are known.
    pub place: Option<[u32; 2]>,
    /// What naga or the driver says, in one line.
    pub cause: String,
}

impl ShaderError {
    /// Of a whole shader.
    pub fn new(name: &str, cause: &str) -> Self {
        Self { name: name.to_owned(), place: None, cause: cause.split_whitespace().collect::<Vec<_>>().join(" ") }
    }

    /// From the lines that naga and naga_oil write: `error: cause`, `┌─ name:line:column`, the text, and `= notes`.
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
/// [`ShaderError`] when the text does not parse or validate, or is not in the table.
pub fn compose(name: &str) -> Result<naga::Module, ShaderError> {
    compose_variant(name, &[])
}

/// As [`compose`], with definitions turned on.
///
/// # Errors
/// As [`compose`].
pub fn compose_variant(name: &str, definitions: &[&str]) -> Result<naga::Module, ShaderError> {
    compose_of(&Texts::of_environment(), name, definitions)
}

/// As [`compose_variant`], of other texts.
///
/// # Errors
/// As [`compose`].
pub fn compose_of(texts: &Texts, name: &str, definitions: &[&str]) -> Result<naga::Module, ShaderError> {
    let (_, embedded) = SHADERS
        .iter()
        .find(|(known, _)| *known == name)
        .ok_or_else(|| ShaderError::new(name, "not in the table of shaders"))?;
    compose_defined(texts, name, &texts.text(name, embedded), definitions)
}

/// Composes a shader that is in no table, with the imports that the others have: to run a shared function by itself.
///
/// # Errors
/// [`ShaderError`] when `source` does not parse or validate; `name` is for errors.
pub fn compose_text(name: &str, source: &str) -> Result<naga::Module, ShaderError> {
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

/// Composers that know all modules, as embedded. To read the modules takes longer than most shaders take, so each is used
/// again; there are as many as threads that compose at once.
static COMPOSERS: Mutex<Vec<Composer>> = Mutex::new(Vec::new());

fn composers() -> MutexGuard<'static, Vec<Composer>> {
    // A panic elsewhere leaves whole composers.
    COMPOSERS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// One that knows all modules.
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
    /// [`ShaderError`] when the text is wrong; what wgpu says of it goes to the open error scope.
    pub fn new(device: &wgpu::Device, texts: &Texts, name: &str, definitions: &[&str]) -> Result<Self, ShaderError> {
        let module = compose_of(texts, name, definitions)?;
        let reflection = Reflection::new(name, &module)?;
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
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
        // Validation, too.
        let text = "fn f() -> f32 {\n    return 1u;\n}\n";
        let error = compose_text("some/pass", text).map(|_| ()).unwrap_err();
        assert!(error.to_string().starts_with("some/pass.wgsl:"), "{error}");
        assert!(!error.cause.is_empty() && !error.to_string().contains('\n'), "{error}");
        // What has no such lines is taken as it is.
        assert_eq!(ShaderError::of_lines("a", "x:\n  y").to_string(), "a.wgsl: x: y");
    }
}
