//! An entry of the cache of pyramids: opened if it is complete, baked if it is missing, baked again if it is damaged.
//!
//! ```text
//! NAME.tif, NAME.tif.tiles   the pyramid
//! NAME.tif.from              the origin of the pyramid, which is also the manifest of the entry: see `manifest`
//! NAME.tif.notes             warnings about the samples of the input, one a line, which are repeated at each use
//! .NAME.tif.lock             locked by the process that bakes it
//! ```
//!
//! Nobody else can write to the folder (`file::cache_folder`). An entry whose origin is missing or is not the whole key
//! is not believed. Files may be damaged in any way, replaced by others, or missing. A pyramid gets its name only when it is complete,
//! and a bake gives the same bytes whoever runs it: if two processes bake an entry at once in spite of the lock (not
//! every file system has locks), they only do the same work twice.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::SystemTime;

use super::manifest::{Manifest, origin_path};
use super::pyramid::Pyramid;
use super::trim::{CACHE_LIMIT_BYTES, lock_path, notes_path, trim};
use crate::file::atomic::{self, Readers};
use crate::file::cache_folder;
use crate::file::input::read_text;
use crate::file::message::named;
use crate::pyramid::bake::remove_parts;
use crate::pyramid::error::PyramidError;
use crate::pyramid::format::sidecar_path;

/// Largest size of the stored warnings, in bytes.
const MAX_NOTES_BYTES: u64 = 1 << 16;

/// Prevents two threads from baking one pyramid at a time: their partial files would be the same.
static BAKING: Mutex<()> = Mutex::new(());

/// An entry of the cache: the files of one pyramid, and the key of its origin.
pub(super) struct Entry {
    folder: PathBuf,
    tif: PathBuf,
    key: String,
    /// The name of the input, for messages.
    name: String,
}

impl Entry {
    /// Creates the entry for the pyramid `file_name` in `folder`, made from the input that `key` identifies and that
    /// messages call `name`.
    pub(super) fn new(folder: PathBuf, file_name: &str, key: &str, name: &str) -> Self {
        Self { tif: folder.join(file_name), folder, key: key.to_owned(), name: name.to_owned() }
    }

    /// Returns the name of the input.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Returns the key that identifies the input of the pyramid.
    pub(super) fn key(&self) -> &str {
        &self.key
    }

    /// Opens the pyramid, or bakes it if it is missing or damaged. Damage is logged as a warning.
    ///
    /// # Errors
    /// [`PyramidError::Cache`] if the folder cannot be written, or the error of `make`.
    pub(super) fn open_or_make(
        &self,
        make: impl FnMut(&Path) -> Result<(), PyramidError>,
    ) -> Result<Pyramid, PyramidError> {
        // The lock guards no data, so a panic elsewhere is harmless.
        let _one_at_a_time = BAKING.lock().unwrap_or_else(PoisonError::into_inner);
        let damage = match self.tif.symlink_metadata() {
            Ok(_) => match self.open() {
                Ok(pyramid) => return Ok(pyramid),
                Err(error) => Some(error),
            },
            Err(_) => None,
        };
        let lock = self.lock().map_err(|error| match (error, &damage) {
            (PyramidError::Cache { source, .. }, Some(damage)) => {
                self.unwritable(format!("{source}; and the cached file is damaged: {}", self.cause_of(damage)))
            }
            (error, _) => error,
        });
        let _lock = lock?;
        // Another process may have baked it meanwhile.
        if let Ok(pyramid) = self.open() {
            return Ok(pyramid);
        }
        if let Some(damage) = damage {
            self.warn(&damage);
        }
        self.make(make)
    }

    /// Bakes the pyramid again, unless another process did. `is_whole` checks the place where damage was found.
    ///
    /// # Errors
    /// The errors of [`Entry::open_or_make`].
    pub(super) fn rebuild(
        &self,
        is_whole: impl FnOnce(&Pyramid) -> bool,
        make: impl FnMut(&Path) -> Result<(), PyramidError>,
    ) -> Result<Pyramid, PyramidError> {
        let _one_at_a_time = BAKING.lock().unwrap_or_else(PoisonError::into_inner);
        let _lock = self.lock()?;
        match self.open() {
            Ok(pyramid) if is_whole(&pyramid) => Ok(pyramid),
            _ => self.make(make),
        }
    }

    fn open(&self) -> Result<Pyramid, PyramidError> {
        let mismatch = |cause: &str| PyramidError::Mismatch { path: self.tif.clone(), cause: cause.to_owned() };
        // A link would lead out of the folder, and a pipe would wait.
        let are_files = [self.tif.clone(), sidecar_path(&self.tif)]
            .iter()
            .all(|path| path.symlink_metadata().is_err() || cache_folder::is_file(path));
        if !are_files {
            return Err(mismatch("it is not a file"));
        }
        let pyramid = Pyramid::open(&self.tif)?;
        match Manifest::read(&self.tif) {
            Some(found) if found == self.manifest()? => {}
            Some(_) => return Err(mismatch("it was baked from another input")),
            None => return Err(mismatch("its origin is not recorded")),
        }
        // The modification time records the last use. It is only a hint for `trim`.
        let used = fs::File::options().append(true).open(&self.tif);
        if let Err(error) = used.and_then(|file| file.set_modified(SystemTime::now())) {
            tracing::debug!("{}: {error}", self.tif.display());
        }
        Ok(pyramid)
    }

    fn manifest(&self) -> Result<Manifest, PyramidError> {
        Manifest::of(&self.tif, &self.key).map_err(PyramidError::io(&self.tif, "opening"))
    }

    fn make(&self, mut make: impl FnMut(&Path) -> Result<(), PyramidError>) -> Result<Pyramid, PyramidError> {
        let mut made = make(&self.tif);
        if matches!(made, Err(PyramidError::Parts { .. })) {
            // The work folder holds parts of another bake.
            remove_parts(&self.tif);
            made = make(&self.tif);
        }
        made.map_err(|error| self.of_cache(error))?;
        let manifest = self.manifest()?.to_bytes();
        cache_folder::write(&origin_path(&self.tif), &manifest).map_err(|error| self.unwritable(error))?;
        trim(&self.folder, &self.tif, CACHE_LIMIT_BYTES);
        Pyramid::open(&self.tif)
    }

    /// Locks the entry until the returned file is dropped, or until the process ends in any way. Returns `None` if
    /// something that is not a file has the name of the lock; the names of partial files then keep processes apart.
    fn lock(&self) -> Result<Option<fs::File>, PyramidError> {
        cache_folder::create_within(&self.folder).map_err(|error| self.unwritable(error))?;
        let path = lock_path(&self.tif);
        // Opening a pipe would wait for its reader.
        if path.symlink_metadata().is_ok() && !cache_folder::is_file(&path) {
            tracing::debug!("{}: is not a file, and no lock", path.display());
            return Ok(None);
        }
        let mut options = fs::File::options();
        options.create(true).truncate(false).write(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        let file = options.open(&path).map_err(|error| self.unwritable(error))?;
        if matches!(file.try_lock(), Err(fs::TryLockError::WouldBlock)) {
            tracing::info!("{}: waiting for another process that bakes it", self.name);
            // Where locks fail, the names of partial files keep processes apart.
            if let Err(error) = file.lock() {
                tracing::debug!("{}: {error}", path.display());
            }
        }
        Ok(Some(file))
    }

    fn unwritable(&self, source: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> PyramidError {
        PyramidError::Cache { folder: self.folder.clone(), source: source.into() }
    }

    /// Converts errors of the cache's disk during a bake into [`PyramidError::Cache`].
    fn of_cache(&self, error: PyramidError) -> PyramidError {
        match error {
            PyramidError::Io { path, source, .. } if path.starts_with(&self.folder) => self.unwritable(source),
            PyramidError::Encode { path, source } if path.starts_with(&self.folder) => self.unwritable(source),
            error => error,
        }
    }

    /// Warns that the cached pyramid is damaged and will be baked again.
    pub(super) fn warn(&self, damage: &PyramidError) {
        tracing::warn!("{}: its cached pyramid is damaged ({}) and is baked again", self.name, self.cause_of(damage));
    }

    /// Returns the damage of the cached files, without their names, which mean nothing to users.
    fn cause_of(&self, damage: &PyramidError) -> String {
        let text = damage.message();
        let names = [sidecar_path(&self.tif), self.tif.clone()].map(named);
        let cause = names.iter().find_map(|name| text.strip_prefix(&**name)?.strip_prefix(": ")).unwrap_or(&text);
        cause.trim_end_matches(": the file is damaged").trim_end_matches("; bake it again").to_owned()
    }

    /// Stores warnings about the input, if there are any.
    pub(super) fn store_notes(&self, notes: &[String]) {
        if notes.is_empty() {
            return;
        }
        // A cache that cannot be written costs only the repetition of the warnings.
        let path = notes_path(&self.tif);
        if let Err(error) = atomic::write_for(&path, notes.join("\n").as_bytes(), Readers::Owner) {
            tracing::debug!("{}: {error}", self.tif.display());
        }
    }

    /// Repeats the stored warnings about the input.
    pub(super) fn repeat_notes(&self) {
        let path = notes_path(&self.tif);
        let notes = if cache_folder::is_file(&path) { read_text(&path, MAX_NOTES_BYTES).ok() } else { None };
        let notes = notes.unwrap_or_default();
        notes.lines().for_each(|note| tracing::warn!("{}: {note}", self.name));
    }
}
