//! A bounded cache of decoded tiles in memory, for uploads to the GPU, for repeated requests, and for queries of ground
//! heights.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use crate::pyramid::tile::TILE_STRIDE;
use crate::pyramid::{LoadedTile, TileAddress};

/// Bytes of a decoded tile: heights, statistics of its 256 patches, and occluder minima of its blocks.
pub(crate) const TILE_BYTES: u64 = TILE_STRIDE as u64 * TILE_STRIDE as u64 * 4 + 256 * 16 + 64 * 64 * 4 + 256;

/// The smallest number of tiles in a cache: tiles under the camera, one per level, must never evict each other.
pub(crate) const LEAST: usize = 16;

/// Decoded tiles, up to a number of bytes.
pub(crate) struct TileCache {
    most: usize,
    tiles: FxHashMap<TileAddress, Entry>,
    /// The number of the current pass: tiles used in an earlier one are evicted before those used in this one. Frames
    /// are too coarse a measure, because a frame for a file makes many passes.
    pass: u64,
}

struct Entry {
    tile: Arc<LoadedTile>,
    last_used: u64,
}

impl TileCache {
    /// Creates a cache of as many tiles as fit in `memory_bytes`, but at least [`LEAST`].
    pub(crate) fn new(memory_bytes: u64) -> Self {
        let most = ((memory_bytes / TILE_BYTES) as usize).max(LEAST);
        Self { most, tiles: FxHashMap::default(), pass: 0 }
    }

    /// Begins a new pass.
    pub(crate) fn begin_pass(&mut self) {
        self.pass += 1;
    }

    /// Returns a cached tile, and marks it as used in this pass.
    pub(crate) fn get(&mut self, address: TileAddress) -> Option<&Arc<LoadedTile>> {
        let entry = self.tiles.get_mut(&address)?;
        entry.last_used = self.pass;
        Some(&entry.tile)
    }

    /// Returns a cached tile, without marking it as used.
    pub(crate) fn peek(&self, address: TileAddress) -> Option<&Arc<LoadedTile>> {
        self.tiles.get(&address).map(|entry| &entry.tile)
    }

    /// Adds a tile; the least recently used ones are removed if the cache is full.
    pub(crate) fn insert(&mut self, address: TileAddress, tile: Arc<LoadedTile>) {
        self.tiles.insert(address, Entry { tile, last_used: self.pass });
        if self.tiles.len() > self.most {
            // A tenth at a time, so that one search serves many tiles.
            let mut ages: Vec<_> = self.tiles.iter().map(|(address, entry)| (entry.last_used, *address)).collect();
            let away = (self.tiles.len() - self.most + self.most / 10).min(self.tiles.len() - 1);
            ages.select_nth_unstable(away);
            ages[..away].iter().for_each(|(_, address)| {
                self.tiles.remove(address);
            });
        }
    }

    /// Returns the memory of the tiles in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        self.tiles.len() as u64 * TILE_BYTES
    }
}
