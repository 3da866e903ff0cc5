//! Removes the least recently used entries of the cache when it is too large. Only files that a bake put there are
//! removed: a pyramid that its manifest describes, with the files of its entry, and temporary files of entries; and
//! folders of unpacked archives that killed processes left.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, UNIX_EPOCH};

use super::manifest::{Manifest, origin_path};
use crate::file::atomic::named_in_temporary;
use crate::file::cache_folder::is_file;
use crate::file::unpacked;
use crate::pyramid::format::sidecar_path;

/// The largest size of the cache: 8 GiB.
pub(crate) const CACHE_LIMIT_BYTES: u64 = 8 << 30;

/// The age from which a partial file counts as abandoned by its bake.
const ABANDONED_AFTER: Duration = Duration::from_secs(24 * 60 * 60);

/// Returns the path of the file with warnings about the input.
pub(super) fn notes_path(tif: &Path) -> PathBuf {
    let mut path = tif.as_os_str().to_owned();
    path.push(".notes");
    path.into()
}

/// Returns the path of the lock file.
pub(super) fn lock_path(tif: &Path) -> PathBuf {
    let mut name = OsString::from(".");
    name.push(tif.file_name().unwrap_or_default());
    name.push(".lock");
    tif.with_file_name(name)
}

/// Removes an entry, as far as possible. Returns whether the GeoTIFF was removed; one that its manifest does not
/// describe stays, because it may be a file of the user.
fn remove(tif: &Path) -> bool {
    if !Manifest::read(tif).is_some_and(|manifest| manifest.describes(tif)) {
        return false;
    }
    // The sidecar first: a GeoTIFF without one does not count as a pyramid. The manifest last: without it, nothing of
    // the entry would ever be removed.
    let _ = fs::remove_file(notes_path(tif));
    let is_removed = [sidecar_path(tif), lock_path(tif), tif.to_owned()].map(|path| fs::remove_file(path).is_ok())[2];
    is_removed && fs::remove_file(origin_path(tif)).is_ok()
}

/// Returns whether a name is that of an entry's GeoTIFF: `NAME.HASH.tif`.
fn is_entry(name: &str) -> bool {
    let hash = name.strip_suffix(".tif").and_then(|name| name.rsplit_once('.')).map_or("", |(_, hash)| hash);
    hash.len() == 16 && hash.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'))
}

/// Returns whether a name is that of a temporary file of an entry.
fn is_partial(name: &str) -> bool {
    let of = named_in_temporary(name).unwrap_or_default();
    is_entry(of.strip_suffix(".tiles").or(of.strip_suffix(".from")).or(of.strip_suffix(".notes")).unwrap_or(of))
}

/// Removes the least recently used pyramids until the folder holds at most `limit_bytes`, and abandoned partial files
/// and folders.
/// `keep` is never removed. Files that cannot be removed are left.
pub(crate) fn trim(folder: &Path, keep: &Path, limit_bytes: u64) {
    unpacked::remove_abandoned(folder);
    let Ok(entries) = fs::read_dir(folder) else { return };
    let mut pyramids = Vec::new();
    for entry in entries.flatten() {
        let (path, name) = (entry.path(), entry.file_name().to_string_lossy().into_owned());
        let Ok(metadata) = entry.metadata() else { continue };
        let used = metadata.modified().unwrap_or(UNIX_EPOCH);
        if !metadata.is_file() {
            continue;
        }
        if is_entry(&name) && is_file(&origin_path(&path)) {
            let sidecar_bytes = fs::metadata(sidecar_path(&path)).map_or(0, |metadata| metadata.len());
            pyramids.push((used, metadata.len() + sidecar_bytes, path));
        } else if is_partial(&name) && used.elapsed().is_ok_and(|age| age > ABANDONED_AFTER) {
            let _ = fs::remove_file(&path);
        }
    }
    pyramids.sort();
    let mut total: u64 = pyramids.iter().map(|(_, bytes, _)| bytes).sum();
    for (_, bytes, path) in pyramids {
        if total <= limit_bytes {
            break;
        }
        if path != keep && remove(&path) {
            total -= bytes;
        }
    }
}
