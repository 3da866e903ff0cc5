//! The interface of all sources of tiles: a baked pyramid, heights in memory, a local or remote COG, several DEMs as
//! one, computed land.
//!
//! A tile is requested in two steps, because they wait for different things: [`TileStore::fetch`] waits for a disk or a
//! network, and the function that it returns decodes and needs a processor. Each step has threads of its own
//! (`tiles::loader`).

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::pyramid::error::PyramidError;
use crate::pyramid::surface::levels::LevelSize;
use crate::pyramid::surface::loaded_tile::LoadedTile;
use crate::pyramid::surface::statistics::PatchStatistics;
use crate::pyramid::tile::TileAddress;
use crate::source::georeference::Georeference;

/// A flag that cancels a fetch.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// Cancels the fetch, which may then return [`PyramidError::Cancelled`].
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Returns whether the fetch has been cancelled.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The second step of a request: decodes the fetched bytes to a tile.
pub type Decode = Box<dyn FnOnce() -> Result<LoadedTile, PyramidError> + Send>;

/// A pyramid of tiles. All methods may be called from several threads at once; only [`TileStore::fetch`] may wait.
pub trait TileStore: Send + Sync {
    /// Returns the file name or URL, for messages.
    fn name(&self) -> String;

    /// Returns the sizes of the levels in samples, finest first, as by
    /// [`level_sizes`](crate::pyramid::surface::levels::level_sizes); the last is a single tile.
    fn levels(&self) -> &[LevelSize];

    /// Returns the georeference of level 0.
    fn georeference(&self) -> &Georeference;

    /// Returns the lowest and highest height in metres, or bounds of them.
    fn range_m(&self) -> [f32; 2];

    /// Returns whether the errors of tiles and patches were measured against the full resolution; otherwise they are
    /// estimates.
    fn is_measured(&self) -> bool;

    /// Returns the patches whose stride is larger than that of the coarsest level: element k has those of stride
    /// 2^(levels + k), row by row, in the number of
    /// [`patch_counts`](crate::pyramid::surface::statistics::patch_counts); the last has a single patch. Empty if the
    /// page of the coarsest tile already has a single patch.
    fn coarse_patches(&self) -> &[Vec<PatchStatistics>];

    /// Returns whether a tile exists. Where a pyramid is sparse, the coarser tile has all the detail.
    fn has_tile(&self, address: TileAddress) -> bool {
        self.levels()
            .get(address.level as usize)
            .is_some_and(|size| address.x < size.tiles_x() && address.y < size.tiles_y())
    }

    /// Returns whether tiles inside the extent of a level may be missing ([`TileStore::has_tile`]). A store that has all
    /// of them returns `false`, which saves a view the search for missing neighbours.
    fn is_sparse(&self) -> bool {
        true
    }

    /// Returns the number of threads that may fetch at a time: two keep a disk busy.
    fn parallel_fetches(&self) -> usize {
        2
    }

    /// Reads the bytes of a tile and returns the function that decodes them.
    ///
    /// # Errors
    /// If the tile does not exist or cannot be read; [`PyramidError::Cancelled`] after `cancel`.
    fn fetch(self: Arc<Self>, address: TileAddress, cancel: &Cancel) -> Result<Decode, PyramidError>;

    /// Fetches and decodes a tile.
    ///
    /// # Errors
    /// The errors of [`TileStore::fetch`].
    fn load(self: Arc<Self>, address: TileAddress) -> Result<LoadedTile, PyramidError> {
        self.fetch(address, &Cancel::default())?()
    }
}
