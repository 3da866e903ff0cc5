//! Maps of an open world: the positions of their pixels, and their eye.

use std::sync::Arc;

use glam::DVec2;

use super::{OpenWorld, lone_model};
use crate::pyramid::surface::statistics::PAGE_PATCHES;
use crate::pyramid::tile::{PATCH_QUADS, TILE_SAMPLES, TileAddress};
use crate::scene::map::{Map, MapArea};
use crate::scene::view::Pose;
use crate::tiles::Terrain;

/// Largest number of tiles along a side whose heights are read.
const ASKED_TILES: u32 = 3;

/// The edges of a picture that are bare paper, and not part of the area of a map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Edges {
    /// Rows at the bottom, inside the frame.
    pub foot_px: u32,
    /// Width of the frame on all sides.
    pub frame_px: u32,
}

impl OpenWorld {
    /// Returns the map of an area with `size_px` pixels, and its eye.
    pub fn map(&self, area: MapArea, size_px: [u32; 2]) -> (Map, Pose) {
        self.map_within(area, size_px, Edges::default())
    }

    /// Returns the map of a picture whose edges are bare paper and not part of the area.
    pub(crate) fn map_within(&self, area: MapArea, [width, height]: [u32; 2], edges: Edges) -> (Map, Pose) {
        let terrain = &self.surfaces.terrain;
        let Edges { foot_px, frame_px } = edges;
        let frame_px = frame_px.min(width.min(height).saturating_sub(1) / 2);
        let [width, height] = [width, height].map(|side| side - 2 * frame_px);
        let foot_px = foot_px.min(height.saturating_sub(1));
        let model_m = lone_model::box_m(&self.scene, &self.surfaces);
        let corners_m = model_m.map_or_else(|| terrain.corners_m(), lone_model::map_corners_m);
        let map = Map::new(area, corners_m, [width, height - foot_px]).with_foot(foot_px).with_frame(frame_px);
        let range_m = local_range_m(terrain, map.corners_m()).unwrap_or_else(|| terrain.range_m()).map(f64::from);
        let pose = match model_m {
            // Nothing else rises above its ground, except trees that someone plants.
            Some([low_m, high_m]) if self.surfaces.forest().is_none() => {
                map.pose_within([range_m[0].min(low_m.z), range_m[1].max(high_m.z)])
            }
            _ => map.pose(range_m),
        };
        (map, pose)
    }
}

/// Returns bounds of the heights between two corners, from the statistics of the patches of a few tiles: the smaller
/// the range of heights, the nearer the eye may be, and the more precise its f32. Returns `None` if there is no land,
/// or it cannot be read, which drawing will report.
fn local_range_m(terrain: &Terrain, [low_m, high_m]: [DVec2; 2]) -> Option<[f32; 2]> {
    let store = terrain.store();
    let middle_m = 0.5 * (low_m + high_m);
    let (xs, ys) = ([low_m.x, middle_m.x, high_m.x], [low_m.y, middle_m.y, high_m.y]);
    let places = xs.into_iter().flat_map(|x| ys.map(|y| terrain.mapping().grid_from_world(DVec2::new(x, y))));
    let finest = store.levels()[0];
    let last = DVec2::new(f64::from(finest.width - 1), f64::from(finest.height - 1));
    let (mut low, mut high) = (last, DVec2::ZERO);
    for place in places {
        if !place.is_finite() {
            return None;
        }
        let place = place.clamp(DVec2::ZERO, last);
        (low, high) = (low.min(place), high.max(place));
    }
    for (level, size) in store.levels().iter().enumerate() {
        let scale = DVec2::new(f64::from(size.width), f64::from(size.height))
            / DVec2::new(f64::from(finest.width), f64::from(finest.height));
        let tile = |place: DVec2| (place * scale / f64::from(TILE_SAMPLES)).floor().max(DVec2::ZERO).as_uvec2();
        // Parallels are curved on the grid, so the area between the places may extend a little beyond them.
        let bent = 0.01 * (high - low) + 1.0;
        let most = glam::UVec2::new(size.tiles_x() - 1, size.tiles_y() - 1);
        let (first, last) = (tile(low - bent).min(most), tile(high + bent).min(most));
        if (last - first).max_element() >= ASKED_TILES {
            continue;
        }
        let addresses =
            (first.y..=last.y).flat_map(|y| (first.x..=last.x).map(move |x| TileAddress { level: level as u32, x, y }));
        let addresses: Vec<TileAddress> = addresses.collect();
        if !addresses.iter().all(|address| store.has_tile(*address)) {
            continue;
        }
        let mut range_m = [f32::NAN; 2];
        for address in addresses {
            let patches = Arc::clone(store).load(address).ok()?.patches;
            for (number, patch) in (0..).zip(patches.patches()) {
                let column = address.x * PAGE_PATCHES + number % PAGE_PATCHES;
                let row = address.y * PAGE_PATCHES + number / PAGE_PATCHES;
                let first = DVec2::new(f64::from(column), f64::from(row)) * patch_samples(level);
                let is_outside =
                    first.cmpgt(high + bent).any() || (first + patch_samples(level)).cmplt(low - bent).any();
                if !is_outside && !patch.min_m.is_nan() {
                    // Between its samples the land may deviate by as much as the patch's triangles do.
                    range_m[0] = range_m[0].min(patch.min_m - patch.mesh_error_m);
                    range_m[1] = range_m[1].max(patch.max_m + patch.mesh_error_m);
                }
            }
        }
        return range_m.iter().all(|height_m| height_m.is_finite()).then_some(range_m);
    }
    None
}

/// Returns the number of level-0 samples along the side of a patch that comes with a tile of a level.
fn patch_samples(level: usize) -> f64 {
    f64::from(PATCH_QUADS) * (1_u64 << level) as f64
}
