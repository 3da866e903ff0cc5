//! Recipes that a style names: those that come with the program, and files beside the style.

use std::borrow::Cow;
use std::io;
use std::path::{Path, PathBuf};

use super::StyleError;
use crate::file::input::{LARGEST_STYLE_BYTES, read_text};

/// Recipes of a kind.
pub(super) struct Recipes {
    /// Those that come with the program: name and text.
    pub built_in: &'static [(&'static str, &'static str)],
    /// That a name is neither one of those nor a file's.
    pub unknown: fn(String) -> StyleError,
    /// That a file cannot be read.
    pub unreadable: fn(String, io::Error) -> StyleError,
}

impl Recipes {
    /// The names of those that come with the program.
    pub fn names(&self) -> Vec<&'static str> {
        self.built_in.iter().map(|(name, _)| *name).collect()
    }

    /// The file that a name means, from `folder` on; none for those that come with the program.
    pub fn file(&self, name: &str, folder: &Path) -> Option<PathBuf> {
        let is_built_in = self.built_in.iter().any(|(known, _)| *known == name);
        (!is_built_in).then(|| folder.join(name))
    }

    /// The text that a name means, and what messages call it.
    ///
    /// # Errors
    /// There is none, or its file cannot be read.
    pub fn text(&self, name: &str, folder: &Path) -> Result<(String, Cow<'static, str>), StyleError> {
        if let Some((_, text)) = self.built_in.iter().find(|(known, _)| *known == name) {
            return Ok((name.to_owned(), Cow::Borrowed(text)));
        }
        if Path::new(name).extension().is_none_or(|extension| extension != "toml") {
            return Err((self.unknown)(name.to_owned()));
        }
        let path = folder.join(name);
        let shown = path.display().to_string();
        match read_text(&path, LARGEST_STYLE_BYTES) {
            Ok(text) => Ok((shown, Cow::Owned(text))),
            Err(error) => Err((self.unreadable)(shown, error)),
        }
    }
}
