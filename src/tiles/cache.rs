//! Decoded tiles in memory, up to a cap: on their way to the GPU, for when they are wanted again, and for questions
//! about the ground.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use crate::pyramid::tile::TILE_STRIDE;
use crate::pyramid::{LoadedTile, TileAddress};

/// Bytes of a decoded tile: heights, what is known of its 256 patches, and how low its blocks are.
pub const TILE_BYTES: u64 = TILE_STRIDE as u64 * TILE_STRIDE as u64 * 4 + 256 * 16 + 64 * 64 * 4 + 256;

/// Decoded tiles, up to a number of bytes.
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

    /// A tile that is in memory; looking does not keep it there.
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

    /// Bytes that the tiles take now.
    pub fn bytes(&self) -> u64 {
        self.tiles.len() as u64 * TILE_BYTES
    }

    /// How many tiles are in memory now.
    pub fn len(&self) -> usize {
        self.tiles.len()
    }

    /// Whether no tile is in memory.
    pub fn is_empty(&self) -> bool {
        self.tiles.is_empty()
    }

    /// How many tiles fit.
    pub fn most(&self) -> usize {
        self.most
    }
}
