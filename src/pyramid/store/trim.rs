//! The files of a cache entry, and their removal when the cache is too large.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, UNIX_EPOCH};

use crate::pyramid::format::sidecar::sidecar_path;

/// The largest size of the cache: 8 GiB.
pub(crate) const CACHE_LIMIT_BYTES: u64 = 8 << 30;

/// The age from which a partial file counts as abandoned by its bake.
const ABANDONED_AFTER: Duration = Duration::from_secs(24 * 60 * 60);

/// Returns the path of the file that identifies the origin of the pyramid.
pub(super) fn origin_path(tif: &Path) -> PathBuf {
    let mut path = tif.as_os_str().to_owned();
    path.push(".from");
    path.into()
}

/// Returns the path of the lock file.
pub(super) fn lock_path(tif: &Path) -> PathBuf {
    let mut name = std::ffi::OsString::from(".");
    name.push(tif.file_name().unwrap_or_default());
    name.push(".lock");
    tif.with_file_name(name)
}

/// Removes the pyramid with its other files, as far as possible. Returns whether the GeoTIFF was removed.
pub(super) fn remove(tif: &Path) -> bool {
    // The sidecar first: a GeoTIFF without one does not count as a pyramid.
    let _ = fs::remove_file(sidecar_path(tif));
    let _ = fs::remove_file(origin_path(tif));
    let _ = fs::remove_file(lock_path(tif));
    fs::remove_file(tif).is_ok()
}

/// Removes the least recently used pyramids until the folder holds at most `limit_bytes`, and abandoned partial files.
/// `keep` is never removed. Files that cannot be removed are left.
pub(crate) fn trim(folder: &Path, keep: &Path, limit_bytes: u64) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    let mut pyramids = Vec::new();
    for entry in entries.flatten() {
        let path = entry.path();
        let Ok(metadata) = entry.metadata() else { continue };
        let used = metadata.modified().unwrap_or(UNIX_EPOCH);
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("tif") => {
                let sidecar_bytes = fs::metadata(sidecar_path(&path)).map_or(0, |metadata| metadata.len());
                pyramids.push((used, metadata.len() + sidecar_bytes, path));
            }
            Some("part") if used.elapsed().is_ok_and(|age| age > ABANDONED_AFTER) => {
                let _ = fs::remove_file(&path);
            }
            _ => {}
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
