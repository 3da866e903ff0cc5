//! Lists the local files that opening a path reads, so that outputs do not overwrite them.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::ehdr::DATA_ENDINGS;
use super::folder::{self, Kind, kind_of};
use super::tile_folder::{self, DESCRIPTIONS, TILE_ENDINGS, TMS_DESCRIPTION};
use super::tile_json;
use crate::file::guard::Inputs;

/// Extensions of the files that belong to a raster. They follow its whole name or replace its extension.
const SIDECAR_EXTENSIONS: [&str; 28] = [
    "hdr", "prj", "toml", "tiles", "tfw", "tifw", "wld", "pgw", "pngw", "blw", "bpw", "aux.xml", "aux", "ovr", "msk",
    "stx", "clr", "qpj", "vrt", "tiffw", "jgw", "wpw", "webpw", "rww", "raww", "r6w", "r16w", "exrw",
];

/// Adds a height file with its sidecar files, a folder of height files, or a folder of tiles.
pub(crate) fn add_inputs(path: &Path, inputs: &mut Inputs) {
    match kind_of(path) {
        Kind::File => {
            files_of(path).iter().for_each(|file| inputs.add(file));
            if let Some(folder) = has_ending(path, "json").then(|| tile_json::folder_of(path)).flatten() {
                add_tiles(&folder, inputs);
            }
        }
        Kind::TileFolder => add_tiles(path, inputs),
        Kind::Folder => {
            inputs.add_folder(path, |inside| inside.components().count() <= 2 && is_geotiff(inside));
            for entry in entries(path) {
                if !entry.is_dir() {
                    inputs.add_if(&entry, is_read_in_folder);
                } else if tile_folder::is_tile_folder(&entry) {
                    add_tiles(&entry, inputs);
                } else {
                    entries(&entry).iter().for_each(|entry| inputs.add_if(entry, is_read_in_folder));
                }
            }
        }
    }
}

/// Returns a height file and all existing sidecar files that may describe it.
#[must_use]
pub(crate) fn files_of(path: &Path) -> Vec<PathBuf> {
    let mut endings = SIDECAR_EXTENSIONS.to_vec();
    if has_ending(path, "hdr") {
        // If a header is given, its data file is read too.
        endings.extend(DATA_ENDINGS);
        endings.push("");
    }
    let mut files = vec![path.to_owned()];
    for ending in endings {
        for ending in [ending.to_owned(), ending.to_ascii_uppercase()] {
            let mut appended = path.as_os_str().to_owned();
            appended.push(".");
            appended.push(&ending);
            files.extend([PathBuf::from(appended), path.with_extension(&ending)]);
        }
    }
    files.retain(|file| file.is_file());
    files.sort();
    files.dedup();
    files
}

/// Adds the tiles of a folder by the pattern of their paths: a folder may have millions of tiles.
fn add_tiles(folder: &Path, inputs: &mut Inputs) {
    inputs.add_folder(folder, |inside| {
        let is_number = |name: &OsStr| name.to_str().is_some_and(|name| name.parse::<u32>().is_ok());
        let names: Vec<&OsStr> = inside.iter().collect();
        match names[..] {
            [zoom, column, _] => {
                is_number(zoom)
                    && is_number(column)
                    && TILE_ENDINGS.iter().any(|ending| has_ending(inside, ending))
                    && inside.file_stem().is_some_and(is_number)
            }
            _ => false,
        }
    });
    files_of(folder).iter().for_each(|file| inputs.add(file));
    let descriptions = DESCRIPTIONS.iter().chain([&TMS_DESCRIPTION]).map(|name| folder.join(name));
    descriptions.filter(|file| file.is_file()).for_each(|file| inputs.add(&file));
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    // Errors are ignored here: opening the folder reports them.
    std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect()
}

fn is_read_in_folder(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let is_sidecar = |ending: &&str| name.strip_suffix(*ending).is_some_and(|stem| stem.ends_with('.'));
    SIDECAR_EXTENSIONS.iter().any(is_sidecar) || folder::is_member(path)
}

fn is_geotiff(path: &Path) -> bool {
    has_ending(path, "tif") || has_ending(path, "tiff")
}

fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|it| it.eq_ignore_ascii_case(ending))
}
