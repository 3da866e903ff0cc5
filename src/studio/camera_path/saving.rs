//! Files of a camera path that is being edited: its own, a new one, a copy for a film, and edits that survive a crash.

use std::io;
use std::path::{Path, PathBuf};

use super::PathDocument;
use crate::file::atomic;
use crate::file::cache_folder;
use crate::file::input::{LARGEST_PATH_BYTES, read_text};
use crate::file::{FileError, message::named};
use crate::studio::file_kind::expand_home;
use crate::studio::unsaved::{Unsaved, lasting};

/// Folder in hachure's cache for copies of paths that are not saved.
const COPIES: &str = "camera-paths";

/// Why a camera path was not saved. The message is one line.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SaveError {
    /// The path has no file.
    #[error("the camera path has no file; save it under a name")]
    NoFile,
    /// There is nothing to save.
    #[error("a camera path needs at least one key frame")]
    NoKeys,
    /// Another program has changed the file.
    #[error("{}: changed by another program since it was read; save under another name", named(path))]
    ChangedOutside {
        /// Path of the file.
        path: PathBuf,
    },
    /// A file of this name exists.
    #[error("{}: exists and is not the camera path that is open; choose another name", named(path))]
    Exists {
        /// Path of the file.
        path: PathBuf,
    },
    /// The name cannot be that of a file.
    #[error("a camera path needs a name")]
    NoName,
    /// The file cannot be written.
    #[error(transparent)]
    Write(#[from] FileError),
    /// There is no cache for a copy.
    #[error("cannot write a copy of the camera path into the cache ({0}); save it under a name")]
    Cache(#[source] io::Error),
}

impl PathDocument {
    /// Writes the path to its file.
    ///
    /// # Errors
    /// [`SaveError`]; the file is then unchanged.
    pub(crate) fn save(&mut self) -> Result<(), SaveError> {
        let Some(path) = self.path.clone() else { return Err(SaveError::NoFile) };
        self.has_keys()?;
        // A file that is gone is written again.
        if let Ok(there) = read_text(&path, LARGEST_PATH_BYTES)
            && there != self.file_text
            && there != self.text
        {
            return Err(SaveError::ChangedOutside { path });
        }
        // A link stays a link.
        let place = path.canonicalize().unwrap_or_else(|_| path.clone());
        atomic::write(&place, self.text.as_bytes()).map_err(|error| FileError::write(&path, error))?;
        self.is_saved();
        Ok(())
    }

    /// Writes the path to a new file, which must not exist, and which is its file from then on. The ending `.csv` is
    /// added if it is missing.
    ///
    /// # Errors
    /// [`SaveError`]; nothing is then written.
    pub(crate) fn save_as(&mut self, name: &str) -> Result<(), SaveError> {
        self.has_keys()?;
        let name = name.trim();
        if name.is_empty() || name.ends_with(['/', '\\']) {
            return Err(SaveError::NoName);
        }
        let mut path = PathBuf::from(expand_home(name));
        if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("csv")) {
            path.as_mut_os_string().push(".csv");
        }
        if path.symlink_metadata().is_ok() {
            return Err(SaveError::Exists { path });
        }
        atomic::write(&path, self.text.as_bytes()).map_err(|error| FileError::write(&path, error))?;
        self.name = path.display().to_string();
        self.path = Some(path);
        self.is_saved();
        Ok(())
    }

    fn has_keys(&self) -> Result<(), SaveError> {
        if self.keys.is_empty() { Err(SaveError::NoKeys) } else { Ok(()) }
    }

    fn is_saved(&mut self) {
        self.saved.clone_from(&self.text);
        self.file_text.clone_from(&self.text);
        self.release();
    }

    /// Returns the value of `--path` for a film of what is shown, and whether it is a copy in hachure's cache, because
    /// there are edits that are not saved or no file. A copy is named after its content.
    ///
    /// # Errors
    /// [`SaveError`], if there are no keys, or no cache.
    pub(crate) fn for_film(&self) -> Result<(String, bool), SaveError> {
        let root = cache_folder::root();
        self.for_film_within(root.as_deref())
    }

    pub(in crate::studio) fn for_film_within(&self, root: Option<&Path>) -> Result<(String, bool), SaveError> {
        self.has_keys()?;
        if !self.is_edited() && !self.name.is_empty() {
            return Ok((self.name.clone(), false));
        }
        let none = || io::Error::new(io::ErrorKind::NotFound, "there is no cache folder");
        let own = root.ok_or_else(none).and_then(cache_folder::open).map_err(SaveError::Cache)?;
        let copy = own.join(COPIES).join(format!("{:08x}.csv", crc32fast::hash(self.text.as_bytes())));
        cache_folder::write(&copy, self.text.as_bytes()).map_err(SaveError::Cache)?;
        Ok((copy.display().to_string(), true))
    }

    /// Keeps the text over a crash if it has edits, and removes what was kept of it otherwise. `world` names the world of
    /// a path that has no file.
    pub(crate) fn keep(&self, unsaved: &Unsaved, world: &str) {
        unsaved.keep_text(&self.lasting_name(world), self.is_edited().then_some(&self.text));
    }

    /// Returns edits that an earlier run has kept, if they differ from the text.
    pub(crate) fn find_kept(&self, unsaved: &Unsaved, world: &str) -> Option<String> {
        let text = unsaved.find_text(&self.lasting_name(world), LARGEST_PATH_BYTES)?;
        (text != self.text).then_some(text)
    }

    /// Removes edits that an earlier run has kept.
    pub(crate) fn forget_kept(&self, unsaved: &Unsaved, world: &str) {
        unsaved.keep_text(&self.lasting_name(world), None);
    }

    fn lasting_name(&self, world: &str) -> String {
        match (&self.path, self.name.is_empty()) {
            (Some(path), _) => lasting(path),
            (None, false) => format!("the built-in camera path {}", self.name),
            (None, true) => format!("a camera path of {world}"),
        }
    }
}
