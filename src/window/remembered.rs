//! The memory of a window from one run to the next: its size, its world, its style and its panels, and that it has
//! welcomed the user. It is the table `[window]` of the settings file, which also has the favourites.

use std::path::PathBuf;

use toml_edit::{Array, DocumentMut, Item, Table, Value};

use crate::studio::settings_file::{self, change, document};

/// The table in the settings file.
const TABLE: &str = "window";
/// Least and greatest side of a window that is remembered, in pixels.
const SIDES_PX: [u32; 2] = [200, 16_384];

/// The settings that a window remembers.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Remembered {
    path: Option<PathBuf>,
    /// Size of the window in pixels.
    pub size_px: Option<[u32; 2]>,
    /// The world: path of a file, an address, or the name of a built-in scene; `None` is the built-in world.
    pub world: Option<String>,
    /// Name of a preset, or path of a style file.
    pub style: Option<String>,
    /// The text of the docked panels.
    pub panels: Option<String>,
    /// Whether the sentences of the first start have been closed.
    pub is_welcomed: bool,
}

impl Remembered {
    /// Reads the memory of the last run. Values that cannot be read count as missing.
    pub(crate) fn open() -> Self {
        Self::of_file(settings_file::path())
    }

    fn of_file(path: Option<PathBuf>) -> Self {
        let settings = path.as_deref().and_then(document).unwrap_or_default();
        let table = settings.get(TABLE).and_then(Item::as_table_like);
        let value = |key: &str| table.and_then(|table| table.get(key)).and_then(Item::as_value);
        let text = |key: &str| value(key).and_then(Value::as_str).map(str::to_owned);
        let sides = value("size").and_then(Value::as_array).map(|sides| {
            let sides = sides.iter().filter_map(|side| u32::try_from(side.as_integer()?).ok());
            sides.filter(|side| (SIDES_PX[0]..=SIDES_PX[1]).contains(side)).collect::<Vec<u32>>()
        });
        Self {
            size_px: sides.and_then(|sides| <[u32; 2]>::try_from(sides).ok()),
            world: text("world"),
            style: text("style"),
            panels: text("panels"),
            is_welcomed: value("welcomed").and_then(Value::as_bool).unwrap_or_default(),
            path,
        }
    }

    /// Writes what the next run is to remember, if it differs from what is in the settings file. Other keys and comments
    /// stay.
    ///
    /// # Errors
    /// One line with the file and the cause, if the file is not valid or cannot be written.
    pub(crate) fn keep(&self) -> Result<(), String> {
        let Some(path) = &self.path else { return Ok(()) };
        if *self == Self::of_file(self.path.clone()) {
            return Ok(());
        }
        change(path, |settings| self.write(settings))
    }

    fn write(&self, settings: &mut DocumentMut) {
        let table = settings.entry(TABLE).or_insert_with(|| Item::Table(Table::new()));
        if !table.is_table_like() {
            *table = Item::Table(Table::new());
        }
        let Some(table) = table.as_table_like_mut() else { return };
        let sides = |sides: [u32; 2]| Value::Array(sides.into_iter().map(i64::from).collect::<Array>());
        let values = [
            ("size", self.size_px.map(sides)),
            ("world", self.world.as_deref().map(Value::from)),
            ("style", self.style.as_deref().map(Value::from)),
            ("panels", self.panels.as_deref().map(Value::from)),
            ("welcomed", Some(self.is_welcomed.into())),
        ];
        for (key, value) in values {
            match (value, table.get_mut(key)) {
                // A comment above the key stays.
                (Some(value), Some(there)) => *there = Item::Value(value),
                (Some(value), None) => _ = table.insert(key, Item::Value(value)),
                // Without a world, the next run opens the built-in one. Other keys keep their values.
                (None, Some(_)) if key == "world" => _ = table.remove(key),
                (None, _) => {}
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::file::atomic;

    #[test]
    fn what_is_remembered_is_read_again_and_other_settings_stay() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("settings.toml");
        let read = || Remembered::of_file(Some(path.clone()));
        assert_eq!(read(), Remembered { path: Some(path.clone()), ..Remembered::default() });
        read().keep().unwrap();
        assert!(!path.exists(), "nothing differs");
        atomic::write(&path, b"# mine\nfavourites = [\"pen\"] # two\n\n[window]\n# small\nsize = [640, 480]\n")
            .unwrap();
        assert_eq!(read().size_px, Some([640, 480]));
        let kept = Remembered {
            size_px: Some([1280, 800]),
            world: Some("/a folder/alps.tif".to_owned()),
            style: Some("/a folder/my \"style\".toml".to_owned()),
            panels: Some("{\"tree\":[]}".to_owned()),
            is_welcomed: true,
            ..read()
        };
        kept.keep().unwrap();
        assert_eq!(read(), kept);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.starts_with("# mine\nfavourites = [\"pen\"] # two\n") && text.contains("# small"), "{text}");
        // The built-in world replaces a file that was remembered.
        Remembered { world: None, ..kept.clone() }.keep().unwrap();
        assert_eq!(read(), Remembered { world: None, ..kept });
    }

    #[test]
    fn values_that_make_no_sense_are_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("settings.toml");
        let texts = [
            "window = 3",
            "[window]\nsize = [1, 1]",
            "[window]\nsize = [99999999999, 300]",
            "[window]\nstyle = 7",
            "[",
        ];
        for text in texts {
            atomic::write(&path, text.as_bytes()).unwrap();
            let read = Remembered::of_file(Some(path.clone()));
            assert_eq!(read, Remembered { path: Some(path.clone()), ..Remembered::default() }, "{text}");
        }
        // A file that is not valid is not replaced: a user's text in it would be lost.
        let text = "favourites = [\"pen\"]\n[window\n";
        atomic::write(&path, text.as_bytes()).unwrap();
        let remembered = Remembered { is_welcomed: true, ..Remembered::of_file(Some(path.clone())) };
        let error = remembered.keep().unwrap_err();
        assert!(error.contains("settings.toml: the settings were not saved") && !error.contains('\n'), "{error}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
    }
}
