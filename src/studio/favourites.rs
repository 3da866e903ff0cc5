//! The favourite styles of the user, in the settings file.

use std::path::PathBuf;

use super::settings_file;

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
        Self::of_file(settings_file::path())
    }

    /// Returns favourites that have no file.
    #[cfg(test)]
    pub(crate) fn of_nobody() -> Self {
        Self::of_file(None)
    }

    fn of_file(path: Option<PathBuf>) -> Self {
        let mut names = FIRST.map(str::to_owned);
        if let Some(list) = path.as_deref().and_then(|path| settings_file::list(path, KEY)) {
            for (place, name) in names.iter_mut().enumerate() {
                *name = list.get(place).cloned().unwrap_or_default();
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
        settings_file::set_list(path, KEY, self.names.iter().map(String::as_str))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::file::atomic;

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
        // Planted: a file that is not TOML, and a digit that does not exist.
        atomic::write(&path, b"favourites = [").unwrap();
        assert_eq!(Favourites::of_file(Some(path)).get(0), Some("ink"));
        assert_eq!(favourites.get(9), None);
    }
}
