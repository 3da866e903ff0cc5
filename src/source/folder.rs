//! What a path is, and which files of a folder are height files.

use std::path::{Path, PathBuf};

use super::format::{self, Format};
use super::place::{cannot_open, ending};
use super::side_file::OpenOptions;
use super::{SourceError, ehdr, hgt, png16, side_file, tile_folder, xyz};
use crate::file::png::is_drawing;

/// What a path is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A file, or nothing: opening it tells.
    File,
    /// A folder of web map tiles, `z/x/y.png`, which is one grid.
    TileFolder,
    /// A folder of height files: see [`members`].
    Folder,
}

/// What a path is, by what lies there.
#[must_use]
pub fn kind_of(path: &Path) -> Kind {
    match path {
        _ if !path.is_dir() => Kind::File,
        _ if tile_folder::is_tile_folder(path) => Kind::TileFolder,
        _ => Kind::Folder,
    }
}

/// The height files of a folder and of the folders in it, sorted. Tiles in `z/x/y.png` are one member, their folder.
/// What is no height file is passed over, as are the headers and side files of those that are. A damaged height file is
/// a member: opening it tells.
///
/// # Errors
/// A folder that cannot be read, or that holds no height file.
pub fn members(folder: &Path) -> Result<Vec<PathBuf>, SourceError> {
    let mut members = Vec::new();
    for path in entries(folder)? {
        if !path.is_dir() {
            members.extend(Some(path).filter(|path| is_member(path)));
        } else if tile_folder::is_tile_folder(&path) {
            members.push(path);
        } else {
            members.extend(entries(&path)?.into_iter().filter(|path| is_member(path)));
        }
    }
    members.sort();
    match members.is_empty() {
        true => Err(SourceError::NoMembers { path: folder.into() }),
        false => Ok(members),
    }
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>, SourceError> {
    let failed = cannot_open(folder);
    let entries = std::fs::read_dir(folder).map_err(&failed)?;
    entries.map(|entry| entry.map(|entry| entry.path()).map_err(&failed)).collect()
}

/// Whether a file of a folder is one of its height files.
pub(super) fn is_member(path: &Path) -> bool {
    let is_hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
    // A header whose data has a known ending is found by its data.
    let is_named_by_data = ending(path) == "hdr" && ehdr::partner(path).is_some_and(|data| data.extension().is_some());
    // Masks and overviews that GDAL writes beside a file are part of it: `dem.tif.msk`, `dem.tif.ovr`.
    let is_part = ["msk", "ovr"].contains(&&*ending(path)) && path.with_extension("").is_file();
    if is_hidden || is_named_by_data || is_part || !path.is_file() {
        return false;
    }
    let options = OpenOptions::default();
    match format::of(path, &options) {
        // What hachure drew of a folder may lie in it.
        Ok(Format::Png) if is_drawing(path) => false,
        // Photographs and textures lie beside DEMs; only the pixels tell them from terrain-RGB.
        Ok(Format::Png) => side_file::Said::of(path, &options).and_then(|said| png16::open(path, &said)).is_ok(),
        Ok(Format::ZippedHgt) => !matches!(hgt::open_zip(path), Err(SourceError::UnknownFormat { .. })),
        // Any table begins as points do, a camera path for one.
        Ok(Format::Xyz) => ending(path) == "xyz" || xyz::open(path).is_ok(),
        Ok(_) => true,
        Err(_) => false,
    }
}
