//! Decides what a path is, and which files of a folder are height files.

use std::path::{Path, PathBuf};

use super::format::{self, Format};
use super::geotiff::guarded;
use super::place::{cannot_open, ending};
use super::sidecar::OpenOptions;
use super::{SourceError, archive, ehdr, png16, sidecar, tile_folder, xyz};
use crate::file::png::is_drawing;

/// The kinds of path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A file, or a path that does not exist; opening it gives the error.
    File,
    /// A folder of web map tiles, `z/x/y.png` or `z/x/y.webp`, which together are one grid.
    TileFolder,
    /// A folder of height files; see [`members`].
    Folder,
}

/// Returns the kind of file or folder at a path.
#[must_use]
pub fn kind_of(path: &Path) -> Kind {
    match path {
        _ if !path.is_dir() => Kind::File,
        _ if tile_folder::is_tile_folder(path) => Kind::TileFolder,
        _ => Kind::Folder,
    }
}

/// Returns the height files of a folder and of its direct subfolders, sorted. A folder of tiles in `z/x/y.png` is one
/// member. Other files, headers and sidecar files are ignored. A damaged height file is a member, so that opening it
/// reports the damage.
///
/// # Errors
/// Fails if the folder cannot be read or contains no height file.
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

/// Returns the pictures of a folder and of its direct subfolders that are not height files, each with its kind as the
/// end of a sentence. Pictures inside a GeoTIFF are not among them.
pub(crate) fn pictures(folder: &Path) -> Vec<(PathBuf, &'static str)> {
    let all = |folder: &Path| entries(folder).unwrap_or_default();
    let of = |path: PathBuf| match path.is_dir() {
        true if tile_folder::is_tile_folder(&path) => Vec::new(),
        true => all(&path),
        false => vec![path],
    };
    let picture = |path: PathBuf| {
        let is_hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        if is_hidden || !path.is_file() || is_member(&path) {
            return None;
        }
        match format::of(&path, &OpenOptions::default()) {
            Ok(Format::Png) if is_drawing(&path) => Some((path, "is a picture that hachure drew")),
            Ok(Format::Png) => Some((path, "is a picture without heights")),
            Ok(Format::Exr) => Some((path, "is an EXR picture without a sidecar file")),
            Err(SourceError::UnknownFormat {
                looks_like: what @ ("is a JPEG picture" | "is a GIF picture"), ..
            }) => Some((path, what)),
            _ => None,
        }
    };
    let mut pictures: Vec<_> = all(folder).into_iter().flat_map(of).filter_map(picture).collect();
    pictures.sort();
    pictures
}

fn entries(folder: &Path) -> Result<Vec<PathBuf>, SourceError> {
    let failed = cannot_open(folder);
    let entries = std::fs::read_dir(folder).map_err(&failed)?;
    entries.map(|entry| entry.map(|entry| entry.path()).map_err(&failed)).collect()
}

/// Returns whether a file of a folder is one of its height files.
pub(super) fn is_member(path: &Path) -> bool {
    let is_hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
    // A header is not a member if its data file has a known extension: that file is the member.
    let is_named_by_data = ending(path) == "hdr" && ehdr::partner(path).is_some_and(|data| data.extension().is_some());
    // Masks and overviews that GDAL writes next to a file are part of that file: `dem.tif.msk`, `dem.tif.ovr`.
    let is_part = ["msk", "ovr"].contains(&&*ending(path)) && path.with_extension("").is_file();
    if is_hidden || is_named_by_data || is_part || !path.is_file() {
        return false;
    }
    let options = OpenOptions::default();
    match format::of(path, &options) {
        // The folder may contain pictures that hachure drew of it.
        Ok(Format::Png) if is_drawing(path) => false,
        // The folder may contain photographs and textures; only the pixels distinguish them from terrain-RGB. Numbers
        // whose encoding is not known count as heights; opening them reports the unknown encoding.
        Ok(Format::Png) => {
            let opened = sidecar::RasterInfo::of(path, &options)
                .and_then(|info| guarded(path, || png16::open(path, &info, &options)));
            matches!(opened, Ok(_) | Err(SourceError::Encodings { .. }))
        }
        // The tiles that it describes are members themselves.
        Ok(Format::TileJson) => false,
        Ok(Format::Container(container)) => archive::holds_heights(path, container),
        // Most EXR pictures are textures or drawings.
        Ok(Format::Exr) => sidecar::sidecar_path(path).is_some(),
        // Any numeric table begins like XYZ points, for example a camera path.
        Ok(Format::Xyz) => ending(path) == "xyz" || xyz::open(path).is_ok(),
        Ok(_) => true,
        Err(_) => false,
    }
}
