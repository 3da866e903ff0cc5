//! The land of the patches of a [`Walk`] that is certain to block the view.
//!
//! Why: `docs/decisions/terrain-occlusion.md`.

use glam::DVec2;

use super::{VisiblePatch, Walk};
use crate::pyramid::TileAddress;
use crate::pyramid::surface::bicubic::OVERSHOOT;
use crate::pyramid::surface::occluder_minima::{BLOCK_SAMPLES, OccluderMinima, TILE_BLOCKS};
use crate::pyramid::surface::statistics::PAGE_PATCHES;
use crate::pyramid::tile::PATCH_QUADS;
use crate::scene::frustum::Bounds;
use crate::tiles::patches::Patches;
use crate::tiles::selection::PatchKey;
use crate::tiles::skyline::Corner;

impl Walk<'_> {
    /// Adds a patch to the skyline, lowered by `slack_m`.
    pub(super) fn add_to_skyline(&mut self, patch: &VisiblePatch, slack_m: f64) {
        let key = patch.key;
        // A patch finer than the data is in few blocks, of which each has one height.
        let most_parts = 4 >> (-key.level).clamp(0, 2);
        let parts = self.skyline.parts(&patch.bounds).min(most_parts);
        let relief_m = f64::from(patch.statistics.max_m - patch.statistics.min_m);
        let lowest_m = f64::from(patch.statistics.min_m) - f64::from(OVERSHOOT) * relief_m;
        let lower_m = slack_m + self.viewpoint.camera_m.z;
        // Lower bounds of the parts' land, relative to the camera, row by row.
        let mut land_m = [lowest_m - lower_m; 16];
        if let Some(minima) = Minima::of(self.patches, key) {
            let of_parts = minima.of_parts(parts);
            for (land_m, minimum_m) in land_m.iter_mut().zip(of_parts).take(parts * parts) {
                *land_m = land_m.max(f64::from(minimum_m) - lower_m);
            }
        }
        let highest_m = land_m[..parts * parts].iter().fold(f64::NEG_INFINITY, |highest, land_m| highest.max(*land_m));
        // Most far patches cannot raise the skyline.
        if self.skyline.blocks(&patch.bounds, highest_m) {
            return;
        }
        let (first, side) = key.area();
        let size = self.patches.size();
        let last = DVec2::new(f64::from(size.width - 1), f64::from(size.height - 1));
        // Corners of the parts, relative to the camera; there are at most 4 × 4 parts.
        let mut corners = [Corner::default(); 25];
        for (i, corner) in corners.iter_mut().enumerate().take((parts + 1) * (parts + 1)) {
            let at = DVec2::new((i % (parts + 1)) as f64, (i / (parts + 1)) as f64);
            let grid = (first + at * (side / parts as f64)).min(last);
            *corner = Corner::at(self.grid_projection.world_from_grid(grid) - self.viewpoint.camera_m.truncate());
        }
        for (x, y) in (0..parts).flat_map(|y| (0..parts).map(move |x| (x, y))) {
            let corner = |x: usize, y: usize| corners[y * (parts + 1) + x];
            let around = [corner(x, y), corner(x + 1, y + 1), corner(x + 1, y), corner(x, y + 1)];
            let z_m = land_m[y * parts + x];
            let [a, b, c, d] = around.map(|corner| corner.at_m);
            let (low_m, high_m) = (a.min(b).min(c.min(d)).extend(z_m), a.max(b).max(c.max(d)).extend(z_m));
            if let Some(bent) = self.viewpoint.earth_curvature.bend_bounds(&Bounds { low_m, high_m }) {
                self.skyline.add(&bent, &around, bent.low_m.z);
            }
        }
    }
}

/// The occluder minima of a patch's tile, and the blocks of the patch.
struct Minima<'a> {
    minima: &'a OccluderMinima,
    key: PatchKey,
}

impl<'a> Minima<'a> {
    /// Returns the minima of a patch; `None` if its tile is not loaded.
    fn of(patches: &'a dyn Patches, key: PatchKey) -> Option<Self> {
        let level = key.level.max(0);
        // A patch covers 4 × 4 blocks of its level, or, if it is finer than the data, less than one of level 0. All of
        // them are in one tile.
        let tile = |patch: i64| {
            let block = (patch * i64::from(PATCH_QUADS / BLOCK_SAMPLES)) >> (level - key.level);
            u32::try_from(block / i64::from(TILE_BLOCKS)).ok()
        };
        let address = TileAddress { level: level as u32, x: tile(key.x)?, y: tile(key.y)? };
        Some(Self { minima: patches.occluder_minima(address)?, key })
    }

    /// Returns lower bounds of the land's height in `parts` × `parts` parts of the patch, in metres, row by row. `parts` is
    /// 1, 2 or 4.
    fn of_parts(&self, parts: usize) -> [f32; 16] {
        let mut minima_m = [f32::INFINITY; 16];
        if self.key.level < 0 {
            for (i, minimum_m) in minima_m.iter_mut().enumerate().take(parts * parts) {
                *minimum_m = self.of_part(parts, i % parts, i / parts);
            }
            return minima_m;
        }
        let patch = |at: i64| (at % i64::from(PAGE_PATCHES)) as u32;
        let blocks = self.minima.of_patch(patch(self.key.x), patch(self.key.y));
        let per_part = 4 / parts;
        for (i, block_m) in blocks.iter().enumerate() {
            let part = &mut minima_m[i / 4 / per_part * parts + i % 4 / per_part];
            *part = part.min(*block_m);
        }
        minima_m
    }

    /// Returns a lower bound of the land's height in one of `parts` × `parts` parts of the patch, in metres.
    fn of_part(&self, parts: usize, x: usize, y: usize) -> f32 {
        let key = self.key;
        let blocks = i64::from(PATCH_QUADS / BLOCK_SAMPLES);
        // First and last block of a part along one axis.
        let span = |patch: i64, part: usize| {
            let (parts, part) = (parts as i64, part as i64);
            let begin = |part: i64| patch * blocks * parts + part * blocks;
            let block = |position: i64| (position >> (key.level.max(0) - key.level)).div_euclid(parts);
            (block(begin(part)), block(begin(part + 1) - 1))
        };
        let ((left, right), (top, bottom)) = (span(key.x, x), span(key.y, y));
        let inside = |block: i64| (block % i64::from(TILE_BLOCKS)) as u32;
        let mut minimum_m = f32::INFINITY;
        for (x, y) in (top..=bottom).flat_map(|y| (left..=right).map(move |x| (x, y))) {
            minimum_m = minimum_m.min(self.minima.get(inside(x), inside(y)));
        }
        minimum_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pyramid::surface::statistics::{TileStatistics, Voids};
    use crate::pyramid::tile::{TILE_STRIDE, Tile};

    #[test]
    fn parts_of_a_patch_are_as_low_as_their_blocks() {
        let statistics =
            TileStatistics { min_m: 0.0, max_m: 1.0, error_m: 0.0, corner_errors_m: [0.0; 4], voids: Voids::None };
        let height = |i: u32| ((i * 7919) % 1013) as f32;
        let minima =
            OccluderMinima::of(&Tile { samples: (0..TILE_STRIDE * TILE_STRIDE).map(height).collect() }, &statistics);
        for (x, y) in [(0, 0), (5, 3), (16 + 15, 32 + 9)] {
            let patch = Minima { minima: &minima, key: PatchKey { level: 2, x, y } };
            for parts in [1, 2, 4] {
                for (i, minimum_m) in patch.of_parts(parts).into_iter().enumerate().take(parts * parts) {
                    assert_eq!(minimum_m, patch.of_part(parts, i % parts, i / parts), "{x} {y} {parts} {i}");
                }
            }
        }
    }
}
