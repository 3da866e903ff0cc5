//! Occluder minima: lower bounds of a tile's land, by blocks of 4 × 4 samples, for occlusion culling.
//!
//! A ridge across a mesh patch of 16 × 16 quads hides little if the patch counts only as high as its lowest place; by
//! blocks it hides the view nearly up to its crest.
//!
//! Why: `docs/decisions/terrain-occlusion.md`.

use super::bicubic::OVERSHOOT;
use super::statistics::TileStatistics;
use crate::pyramid::tile::{PATCH_QUADS, TILE_SAMPLES, TILE_STRIDE, Tile, is_void};

/// Number of samples along the side of a block.
pub(crate) const BLOCK_SAMPLES: u32 = 4;
/// Number of blocks along the side of a tile.
pub(crate) const TILE_BLOCKS: u32 = TILE_SAMPLES / BLOCK_SAMPLES;

/// Number of blocks along the side of a mesh patch.
const PATCH_BLOCKS: u32 = PATCH_QUADS / BLOCK_SAMPLES;

/// For each block, a height in metres that the surface of full resolution never goes below. The blocks of a mesh patch
/// follow each other, so that they are in one line of the processor's cache.
#[derive(Clone, Debug, PartialEq)]
pub struct OccluderMinima(Box<[f32]>);

/// Returns the index of the block in column `x` and row `y` of a tile.
#[inline]
fn index(x: u32, y: u32) -> usize {
    let patch = (y / PATCH_BLOCKS) * (TILE_BLOCKS / PATCH_BLOCKS) + x / PATCH_BLOCKS;
    ((patch * PATCH_BLOCKS + y % PATCH_BLOCKS) * PATCH_BLOCKS + x % PATCH_BLOCKS) as usize
}

impl OccluderMinima {
    /// Computes the minima of a tile: its samples minus their possible error. −∞ where a sample is no-data.
    pub fn of(tile: &Tile, statistics: &TileStatistics) -> Self {
        const STRIDE: usize = TILE_STRIDE as usize;
        const BLOCKS: usize = TILE_BLOCKS as usize;
        // A level's samples are up to half a sample away from those of the mesh, so a block includes two more samples
        // on each side.
        const SIDE: usize = BLOCK_SAMPLES as usize + 4;
        let mut minima_m = vec![0.0; BLOCKS * BLOCKS];
        let mut columns = [(0.0_f32, 0.0_f32); STRIDE];
        for row in 0..BLOCKS {
            columns.fill((f32::INFINITY, f32::NEG_INFINITY));
            let first = row * BLOCK_SAMPLES as usize * STRIDE;
            for samples in tile.samples[first..first + SIDE * STRIDE].chunks_exact(STRIDE) {
                for ((low, high), &sample) in columns.iter_mut().zip(samples) {
                    let least = if is_void(sample) { f32::NEG_INFINITY } else { sample };
                    (*low, *high) = (low.min(least), high.max(sample));
                }
            }
            for block in 0..BLOCKS {
                let around = &columns[block * BLOCK_SAMPLES as usize..][..SIDE];
                let low_m = around.iter().map(|column| column.0).fold(f32::INFINITY, f32::min);
                let high_m = around.iter().map(|column| column.1).fold(f32::NEG_INFINITY, f32::max);
                minima_m[index(block as u32, row as u32)] = low_m - OVERSHOOT * (high_m - low_m) - statistics.error_m;
            }
        }
        Self(minima_m.into())
    }

    /// Returns the minima of the 4 × 4 blocks of a mesh patch of the tile, in metres, row by row. The patch is in column `x`
    /// and row `y`.
    #[inline]
    pub(crate) fn of_patch(&self, x: u32, y: u32) -> &[f32] {
        &self.0[index(x * PATCH_BLOCKS, y * PATCH_BLOCKS)..][..(PATCH_BLOCKS * PATCH_BLOCKS) as usize]
    }

    /// Returns the minimum of the block in column `x` and row `y` of the tile, in metres; −∞ next to no-data.
    #[inline]
    pub fn get(&self, x: u32, y: u32) -> f32 {
        self.0[index(x, y)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pyramid::surface::statistics::Voids;
    use crate::pyramid::tile::flagged;

    #[test]
    fn a_block_is_as_low_as_what_is_around_it() {
        let statistics =
            TileStatistics { min_m: 0.0, max_m: 1.0, error_m: 0.5, corner_errors_m: [0.5; 4], voids: Voids::Some };
        let mut samples = vec![flagged(100.0, false); (TILE_STRIDE * TILE_STRIDE) as usize];
        // Sample (40, 80) of the tile, and a no-data sample at (200, 200).
        samples[(82 * TILE_STRIDE + 42) as usize] = flagged(90.0, false);
        samples[(202 * TILE_STRIDE + 202) as usize] = flagged(100.0, true);
        let minima = OccluderMinima::of(&Tile { samples }, &statistics);
        assert_eq!(minima.get(0, 0), 99.5);
        for (x, y) in [(9, 19), (10, 20), (10, 19)] {
            assert_eq!(minima.get(x, y), 90.0 - 1.5 - 0.5, "{x} {y}");
        }
        assert_eq!((minima.get(11, 20), minima.get(10, 21), minima.get(8, 20)), (99.5, 99.5, 99.5));
        assert_eq!(minima.get(50, 50), f32::NEG_INFINITY);
        for (x, y) in [(0, 0), (2, 4), (2, 5), (12, 12), (15, 15)] {
            let blocks = (0..16).map(|i| minima.get(4 * x + i % 4, 4 * y + i / 4));
            assert!(minima.of_patch(x, y).iter().copied().eq(blocks), "{x} {y}");
        }
    }
}
