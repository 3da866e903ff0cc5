//! Where tiles come from: a baked pyramid, a COG on this machine or another, several DEMs as one, a formula.
//!
//! A store is asked for a tile in two steps, because they wait for different things: [`TileStore::fetch`] waits for a
//! disk or a network, what it returns decodes and needs a processor. Each has threads of its own (`tiles::loader`).

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::levels::LevelSize;
use super::lows::Lows;
use super::statistics::{PatchStatistics, TileStatistics, Voids};
use super::{PyramidError, Tile, TileAddress};
use crate::source::georeference::Georeference;

/// Patches along the side of a page.
pub const PAGE_PATCHES: u32 = super::TILE_SAMPLES / super::PATCH_QUADS;

/// Tells a fetch that nobody wants its tile any more.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// From now on the fetch may give up with [`PyramidError::Cancelled`].
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether it may.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// The mesh patches that come with a tile of level L: the 16 × 16 patches of stride 2^L whose columns and rows begin
/// at 16 times the tile's.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchPage {
    patches: Box<[PatchStatistics]>,
}

impl PatchPage {
    /// From 256 patches, row by row; those beyond the grid are [`PatchPage::NOTHING`].
    ///
    /// # Panics
    /// If they are not 256.
    pub fn new(patches: Vec<PatchStatistics>) -> Self {
        assert_eq!(patches.len(), (PAGE_PATCHES * PAGE_PATCHES) as usize);
        Self { patches: patches.into() }
    }

    /// A patch beyond the grid.
    pub const NOTHING: PatchStatistics =
        PatchStatistics { min_m: f32::NAN, max_m: f32::NAN, mesh_error_m: 0.0, voids: Voids::All };

    /// The patch in column `x` and row `y` of the page.
    pub fn get(&self, x: u32, y: u32) -> &PatchStatistics {
        &self.patches[(y * PAGE_PATCHES + x) as usize]
    }

    /// All, row by row.
    pub fn patches(&self) -> &[PatchStatistics] {
        &self.patches
    }

    /// For changes.
    pub fn patches_mut(&mut self) -> &mut [PatchStatistics] {
        &mut self.patches
    }
}

/// A tile with all that is known of it.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedTile {
    /// The heights.
    pub tile: Tile,
    /// Of the tile.
    pub statistics: TileStatistics,
    /// Of the patches that come with it.
    pub patches: PatchPage,
    /// How low it can be.
    pub lows: Arc<Lows>,
}

impl LoadedTile {
    /// From the heights and their statistics.
    pub fn new(tile: Tile, statistics: TileStatistics, patches: PatchPage) -> Self {
        let lows = Arc::new(Lows::of(&tile, &statistics));
        Self { tile, statistics, patches, lows }
    }
}

/// The second step: from what was fetched to a tile.
pub type Decode = Box<dyn FnOnce() -> Result<LoadedTile, PyramidError> + Send>;

/// A pyramid of tiles. All methods may be called from several threads at once; only [`TileStore::fetch`] may wait.
pub trait TileStore: Send + Sync {
    /// The file or address, for messages.
    fn name(&self) -> String;

    /// The sizes of the levels in samples, finest first; the last is a single tile ([`super::levels::level_sizes`]).
    fn levels(&self) -> &[LevelSize];

    /// Where level 0 lies.
    fn georeference(&self) -> &Georeference;

    /// Lowest and highest height in metres, or bounds of them.
    fn range_m(&self) -> [f32; 2];

    /// Whether the errors of tiles and patches were measured against the full resolution; otherwise they are estimates.
    fn is_measured(&self) -> bool;

    /// The patches whose stride is larger than that of the coarsest level: element k has those of stride
    /// 2^(levels + k), row by row ([`super::statistics::patch_counts`]); the last has a single patch. Empty if the
    /// page of the coarsest tile has a single patch already.
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
