//! Reads a folder of terrain-RGB tiles, `z/x/y.png` or `z/x/y.webp`. Only the deepest zoom level is read.
//!
//! Descriptions in the folder are used: `tilemapresource.xml` of a Tile Map Service, and TileJSON.

use std::collections::HashMap;
use std::fs::DirEntry;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

use super::picture::{self, Picture};
use super::place::{cannot_open, small_text};
use super::sidecar::{OpenOptions, RasterInfo};
use super::tile_json::TileJson;
use super::tile_set::{TileLevel, TileSetReader, TileStoreReader};
use super::{SourceError, TileRows};

/// Extensions of tiles.
pub(super) const TILE_ENDINGS: [&str; 3] = ["png", "webp", "pngraw"];
/// Names of files in a folder of tiles that describe them as TileJSON does.
pub(super) const DESCRIPTIONS: [&str; 4] = ["tilejson.json", "tiles.json", "tile.json", "metadata.json"];
/// The description of a Tile Map Service.
pub(super) const TMS_DESCRIPTION: &str = "tilemapresource.xml";

/// Returns whether a folder has the structure `z/x/y.png`.
pub(super) fn is_tile_folder(folder: &Path) -> bool {
    let folders = |folder: &Path| numbered(folder, &[]).unwrap_or_default();
    let has_tiles = |folder: &Path| !numbered(folder, &TILE_ENDINGS).unwrap_or_default().is_empty();
    folders(folder).iter().any(|(_, zoom)| folders(zoom).iter().any(|(_, column)| has_tiles(column)))
}

/// Returns the entries of a folder whose names are numbers: folders, or files with one of the given extensions.
fn numbered(folder: &Path, endings: &[&'static str]) -> Result<Vec<(u32, PathBuf)>, SourceError> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(cannot_open(folder))? {
        let entry: DirEntry = entry.map_err(cannot_open(folder))?;
        let path = entry.path();
        let stem = if endings.is_empty() { path.file_name() } else { path.file_stem() };
        let number = stem.and_then(|stem| stem.to_str()).and_then(|stem| stem.parse().ok());
        // A name such as `07` instead of `7` belongs to another scheme.
        let number = number.filter(|number: &u32| stem.is_some_and(|stem| stem.to_str() == Some(&number.to_string())));
        let fits = || match endings.is_empty() {
            true => path.is_dir(),
            false => ending_of(&path, endings).is_some() && path.is_file(),
        };
        if let Some(number) = number.filter(|_| fits()) {
            found.push((number, path));
        }
    }
    found.sort();
    Ok(found)
}

fn ending_of(path: &Path, endings: &[&'static str]) -> Option<&'static str> {
    endings.iter().find(|ending| path.extension().is_some_and(|it| it == **ending)).copied()
}

/// The tiles of a level in a folder.
struct FolderTiles {
    level: PathBuf,
    /// The extension that most tiles have, and the tiles that have another.
    ending: &'static str,
    others: HashMap<[u32; 2], &'static str>,
}

impl TileStoreReader for FolderTiles {
    fn picture(&self, tile: [u32; 2]) -> Result<Picture, SourceError> {
        let path = self.name(tile);
        picture::decode_bytes(&path, &picture::small_file(&path)?)
    }

    fn name(&self, [x, y]: [u32; 2]) -> PathBuf {
        let ending = self.others.get(&[x, y]).unwrap_or(&self.ending);
        self.level.join(format!("{x}/{y}.{ending}"))
    }
}

/// Opens the deepest level of a folder as one grid of heights in metres, in Web Mercator.
///
/// # Errors
/// Fails if a folder or a description cannot be read, if the descriptions name another grid of tiles than that of web
/// maps, if there is no tile; and as [`TileSetReader::open`] does.
pub(super) fn open(folder: &Path, options: &OpenOptions) -> Result<TileSetReader, SourceError> {
    let mut info = RasterInfo::of(folder, options)?;
    let mut rows = None;
    for name in DESCRIPTIONS {
        let path = folder.join(name);
        if let Some(described) = path.is_file().then(|| TileJson::read(&path)).transpose()?.flatten() {
            rows = rows.or(described.rows);
            info.declare(&described);
        }
    }
    let service = folder.join(TMS_DESCRIPTION);
    if service.is_file() {
        check_service(&service)?;
        rows = Some(TileRows::Tms);
    }
    open_described(folder, folder, &TILE_ENDINGS, &info, rows)
}

/// Checks that a Tile Map Service has tiles of web maps.
fn check_service(path: &Path) -> Result<(), SourceError> {
    let text = small_text(path)?;
    let srs = text.split("<SRS>").nth(1).and_then(|rest| rest.split('<').next()).unwrap_or("").trim().to_owned();
    // The specification of the Tile Map Service calls Web Mercator OSGEO:41001.
    let is_mercator = ["3857", "900913", "3785", "102113", "102100", ":41001"].iter().any(|code| srs.ends_with(code));
    match is_mercator || srs.is_empty() {
        true => Ok(()),
        false => Err(SourceError::Unsupported { path: path.into(), what: format!("tiles in {srs}") }),
    }
}

/// Opens the deepest level below `folder`; `path` is the name of the tiles in messages.
pub(super) fn open_described(
    path: &Path,
    folder: &Path,
    endings: &[&'static str],
    info: &RasterInfo,
    rows: Option<TileRows>,
) -> Result<TileSetReader, SourceError> {
    let mut files: Vec<([u32; 2], PathBuf)> = Vec::new();
    let mut deepest = None;
    for (zoom, level) in numbered(folder, &[])?.into_iter().rev() {
        for (x, column) in numbered(&level, &[])? {
            files.extend(numbered(&column, endings)?.into_iter().map(|(y, path)| ([x, y], path)));
        }
        if !files.is_empty() {
            deepest = Some((zoom, level));
            break;
        }
    }
    let Some((zoom, level)) = deepest else { return Err(SourceError::NoMembers { path: path.into() }) };
    let identity = format!("{} tiles, {:016x}", files.len(), hash(&files));
    let count = |ending: &str| files.iter().filter(|(_, path)| has(path, ending)).count();
    let ending = endings.iter().copied().max_by_key(|ending| count(ending)).unwrap_or("png");
    let others = files.iter().filter(|(_, path)| !has(path, ending));
    let others = others.filter_map(|(tile, path)| Some((*tile, ending_of(path, endings)?))).collect();
    let mut tiles: Vec<[u32; 2]> = files.into_iter().map(|(tile, _)| tile).collect();
    tiles.dedup();
    let store = Box::new(FolderTiles { level, ending, others });
    TileSetReader::open(path, info, TileLevel { zoom, tiles, store, rows, identity })
}

fn has(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|it| it == ending)
}

/// Returns every tile's size and modification time as a hash, because there may be millions of tiles.
fn hash(files: &[([u32; 2], PathBuf)]) -> u64 {
    let mut hasher = DefaultHasher::new();
    for (tile, path) in files {
        let metadata = std::fs::metadata(path).ok();
        let changed = metadata.as_ref().and_then(|it| it.modified().ok());
        (tile, metadata.as_ref().map(std::fs::Metadata::len), changed).hash(&mut hasher);
    }
    hasher.finish()
}
