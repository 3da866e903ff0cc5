//! Ground height at a place, from the finest existing tile.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::tile_store::TileStore;
use crate::pyramid::error::PyramidError;
use crate::pyramid::surface::loaded_tile::LoadedTile;
use crate::pyramid::surface::tile_height::{height_in_tile, tile_at};
use crate::pyramid::tile::TileAddress;

/// Number of recently used tiles that are cached.
const TILES: usize = 32;
/// Pause after a failed read, so that a thousand queries do not wait a thousand times.
const REST: Duration = Duration::from_secs(30);

/// Ground heights, read on demand.
pub(crate) struct Ground {
    store: Arc<dyn TileStore>,
    /// Cached tiles, most recently used first.
    tiles: Mutex<VecDeque<(TileAddress, Arc<LoadedTile>)>>,
    failed: Mutex<Option<(Instant, Arc<PyramidError>)>>,
}

impl Ground {
    /// Creates a source that has read nothing yet.
    pub(crate) fn new(store: Arc<dyn TileStore>) -> Self {
        Self { store, tiles: Mutex::default(), failed: Mutex::default() }
    }

    /// Returns the height in metres of the finest surface at a place in grid coordinates (sample centres are whole
    /// numbers). Returns `None` outside the outermost samples, in cells with a no-data corner, and where the tile
    /// cannot be read. The call may read a tile, and wait for it.
    pub(crate) fn height_m(&self, column: f64, row: f64) -> Option<f64> {
        let levels = self.store.levels();
        let address = (0..levels.len() as u32)
            .map(|level| tile_at(levels, level, column, row))
            .find(|address| address.is_none_or(|address| self.store.has_tile(address)))??;
        let tile = self.tile(address)?;
        height_in_tile(levels, address, &tile.tile, column, row)
    }

    /// Returns the error of the last read that failed, if any. For a while after it, heights were `None`.
    pub(crate) fn failure(&self) -> Option<Arc<PyramidError>> {
        let failed = self.failed.lock().unwrap_or_else(PoisonError::into_inner);
        failed.as_ref().map(|(_, error)| Arc::clone(error))
    }

    fn tile(&self, address: TileAddress) -> Option<Arc<LoadedTile>> {
        // The lock guards only a cache, which is consistent between statements, so poisoning is harmless.
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
