//! The blocks of a file that are in memory, and claims on those that are being fetched.

use std::ops::Range;
use std::sync::{Arc, Weak};

use rustc_hash::{FxHashMap, FxHashSet};

/// Bytes of a block; the last block of a file is shorter.
pub const BLOCK_BYTES: u64 = 64 * 1024;

/// A block of a file.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Block {
    /// Its first byte is at this times [`BLOCK_BYTES`].
    pub index: u64,
    pub bytes: Vec<u8>,
}

struct Slot {
    /// A caller may hold a block longer than the cache retains it.
    block: Weak<Block>,
    kept: Option<Arc<Block>>,
    used: u64,
}

/// The blocks in memory. A block is fetched by one thread at a time: the one that has claimed it.
#[derive(Default)]
pub(super) struct Blocks {
    slots: FxHashMap<u64, Slot>,
    claims: FxHashSet<u64>,
    kept: usize,
    limit: usize,
    clock: u64,
    careful: FxHashSet<u64>,
    /// Increased by each [`Blocks::forget`]: a block that was read from disk before that may be the invalid one.
    generation: u64,
}

impl Blocks {
    /// Creates a cache of about `bytes`; it holds at least one block.
    pub(super) fn new(bytes: usize) -> Self {
        Self { limit: (bytes / BLOCK_BYTES as usize).max(1), ..Self::default() }
    }

    /// Returns the block, if it is in memory.
    pub(super) fn get(&mut self, index: u64) -> Option<Arc<Block>> {
        let slot = self.slots.get_mut(&index)?;
        let block = slot.block.upgrade()?;
        self.clock += 1;
        slot.used = self.clock;
        if slot.kept.is_none() {
            slot.kept = Some(block.clone());
            self.kept += 1;
            self.evict();
        }
        Some(block)
    }

    /// Caches a block.
    pub(super) fn insert(&mut self, block: &Arc<Block>) {
        self.clock += 1;
        let slot = Slot { block: Arc::downgrade(block), kept: Some(block.clone()), used: self.clock };
        let former = self.slots.insert(block.index, slot);
        self.kept += usize::from(former.is_none_or(|former| former.kept.is_none()));
        self.evict();
    }

    fn evict(&mut self) {
        while self.kept > self.limit {
            let kept = self.slots.values_mut().filter(|slot| slot.kept.is_some());
            if let Some(oldest) = kept.min_by_key(|slot| slot.used) {
                oldest.kept = None;
                self.kept -= 1;
            }
        }
        if self.slots.len() > 4 * self.limit + 64 {
            self.slots.retain(|_, slot| slot.block.strong_count() > 0);
        }
    }

    /// Drops a block from the cache; callers that hold it keep it.
    pub(super) fn forget(&mut self, index: u64) {
        self.generation += 1;
        if self.slots.remove(&index).is_some_and(|slot| slot.kept.is_some()) {
            self.kept -= 1;
        }
    }

    /// Drops all cached blocks.
    pub(super) fn clear(&mut self) {
        self.slots.clear();
        self.kept = 0;
    }

    /// From now on, requests the block twice whenever it is fetched over the network.
    pub(super) fn be_careful(&mut self, index: u64) {
        self.careful.insert(index);
    }

    /// Returns whether one of the blocks is requested twice.
    pub(super) fn is_careful(&self, indices: Range<u64>) -> bool {
        !self.careful.is_empty() && indices.into_iter().any(|index| self.careful.contains(&index))
    }

    /// Returns the number of [`Blocks::forget`] calls so far.
    pub(super) fn generation(&self) -> u64 {
        self.generation
    }

    /// Claims a block; returns `true` if the caller is the one that must fetch it.
    pub(super) fn claim(&mut self, index: u64) -> bool {
        self.claims.insert(index)
    }

    /// Releases a claim, after the block was fetched or the fetch was abandoned.
    pub(super) fn release(&mut self, index: u64) {
        self.claims.remove(&index);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_recently_used_block_is_evicted_unless_it_is_held() {
        let mut blocks = Blocks::new(2 * BLOCK_BYTES as usize);
        let block = |index| Arc::new(Block { index, bytes: vec![index as u8] });
        let first = block(0);
        blocks.insert(&first);
        blocks.insert(&block(1));
        assert!(blocks.get(0).is_some());
        blocks.insert(&block(2));
        assert!(blocks.get(1).is_none() && blocks.get(2).is_some());
        blocks.insert(&block(3));
        blocks.insert(&block(4));
        assert_eq!(blocks.get(0), Some(first.clone()), "the caller holds it");
        blocks.forget(0);
        assert!(blocks.get(0).is_none());
        assert_eq!(blocks.generation(), 1);
        assert!(blocks.kept <= 2);
    }
}
