//! Where a store of tiles has heights: many rasters are mostly no-data, such as clips and strips of LiDAR.
//!
//! The statistics of a tile include all finer ones, so an empty tile is not read any further. Stores without measured
//! statistics (COGs of other programs, mosaics) estimate them from each tile, and may miss areas smaller than a coarse
//! sample.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::tile_store::TileStore;
use crate::pyramid::error::PyramidError;
use crate::pyramid::surface::levels::{LevelSize, coordinate};
use crate::pyramid::surface::loaded_tile::LoadedTile;
use crate::pyramid::surface::statistics::PAGE_PATCHES;
use crate::pyramid::tile::{PATCH_QUADS, TILE_BORDER, TILE_SAMPLES, TILE_STRIDE, TileAddress, is_void};

/// Number of cells from which on the area of the data is known well enough for a camera.
const ENOUGH_CELLS: usize = 400;
/// Largest number of tiles of a level that are read for it.
const MAX_TILES: usize = 48;

/// A part of the finest level that has heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct DataCell {
    /// First column and row that have heights, in samples of the finest level; fractions come from coarser levels.
    pub low: [f64; 2],
    /// Last column and row.
    pub high: [f64; 2],
    /// Lowest and highest height in metres.
    pub range_m: [f32; 2],
}

/// The cells of a store that have heights.
#[derive(Clone, Debug, Default)]
pub(crate) struct DataArea {
    pub cells: Vec<DataCell>,
    /// Whether the whole grid has heights, according to the tiles that were read.
    pub is_whole: bool,
}

impl DataArea {
    /// Finds the cells from a few tiles. The coarsest tile suffices if all of it has heights.
    ///
    /// # Errors
    /// Fails if a tile cannot be read.
    pub(crate) fn of(store: &Arc<dyn TileStore>) -> Result<Self, PyramidError> {
        let levels = store.levels().to_vec();
        let mut level = levels.len() as u32 - 1;
        let mut tiles = vec![TileAddress { level, x: 0, y: 0 }];
        loop {
            let mut cells = Vec::new();
            let mut is_whole = true;
            for &address in &tiles {
                let loaded = Arc::clone(store).load(address)?;
                is_whole &= cells_of(&levels, address, &loaded, &mut cells);
            }
            if is_whole || level == 0 || cells.len() >= ENOUGH_CELLS {
                return Ok(Self { cells, is_whole });
            }
            let finer = finer_tiles(&levels, level - 1, &cells);
            if finer.len() > MAX_TILES || !finer.iter().all(|address| store.has_tile(*address)) {
                return Ok(Self { cells, is_whole });
            }
            level -= 1;
            tiles = finer.into_iter().collect();
        }
    }

    /// Returns the first column and row with a height, and the last.
    pub(crate) fn bounds(&self) -> Option<[[f64; 2]; 2]> {
        let low = |axis: usize| self.cells.iter().map(|cell| cell.low[axis]).reduce(f64::min);
        let high = |axis: usize| self.cells.iter().map(|cell| cell.high[axis]).reduce(f64::max);
        Some([[low(0)?, low(1)?], [high(0)?, high(1)?]])
    }
}

/// Returns the tiles of a level that cells are in.
fn finer_tiles(levels: &[LevelSize], level: u32, cells: &[DataCell]) -> BTreeSet<TileAddress> {
    let (finest, size) = (levels[0], levels[level as usize]);
    let tile =
        |c: f64, from: u32, to: u32| (coordinate(c, from, to).round().max(0.0) as u32).min(to - 1) / TILE_SAMPLES;
    let mut tiles = BTreeSet::new();
    for cell in cells {
        let span = |axis: usize, from: u32, to: u32| tile(cell.low[axis], from, to)..=tile(cell.high[axis], from, to);
        for y in span(1, finest.height, size.height) {
            tiles.extend(span(0, finest.width, size.width).map(|x| TileAddress { level, x, y }));
        }
    }
    tiles
}

/// Appends the patches of a tile that have heights. Returns whether all of the tile has.
fn cells_of(levels: &[LevelSize], address: TileAddress, loaded: &LoadedTile, cells: &mut Vec<DataCell>) -> bool {
    let (finest, size) = (levels[0], levels[address.level as usize]);
    let own = size.tile_region(address.x, address.y, 0);
    let mut is_whole = true;
    for (number, patch) in (0..).zip(loaded.patches.patches()) {
        let [column, row] = [number % PAGE_PATCHES, number / PAGE_PATCHES].map(|at| at * PATCH_QUADS);
        if column >= own.width || row >= own.height {
            continue;
        }
        let columns = column..(column + PATCH_QUADS).min(own.width);
        let rows = row..(row + PATCH_QUADS).min(own.height);
        let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
        let mut range_m = [f32::NAN; 2];
        for (y, x) in rows.clone().flat_map(|y| columns.clone().map(move |x| (y, x))) {
            let sample = loaded.tile.samples[((y + TILE_BORDER) * TILE_STRIDE + x + TILE_BORDER) as usize];
            if is_void(sample) {
                is_whole = false;
                continue;
            }
            (low, high) = ([low[0].min(x), low[1].min(y)], [high[0].max(x), high[1].max(y)]);
            range_m = [range_m[0].min(sample), range_m[1].max(sample)];
        }
        if low[0] > high[0] {
            if patch.min_m.is_nan() {
                continue;
            }
            // The data are narrower than the samples of this level.
            (low, high) = ([column, row], [columns.end - 1, rows.end - 1]);
            range_m = [patch.min_m, patch.max_m];
        }
        let fine = |x: u32, y: u32| {
            let at = |c: u32, first: u32, from: u32, to: u32| coordinate(f64::from(first + c), from, to);
            [at(x, own.x, size.width, finest.width), at(y, own.y, size.height, finest.height)]
        };
        cells.push(DataCell { low: fine(low[0], low[1]), high: fine(high[0], high[1]), range_m });
    }
    is_whole
}

/// Returns the columns and rows of the finest level that have heights: the first and the last, both inclusive; `None`
/// if no sample has one. It is exact for stores with measured statistics.
///
/// # Errors
/// Fails if a tile cannot be read.
pub(crate) fn data_bounds(store: &Arc<dyn TileStore>) -> Result<Option<[[u32; 2]; 2]>, PyramidError> {
    let levels = store.levels().to_vec();
    let finest = levels[0];
    let mut bounds: Option<[[u32; 2]; 2]> = None;
    let mut waiting = vec![TileAddress { level: levels.len() as u32 - 1, x: 0, y: 0 }];
    while let Some(address) = waiting.pop() {
        let size = levels[address.level as usize];
        let own = size.tile_region(address.x, address.y, 0);
        let fine = |c: u32, from: u32, to: u32| {
            let first = (f64::from(c) * f64::from(to) / f64::from(from)).floor() as u32;
            let end = (f64::from(c + 1) * f64::from(to) / f64::from(from)).ceil() as u32;
            [first, end.clamp(first + 1, to.max(first + 1)) - 1]
        };
        let span = |first: [u32; 2], last: [u32; 2]| {
            [
                [fine(first[0], size.width, finest.width)[0], fine(first[1], size.height, finest.height)[0]],
                [fine(last[0], size.width, finest.width)[1], fine(last[1], size.height, finest.height)[1]],
            ]
        };
        let area = span([own.x, own.y], [own.x + own.width - 1, own.y + own.height - 1]);
        let is_inside = |[low, high]: [[u32; 2]; 2]| (0..2).all(|i| low[i] <= area[0][i] && high[i] >= area[1][i]);
        if bounds.is_some_and(is_inside) {
            continue;
        }
        let loaded = Arc::clone(store).load(address)?;
        if loaded.statistics.min_m.is_nan() {
            continue;
        }
        if address.level > 0 {
            let level = address.level - 1;
            let tile =
                |c: u32, from: u32, to: u32| (u64::from(c) * u64::from(to) / u64::from(from)) as u32 / TILE_SAMPLES;
            let finer = levels[level as usize];
            let [low, high] = area;
            let (left, right) = (tile(low[0], finest.width, finer.width), tile(high[0], finest.width, finer.width));
            let (top, bottom) = (tile(low[1], finest.height, finer.height), tile(high[1], finest.height, finer.height));
            let tiles: Vec<_> =
                (top..=bottom).flat_map(|y| (left..=right).map(move |x| TileAddress { level, x, y })).collect();
            if tiles.iter().all(|address| store.has_tile(*address)) {
                waiting.extend(tiles);
                continue;
            }
        }
        let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
        for (y, x) in (0..own.height).flat_map(|y| (0..own.width).map(move |x| (y, x))) {
            if !is_void(loaded.tile.samples[((y + TILE_BORDER) * TILE_STRIDE + x + TILE_BORDER) as usize]) {
                low = [low[0].min(own.x + x), low[1].min(own.y + y)];
                high = [high[0].max(own.x + x), high[1].max(own.y + y)];
            }
        }
        if low[0] <= high[0] {
            let [low, high] = span(low, high);
            let [first, last] = bounds.unwrap_or([low, high]);
            bounds = Some([[0, 1].map(|i| first[i].min(low[i])), [0, 1].map(|i| last[i].max(high[i]))]);
        }
    }
    Ok(bounds)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pyramid::store::MemoryStore;
    use crate::source::georeference::Georeference;
    use crate::source::{HeightGrid, Silent};

    fn store([width, height]: [u32; 2], is_land: impl Fn(u32, u32) -> bool) -> Arc<dyn TileStore> {
        let height_m = |i: u32| {
            let (x, y) = (i % width, i / width);
            if is_land(x, y) { 300.0 + x as f32 } else { f32::NAN }
        };
        let heights_m = (0..width * height).map(height_m).collect();
        let georeference = Georeference::local(width, height, 10.0);
        Arc::new(MemoryStore::new(HeightGrid { width, height, heights_m, georeference }, "grid", &Silent).unwrap())
    }

    #[test]
    fn bounds_are_exact() {
        let size = [1100, 900];
        // A corner, a line of single samples that no coarse sample shows, two far points, and everything.
        let corner = store(size, |x, y| (3..40).contains(&x) && (700..811).contains(&y));
        assert_eq!(data_bounds(&corner).unwrap(), Some([[3, 700], [39, 810]]));
        let line = store(size, |x, y| x == y + 100 && y > 20);
        assert_eq!(data_bounds(&line).unwrap(), Some([[121, 21], [999, 899]]));
        let points = store(size, |x, y| [(7, 500), (1050, 8)].contains(&(x, y)));
        assert_eq!(data_bounds(&points).unwrap(), Some([[7, 8], [1050, 500]]));
        assert_eq!(data_bounds(&store(size, |_, _| true)).unwrap(), Some([[0, 0], [1099, 899]]));
    }

    #[test]
    fn cells_cover_the_data_and_little_else() {
        let size = [1100, 900];
        let line = DataArea::of(&store(size, |x, y| x == y + 100)).unwrap();
        assert!(!line.is_whole && line.cells.len() > 50, "{}", line.cells.len());
        for [x, y] in line.cells.iter().map(|cell| [0, 1].map(|i| 0.5 * (cell.low[i] + cell.high[i]))) {
            assert!((x - y - 100.0).abs() < 40.0, "a cell at {x}, {y}");
        }
        let [low, high] = line.bounds().unwrap();
        assert!((low[0] - 100.0).abs() < 40.0 && (high[1] - 899.0).abs() < 40.0, "{low:?} {high:?}");
        let whole = DataArea::of(&store(size, |_, _| true)).unwrap();
        assert!(whole.is_whole);
    }
}
