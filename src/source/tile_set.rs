//! Terrain-RGB tiles in the numbering of web maps as one grid, whatever stores them: a folder `z/x/y.png`
//! (`tile_folder`) or an archive (`pmtiles`). Missing tiles are no-data.
//!
//! Level z has 2^z × 2^z tiles; x counts from 180° west, y from the north, or in a Tile Map Service (TMS) from the south.
//! The CRS is Web Mercator (EPSG:3857).

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use super::colour_proof::{self, PlaceHints};
use super::georeference::Georeference;
use super::picture::Picture;
use super::place::{self, begin_window, inconsistent};
use super::reader::{HeightReader, Window};
use super::sidecar::RasterInfo;
use super::terrain_rgb::ColourEncoding;
use super::tile_seams::Seams;
use super::values::Holds;
use super::{SourceError, TileRows};

/// Half the width of the map in metres: π times the equatorial radius of WGS 84.
const HALF_MAP_M: f64 = 20_037_508.342_789_244;
/// Deepest zoom level: 2^22 tiles of 512 pixels are 2^31 pixels.
const MAX_ZOOM: u32 = 22;
/// Largest side of a tile in pixels.
const MAX_TILE_PX: u32 = 4096;
/// Number of tiles that are examined to find out the encoding of heights.
const SAMPLE_TILES: usize = 8;
/// Longitudes and latitudes around Japan, in degrees: west, south, east, north.
const JAPAN: [f64; 4] = [122.0, 20.0, 154.0, 46.0];

/// A store of tiles.
pub(super) trait TileStoreReader: Send + Sync {
    /// Returns the picture of a tile by its column and row, as the store counts them.
    fn picture(&self, tile: [u32; 2]) -> Result<Picture, SourceError>;

    /// Returns the name of a tile for messages.
    fn name(&self, tile: [u32; 2]) -> PathBuf;
}

/// The deepest level of a tile store.
pub(super) struct TileLevel {
    /// The deepest zoom level.
    pub zoom: u32,
    /// Column and row of the tiles of that level, as the store counts them.
    pub tiles: Vec<[u32; 2]>,
    pub store: Box<dyn TileStoreReader>,
    /// The direction of the rows, if the store or its description gives it.
    pub rows: Option<TileRows>,
    /// Text that changes whenever the heights change (see `HeightReader::identity`).
    pub identity: String,
}

/// The tiles of a level as one grid.
pub(super) struct TileSetReader {
    path: PathBuf,
    store: Box<dyn TileStoreReader>,
    tile_px: u32,
    /// Tile numbers of the westernmost column and the northernmost row, counted from the north.
    first: [u32; 2],
    /// The existing tiles, counted from the north; columns east of the antimeridian continue to count if `first` is west
    /// of it.
    present: HashSet<[u32; 2]>,
    /// Number of columns and rows of the level; column 0 follows the last one.
    count: u32,
    /// The direction in which the store counts rows.
    rows: TileRows,
    packing: ColourEncoding,
    size: [u32; 2],
    georeference: Georeference,
    identity: String,
}

impl TileSetReader {
    /// Opens the tiles of a store; `path` is their name in errors.
    ///
    /// # Errors
    /// Fails if tiles are damaged, lossy or of different sizes, and if their encoding is neither given nor proved.
    pub(super) fn open(path: &Path, info: &RasterInfo, found: TileLevel) -> Result<Self, SourceError> {
        let TileLevel { zoom, tiles, store, rows, identity } = found;
        let count = 1u32.checked_shl(zoom).filter(|_| zoom <= MAX_ZOOM);
        let count = count.ok_or_else(|| inconsistent(path, format!("its zoom level {zoom} is too deep")))?;
        if let Some(tile) = tiles.iter().find(|tile| tile.iter().any(|&number| number >= count)) {
            let name = store.name(*tile);
            return Err(inconsistent(&name, format!("level {zoom} only has {count}×{count} tiles")));
        }
        let Some(first_tile) = tiles.first() else { return Err(SourceError::NoMembers { path: path.into() }) };
        let first_picture = picture(&*store, *first_tile, None)?;
        let [tile_px, tile_rows] = first_picture.size;
        if tile_px != tile_rows || !(2..=MAX_TILE_PX).contains(&tile_px) {
            let name = store.name(*first_tile);
            return Err(inconsistent(&name, format!("a tile must be square, not {tile_px}×{tile_rows}")));
        }
        let step = (tiles.len() / SAMPLE_TILES).max(1);
        let sample_pictures =
            tiles.iter().step_by(step).take(SAMPLE_TILES).map(|tile| picture(&*store, *tile, Some(tile_px)));
        let sample_pictures = sample_pictures.collect::<Result<Vec<_>, _>>()?;

        let mut present: HashSet<[u32; 2]> = tiles.iter().copied().collect();
        let hints = place_hints(&tiles, info.tile_rows().or(rows), count, tile_px);
        let packing = colour_proof::packing(path, info, &sample_pictures, &hints)?;
        let heights = |tile| Ok(packing.heights_m(&picture(&*store, tile, Some(tile_px))?).collect::<Vec<_>>());
        let seams = Seams::measure(&tiles, &present, tile_px as usize, &heights)?;
        let rows = seams.decide(path, info.tile_rows(), rows);
        let (x, columns) = columns_around(tiles.iter().map(|[x, _]| *x), count);
        let from_north = |y: u32| if rows == TileRows::Tms { count - 1 - y } else { y };
        let unwrapped = |column: u32| if column < x { column + count } else { column };
        present = present.into_iter().map(|[x, y]| [unwrapped(x), from_north(y)]).collect();
        let numbers = || present.iter().map(|[_, y]| *y);
        let y = numbers().min().unwrap_or(0);
        let rows_of_tiles = numbers().max().unwrap_or(0) - y + 1;
        let samples_of_tiles = |tiles: u32| {
            tiles.checked_mul(tile_px).ok_or_else(|| inconsistent(path, "its tiles span too wide an area"))
        };
        let size = [samples_of_tiles(columns)?, samples_of_tiles(rows_of_tiles)?];
        let pixel_m = 2.0 * HALF_MAP_M / (f64::from(count) * f64::from(tile_px));
        let centre = |tile: u32| (f64::from(tile) * f64::from(tile_px) + 0.5) * pixel_m - HALF_MAP_M;
        let crs_from_grid = place::north_up([centre(x), -centre(y)], [pixel_m; 2]);
        let georeference = place::locate(path, crs_from_grid, place::epsg(3857, false), size)?;
        // The descriptions of the tiles may say something else the next time.
        let identity = format!("{}\n{identity}, rows {}, {packing:?}", info.identity(path), rows.name());
        Ok(Self {
            path: path.into(),
            store,
            tile_px,
            first: [x, y],
            present,
            count,
            rows,
            packing,
            size,
            georeference,
            identity,
        })
    }

    /// Returns the heights of an existing tile, counted from the north.
    fn tile_m(&self, [x, y]: [u32; 2]) -> Result<Vec<f32>, SourceError> {
        let y = if self.rows == TileRows::Tms { self.count - 1 - y } else { y };
        let picture = picture(&*self.store, [x % self.count, y], Some(self.tile_px))?;
        Ok(self.packing.heights_m(&picture).collect())
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

/// Returns where the tiles are and how far apart their samples are on the ground.
fn place_hints(tiles: &[[u32; 2]], rows: Option<TileRows>, count: u32, tile_px: u32) -> PlaceHints {
    let [x, y] = tiles.get(tiles.len() / 2).copied().unwrap_or_default().map(|number| f64::from(number) + 0.5);
    let count = f64::from(count);
    let place = |y: f64| {
        let latitude = (std::f64::consts::PI * (1.0 - 2.0 * y / count)).sinh().atan();
        let (longitude_deg, latitude_deg) = (x / count * 360.0 - 180.0, latitude.to_degrees());
        let [west, south, east, north] = JAPAN;
        ((west..east).contains(&longitude_deg) && (south..north).contains(&latitude_deg), latitude.cos())
    };
    let (from_north, from_south) = (place(y), place(count - y));
    let (in_japan, scale) = if rows == Some(TileRows::Tms) { from_south } else { from_north };
    let in_japan = in_japan || (rows.is_none() && from_south.0);
    let spacing_m = 2.0 * HALF_MAP_M / (count * f64::from(tile_px)) * scale;
    PlaceHints { spacing_m: Some(spacing_m), in_japan: Some(in_japan) }
}

/// Decodes a tile, which must be a colour picture of the size of the others.
fn picture(store: &dyn TileStoreReader, tile: [u32; 2], tile_px: Option<u32>) -> Result<Picture, SourceError> {
    let picture = store.picture(tile)?;
    let path = store.name(tile);
    if let Some(tile_px) = tile_px.filter(|tile_px| picture.size != [*tile_px; 2]) {
        let [width, height] = picture.size;
        let what = format!("it has {width}×{height} pixels, but other tiles have {tile_px}×{tile_px}");
        return Err(inconsistent(&path, what));
    }
    if picture.channels < 3 || picture.channel_bytes != 1 {
        return Err(SourceError::NotHeights { path, what: "a grey or 16-bit picture", holds: Holds::Heights });
    }
    Ok(picture)
}

impl HeightReader for TileSetReader {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        let mut heights_m = begin_window(&self.path, window, self.size)?;
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
                let heights = self.tile_m(tile)?;
                let whole = Window { x: column * tile_px, y: row * tile_px, width: tile_px, height: tile_px };
                // The part of the tile inside the window.
                let (x, y) = (whole.x.max(window.x), whole.y.max(window.y));
                let width = (whole.x + tile_px).min(window.x + window.width) - x;
                let part = Window { x, y, width, height: (whole.y + tile_px).min(window.y + window.height) - y };
                for (from, to) in part.rows_in(whole).zip(part.rows_in(window)) {
                    heights_m[to].copy_from_slice(&heights[from]);
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
