//! Pyramids that hachure bakes for itself: kept in a folder of the system's cache, found again by what they were made
//! from, and removed, the longest unused first, when they grow too many.
//!
//! The folder is the one that the caller names, else `HACHURE_CACHE`, else the system's cache folder for hachure.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use super::bytes::fnv;
use super::link::has_sidecar;
use super::sidecar::{self, sidecar_path};
use super::{BakeOptions, BakeWork, Pyramid, PyramidError, bake, bake_reader};
use crate::source::{self, HeightGrid, OpenOptions, Progress, SourceError};

/// How much the cache may hold: 8 GiB.
pub const CACHE_LIMIT_BYTES: u64 = 8 << 30;

/// With more samples a DEM is read by windows: half a gigabyte.
const IN_MEMORY_SAMPLES: u64 = 1 << 27;

/// A partial file this old belongs to no running bake.
const ABANDONED_AFTER: Duration = Duration::from_secs(24 * 60 * 60);

/// Two threads must not bake one pyramid at a time: their partial files would be the same.
static BAKING: Mutex<()> = Mutex::new(());

/// Opens `path` itself if it is a pyramid with a valid sidecar; else the pyramid that was baked from it before; else
/// bakes one from the heights that `load` gives. A file counts as the same if its absolute path, size and time of
/// change are.
///
/// # Errors
/// If `path` is not there, `load` fails ([`PyramidError::Load`]), or the cache cannot be written.
pub fn open_or_bake<E>(
    path: &Path,
    load: impl FnOnce() -> Result<HeightGrid, E>,
    cache_dir: Option<&Path>,
    progress: &dyn Progress,
) -> Result<Pyramid, PyramidError>
where
    E: Into<Box<dyn std::error::Error + Send + Sync>>,
{
    if has_sidecar(path) {
        match Pyramid::open(path) {
            Err(error) if error.wants_bake() => tracing::warn!("{error}; baking anew"),
            opened => return opened,
        }
    }
    let metadata = fs::metadata(path).map_err(PyramidError::io(path, "opening"))?;
    let absolute = fs::canonicalize(path).map_err(PyramidError::io(path, "opening"))?;
    let changed = metadata.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok()).unwrap_or_default();
    let key = format!("{}\n{}\n{}", absolute.display(), metadata.len(), changed.as_nanos());
    open_or_bake_key(&key, &path.display().to_string(), load, cache_dir, progress)
}

/// The same for a DEM of any format and size: a large one is read by windows, and a bake that was stopped goes on.
///
/// # Errors
/// As [`open_or_bake`].
pub fn open_or_bake_file(path: &Path, progress: &dyn Progress) -> Result<Pyramid, PyramidError> {
    open_or_bake_file_with(path, &OpenOptions::default(), progress)
}

/// The same for a file that does not say all of itself. Other options are another pyramid; where they name a void,
/// heights that were baked before are baked anew.
///
/// # Errors
/// As [`open_or_bake`].
pub fn open_or_bake_file_with(
    path: &Path,
    options: &OpenOptions,
    progress: &dyn Progress,
) -> Result<Pyramid, PyramidError> {
    let load = |error: SourceError| PyramidError::Load(Box::new(error));
    if has_sidecar(path) && options.no_data.is_none() || !path.exists() {
        return open_or_bake(path, || source::open(path, progress), None, progress);
    }
    let reader = source::open_reader_with(path, options).map_err(load)?;
    let [width, height] = reader.size();
    let (key, name) = (reader.identity(), path.display().to_string());
    let is_large = u64::from(width) * u64::from(height) > IN_MEMORY_SAMPLES;
    cached(&key, &name, None, |out| {
        if is_large {
            let work = BakeWork { in_folder: true, resume: true, ..BakeWork::default() };
            bake_reader(&*reader, out, &BakeOptions::default(), &work, progress)?;
        } else {
            let grid = source::read_all(&*reader, path, progress).map_err(load)?;
            bake(&grid, out, &BakeOptions::default(), progress)?;
        }
        Ok(())
    })
}

/// The same for heights that no file holds: `key` says all that they depend on, `name` stands in messages and in the
/// name of the cached file.
///
/// # Errors
/// If `load` fails ([`PyramidError::Load`]) or the cache cannot be written.
pub fn open_or_bake_key<E>(
    key: &str,
    name: &str,
    load: impl FnOnce() -> Result<HeightGrid, E>,
    cache_dir: Option<&Path>,
    progress: &dyn Progress,
) -> Result<Pyramid, PyramidError>
where
    E: Into<Box<dyn std::error::Error + Send + Sync>>,
{
    cached(key, name, cache_dir, |out| {
        let grid = load().map_err(|source: E| PyramidError::Load(source.into()))?;
        bake(&grid, out, &BakeOptions::default(), progress).map(drop)
    })
}

/// The pyramid of a key, which `make` bakes where there is none.
fn cached(
    key: &str,
    name: &str,
    cache_dir: Option<&Path>,
    make: impl FnOnce(&Path) -> Result<(), PyramidError>,
) -> Result<Pyramid, PyramidError> {
    let folder = cache_folder(cache_dir)?;
    let cached = folder.join(file_name(key, name));
    // The lock guards no data, so a panic elsewhere does not spoil it.
    let _one_at_a_time = BAKING.lock().unwrap_or_else(PoisonError::into_inner);
    if cached.exists() {
        match Pyramid::open(&cached) {
            Ok(pyramid) => {
                mark_used(&cached);
                return Ok(pyramid);
            }
            Err(error) if error.wants_bake() => tracing::warn!("{error}; baking anew"),
            Err(error) => return Err(error),
        }
    }
    fs::create_dir_all(&folder).map_err(PyramidError::io(&folder, "creating"))?;
    make(&cached)?;
    trim(&folder, &cached, CACHE_LIMIT_BYTES);
    Pyramid::open(&cached)
}

/// The folder of cached pyramids, and of all else that hachure keeps.
pub(crate) fn cache_folder(named: Option<&Path>) -> Result<PathBuf, PyramidError> {
    if let Some(folder) = named {
        return Ok(folder.to_owned());
    }
    if let Some(folder) = std::env::var_os("HACHURE_CACHE").filter(|folder| !folder.is_empty()) {
        return Ok(folder.into());
    }
    let folders = directories::ProjectDirs::from("", "", "hachure").ok_or(PyramidError::NoCacheFolder)?;
    Ok(folders.cache_dir().to_owned())
}

/// A readable beginning, then what tells the keys apart, with the version of the format in it.
fn file_name(key: &str, name: &str) -> String {
    let stem = Path::new(name).file_stem().map(|stem| stem.to_string_lossy()).unwrap_or_default();
    let stem: String =
        stem.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).take(40).collect();
    let versioned = format!("{}\n{key}", sidecar::VERSION);
    format!("{stem}.{:016x}.tif", fnv(versioned.as_bytes()))
}

/// The time of change of a cached pyramid is that of its last use. It is only a hint for [`trim`].
fn mark_used(tif: &Path) {
    let touched = fs::File::options().append(true).open(tif).and_then(|file| file.set_modified(SystemTime::now()));
    if let Err(error) = touched {
        tracing::debug!("{}: {error}", tif.display());
    }
}

/// Removes the pyramids that were not used for the longest time until the folder holds no more than `limit_bytes`, and
/// partial files that were left behind. `keep` stays in any case. What cannot be removed stays.
pub fn trim(folder: &Path, keep: &Path, limit_bytes: u64) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    let mut pyramids = Vec::new();
    for entry in entries.flatten() {
        let path = entry.path();
        let Ok(metadata) = entry.metadata() else { continue };
        let used = metadata.modified().unwrap_or(UNIX_EPOCH);
        match path.extension().and_then(|extension| extension.to_str()) {
            Some("tif") => {
                let beside = fs::metadata(sidecar_path(&path)).map_or(0, |metadata| metadata.len());
                pyramids.push((used, metadata.len() + beside, path));
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
        if path != keep {
            // The sidecar first: a GeoTIFF without one is no pyramid.
            let _ = fs::remove_file(sidecar_path(&path));
            if fs::remove_file(&path).is_ok() {
                total -= bytes;
            }
        }
    }
}
