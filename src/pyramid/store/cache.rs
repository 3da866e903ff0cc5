//! The cache of baked pyramids: stored in a folder of the system's cache, found again by their origin, and removed, the
//! least recently used first, when they take too much space. Damaged files are rebuilt (`entry`, `healing`).
//!
//! The folder is hachure's own ([`crate::file::cache_folder`]) within the one that the caller names, otherwise
//! `HACHURE_CACHE`, otherwise the system's cache folder for hachure.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::UNIX_EPOCH;

use super::entry::Entry;
use super::healing::Healing;
use super::pyramid::Pyramid;
use super::tile_store::TileStore;
use crate::file::cache_folder as own_folder;
use crate::pyramid::bake::{BakeOptions, BakeWork, bake_reader, bake_with};
use crate::pyramid::error::PyramidError;
use crate::pyramid::format::bytes::fnv;
use crate::pyramid::format::pair::has_sidecar;
use crate::pyramid::format::sidecar;
use crate::source::{self, HeightGrid, HeightReader, OpenOptions, Progress, Silent, SourceError};

/// A DEM with more samples is read in windows: half a gigabyte.
const IN_MEMORY_SAMPLES: u64 = 1 << 27;

/// The work of a bake into the cache: only the user may read the files.
const WORK: BakeWork<'static> = BakeWork { is_private: true, ..BakeWork::NEW };

/// Opens `path` itself if it is a pyramid with a valid sidecar; otherwise the pyramid that was baked from it before;
/// otherwise bakes one from the heights that `load` returns. A file counts as the same if its absolute path, size and
/// modification time are unchanged.
///
/// # Errors
/// If `path` does not exist, `load` fails ([`PyramidError::Load`]), or the cache cannot be written.
pub(crate) fn open_or_bake<E>(
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
            Err(error) if error.wants_bake() => tracing::warn!("{error}; baking again"),
            opened => return opened,
        }
    }
    let metadata = fs::metadata(path).map_err(PyramidError::io(path, "opening"))?;
    let absolute = fs::canonicalize(path).map_err(PyramidError::io(path, "opening"))?;
    let changed = metadata.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok()).unwrap_or_default();
    let key = format!("{}\n{}\n{}", absolute.display(), metadata.len(), changed.as_nanos());
    open_or_bake_key(&key, &path.display().to_string(), load, cache_dir, progress)
}

/// Opens or bakes a DEM of any format and size, like [`open_or_bake`]. A large one is read in windows, and an
/// interrupted bake is resumed.
///
/// # Errors
/// The errors of [`open_or_bake`].
pub fn open_or_bake_file(path: &Path, progress: &dyn Progress) -> Result<Pyramid, PyramidError> {
    open_or_bake_file_with(path, &OpenOptions::default(), progress)
}

/// Like [`open_or_bake_file`], with options for what the file does not declare itself. Other options make another
/// pyramid. With a no-data value, even a baked pyramid is baked again.
///
/// # Errors
/// The errors of [`open_or_bake`].
pub(crate) fn open_or_bake_file_with(
    path: &Path,
    options: &OpenOptions,
    progress: &dyn Progress,
) -> Result<Pyramid, PyramidError> {
    if is_pyramid(path, options) || !path.exists() {
        let open = || source::read_all(&*source::open_reader_with(path, options)?, path, progress);
        return open_or_bake(path, open, None, progress);
    }
    file_of_cache(path, options, progress).map(|(pyramid, _)| pyramid)
}

/// Like [`open_or_bake_file_with`], as a store of tiles that rebuilds a cached pyramid if damage is found while it is
/// read.
///
/// # Errors
/// The errors of [`open_or_bake`].
pub fn open_or_bake_store(
    path: &Path,
    options: &OpenOptions,
    progress: &dyn Progress,
) -> Result<Arc<dyn TileStore>, PyramidError> {
    if is_pyramid(path, options) || !path.exists() {
        return Ok(Arc::new(open_or_bake_file_with(path, options, progress)?));
    }
    let (pyramid, entry) = file_of_cache(path, options, progress)?;
    let (path, options, key) = (path.to_owned(), *options, entry.key().to_owned());
    let make = move |out: &Path| {
        let reader = source::open_reader_with(&path, &options).map_err(load_error)?;
        if reader.identity() != key {
            let cause = "the file has changed since it was opened".to_owned();
            return Err(PyramidError::Mismatch { path: path.clone(), cause });
        }
        bake_file(&*reader, &path, out, &Silent)
    };
    Ok(Arc::new(Healing::new(pyramid, entry, Box::new(make))))
}

/// Returns whether the file is read as a pyramid. With a no-data value it is not, because the levels already include
/// that value in their averages; nor with another unit of heights.
fn is_pyramid(path: &Path, options: &OpenOptions) -> bool {
    has_sidecar(path) && !options.changes_heights()
}

fn load_error(error: SourceError) -> PyramidError {
    PyramidError::Load(Box::new(error))
}

fn file_of_cache(
    path: &Path,
    options: &OpenOptions,
    progress: &dyn Progress,
) -> Result<(Pyramid, Entry), PyramidError> {
    let reader = source::open_reader_with(path, options).map_err(load_error)?;
    let entry = entry_of(&reader.identity(), &path.display().to_string(), None)?;
    let mut is_made = false;
    let pyramid = entry.open_or_make(|out| {
        is_made = true;
        bake_file(&*reader, path, out, progress)
    })?;
    match is_made {
        true => entry.store_notes(&reader.warnings()),
        false => entry.repeat_notes(),
    }
    Ok((pyramid, entry))
}

fn bake_file(reader: &dyn HeightReader, path: &Path, out: &Path, progress: &dyn Progress) -> Result<(), PyramidError> {
    let [width, height] = reader.size();
    if u64::from(width) * u64::from(height) > IN_MEMORY_SAMPLES {
        let work = BakeWork { in_folder: true, resume: true, stop: progress.stop(), ..WORK };
        bake_reader(reader, out, &BakeOptions::default(), &work, progress)?;
    } else {
        let grid = source::read_all(reader, path, progress).map_err(load_error)?;
        bake_with(&grid, out, &BakeOptions::default(), &BakeWork { stop: progress.stop(), ..WORK }, progress)?;
    }
    Ok(())
}

/// Like [`open_or_bake`] for heights that are not in a file: `key` contains everything that they depend on, `name` is
/// used in messages and in the name of the cached file.
///
/// # Errors
/// If `load` fails ([`PyramidError::Load`]) or the cache cannot be written.
pub(crate) fn open_or_bake_key<E>(
    key: &str,
    name: &str,
    load: impl FnOnce() -> Result<HeightGrid, E>,
    cache_dir: Option<&Path>,
    progress: &dyn Progress,
) -> Result<Pyramid, PyramidError>
where
    E: Into<Box<dyn std::error::Error + Send + Sync>>,
{
    let mut load = Some(load);
    entry_of(key, name, cache_dir)?.open_or_make(|out| {
        let Some(load) = load.take() else { return Err(PyramidError::Stopped) };
        let grid = load().map_err(|source: E| PyramidError::Load(source.into()))?;
        bake_with(&grid, out, &BakeOptions::default(), &BakeWork { stop: progress.stop(), ..WORK }, progress).map(drop)
    })
}

/// Like [`open_or_bake_key`], as a store of tiles, for heights that can be generated again: if the pyramid turns out to
/// be damaged, it is rebuilt while it is read.
///
/// # Errors
/// If the cache cannot be written.
pub fn open_or_grow_store(
    key: &str,
    name: &str,
    grow: impl Fn(&dyn Progress) -> HeightGrid + Send + Sync + 'static,
    cache_dir: Option<&Path>,
    progress: &dyn Progress,
) -> Result<Arc<dyn TileStore>, PyramidError> {
    let entry = entry_of(key, name, cache_dir)?;
    let make = move |out: &Path, progress: &dyn Progress| {
        bake_with(&grow(progress), out, &BakeOptions::default(), &BakeWork { stop: progress.stop(), ..WORK }, progress)
            .map(drop)
    };
    let pyramid = entry.open_or_make(|out| make(out, progress))?;
    Ok(Arc::new(Healing::new(pyramid, entry, Box::new(move |out| make(out, &Silent)))))
}

fn entry_of(key: &str, name: &str, cache_dir: Option<&Path>) -> Result<Entry, PyramidError> {
    Ok(Entry::new(cache_folder(cache_dir)?, &file_name(key, name), key, name))
}

/// Returns hachure's own folder for cached pyramids and its other caches. It exists and may be trusted.
pub(crate) fn cache_folder(named: Option<&Path>) -> Result<PathBuf, PyramidError> {
    let root = named.map(Path::to_owned).or_else(own_folder::root).ok_or(PyramidError::NoCacheFolder)?;
    own_folder::open(&root).map_err(|source| PyramidError::Cache { folder: root, source: source.into() })
}

/// Returns the file name: a readable prefix, then a hash of the key and the format version.
fn file_name(key: &str, name: &str) -> String {
    let stem = Path::new(name).file_stem().map(|stem| stem.to_string_lossy()).unwrap_or_default();
    let stem: String =
        stem.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).take(40).collect();
    let versioned = format!("{}\n{}\n{key}", sidecar::VERSION, source::VERSION);
    format!("{stem}.{:016x}.tif", fnv(versioned.as_bytes()))
}
