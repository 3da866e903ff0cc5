//! The files that were opened last, in the settings file: newest first, each once.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::settings_file;
use crate::scene::embedded;

/// Largest number of files.
pub(crate) const COUNT: usize = 10;
/// The key of the list in the settings file.
const KEY: &str = "recent";

/// A file that was opened.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Entry {
    /// Path of the file, an address, or the name of a built-in scene or camera path.
    pub name: String,
    /// The reason why the file cannot be opened now; `None` if it probably can.
    pub missing: Option<String>,
}

/// The files that were opened last.
#[derive(Clone, Debug)]
pub(crate) struct Recent {
    path: Option<PathBuf>,
    names: Vec<String>,
}

impl Recent {
    /// Reads the list of the user; it is empty if there is none.
    pub(crate) fn open() -> Self {
        Self::of_file(settings_file::path())
    }

    fn of_file(path: Option<PathBuf>) -> Self {
        let mut recent = Self { path, names: Vec::new() };
        recent.read();
        recent
    }

    /// Reads the list again: another window may have changed it.
    fn read(&mut self) {
        if let Some(names) = self.path.as_deref().and_then(|path| settings_file::list(path, KEY)) {
            self.names = names.into_iter().filter(|name| !name.is_empty()).take(COUNT).collect();
        }
    }

    /// Puts a file at the beginning, and writes the settings file. Names of files become absolute.
    ///
    /// # Errors
    /// One line with the file and the cause, if the settings file cannot be written.
    pub(crate) fn add(&mut self, name: &str) -> Result<(), String> {
        let Some(name) = kept(name) else { return Ok(()) };
        self.read();
        self.names.retain(|known| *known != name);
        self.names.insert(0, name);
        self.names.truncate(COUNT);
        let Some(path) = &self.path else { return Ok(()) };
        settings_file::set_list(path, KEY, self.names.iter().map(String::as_str))
    }

    /// Returns the files, newest first, and looks whether they exist.
    pub(crate) fn entries(&self) -> Vec<Entry> {
        self.names.iter().map(|name| Entry { name: name.clone(), missing: missing(name) }).collect()
    }
}

/// Returns whether a name is an address, or that of a built-in scene or camera path, instead of the path of a file.
pub(crate) fn names_no_file(name: &str) -> bool {
    name.contains("://") || embedded::scene(name).is_some() || embedded::path(Path::new(name)).is_some()
}

/// Returns a name that does not depend on the current folder, if it may be written into the settings file: what is behind a
/// question mark or before an at sign of an address may be a password.
pub(crate) fn kept(name: &str) -> Option<String> {
    let is_secret = name.contains("://") && name.contains(['?', '@']);
    (!is_secret).then(|| lasting(name))
}

/// Returns a name that does not depend on the current folder.
pub(super) fn lasting(name: &str) -> String {
    match names_no_file(name) {
        true => name.to_owned(),
        false => std::path::absolute(name).map_or_else(|_| name.to_owned(), |path| path.display().to_string()),
    }
}

/// Returns a name under which something is remembered of a world with the seed that replaces its own.
pub(crate) fn with_seed(world: String, seed: Option<u32>) -> String {
    match seed {
        Some(seed) => format!("{world} (seed {seed})"),
        None => world,
    }
}

/// Returns why a file cannot be opened.
fn missing(name: &str) -> Option<String> {
    if names_no_file(name) {
        return None;
    }
    let error = std::fs::metadata(name).err()?;
    Some(match error.kind() {
        ErrorKind::NotFound => "the file no longer exists".to_owned(),
        ErrorKind::PermissionDenied => "permission denied".to_owned(),
        _ => crate::file::message::shown(&error.to_string()),
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::file::atomic;

    #[test]
    fn the_newest_comes_first_and_each_once() {
        let folder = tempfile::tempdir().unwrap();
        let settings = folder.path().join("config/settings.toml");
        let file = |number: usize| folder.path().join(format!("{number}.tif")).display().to_string();
        let mut recent = Recent::of_file(Some(settings.clone()));
        assert!(recent.entries().is_empty());
        for secret in ["s3://name:password@host/a.tif", "https://host/a.tif?signature=abc"] {
            recent.add(secret).unwrap();
            assert!(recent.entries().is_empty() && !settings.exists(), "{secret}");
        }
        (0..13).for_each(|number| recent.add(&file(number)).unwrap());
        recent.add(&file(5)).unwrap();
        recent.add("continent").unwrap();
        let again = Recent::of_file(Some(settings.clone()));
        let names: Vec<String> = again.entries().into_iter().map(|entry| entry.name).collect();
        let wanted: Vec<String> =
            std::iter::once("continent".to_owned()).chain([5, 12, 11, 10, 9, 8, 7, 6, 4].map(file)).collect();
        assert_eq!(names, wanted);
        // Two windows do not undo each other's entries.
        let mut other = Recent::of_file(Some(settings.clone()));
        recent.add(&file(20)).unwrap();
        other.add(&file(21)).unwrap();
        let names: Vec<String> = other.entries().into_iter().map(|entry| entry.name).take(3).collect();
        assert_eq!(names, [file(21), file(20), "continent".to_owned()]);
        // Other settings stay.
        let text = std::fs::read_to_string(&settings).unwrap();
        atomic::write(&settings, format!("# mine\nfavourites = [\"pen\"]\n{text}").as_bytes()).unwrap();
        other.add(&file(22)).unwrap();
        let text = std::fs::read_to_string(&settings).unwrap();
        assert!(text.starts_with("# mine\nfavourites = [\"pen\"]\n"), "{text}");
    }

    #[test]
    fn a_missing_file_has_its_reason() {
        let folder = tempfile::tempdir().unwrap();
        let mut recent = Recent::of_file(None);
        let [here, gone] = ["here.tif", "gone.tif"].map(|name| folder.path().join(name).display().to_string());
        atomic::write(Path::new(&here), b"x").unwrap();
        for name in [&*gone, &here, "https://example.org/a.tif", "tour"] {
            recent.add(name).unwrap();
        }
        let reasons: Vec<Option<String>> = recent.entries().into_iter().map(|entry| entry.missing).collect();
        assert_eq!(reasons, [None, None, None, Some("the file no longer exists".to_owned())]);
    }
}
