//! The texts of shaders: those in the program, or those of a folder that is being worked on, which may change.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use rustc_hash::{FxHashMap, FxHashSet};

use super::shader::{MODULES, SHADERS};

/// The folder of `HACHURE_SHADERS`, if there is one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Texts {
    folder: Option<Arc<Path>>,
}

impl Texts {
    /// Of the folder that `HACHURE_SHADERS` names, or embedded.
    pub fn of_environment() -> Self {
        Self::of(std::env::var_os("HACHURE_SHADERS").map(PathBuf::from))
    }

    /// Of a folder; what it lacks is embedded, and so is all without a folder.
    pub fn of(folder: Option<PathBuf>) -> Self {
        Self { folder: folder.map(Arc::from) }
    }

    /// Whether they may change.
    pub fn are_files(&self) -> bool {
        self.folder.is_some()
    }

    /// The text of a shader.
    pub fn text(&self, name: &str, embedded: &'static str) -> Cow<'static, str> {
        let read = self.path(name).and_then(|path| std::fs::read_to_string(path).ok());
        read.map_or(Cow::Borrowed(embedded), Cow::Owned)
    }

    fn path(&self, name: &str) -> Option<PathBuf> {
        Some(self.folder.as_ref()?.join(format!("{name}.wgsl")))
    }
}

/// When a file was written and how long it is; none where there is none.
type Stamp = Option<(SystemTime, u64)>;

/// Looks for texts that have changed since it last looked.
#[derive(Debug, Default)]
pub struct Watch {
    stamps: FxHashMap<&'static str, Stamp>,
}

impl Watch {
    /// From now on.
    pub fn new(texts: &Texts) -> Self {
        let mut watch = Self::default();
        watch.changed(texts);
        watch
    }

    /// The shaders whose files have changed, modules among them.
    pub fn changed(&mut self, texts: &Texts) -> FxHashSet<&'static str> {
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

/// The shaders that are made of one of `changed`: themselves, or what they import.
pub fn made_of(texts: &Texts, changed: &FxHashSet<&'static str>) -> FxHashSet<&'static str> {
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
            // An import names a module, or something in it.
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
        // By itself, and through another module.
        for name in ["shared/view", "lines/lsa", "composite/composite", "shared/hatch", "tones/hatching"] {
            assert!(view.contains(name), "{name}");
        }
        // Planted: what does not import it, among it a module whose name begins as another one's does.
        assert!(!view.contains("lines/strokes/chain_clear") && !view.contains("composite/present"));
        assert!(!importers("shared/strokes").contains("shared/stroke_samples"));
        assert_eq!(importers("lines/lsa"), FxHashSet::from_iter(["lines/lsa"]));
    }

    #[test]
    fn embedded_texts_do_not_change() {
        let texts = Texts::default();
        assert!(Watch::new(&texts).changed(&texts).is_empty() && !texts.are_files());
    }
}
