//! The sidecar files of a model: material libraries and textures.
//!
//! They are searched in the folder of the model and below it only, so that a model from somebody else cannot make
//! hachure read other files, as a scene cannot either (`scene::reach`). A name that is a path to elsewhere, as programs
//! write those of the machine where a model was made, is searched by its last component in the model's folder. If there
//! is no file of that name, one that differs only in upper and lower case is used.

use std::path::{Component, Path, PathBuf};

/// Returns the path of the file `name` in or below `folder`, if it exists.
pub(super) fn find(folder: &Path, name: &[u8]) -> Option<PathBuf> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let real = folder.canonicalize().ok()?;
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
        let found = whole.into_iter().chain([folder.join(last)]).find_map(|path| as_it_is_or_in_other_case(&path))?;
        // Links to outside of the folder count as outside.
        found.canonicalize().is_ok_and(|found| found.starts_with(&real)).then_some(found)
    })
}

/// Returns the possible meanings of the bytes of a name: UTF-8 or Latin-1, with the path separators of either system.
fn readings(name: &[u8]) -> Vec<String> {
    let text =
        std::str::from_utf8(name).map_or_else(|_| name.iter().map(|&byte| char::from(byte)).collect(), str::to_owned);
    let turned = text.replace('\\', "/");
    if turned == text { vec![text] } else { vec![text, turned] }
}

fn as_it_is_or_in_other_case(path: &Path) -> Option<PathBuf> {
    if path.is_file() {
        return Some(path.to_owned());
    }
    let wanted = path.file_name()?.to_str()?.to_lowercase();
    let entries = std::fs::read_dir(path.parent()?).ok()?.flatten();
    // The first by name, because the order of a folder is arbitrary.
    let alike = entries.filter(|entry| entry.file_name().to_str().is_some_and(|name| name.to_lowercase() == wanted));
    alike.map(|entry| entry.path()).filter(|path| path.is_file()).min()
}
