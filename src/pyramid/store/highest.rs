//! The highest sample of a store of tiles.
//!
//! The statistics of a tile include all finer ones, so that only tiles that may hold the highest sample are read: those
//! with the largest maximum first, from the coarsest level down. Stores without measured statistics (COGs of other
//! programs, mosaics) estimate them, and may hide a sample that is higher.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::Arc;

use super::tile_store::TileStore;
use crate::pyramid::error::PyramidError;
use crate::pyramid::tile::{TILE_BORDER, TILE_SAMPLES, TILE_STRIDE, TileAddress, is_void};

/// Largest number of tiles that are read.
const MOST_TILES: usize = 96;

/// The highest sample of a store.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HighestSample {
    /// Column and row of the finest level.
    pub sample: [u32; 2],
    pub height_m: f32,
    /// Whether no other sample is higher.
    pub is_exact: bool,
}

/// A tile, by its largest height.
struct Ranked {
    max_m: f32,
    address: TileAddress,
}

impl PartialEq for Ranked {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Ranked {}

impl PartialOrd for Ranked {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Ranked {
    fn cmp(&self, other: &Self) -> Ordering {
        // Of equal heights, finer and more northern tiles come first.
        let key = |it: &Self| (it.address.level, it.address.y, it.address.x);
        self.max_m.total_cmp(&other.max_m).then_with(|| key(other).cmp(&key(self)))
    }
}

/// Finds the highest sample; `None` if no sample has a height.
///
/// # Errors
/// Fails if a tile cannot be read.
pub(crate) fn highest_sample(store: &Arc<dyn TileStore>) -> Result<Option<HighestSample>, PyramidError> {
    let levels = store.levels().to_vec();
    let finest = levels[0];
    let mut waiting = BinaryHeap::new();
    waiting.push(Ranked { max_m: f32::INFINITY, address: TileAddress { level: levels.len() as u32 - 1, x: 0, y: 0 } });
    let mut best: Option<HighestSample> = None;
    let mut read = 0;
    while let Some(Ranked { max_m, address }) = waiting.pop() {
        // The lowest bit of a sample says whether it is no-data, and not how high it is.
        if best.is_some_and(|best| best.height_m >= max_m - 2.0 * f32::EPSILON * max_m.abs()) {
            break;
        }
        if read == MOST_TILES {
            return Ok(best.map(|best| HighestSample { is_exact: false, ..best }));
        }
        read += 1;
        let loaded = Arc::clone(store).load(address)?;
        let size = levels[address.level as usize];
        let own = size.tile_region(address.x, address.y, 0);
        if loaded.statistics.max_m.is_nan() {
            continue;
        }
        if address.level > 0 {
            let level = address.level - 1;
            let finer = levels[level as usize];
            let span = |first: u32, count: u32, from: u32, to: u32| {
                let tile = |c: u32| (u64::from(c) * u64::from(to) / u64::from(from)) as u32 / TILE_SAMPLES;
                tile(first)..=tile(first + count - 1).max(tile(first))
            };
            let columns = span(own.x, own.width, size.width, finer.width);
            let rows = span(own.y, own.height, size.height, finer.height);
            let mut has_finer = false;
            for (y, x) in rows.flat_map(|y| columns.clone().map(move |x| (y, x))) {
                let finer = TileAddress { level, x, y };
                if store.has_tile(finer) {
                    has_finer = true;
                    // The tile's own maximum is not known before it is read, and is not larger than this one.
                    waiting.push(Ranked { max_m: loaded.statistics.max_m.min(max_m), address: finer });
                }
            }
            if has_finer {
                continue;
            }
        } else if loaded.statistics.max_m < max_m
            && waiting.peek().is_some_and(|next| next.max_m > loaded.statistics.max_m)
        {
            // Another tile may hold a higher sample; this one comes back when it is its turn.
            waiting.push(Ranked { max_m: loaded.statistics.max_m, address });
            continue;
        }
        for row in 0..own.height {
            for column in 0..own.width {
                let at = (row + TILE_BORDER) * TILE_STRIDE + column + TILE_BORDER;
                let height_m = loaded.tile.samples[at as usize];
                if !is_void(height_m) && best.is_none_or(|best| height_m > best.height_m) {
                    let fine = |c: u32, from: u32, to: u32| {
                        let c = (f64::from(c) + 0.5) * f64::from(to) / f64::from(from) - 0.5;
                        (c.round().max(0.0) as u32).min(to - 1)
                    };
                    let sample =
                        [fine(own.x + column, size.width, finest.width), fine(own.y + row, size.height, finest.height)];
                    best =
                        Some(HighestSample { sample, height_m, is_exact: store.is_measured() && address.level == 0 });
                }
            }
        }
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;
    use crate::pyramid::store::MemoryStore;
    use crate::source::georeference::Georeference;
    use crate::source::{HeightGrid, Silent};

    fn highest([width, height]: [u32; 2], height_m: impl Fn(u32, u32) -> f32) -> Option<HighestSample> {
        let heights_m = (0..width * height).map(|i| height_m(i % width, i / width)).collect();
        let georeference = Georeference::local(width, height, 10.0);
        let grid = HeightGrid { width, height, heights_m, georeference };
        let store: Arc<dyn TileStore> = Arc::new(MemoryStore::new(grid, "grid", &Silent).unwrap());
        highest_sample(&store).unwrap()
    }

    #[test]
    fn the_highest_sample_is_found_wherever_it_is() {
        let size = [1100, 900];
        // A single sample in a broad hill elsewhere, in the last row, and next to no-data.
        for peak in [[3, 5], [1099, 899], [511, 512], [700, 256], [255, 255]] {
            let land = |x: u32, y: u32| {
                let hill = 400.0 - 0.5 * (f64::from(x) - 300.0).hypot(f64::from(y) - 600.0);
                if [x, y] == peak {
                    500.0
                } else if x == peak[0] + 1 {
                    f32::NAN
                } else {
                    hill as f32
                }
            };
            let found = highest(size, land).unwrap();
            assert!(
                found.sample == peak && found.is_exact && (found.height_m - 500.0).abs() < 0.01,
                "{found:?} {peak:?}"
            );
        }
        // Without the peak, the hill.
        let hill = |x: u32, y: u32| 400.0 - 0.5 * (x as f32 - 300.0).hypot(y as f32 - 600.0);
        assert_eq!(highest(size, hill).unwrap().sample, [300, 600]);
    }
}
