//! Reads a folder of terrain-RGB tiles, `z/x/y.png`, in the numbering of web maps. Only the deepest zoom level is read;
//! missing tiles are no-data.
//!
//! Level z has 2^z × 2^z tiles; x counts from 180° west, y from the north. The CRS is Web Mercator (EPSG:3857).

use std::collections::HashSet;
use std::fs::DirEntry;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

use super::SourceError;
use super::georeference::Georeference;
use super::memory;
use super::picture::{self, Picture};
use super::place::{self, cannot_open, check_window, inconsistent};
use super::reader::{HeightReader, Window};
use super::sidecar::{OpenOptions, RasterInfo};
use super::terrain_rgb::Packing;
use super::values::Holds;

/// Half the width of the map in metres: π times the equatorial radius of WGS 84.
const HALF_MAP_M: f64 = 20_037_508.342_789_244;
/// Deepest zoom level: 2^22 tiles of 512 pixels are 2^31 pixels.
const MAX_ZOOM: u32 = 22;
/// Number of tiles that are examined to find out the encoding of heights.
const SAMPLE_TILES: usize = 8;

/// A folder of tiles as one grid.
pub(super) struct TileFolderReader {
    folder: PathBuf,
    zoom: u32,
    tile_px: u32,
    /// Tile numbers of the westernmost column and the northernmost row.
    first: [u32; 2],
    /// Number of columns of the level; column 0 follows the last one.
    columns: u32,
    /// The existing tiles; columns east of the antimeridian continue to count if `first` is west of it.
    present: HashSet<[u32; 2]>,
    packing: Packing,
    size: [u32; 2],
    georeference: Georeference,
    identity: String,
}

/// Returns whether a folder has the structure `z/x/y.png`.
pub(super) fn is_tile_folder(folder: &Path) -> bool {
    let folders = |folder: &Path| numbered(folder, "").unwrap_or_default();
    let has_tiles = |folder: &Path| !numbered(folder, "png").unwrap_or_default().is_empty();
    folders(folder).iter().any(|(_, zoom)| folders(zoom).iter().any(|(_, column)| has_tiles(column)))
}

/// Returns the entries of a folder whose names are numbers: folders, or files with the given extension.
fn numbered(folder: &Path, ending: &str) -> Result<Vec<(u32, PathBuf)>, SourceError> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(cannot_open(folder))? {
        let entry: DirEntry = entry.map_err(cannot_open(folder))?;
        let path = entry.path();
        let stem = if ending.is_empty() { path.file_name() } else { path.file_stem() };
        let number = stem.and_then(|stem| stem.to_str()).and_then(|stem| stem.parse().ok());
        // A name such as `07` instead of `7` belongs to another scheme.
        let number = number.filter(|number: &u32| stem.is_some_and(|stem| stem.to_str() == Some(&number.to_string())));
        let fits = if ending.is_empty() {
            path.is_dir()
        } else {
            path.extension().is_some_and(|it| it == ending) && path.is_file()
        };
        found.extend(number.filter(|_| fits).map(|number| (number, path)));
    }
    found.sort();
    Ok(found)
}

impl TileFolderReader {
    /// Opens the deepest level of a folder.
    pub(super) fn open(folder: &Path, options: &OpenOptions) -> Result<Self, SourceError> {
        let mut tiles: Vec<([u32; 2], PathBuf)> = Vec::new();
        let mut zoom = 0;
        for (level, level_folder) in numbered(folder, "")?.into_iter().rev() {
            for (x, column_folder) in numbered(&level_folder, "")? {
                tiles.extend(numbered(&column_folder, "png")?.into_iter().map(|(y, path)| ([x, y], path)));
            }
            if !tiles.is_empty() {
                zoom = level;
                break;
            }
        }
        let count = 1u32.checked_shl(zoom).filter(|_| zoom <= MAX_ZOOM);
        let count = count.ok_or_else(|| inconsistent(folder, format!("its zoom level {zoom} is too deep")))?;
        if let Some((_, path)) = tiles.iter().find(|(tile, _)| tile.iter().any(|&number| number >= count)) {
            return Err(inconsistent(path, format!("level {zoom} only has {count}×{count} tiles")));
        }
        let Some((_, first_tile)) = tiles.first() else {
            return Err(SourceError::NoMembers { path: folder.into() });
        };
        let [tile_px, tile_rows] = picture::header(first_tile)?.size;
        if tile_px != tile_rows || !(2..=4096).contains(&tile_px) {
            return Err(inconsistent(first_tile, format!("a tile must be square, not {tile_px}×{tile_rows}")));
        }

        let info = RasterInfo::of(folder, options)?;
        let step = (tiles.len() / SAMPLE_TILES).max(1);
        let samples = tiles.iter().step_by(step).take(SAMPLE_TILES).map(|(_, path)| decode(path, tile_px));
        let packing = Packing::of(folder, &info, &samples.collect::<Result<Vec<_>, _>>()?)?;

        let numbers = |axis: usize| tiles.iter().map(move |(tile, _)| tile[axis]);
        let (x, columns) = columns_around(numbers(0), count);
        let y = numbers(1).min().unwrap_or(0);
        let rows = numbers(1).max().unwrap_or(0) - y + 1;
        let samples = |tiles: u32| {
            tiles.checked_mul(tile_px).ok_or_else(|| inconsistent(folder, "its tiles span too wide an area"))
        };
        let size = [samples(columns)?, samples(rows)?];
        let pixel_m = 2.0 * HALF_MAP_M / (f64::from(count) * f64::from(tile_px));
        let centre = |tile: u32| (f64::from(tile) * f64::from(tile_px) + 0.5) * pixel_m - HALF_MAP_M;
        let crs_from_grid = place::north_up([centre(x), -centre(y)], [pixel_m; 2]);
        let georeference = place::locate(folder, crs_from_grid, place::epsg(3857, false), size)?;
        let identity = identity(folder, &info, &tiles);
        let unwrapped = |[column, row]: [u32; 2]| [if column < x { column + count } else { column }, row];
        let present = tiles.into_iter().map(|(tile, _)| unwrapped(tile)).collect();
        Ok(Self {
            folder: folder.into(),
            zoom,
            tile_px,
            first: [x, y],
            columns: count,
            present,
            packing,
            size,
            georeference,
            identity,
        })
    }
}

/// Returns the first column and the number of columns that contain all tiles. Column 0 follows the last one, so that
/// tiles on both sides of 180° are neighbours; the widest gap between tiles is left out. `count` is the number of
/// columns of the level.
fn columns_around(columns: impl Iterator<Item = u32>, count: u32) -> (u32, u32) {
    let mut columns: Vec<u32> = columns.collect();
    columns.sort_unstable();
    columns.dedup();
    let (Some(&west), Some(&east)) = (columns.first(), columns.last()) else { return (0, 0) };
    let widest = columns.windows(2).max_by_key(|pair| pair[1] - pair[0]);
    match widest {
        // The gap over the antimeridian is left out if it is as wide as any other.
        Some(&[before, after]) if after - before > west + count - east => (after, before + count - after + 1),
        _ => (west, east - west + 1),
    }
}

/// Returns every tile's size and modification time as a hash, because there may be millions of tiles.
fn identity(folder: &Path, info: &RasterInfo, tiles: &[([u32; 2], PathBuf)]) -> String {
    let mut hasher = DefaultHasher::new();
    for (tile, path) in tiles {
        let metadata = std::fs::metadata(path).ok();
        let changed = metadata.as_ref().and_then(|it| it.modified().ok());
        (tile, metadata.as_ref().map(std::fs::Metadata::len), changed).hash(&mut hasher);
    }
    format!("{}\n{} tiles, {:016x}", info.identity(folder), tiles.len(), hasher.finish())
}

/// Decodes a tile, which must be a colour picture.
fn decode(path: &Path, tile_px: u32) -> Result<Picture, SourceError> {
    let header = picture::header(path)?;
    if header.size != [tile_px; 2] {
        let [width, height] = header.size;
        return Err(inconsistent(
            path,
            format!("it has {width}×{height} pixels, but other tiles have {tile_px}×{tile_px}"),
        ));
    }
    let picture = picture::decode(path)?;
    if picture.channels < 3 || picture.channel_bytes != 1 {
        return Err(SourceError::NotHeights {
            path: path.into(),
            what: "a grey or 16-bit picture",
            holds: Holds::Heights,
        });
    }
    Ok(picture)
}

impl HeightReader for TileFolderReader {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        check_window(&self.folder, window, self.size)?;
        let mut heights_m = memory::window_room(&self.folder, window)?;
        heights_m.resize(window.samples(), f32::NAN);
        if heights_m.is_empty() {
            return Ok(heights_m);
        }
        let tile_px = self.tile_px;
        let tiles = |first: u32, count: u32| first / tile_px..(first + count).div_ceil(tile_px);
        for row in tiles(window.y, window.height) {
            for column in tiles(window.x, window.width) {
                let tile = [self.first[0] + column, self.first[1] + row];
                if !self.present.contains(&tile) {
                    continue;
                }
                let path = self.folder.join(format!("{}/{}/{}.png", self.zoom, tile[0] % self.columns, tile[1]));
                let picture = decode(&path, tile_px)?;
                let heights = self.packing.heights_m(&picture).collect::<Vec<_>>();
                // The part of the tile inside the window, in samples of the grid.
                let overlap = |tile: u32, first: u32, count: u32| {
                    (tile * tile_px).max(first)..((tile + 1) * tile_px).min(first + count)
                };
                let columns = overlap(column, window.x, window.width);
                for y in overlap(row, window.y, window.height) {
                    let from = ((y - row * tile_px) * tile_px + columns.start - column * tile_px) as usize;
                    let to = (y - window.y) as usize * window.width as usize + (columns.start - window.x) as usize;
                    heights_m[to..to + columns.len()].copy_from_slice(&heights[from..from + columns.len()]);
                }
            }
        }
        Ok(heights_m)
    }

    fn block(&self) -> [u32; 2] {
        [self.tile_px; 2]
    }

    fn known_m(&self, window: Window) -> Option<f32> {
        let tile = |axis: usize, at: u32| self.first[axis] + at / self.tile_px;
        let (right, bottom) = (window.x + window.width.max(1) - 1, window.y + window.height.max(1) - 1);
        let (columns, mut rows) = (tile(0, window.x)..=tile(0, right), tile(1, window.y)..=tile(1, bottom));
        // The loop goes over the existing tiles or over the tiles of the window, whichever are fewer.
        let places = u64::from(columns.end() - columns.start() + 1) * u64::from(rows.end() - rows.start() + 1);
        let is_present = match places < self.present.len() as u64 {
            true => rows.any(|y| columns.clone().any(|x| self.present.contains(&[x, y]))),
            false => self.present.iter().any(|[x, y]| columns.contains(x) && rows.contains(y)),
        };
        (!is_present).then_some(f32::NAN)
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_on_both_sides_of_the_antimeridian_are_neighbours() {
        let around = |columns: &[u32]| columns_around(columns.iter().copied(), 256);
        assert_eq!(around(&[255, 0]), (255, 2));
        assert_eq!(around(&[1, 254, 0, 254]), (254, 4));
        assert_eq!(around(&[130, 133]), (130, 4));
        assert_eq!(around(&[7]), (7, 1));
        assert_eq!(around(&(0..256).collect::<Vec<_>>()), (0, 256), "a whole earth stays as it is");
    }
}
