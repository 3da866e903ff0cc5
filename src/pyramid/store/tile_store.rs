//! Where tiles come from: a baked pyramid, a COG on this machine or another, several DEMs as one, a formula.
//!
//! A store is asked for a tile in two steps, because they wait for different things: [`TileStore::fetch`] waits for a
//! disk or a network, what it returns decodes and needs a processor. Each has threads of its own (`tiles::loader`).

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::pyramid::error::PyramidError;
use crate::pyramid::surface::levels::LevelSize;
use crate::pyramid::surface::loaded_tile::LoadedTile;
use crate::pyramid::surface::statistics::PatchStatistics;
use crate::pyramid::tile::TileAddress;
use crate::source::georeference::Georeference;

/// Tells a fetch that nobody wants its tile any more.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// From now on the fetch may give up with [`PyramidError::Cancelled`].
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether the fetch may give up.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The second step: from what was fetched to a tile.
pub type Decode = Box<dyn FnOnce() -> Result<LoadedTile, PyramidError> + Send>;

/// A pyramid of tiles. All methods may be called from several threads at once; only [`TileStore::fetch`] may wait.
pub trait TileStore: Send + Sync {
    /// The file or address, for messages.
    fn name(&self) -> String;

    /// The sizes of the levels in samples, finest first, as
    /// [`level_sizes`](crate::pyramid::surface::levels::level_sizes) gives them; the last is a single tile.
    fn levels(&self) -> &[LevelSize];

    /// Where level 0 lies.
    fn georeference(&self) -> &Georeference;

    /// Lowest and highest height in metres, or bounds of them.
    fn range_m(&self) -> [f32; 2];

    /// Whether the errors of tiles and patches were measured against the full resolution; otherwise they are estimates.
    fn is_measured(&self) -> bool;

    /// The patches whose stride is larger than that of the coarsest level: element k has those of stride
    /// 2^(levels + k), row by row, as many as [`patch_counts`](crate::pyramid::surface::statistics::patch_counts) says;
    /// the last has a single patch. Empty if the page of the coarsest tile has a single patch already.
    fn coarse_patches(&self) -> &[Vec<PatchStatistics>];

    /// Whether there is such a tile. Where a pyramid is sparse, the coarser tile holds all that is known.
    fn has_tile(&self, address: TileAddress) -> bool {
        self.levels()
            .get(address.level as usize)
            .is_some_and(|size| address.x < size.tiles_x() && address.y < size.tiles_y())
    }

    /// How many threads may fetch at a time: a disk is kept busy by two.
    fn parallel_fetches(&self) -> usize {
        2
    }

    /// Reads what a tile is made of; what is returned makes it.
    ///
    /// # Errors
    /// If there is no such tile, or it cannot be read; [`PyramidError::Cancelled`] after `cancel`.
    fn fetch(self: Arc<Self>, address: TileAddress, cancel: &Cancel) -> Result<Decode, PyramidError>;

    /// Both steps.
    ///
    /// # Errors
    /// As [`TileStore::fetch`].
    fn load(self: Arc<Self>, address: TileAddress) -> Result<LoadedTile, PyramidError> {
        self.fetch(address, &Cancel::default())?()
    }
}
