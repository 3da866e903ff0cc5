//! The favourite styles of the user, in the settings file.
//!
//! The settings file is `settings.toml` in the folder that `HACHURE_CONFIG` names, otherwise in the system's folder for
//! hachure's configuration. Keys and comments that this version does not know are kept.

use std::path::{Path, PathBuf};

use toml_edit::{Array, DocumentMut, Item, Value};

use crate::file::atomic;
use crate::file::input::{LARGEST_STYLE_BYTES, read_text};

/// Number of favourites: the digits from 1 to 9.
pub(crate) const COUNT: usize = 9;
/// The favourites of a user who has set none.
const FIRST: [&str; COUNT] = ["ink", "pen", "brush", "pencil", "crosshatch", "hachures", "wash", "hokusai", "relief"];
/// The key of the list in the settings file.
const KEY: &str = "favourites";

/// The styles that the digits choose.
#[derive(Clone, Debug)]
pub(crate) struct Favourites {
    path: Option<PathBuf>,
    /// Names of presets and paths of files; empty ones are not set.
    names: [String; COUNT],
}

impl Favourites {
    /// Reads the favourites of the user. Without a settings file, or with one that cannot be read, they are a choice of
    /// presets.
    pub(crate) fn open() -> Self {
        Self::of_file(settings_file())
    }

    /// Returns favourites that have no file.
    #[cfg(test)]
    pub(crate) fn of_nobody() -> Self {
        Self::of_file(None)
    }

    fn of_file(path: Option<PathBuf>) -> Self {
        let mut names = FIRST.map(str::to_owned);
        if let Some(list) = path.as_deref().and_then(document).as_ref().and_then(|it| it.get(KEY)?.as_array()) {
            for (place, name) in names.iter_mut().enumerate() {
                *name = list.get(place).and_then(Value::as_str).unwrap_or_default().to_owned();
            }
        }
        Self { path, names }
    }

    /// Returns the style of a digit; digits are counted from 0.
    pub(crate) fn get(&self, digit: usize) -> Option<&str> {
        self.names.get(digit).map(String::as_str).filter(|name| !name.is_empty())
    }

    /// Returns the digit of a style, counted from 0.
    pub(crate) fn digit(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// Makes a style the favourite of a digit, or of none, and writes the settings file.
    ///
    /// # Errors
    /// One line with the file and the cause, if the file cannot be written.
    pub(crate) fn set(&mut self, digit: Option<usize>, name: &str) -> Result<(), String> {
        self.names.iter_mut().filter(|known| *known == name).for_each(String::clear);
        if let Some(place) = digit.and_then(|digit| self.names.get_mut(digit)) {
            name.clone_into(place);
        }
        let Some(path) = &self.path else { return Ok(()) };
        let mut document = document(path).unwrap_or_default();
        let list: Array = self.names.iter().map(String::as_str).collect();
        // A comment above the key stays.
        match document.get_mut(KEY) {
            Some(there) => *there = Item::Value(list.into()),
            None => _ = document.insert(KEY, Item::Value(list.into())),
        }
        let written = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        let written = written.and_then(|()| atomic::write(path, document.to_string().as_bytes()));
        written.map_err(|error| format!("{}: cannot write the settings: {error}", path.display()))
    }
}

/// Returns the path of the settings file.
pub(crate) fn settings_file() -> Option<PathBuf> {
    let given = std::env::var_os("HACHURE_CONFIG").filter(|folder| !folder.is_empty()).map(PathBuf::from);
    let own = || Some(directories::ProjectDirs::from("", "", "hachure")?.config_dir().to_owned());
    Some(given.or_else(own)?.join("settings.toml"))
}

/// Reads the settings file; `None` if there is none, or no valid one.
pub(crate) fn document(path: &Path) -> Option<DocumentMut> {
    let text = read_text(path, LARGEST_STYLE_BYTES).ok()?;
    text.parse().inspect_err(|error| tracing::warn!("{}: {error}", path.display())).ok()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    #[test]
    fn favourites_outlive_a_run_and_other_settings_stay() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("config/settings.toml");
        let mut favourites = Favourites::of_file(Some(path.clone()));
        assert_eq!((favourites.get(0), favourites.digit("relief")), (Some("ink"), Some(8)));
        favourites.set(Some(1), "/a/mine.toml").unwrap();
        favourites.set(Some(2), "ink").unwrap();
        let again = Favourites::of_file(Some(path.clone()));
        assert_eq!(
            [0, 1, 2, 3].map(|digit| again.get(digit)),
            [None, Some("/a/mine.toml"), Some("ink"), Some("pencil")]
        );
        let text = std::fs::read_to_string(&path).unwrap();
        atomic::write(&path, format!("# mine\n{text}[other]\nkey = 3\n").as_bytes()).unwrap();
        favourites.set(None, "ink").unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.starts_with("# mine\n") && text.contains("key = 3"), "{text}");
        assert_eq!(Favourites::of_file(Some(path.clone())).get(2), None);
        // Planted: a file that is no TOML, and a digit that there is not.
        atomic::write(&path, b"favourites = [").unwrap();
        assert_eq!(Favourites::of_file(Some(path)).get(0), Some("ink"));
        assert_eq!(favourites.get(9), None);
    }
}
