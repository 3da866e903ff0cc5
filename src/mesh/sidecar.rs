//! The sidecar files of a model: material libraries and textures.
//!
//! They are searched for only in the folder of the model and below it, so that a model from somebody else cannot make
//! hachure read other files; the same holds for scenes (`scene::reach`). A name that is a path to elsewhere, as
//! programs write those of the machine where a model was made, is searched by its last component in the model's folder.
//! If there is no file of that name, one that differs only in upper and lower case is used.

use std::path::{Component, Path, PathBuf};

use rustc_hash::FxHashMap;

/// The folder of a model, with lists of the folders that were looked through: a library may name thousands of files.
pub(super) struct Sidecars {
    folder: PathBuf,
    /// The folder without links, if it exists.
    real: Option<PathBuf>,
    /// The files of each folder by their names in lower case.
    listed: FxHashMap<PathBuf, FxHashMap<String, PathBuf>>,
}

impl Sidecars {
    /// Finds files for the model at `path`.
    pub(super) fn of(path: &Path) -> Self {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Self { folder: folder.to_owned(), real: folder.canonicalize().ok(), listed: FxHashMap::default() }
    }

    /// Returns the path of the file `name` in or below the folder, if it exists.
    pub(super) fn find(&mut self, name: &[u8]) -> Option<PathBuf> {
        let (folder, real) = (self.folder.clone(), self.real.clone()?);
        let quotes = |byte: u8| byte == b'"';
        let bare = name.trim_ascii();
        let bare = match bare {
            [first, inner @ .., last] if quotes(*first) && quotes(*last) => inner,
            _ => bare,
        };
        readings(bare).into_iter().find_map(|name| {
            let path = Path::new(&name);
            let is_inside = path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
            let last = path.file_name()?;
            let whole = is_inside.then(|| folder.join(path));
            let found =
                whole.into_iter().chain([folder.join(last)]).find_map(|path| self.as_it_is_or_in_other_case(&path))?;
            // Links to outside of the folder count as outside.
            found.canonicalize().is_ok_and(|found| found.starts_with(&real)).then_some(found)
        })
    }

    fn as_it_is_or_in_other_case(&mut self, path: &Path) -> Option<PathBuf> {
        if path.is_file() {
            return Some(path.to_owned());
        }
        let (wanted, folder) = (path.file_name()?.to_str()?.to_lowercase(), path.parent()?);
        if !self.listed.contains_key(folder) {
            self.listed.insert(folder.to_owned(), files_of(folder));
        }
        self.listed[folder].get(&wanted).cloned()
    }
}

/// Returns the files of a folder by their names in lower case. Of several, the first by name, because the order of a
/// folder is arbitrary.
fn files_of(folder: &Path) -> FxHashMap<String, PathBuf> {
    let mut files: FxHashMap<String, PathBuf> = FxHashMap::default();
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let (name, path) = (entry.file_name(), entry.path());
        let Some(name) = name.to_str().map(str::to_lowercase).filter(|_| path.is_file()) else { continue };
        let first = files.entry(name).or_insert_with(|| path.clone());
        if path < *first {
            *first = path;
        }
    }
    files
}

/// Returns the possible meanings of the bytes of a name: UTF-8 or Latin-1, with the path separators of either system.
fn readings(name: &[u8]) -> Vec<String> {
    let text =
        std::str::from_utf8(name).map_or_else(|_| name.iter().map(|&byte| char::from(byte)).collect(), str::to_owned);
    let turned = text.replace('\\', "/");
    if turned == text { vec![text] } else { vec![text, turned] }
}
