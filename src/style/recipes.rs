//! Recipes that a style names: built-in ones, and files relative to the style.

use std::borrow::Cow;
use std::io;
use std::path::{Path, PathBuf};

use super::StyleError;
use crate::file::input::{LARGEST_STYLE_BYTES, read_text};

/// The recipes of one kind.
pub(super) struct Recipes {
    /// Name and text of each built-in recipe.
    pub built_in: &'static [(&'static str, &'static str)],
    /// Makes the error for a name that is neither built in nor ends with `.toml`.
    pub unknown: fn(String) -> StyleError,
    /// Makes the error for a file that cannot be read.
    pub unreadable: fn(String, io::Error) -> StyleError,
}

impl Recipes {
    /// Returns the names of the built-in recipes.
    pub(super) fn names(&self) -> Vec<&'static str> {
        self.built_in.iter().map(|(name, _)| *name).collect()
    }

    /// Returns the file that `name` refers to, relative to `folder`; `None` for a built-in recipe.
    pub(super) fn file(&self, name: &str, folder: &Path) -> Option<PathBuf> {
        let is_built_in = self.built_in.iter().any(|(known, _)| *known == name);
        (!is_built_in).then(|| folder.join(name))
    }

    /// Returns the recipe's name or path for messages, and its text.
    ///
    /// # Errors
    /// The recipe does not exist, or its file cannot be read.
    pub(super) fn text(&self, name: &str, folder: &Path) -> Result<(String, Cow<'static, str>), StyleError> {
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
