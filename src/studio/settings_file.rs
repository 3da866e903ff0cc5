//! The settings file of the user: `settings.toml` in the folder that `HACHURE_CONFIG` names, otherwise in the system's
//! folder for hachure's configuration. Keys and comments that this version does not know are kept.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use toml_edit::{Array, DocumentMut, Item, Value};

use crate::file::atomic;
use crate::file::input::{LARGEST_STYLE_BYTES, read_text};
use crate::file::message::shown;

/// Returns the path of the settings file.
pub(crate) fn path() -> Option<PathBuf> {
    let given = std::env::var_os("HACHURE_CONFIG").filter(|folder| !folder.is_empty()).map(PathBuf::from);
    let own = || Some(directories::ProjectDirs::from("", "", "hachure")?.config_dir().to_owned());
    Some(given.or_else(own)?.join("settings.toml"))
}

/// Reads a list of texts; `None` if the file does not have it. A value that is not text is empty.
pub(super) fn list(path: &Path, key: &str) -> Option<Vec<String>> {
    let document = document(path)?;
    let list = document.get(key)?.as_array()?;
    Some(list.iter().map(|value| Value::as_str(value).unwrap_or_default().to_owned()).collect())
}

/// Writes a list of texts, and keeps everything else in the file.
///
/// # Errors
/// The errors of [`change`].
pub(super) fn set_list<'a>(path: &Path, key: &str, texts: impl Iterator<Item = &'a str>) -> Result<(), String> {
    let list: Array = texts.collect();
    change(path, |settings| match settings.get_mut(key) {
        // A comment above the key stays.
        Some(there) => *there = Item::Value(list.into()),
        None => _ = settings.insert(key, Item::Value(list.into())),
    })
}

/// Changes the settings file. A file that cannot be read, or that is not valid, is never replaced: a user may have
/// written it.
///
/// # Errors
/// One line with the file and the cause, if the file is not valid or cannot be written.
pub(crate) fn change(path: &Path, change: impl FnOnce(&mut DocumentMut)) -> Result<(), String> {
    let unchanged = |error: &dyn std::fmt::Display| {
        let cause = shown(&error.to_string());
        format!("{}: the settings were not saved, because the file is not valid: {cause}", path.display())
    };
    let mut settings = match read_text(path, LARGEST_STYLE_BYTES) {
        Ok(text) => text.parse().map_err(|error: toml_edit::TomlError| unchanged(&error.message()))?,
        Err(error) if error.kind() == ErrorKind::NotFound => DocumentMut::new(),
        Err(error) => {
            return Err(format!(
                "{}: the settings were not saved, because the file cannot be read: {error}",
                path.display()
            ));
        }
    };
    change(&mut settings);
    let written = path.parent().map_or(Ok(()), std::fs::create_dir_all);
    let written = written.and_then(|()| atomic::write(path, settings.to_string().as_bytes()));
    written.map_err(|error| format!("{}: cannot write the settings: {error}", path.display()))
}

/// Reads the settings file; `None` if there is none, or no valid one.
pub(crate) fn document(path: &Path) -> Option<DocumentMut> {
    let text = read_text(path, LARGEST_STYLE_BYTES).ok()?;
    text.parse().inspect_err(|error| tracing::warn!("{}: {error}", path.display())).ok()
}
