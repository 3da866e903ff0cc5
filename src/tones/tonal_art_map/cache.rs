//! The cache of tonal art maps, in `marks/` of the cache folder: a file for each recipe.
//!
//! ```text
//! 8 bytes  "HACHTAM1"
//! u64      hash of the recipe and the generator's version
//! u32      side in pixels
//! u64      FNV-1a of the thresholds
//! …        the thresholds
//! ```
//!
//! A file that is damaged, cut off or of another recipe is regenerated. If the folder cannot be written, the map is
//! generated each time.

use std::fs;
use std::path::Path;
use std::time::UNIX_EPOCH;

use super::{GENERATOR_VERSION, TonalArtMap};
use crate::file::cache_folder;
use crate::file::unnamed::head;
use crate::remote::Fnv;
use crate::style::StyleError;
use crate::style::marks::{Kind, Recipe};

const MAGIC: &[u8; 8] = b"HACHTAM1";
const HEAD_BYTES: usize = 8 + 8 + 4 + 8;
/// A user who edits a recipe generates many maps; the oldest files are removed.
const MAX_FILES: usize = 64;
/// Largest file that is read, in bytes: a side has at most 2048 texels.
const LARGEST_BYTES: u64 = 64 << 20;

/// Returns the recipe's map from `folder`; if it is not there, generates and stores it.
///
/// # Errors
/// The same as [`TonalArtMap::make`].
pub(crate) fn read_or_make(recipe: &Recipe, folder: &Path) -> Result<TonalArtMap, StyleError> {
    if recipe.kind == Kind::Stack {
        // The pictures may change without their names, and reading them takes most of the time.
        return TonalArtMap::make(recipe);
    }
    let key = key(recipe);
    let path = folder.join(format!("{key:016x}.tam"));
    if let Some(bytes) = cache_folder::read(&path, LARGEST_BYTES) {
        if let Some(map) = unpack(&bytes, key) {
            return Ok(map);
        }
        tracing::warn!("a cached tonal art map (a pattern of hatching) is damaged and is regenerated");
        tracing::debug!("{}: is damaged", path.display());
    }
    let map = TonalArtMap::make(recipe)?;
    if let Err(error) = cache_folder::write(&path, &pack(&map, key)) {
        tracing::debug!("{}: {error}", path.display());
    }
    trim(folder);
    Ok(map)
}

/// Returns a hash of everything that a map depends on.
fn key(recipe: &Recipe) -> u64 {
    // `Debug` writes every number so that it can be read back; the description does not affect the marks.
    let recipe = Recipe { description: String::new(), ..recipe.clone() };
    Fnv::new().add(&GENERATOR_VERSION.to_le_bytes()).add(format!("{recipe:?}").as_bytes()).finish()
}

fn pack(map: &TonalArtMap, key: u64) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEAD_BYTES + map.thresholds.len());
    bytes.extend(MAGIC);
    bytes.extend(key.to_le_bytes());
    bytes.extend(map.side_px.to_le_bytes());
    bytes.extend(Fnv::new().add(&map.thresholds).finish().to_le_bytes());
    bytes.extend(&map.thresholds);
    bytes
}

fn unpack(bytes: &[u8], key: u64) -> Option<TonalArtMap> {
    let (magic, rest) = bytes.split_first_chunk::<8>()?;
    let (for_key, rest) = rest.split_first_chunk::<8>()?;
    let (side_px, rest) = rest.split_first_chunk::<4>()?;
    let (sum, thresholds) = rest.split_first_chunk::<8>()?;
    let side_px = u32::from_le_bytes(*side_px);
    let is_whole = magic == MAGIC
        && u64::from_le_bytes(*for_key) == key
        && thresholds.len() as u64 == u64::from(side_px) * u64::from(side_px)
        && Fnv::new().add(thresholds).finish() == u64::from_le_bytes(*sum);
    is_whole.then(|| TonalArtMap { side_px, thresholds: thresholds.to_vec() })
}

/// Returns whether a file of the folder is a map, by its name and its first bytes.
fn is_own(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let hash = name.strip_suffix(".tam").unwrap_or_default();
    hash.len() == 16
        && hash.bytes().all(|byte| byte.is_ascii_hexdigit())
        && cache_folder::is_file(path)
        && head(path, MAGIC.len()) == MAGIC
}

/// Removes the oldest files beyond [`MAX_FILES`]. Files that cannot be removed stay.
fn trim(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    let mut maps: Vec<_> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| is_own(path))
        .map(|path| (fs::metadata(&path).and_then(|metadata| metadata.modified()).unwrap_or(UNIX_EPOCH), path))
        .collect();
    maps.sort();
    let too_many = maps.len().saturating_sub(MAX_FILES);
    for (_, path) in &maps[..too_many] {
        let _ = fs::remove_file(path);
    }
}
