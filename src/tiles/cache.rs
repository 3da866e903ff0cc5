//! Decoded tiles in memory, up to a cap: on their way to the GPU, for when they are wanted again, and for questions
//! about the ground.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use crate::pyramid::{LoadedTile, TILE_STRIDE, TileAddress};

/// Bytes of a decoded tile: heights, what is known of its 256 patches, and how low its blocks are.
pub const TILE_BYTES: u64 = TILE_STRIDE as u64 * TILE_STRIDE as u64 * 4 + 256 * 16 + 64 * 64 * 4 + 256;

/// The tiles.
pub struct TileCache {
    most: usize,
    tiles: FxHashMap<TileAddress, Entry>,
}

struct Entry {
    tile: Arc<LoadedTile>,
    last_used: u64,
}

impl TileCache {
    /// As many tiles as fit in `memory_bytes`, and at least one.
    pub fn new(memory_bytes: u64) -> Self {
        Self { most: (memory_bytes / TILE_BYTES).max(1) as usize, tiles: FxHashMap::default() }
    }

    /// A tile that is there; it counts as used in frame `frame`.
    pub fn get(&mut self, address: TileAddress, frame: u64) -> Option<&Arc<LoadedTile>> {
        let entry = self.tiles.get_mut(&address)?;
        entry.last_used = entry.last_used.max(frame);
        Some(&entry.tile)
    }

    /// A tile that is there.
    pub fn peek(&self, address: TileAddress) -> Option<&Arc<LoadedTile>> {
        self.tiles.get(&address).map(|entry| &entry.tile)
    }

    /// Keeps a tile; those that were not used for longest make room.
    pub fn insert(&mut self, address: TileAddress, tile: Arc<LoadedTile>, frame: u64) {
        self.tiles.insert(address, Entry { tile, last_used: frame });
        if self.tiles.len() > self.most {
            // A tenth at a time: one search for many tiles.
            let mut ages: Vec<_> = self.tiles.iter().map(|(address, entry)| (entry.last_used, *address)).collect();
            let away = (self.tiles.len() - self.most + self.most / 10).min(self.tiles.len() - 1);
            ages.select_nth_unstable(away);
            ages[..away].iter().for_each(|(_, address)| {
                self.tiles.remove(address);
            });
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        self.tiles.len() as u64 * TILE_BYTES
    }

    /// Tiles held.
    pub fn len(&self) -> usize {
        self.tiles.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.tiles.is_empty()
    }

    /// How many fit.
    pub fn most(&self) -> usize {
        self.most
    }
}
