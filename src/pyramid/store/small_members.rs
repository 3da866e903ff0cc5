//! Members of a mosaic that are too small for the samples of a coarse tile.
//!
//! A member that is smaller than the space between samples leaves no trace in a tile's heights, so [`derive()`] would
//! estimate that nothing is lost there, and finer tiles would never be requested. The statistics of the tile and of its
//! mesh patches therefore take in the members' height ranges, which are known without reading samples.
//!
//! [`derive()`]: super::derive()

use std::sync::Arc;

use super::tile_store::TileStore;
use crate::pyramid::surface::levels::LevelSize;
use crate::pyramid::surface::loaded_tile::LoadedTile;
use crate::pyramid::surface::statistics::{PAGE_PATCHES, PatchPage, Voids, patch_counts};
use crate::pyramid::tile::{PATCH_QUADS, TileAddress};
use crate::source::mosaic::Placed;

/// Number of samples along the shorter side of a member from which on the tile's own samples show the loss.
const SHOWN_SAMPLES: f64 = 2.0;
/// Least error that a small member causes, as a share of its height range: the error where other land has the same
/// heights.
const LEAST_SHARE: f32 = 0.1;

/// A member that is too small for a tile.
struct Small {
    /// West, north, east and south, in mesh patches of the tile's page.
    extent: [f64; 4],
    range_m: [f32; 2],
    /// Length of its longer side, in metres.
    side_m: f32,
}

/// The members that are too small for a tile, and where they are in it.
pub(super) struct SmallMembers {
    members: Vec<Small>,
    /// Columns and rows of the page's patches that are on the grid.
    counts: [u32; 2],
}

impl SmallMembers {
    /// Finds the members in the area of a tile that its level does not show. `finest` is the size of level 0.
    pub(super) fn at(
        places: &[Placed],
        stores: &[Arc<dyn TileStore>],
        finest: LevelSize,
        address: TileAddress,
    ) -> Self {
        let sample = f64::from(address.level).exp2();
        let patch = sample * f64::from(PATCH_QUADS);
        let first = [address.x, address.y].map(|tile| f64::from(tile * PAGE_PATCHES));
        let [columns, rows]: [u32; 2] = patch_counts(finest, address.level).into();
        let counts = [columns, rows].map(f64::from);
        let counts = [0, 1].map(|axis| (counts[axis] - first[axis]).clamp(0.0, f64::from(PAGE_PATCHES)) as u32);
        let members = places.iter().zip(stores).filter_map(|(placed, store)| {
            let [west, north, east, south] = placed.extent;
            if (east - west).min(south - north) >= SHOWN_SAMPLES * sample || !store.range_m()[0].is_finite() {
                return None;
            }
            // A mesh patch has its borders, and the surface bends one sample beyond a member.
            let extent = [west - sample, north - sample, east + sample, south + sample];
            let extent = [0, 1, 2, 3].map(|side: usize| extent[side] / patch - first[side % 2]);
            let is_in_tile = (0..2).all(|axis| extent[axis + 2] >= 0.0 && extent[axis] <= f64::from(counts[axis]));
            let side_m = placed.size.map(f64::from).into_iter().fold(0.0, f64::max) * placed.spacing_m;
            is_in_tile.then(|| Small { extent, range_m: store.range_m(), side_m: side_m as f32 })
        });
        Self { members: members.collect(), counts }
    }

    /// Returns a tile whose statistics take in the members.
    pub(super) fn noted_in(&self, loaded: LoadedTile) -> LoadedTile {
        if self.members.is_empty() {
            return loaded;
        }
        let LoadedTile { tile, mut statistics, patches, .. } = loaded;
        let mut patches = patches.patches().to_vec();
        for small in &self.members {
            let error_m = small.error_m([statistics.min_m, statistics.max_m], statistics.voids);
            statistics.error_m = statistics.error_m.max(error_m);
            statistics.corner_errors_m = statistics.corner_errors_m.map(|corner_m| corner_m.max(error_m));
            [statistics.min_m, statistics.max_m] = small.widened([statistics.min_m, statistics.max_m]);
            statistics.voids = statistics.voids.with_land();
            let [columns, rows] = [0, 1].map(|axis| {
                let first = small.extent[axis].floor().max(0.0) as u32;
                let end = small.extent[axis + 2].ceil().max(0.0) as u32;
                first..end.min(self.counts[axis])
            });
            for (row, column) in rows.flat_map(|row| columns.clone().map(move |column| (row, column))) {
                let patch = &mut patches[(row * PAGE_PATCHES + column) as usize];
                patch.mesh_error_m = patch.mesh_error_m.max(small.error_m([patch.min_m, patch.max_m], patch.voids));
                [patch.min_m, patch.max_m] = small.widened([patch.min_m, patch.max_m]);
                patch.voids = patch.voids.with_land();
            }
        }
        LoadedTile::new(tile, statistics, PatchPage::new(patches))
    }
}

impl Small {
    /// Returns how wrong the surface of land with a height range is without this member, in metres. Between no-data, all
    /// of the member is missing, also if it is flat.
    fn error_m(&self, [low_m, high_m]: [f32; 2], voids: Voids) -> f32 {
        let relief_m = self.range_m[1] - self.range_m[0];
        let beyond_m = (self.range_m[1] - high_m).max(low_m - self.range_m[0]);
        let side_m = if voids == Voids::None { 0.0 } else { self.side_m };
        beyond_m.max(LEAST_SHARE * relief_m).max(side_m)
    }

    /// Returns a height range, NaN if it is empty, that includes the member's.
    fn widened(&self, [low_m, high_m]: [f32; 2]) -> [f32; 2] {
        [low_m.min(self.range_m[0]), high_m.max(self.range_m[1])]
    }
}
