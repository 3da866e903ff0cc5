//! The height of the ground at a place, from the finest tile that there is.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::bicubic;
use super::fill::is_void;
use super::levels::{LevelSize, coordinate};
use super::{LoadedTile, PyramidError, TILE_BORDER, TILE_SAMPLES, TILE_STRIDE, Tile, TileAddress, TileStore};

/// Tiles kept for the next question.
const TILES: usize = 32;
/// After a failure nothing is read for so long: a thousand questions must not wait a thousand times.
const REST: Duration = Duration::from_secs(30);

/// The tile of level `level` whose cell holds a place in grid coordinates of level 0; none outside the outermost
/// samples.
pub fn tile_at(levels: &[LevelSize], level: u32, column: f64, row: f64) -> Option<TileAddress> {
    let (finest, size) = (levels[0], levels[level as usize]);
    let inside = |c: f64, count: u32| (0.0..=f64::from(count - 1)).contains(&c);
    if !inside(column, finest.width) || !inside(row, finest.height) {
        return None;
    }
    let (x, _) = bicubic::cell(coordinate(column, finest.width, size.width), size.width);
    let (y, _) = bicubic::cell(coordinate(row, finest.height, size.height), size.height);
    Some(TileAddress { level, x: x / TILE_SAMPLES, y: y / TILE_SAMPLES })
}

/// The height in metres of a tile's bicubic surface at a place in grid coordinates of level 0; none in cells with a
/// void corner. The place lies in the tile ([`tile_at`]).
pub fn height_in_tile(levels: &[LevelSize], address: TileAddress, tile: &Tile, column: f64, row: f64) -> Option<f64> {
    let (finest, size) = (levels[0], levels[address.level as usize]);
    let (cell_x, fx) = bicubic::cell(coordinate(column, finest.width, size.width), size.width);
    let (cell_y, fy) = bicubic::cell(coordinate(row, finest.height, size.height), size.height);
    // The tile's rows begin TILE_BORDER samples early and the four samples one early.
    let (left, top) = (cell_x % TILE_SAMPLES + TILE_BORDER - 1, cell_y % TILE_SAMPLES + TILE_BORDER - 1);
    let samples: [[f32; 4]; 4] = std::array::from_fn(|k| {
        let start = ((top + k as u32) * TILE_STRIDE + left) as usize;
        std::array::from_fn(|i| tile.samples[start + i])
    });
    let void = samples[1..3].iter().any(|row| row[1..3].iter().any(|&sample| is_void(sample)));
    (!void).then(|| bicubic::height_and_gradient(&samples, fx, fy).0)
}

/// Heights of the ground, read as they are asked for.
pub struct Ground {
    store: Arc<dyn TileStore>,
    /// Most recently used first.
    tiles: Mutex<VecDeque<(TileAddress, Arc<LoadedTile>)>>,
    failed: Mutex<Option<(Instant, Arc<PyramidError>)>>,
}

impl Ground {
    /// Of a pyramid.
    pub fn new(store: Arc<dyn TileStore>) -> Self {
        Self { store, tiles: Mutex::default(), failed: Mutex::default() }
    }

    /// The height in metres of the finest surface at a place in grid coordinates (sample centres are whole numbers);
    /// none outside the outermost samples, in cells with a void corner, and where the tile cannot be read. It may read
    /// a tile, and wait for it.
    pub fn height_m(&self, column: f64, row: f64) -> Option<f64> {
        let levels = self.store.levels();
        let address = (0..levels.len() as u32)
            .map(|level| tile_at(levels, level, column, row))
            .find(|address| address.is_none_or(|address| self.store.has_tile(address)))??;
        let tile = self.tile(address)?;
        height_in_tile(levels, address, &tile.tile, column, row)
    }

    /// Why the last tile that could not be read could not: heights have been answered with none since.
    pub fn failure(&self) -> Option<Arc<PyramidError>> {
        let failed = self.failed.lock().unwrap_or_else(PoisonError::into_inner);
        failed.as_ref().map(|(_, error)| Arc::clone(error))
    }

    fn tile(&self, address: TileAddress) -> Option<Arc<LoadedTile>> {
        // A poisoned lock guards only a cache, which is whole between statements.
        let mut tiles = self.tiles.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = tiles.iter().position(|(kept, _)| *kept == address) {
            if let Some(found) = tiles.remove(at) {
                tiles.push_front(found);
            }
            return tiles.front().map(|(_, tile)| tile.clone());
        }
        drop(tiles);
        let failed = || self.failed.lock().unwrap_or_else(PoisonError::into_inner);
        if failed().as_ref().is_some_and(|(at, _)| at.elapsed() < REST) {
            return None;
        }
        let tile = match Arc::clone(&self.store).load(address) {
            Ok(tile) => Arc::new(tile),
            Err(error) => {
                tracing::debug!("{error}");
                *failed() = Some((Instant::now(), Arc::new(error)));
                return None;
            }
        };
        let mut tiles = self.tiles.lock().unwrap_or_else(PoisonError::into_inner);
        tiles.push_front((address, tile.clone()));
        tiles.truncate(TILES);
        Some(tile)
    }
}
