//! Writes a document to its file, or to a new one.

use std::path::{Path, PathBuf};

use super::document::{Extends, StyleDocument};
use crate::file::FileError;
use crate::file::atomic;
use crate::file::input::{LARGEST_STYLE_BYTES, read_text};
use crate::style::differences::written;
use crate::style::parameters::set;
use crate::style::{Style, StyleError, names};

/// Why a style was not saved.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SaveError {
    /// The document is a preset, which has no file.
    #[error("{name} is built in; save it under another name")]
    Preset {
        /// Name of the preset.
        name: String,
    },
    /// Another program has changed the file.
    #[error("{}: changed by another program since it was read; save under another name, or return to what is saved", path.display())]
    ChangedOutside {
        /// Path of the file.
        path: PathBuf,
    },
    /// A file of this name exists.
    #[error("{}: exists and is not the style that is open; choose another name", path.display())]
    Exists {
        /// Path of the file.
        path: PathBuf,
    },
    /// The name cannot be that of a style file.
    #[error("a style file needs a name")]
    NoName,
    /// The file cannot be written.
    #[error(transparent)]
    Write(#[from] FileError),
    /// The style is not valid at its new place.
    #[error(transparent)]
    Style(#[from] StyleError),
}

impl StyleDocument {
    /// Writes the document to its file.
    ///
    /// # Errors
    /// [`SaveError`]; the file is then unchanged.
    pub(crate) fn save(&mut self) -> Result<(), SaveError> {
        let Some(path) = self.path.clone() else {
            return Err(SaveError::Preset { name: self.name().to_owned() });
        };
        let text = self.text_to_write()?;
        // A file that is gone is written again.
        if let Ok(there) = read_text(&path, LARGEST_STYLE_BYTES)
            && there != self.file_text()
            && there != text
        {
            return Err(SaveError::ChangedOutside { path });
        }
        // A link stays a link.
        let place = path.canonicalize().unwrap_or_else(|_| path.clone());
        atomic::write(&place, text.as_bytes()).map_err(|error| FileError::write(&path, error))?;
        if let Some(extends) = &mut self.extends {
            extends.text = text;
        }
        self.saved = self.text().to_owned();
        self.release();
        self.find_positions();
        Ok(())
    }

    /// Returns the text that the file gets: the whole style, or its differences from the preset that it extends.
    fn text_to_write(&self) -> Result<String, StyleError> {
        match &self.extends {
            Some(Extends { preset, text }) => written(self.name(), preset, self.text(), Some(text)),
            None => Ok(self.text().to_owned()),
        }
    }

    /// Writes the document to a new file, which must not exist, and returns the document of that file. A preset gets
    /// the name of the file, so that it differs from the preset in lists. The ending `.toml` is added if it is missing.
    /// With `extends`, the file has only the differences from that preset; without it, the whole style.
    ///
    /// # Errors
    /// [`SaveError`]; nothing is then written.
    pub(crate) fn save_as(&self, path: &str, extends: Option<&str>) -> Result<Self, SaveError> {
        let path = path.trim();
        if path.is_empty() || path.ends_with(['/', '\\']) {
            return Err(SaveError::NoName);
        }
        let mut path = PathBuf::from(path);
        if path.extension().is_none_or(|extension| extension != "toml") {
            path.as_mut_os_string().push(".toml");
        }
        let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
        let mut text = match names().contains(&self.style().name.as_str()) {
            true => set::<Style>(self.name(), self.text(), "name", stem).map_err(StyleError::from)?,
            false => self.text().to_owned(),
        };
        if let Some(preset) = extends {
            // Comments of a file that extends the same preset are kept.
            let file = self.extends.as_ref().filter(|known| known.preset == preset);
            text = written(self.name(), preset, &text, file.map(|known| known.text.as_str()))?;
        }
        // Recipes are found relative to the new file.
        let saved = Self::of_file(&path, &text)?;
        create(&path, &text)?;
        Ok(saved)
    }
}

/// Writes a file that must not exist.
fn create(path: &Path, text: &str) -> Result<(), SaveError> {
    if path.symlink_metadata().is_ok() {
        return Err(SaveError::Exists { path: path.to_owned() });
    }
    Ok(atomic::write(path, text.as_bytes()).map_err(|error| FileError::write(path, error))?)
}
