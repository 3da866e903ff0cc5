//! Finds the style files in a folder, with a thread, so that no frame waits for a disk.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, TryRecvError, channel};

use super::document::StyleDocument;
use crate::file::input::{LARGEST_STYLE_BYTES, read_text};
use crate::file::toml_text;

/// Largest number of styles of a folder.
const MOST: usize = 64;
/// Largest number of TOML files of a folder that are read.
const MOST_READ: usize = 512;

/// A search for the style files of a folder.
#[derive(Debug)]
pub(crate) struct StyleSearch {
    found: Receiver<StyleDocument>,
}

impl StyleSearch {
    /// Begins to search a folder, the current one if its name is empty; `None` if the system has no thread for it.
    pub(crate) fn start(folder: PathBuf) -> Option<Self> {
        let (sender, found) = channel();
        let search = move || {
            let here = if folder.as_os_str().is_empty() { Path::new(".") } else { &folder };
            let mut paths: Vec<PathBuf> = here
                .read_dir()
                .into_iter()
                .flatten()
                .filter_map(|entry| Some(folder.join(entry.ok()?.file_name())))
                .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
                .collect();
            paths.sort();
            let styles = paths.iter().take(MOST_READ).filter_map(|path| read(path)).take(MOST);
            for document in styles {
                // The window has closed.
                if sender.send(document).is_err() {
                    return;
                }
            }
        };
        std::thread::Builder::new().name("styles of a folder".to_owned()).spawn(search).ok()?;
        Some(Self { found })
    }

    /// Returns a style that has been found.
    ///
    /// # Errors
    /// Whether the search has ended, or may find more.
    pub(crate) fn take(&self) -> Result<StyleDocument, TryRecvError> {
        self.found.try_recv()
    }
}

/// Reads a file that is a valid style.
fn read(path: &Path) -> Option<StyleDocument> {
    let text = read_text(path, LARGEST_STYLE_BYTES).ok()?;
    let keys = toml_text::keys("", &text).ok()?;
    let has = |key: &str| keys.iter().any(|known| known == key);
    // Scenes and recipes are TOML, too.
    if !(has("tone") || has("extends")) {
        return None;
    }
    StyleDocument::of_file(path, &text).inspect_err(|error| tracing::info!("{error}")).ok()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::file::atomic;

    #[test]
    fn only_valid_styles_are_found() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| atomic::write(&folder.path().join(name), text.as_bytes()).unwrap();
        write("b.toml", "extends = \"ink\"\nname = \"b\"");
        write("a.toml", crate::style::preset_text("wash").unwrap());
        write("scene.toml", "[world]\ndem = \"x.tif\"");
        write("bad.toml", "extends = \"nothing\"");
        write("c.txt", "extends = \"ink\"");
        let search = StyleSearch::start(folder.path().to_owned()).unwrap();
        let mut names = Vec::new();
        while let Ok(document) = search.found.recv() {
            names.push(document.style().name.clone());
        }
        assert_eq!(names, ["wash", "b"]);
        assert_eq!(search.take().unwrap_err(), TryRecvError::Disconnected);
    }
}
