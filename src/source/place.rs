//! Helpers for the readers of formats other than GeoTIFF: georeferences, identities of files, checks and errors.

use std::fmt::{Display, Write as _};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

use super::georeference::{self, Georeference};
use super::reader::Window;
use super::{GeoKeys, SourceError, WorldMapping, crs_catalogue, geokeys as key, memory};
use crate::file::input;
use crate::file::message::printable;
use key::GeoKey;

/// Returns the keys of an EPSG code; `is_geographic` is true for longitudes and latitudes.
pub(super) fn epsg(code: u16, is_geographic: bool) -> GeoKeys {
    let (model, id) = if is_geographic { (2, key::GEOGRAPHIC_CRS) } else { (1, key::PROJECTED_CRS) };
    GeoKeys::from_keys(vec![GeoKey::short(key::MODEL_TYPE, model), GeoKey::short(id, code)])
}

/// Returns the EPSG code of a text such as `EPSG:32632`.
pub(super) fn code_of(crs: &str) -> Option<u16> {
    crs.trim().to_ascii_uppercase().strip_prefix("EPSG:")?.parse().ok()
}

/// Returns the keys of a CRS that is given by its code; `None` if the catalogue does not contain it.
pub(super) fn keys_of_code(crs: &str) -> Option<GeoKeys> {
    let code = code_of(crs)?;
    match crs_catalogue::look_up(code)?.kind {
        crs_catalogue::Kind::Projected => Some(epsg(code, false)),
        crs_catalogue::Kind::Geographic => Some(epsg(code, true)),
        crs_catalogue::Kind::Geocentric => None,
    }
}

/// Returns the keys of longitudes and latitudes in degrees on WGS 84.
pub(super) fn wgs84() -> GeoKeys {
    epsg(4326, true)
}

/// Returns the keys of a grid in metres without a position on the earth, which causes no warning.
pub(super) fn local_metres() -> GeoKeys {
    GeoKeys::from_keys(vec![GeoKey::short(key::LINEAR_UNITS, key::METRE)])
}

/// Returns the transform of a grid whose rows run south. `first` is the centre of its first sample and `step` the
/// distance between samples along columns and rows, both in units of the CRS.
pub(super) fn north_up(first: [f64; 2], step: [f64; 2]) -> [f64; 6] {
    [first[0], step[0], 0.0, first[1], 0.0, -step[1]]
}

/// Returns the georeference of a grid, and checks that it can be mapped to world coordinates.
pub(super) fn locate(
    path: &Path,
    crs_from_grid: [f64; 6],
    geokeys: GeoKeys,
    size: [u32; 2],
) -> Result<Georeference, SourceError> {
    let located = |source| SourceError::Georeference { path: path.into(), source };
    let georeference =
        georeference::from_transform(crs_from_grid, geokeys, &path.display().to_string()).map_err(located)?;
    WorldMapping::new(&georeference, size[0], size[1]).map_err(located)?;
    Ok(georeference)
}

/// Returns a text that identifies the heights of a reader: its files with their sizes and modification times, and
/// `options`.
pub(super) fn identity(files: &[&Path], options: &str) -> String {
    let mut text = String::new();
    for file in files {
        // A missing file has no size, so that its absence is part of the identity.
        let metadata = std::fs::metadata(file).ok();
        let length = metadata.as_ref().map_or(0, std::fs::Metadata::len);
        let changed = metadata.and_then(|it| it.modified().ok()).and_then(|time| time.duration_since(UNIX_EPOCH).ok());
        let absolute = std::path::absolute(file).unwrap_or_else(|_| file.to_path_buf());
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}\t{length}\t{}", absolute.display(), changed.unwrap_or_default().as_nanos());
    }
    text + options
}

/// Checks that a size is large enough for a surface.
pub(super) fn check_size(path: &Path, [width, height]: [u32; 2]) -> Result<(), SourceError> {
    match width < 2 || height < 2 {
        true => Err(SourceError::TooSmall { path: path.into(), width, height }),
        false => Ok(()),
    }
}

/// Checks that a window is inside the grid, and reserves memory for its heights.
///
/// # Errors
/// Fails if the window is outside, or if the allocation fails.
pub(super) fn begin_window(path: &Path, window: Window, size: [u32; 2]) -> Result<Vec<f32>, SourceError> {
    check_window(path, window, size)?;
    memory::window_room(path, window)
}

/// Checks that a window is inside the grid.
pub(super) fn check_window(path: &Path, window: Window, size: [u32; 2]) -> Result<(), SourceError> {
    let is_inside = |first: u32, count: u32, size: u32| first.checked_add(count).is_some_and(|end| end <= size);
    if is_inside(window.x, window.width, size[0]) && is_inside(window.y, window.height, size[1]) {
        return Ok(());
    }
    Err(inconsistent(path, format!("a requested window is outside its {}×{} samples", size[0], size[1])))
}

/// Largest number of characters of a cause: our own sentences are never longer, and foreign texts in them are cut by
/// themselves.
const LONGEST_CAUSE: usize = 300;

/// Returns the error of a file that contradicts itself.
pub(super) fn inconsistent(path: &Path, what: impl Into<String>) -> SourceError {
    SourceError::Inconsistent { path: path.into(), what: printable(&what.into(), LONGEST_CAUSE) }
}

/// Returns the error of a file that lacks necessary information.
pub(super) fn unclear(path: &Path, why: impl Into<String>) -> SourceError {
    SourceError::Unclear { path: path.into(), why: printable(&why.into(), LONGEST_CAUSE) }
}

/// Largest number of characters of a library's message.
const MAX_FOREIGN_CHARS: usize = 120;

/// Returns the message of a library in one short line.
pub(super) fn foreign_message(error: &dyn Display) -> String {
    printable(&error.to_string(), MAX_FOREIGN_CHARS)
}

/// Returns a function that converts an error of the file system.
pub(super) fn cannot_open(path: &Path) -> impl Fn(std::io::Error) -> SourceError + '_ {
    |source| SourceError::Open { path: path.into(), source: input::plain(source) }
}

/// Returns the existing file that has the name of `path` with another extension, in lower or upper case or with a
/// capital: `dem.bil` and `dem.HDR`.
pub(super) fn sibling(path: &Path, ending: &str) -> Option<PathBuf> {
    let appended = |ending: &str| {
        let mut name = path.as_os_str().to_owned();
        name.push(".");
        name.push(ending);
        PathBuf::from(name)
    };
    let upper = ending.to_ascii_uppercase();
    let mut chars = ending.chars();
    let capital: String = chars.next().map(|first| first.to_ascii_uppercase()).into_iter().chain(chars).collect();
    let spellings = [ending, &upper, &capital];
    spellings
        .map(|ending| path.with_extension(ending))
        .into_iter()
        .chain(spellings.map(appended))
        .find(|sibling| sibling != path && sibling.is_file())
}

/// Returns the extension of a name in lower case; empty if it has none.
pub(super) fn ending(path: &Path) -> String {
    path.extension().map(|it| it.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// Largest size of a header or sidecar file in bytes.
const MAX_TEXT_BYTES: u64 = 1 << 20;

/// Reads a small text file, such as a header; invalid UTF-8 is replaced.
pub(super) fn small_text(path: &Path) -> Result<String, SourceError> {
    let length = std::fs::metadata(path).map_err(cannot_open(path))?.len();
    if length > MAX_TEXT_BYTES {
        return Err(inconsistent(path, format!("{length} bytes are too many for a header")));
    }
    let bytes = std::fs::read(path).map_err(cannot_open(path))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
