//! The residency floor: where the surface must stay coarser than the view wants, because finer tiles are missing.
//!
//! Each corner of the tiles of a level has a number: 1 while one of the tiles that meet there is missing, 0 when all
//! are on the GPU, and values in between for a moment after the last one has arrived, so that detail does not pop but
//! fades in. Its interpolation is the fraction of a level by which the surface stays above that level. A tile is used
//! only where its parent's floor is 0, so the surface has no step in space either: a child is shown when it and all
//! tiles around it can be shown (Cesium calls this "forbid holes"; the interpolation is ours).
//!
//! Why: `docs/decisions/residency-floor.md`.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::pyramid::TileAddress;

/// Time for a level to fade in, in seconds.
pub(crate) const FADE_S: f64 = 0.15;

/// A corner: level, column, row.
type Corner = (u32, u32, u32);

/// The floor at the corners where it is not 0.
#[derive(Default)]
pub(crate) struct ResidencyFloor {
    corners: FxHashMap<Corner, f32>,
    version: u64,
}

fn corners(tile: TileAddress) -> [Corner; 4] {
    [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| (tile.level, tile.x + dx, tile.y + dy))
}

impl ResidencyFloor {
    /// Returns whether the whole surface is as fine as the view wants.
    pub(crate) fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// Returns a number that changes whenever the floor changes.
    pub(crate) fn version(&self) -> u64 {
        self.version
    }

    /// Returns whether the floor is decreasing at some corner.
    pub(crate) fn is_fading(&self) -> bool {
        self.corners.values().any(|value| *value < 1.0)
    }

    /// Returns the floor at the corners of a tile: north-west, north-east, south-west, south-east.
    pub(crate) fn at(&self, tile: TileAddress) -> [f32; 4] {
        corners(tile).map(|corner| self.corners.get(&corner).copied().unwrap_or(0.0))
    }

    /// Advances by a frame. `wanted` has all tiles that the view needs, coarser levels first, each with whether it is
    /// on the GPU. `step_s` is the time since the last frame; `None` disables fading.
    pub(crate) fn update(&mut self, wanted: impl Iterator<Item = (TileAddress, bool)>, step_s: Option<f64>) {
        let had_corners = !self.corners.is_empty();
        let fading = match step_s {
            Some(step_s) => {
                let step = (step_s / FADE_S) as f32;
                let left = self.corners.drain().map(|(corner, value)| (corner, value - step));
                left.filter(|(_, value)| *value > 0.0).collect()
            }
            None => FxHashMap::default(),
        };
        let mut now: FxHashMap<Corner, f32> = FxHashMap::default();
        let mut met: FxHashSet<Corner> = FxHashSet::default();
        for (tile, is_there) in wanted {
            let parent = TileAddress { level: tile.level + 1, x: tile.x / 2, y: tile.y / 2 };
            // Corners of the level above have been computed, because coarser levels come first.
            let parent_is_free = corners(parent).iter().all(|corner| !now.contains_key(corner));
            for corner in corners(tile) {
                if !is_there || !parent_is_free {
                    now.insert(corner, 1.0);
                } else if met.insert(corner)
                    && let Some(value) = fading.get(&corner)
                {
                    now.entry(corner).or_insert(*value);
                }
            }
        }
        self.corners = now;
        self.version += u64::from(had_corners || !self.corners.is_empty());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tile(level: u32, x: u32, y: u32) -> TileAddress {
        TileAddress { level, x, y }
    }

    fn pyramid(missing: &[TileAddress]) -> Vec<(TileAddress, bool)> {
        let mut wanted = vec![(tile(2, 0, 0), true)];
        for level in [1, 0] {
            let side = 4 >> level;
            wanted
                .extend((0..side * side).map(|i| tile(level, i % side, i / side)).map(|t| (t, !missing.contains(&t))));
        }
        wanted
    }

    #[test]
    fn a_missing_tile_raises_the_floor_at_its_corners_and_all_below() {
        let mut floor = ResidencyFloor::default();
        floor.update(pyramid(&[tile(1, 0, 0)]).into_iter(), None);
        assert_eq!(floor.at(tile(1, 0, 0)), [1.0; 4]);
        assert_eq!(floor.at(tile(1, 1, 1)), [1.0, 0.0, 0.0, 0.0]);
        // Its neighbours are blocked, so finer tiles there are not used.
        assert_eq!(floor.at(tile(0, 3, 3)), [1.0; 4]);
        assert_eq!(floor.at(tile(2, 0, 0)), [0.0; 4]);
    }

    #[test]
    fn detail_fades_in_level_by_level() {
        let mut floor = ResidencyFloor::default();
        floor.update(pyramid(&[tile(1, 0, 0), tile(0, 0, 0)]).into_iter(), Some(0.05));
        assert!(!floor.is_fading());
        floor.update(pyramid(&[]).into_iter(), Some(FADE_S / 2.0));
        assert!(floor.is_fading());
        assert!((floor.at(tile(1, 0, 0))[3] - 0.5).abs() < 1e-6);
        assert_eq!(floor.at(tile(0, 0, 0)), [1.0; 4], "a child waits for its parent");
        floor.update(pyramid(&[]).into_iter(), Some(FADE_S));
        assert_eq!(floor.at(tile(1, 0, 0)), [0.0; 4]);
        floor.update(pyramid(&[]).into_iter(), Some(FADE_S));
        assert!(floor.is_empty());
        // Without a time step, as in a file, nothing fades.
        floor.update(pyramid(&[tile(0, 1, 1)]).into_iter(), None);
        floor.update(pyramid(&[]).into_iter(), None);
        assert!(floor.is_empty());
    }
}
