//! The texts of shaders: embedded in the program, or read from a folder whose files may be edited while it runs.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use rustc_hash::{FxHashMap, FxHashSet};

use super::shader::{MODULES, SHADERS};

/// The source of the texts of shaders.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Texts {
    /// The folder to read from; `None` means embedded texts.
    folder: Option<Arc<Path>>,
}

impl Texts {
    /// Reads shaders from the folder that the variable `HACHURE_SHADERS` names; without it, they are embedded.
    pub(crate) fn of_environment() -> Self {
        Self::of(std::env::var_os("HACHURE_SHADERS").map(PathBuf::from))
    }

    /// Reads shaders from `folder`. For shaders that it lacks, and for all of them without a folder, the embedded texts
    /// are used.
    pub(crate) fn of(folder: Option<PathBuf>) -> Self {
        Self { folder: folder.map(Arc::from) }
    }

    /// Returns whether the texts are files, which may change.
    pub(crate) fn are_files(&self) -> bool {
        self.folder.is_some()
    }

    /// Returns the text of the shader `name`; `embedded` is used if the folder lacks it.
    pub(crate) fn text(&self, name: &str, embedded: &'static str) -> Cow<'static, str> {
        let read = self.path(name).and_then(|path| std::fs::read_to_string(path).ok());
        read.map_or(Cow::Borrowed(embedded), Cow::Owned)
    }

    fn path(&self, name: &str) -> Option<PathBuf> {
        Some(self.folder.as_ref()?.join(format!("{name}.wgsl")))
    }
}

/// Modification time and length of a file; `None` if there is no file.
type Stamp = Option<(SystemTime, u64)>;

/// Finds texts that have changed since the last check.
#[derive(Debug, Default)]
pub(crate) struct Watch {
    stamps: FxHashMap<&'static str, Stamp>,
}

impl Watch {
    /// Starts watching; only later changes count.
    pub(crate) fn new(texts: &Texts) -> Self {
        let mut watch = Self::default();
        watch.changed(texts);
        watch
    }

    /// Returns the names of the shaders and modules whose files have changed since the last call.
    pub(crate) fn changed(&mut self, texts: &Texts) -> FxHashSet<&'static str> {
        let stamp = |name: &str| {
            let about = std::fs::metadata(texts.path(name)?).ok()?;
            Some((about.modified().ok()?, about.len()))
        };
        let mut changed = FxHashSet::default();
        if texts.are_files() {
            for &(name, _) in MODULES.iter().chain(SHADERS) {
                let now = stamp(name);
                if self.stamps.insert(name, now) != Some(now) {
                    changed.insert(name);
                }
            }
        }
        changed
    }
}

/// Returns the names of `changed` and of all shaders and modules that import one of them, directly or indirectly.
pub(crate) fn made_of(texts: &Texts, changed: &FxHashSet<&'static str>) -> FxHashSet<&'static str> {
    let read = |(name, embedded): &(&'static str, &'static str)| {
        let (path, imports, _) = naga_oil::compose::get_preprocessor_data(&texts.text(name, embedded));
        (*name, path.unwrap_or_default(), imports)
    };
    let all: Vec<_> = MODULES.iter().chain(SHADERS).map(read).collect();
    let mut made_of = changed.clone();
    loop {
        let before = made_of.len();
        let paths: Vec<&str> =
            all.iter().filter(|(name, ..)| made_of.contains(name)).map(|(_, path, _)| path.as_str()).collect();
        for (name, _, imports) in &all {
            // An import names a module or an item in it.
            let names = |path: &&str| {
                let rest = |import: &str| {
                    import.strip_prefix(*path).is_some_and(|rest| rest.is_empty() || rest.starts_with("::"))
                };
                !path.is_empty() && imports.iter().any(|import| rest(&import.import))
            };
            if paths.iter().any(names) {
                made_of.insert(name);
            }
        }
        if made_of.len() == before {
            return made_of;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn importers(name: &'static str) -> FxHashSet<&'static str> {
        made_of(&Texts::default(), &FxHashSet::from_iter([name]))
    }

    #[test]
    fn a_module_is_in_all_that_imports_it() {
        let view = importers("shared/view");
        // Directly, and through another module.
        for name in ["shared/view", "lines/lsa", "composite/composite", "shared/hatch", "tones/hatching"] {
            assert!(view.contains(name), "{name}");
        }
        // Planted: shaders that do not import it; and a module whose name begins with the name of another.
        assert!(!view.contains("gpu/scan") && !view.contains("composite/present"));
        assert!(!importers("shared/strokes").contains("shared/stroke_samples"));
        assert_eq!(importers("lines/lsa"), FxHashSet::from_iter(["lines/lsa"]));
    }

    #[test]
    fn embedded_texts_do_not_change() {
        let texts = Texts::default();
        assert!(Watch::new(&texts).changed(&texts).is_empty() && !texts.are_files());
    }
}
