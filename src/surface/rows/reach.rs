//! Culls blocks of rows whose marks are neither in view nor so near to it that they affect a mark that is.
//!
//! The test is that of `level_share` in `shaders/surface/rows/proposals.wgsl`, for a box around blocks instead of a mark:
//! it keeps every block of which the shader would propose a mark, so culling changes no picture. Whether a mark is drawn
//! depends on its neighbours in the same block, and on proposals near it on the picture; so it does not depend on blocks
//! that are culled, and a mark stays when a neighbouring block goes out of view.

use glam::{DVec2, DVec3};

use super::blocks::MIN_LEVEL;
use super::needed::Blocks;
use crate::gpu::wgsl::shared::rows::{CELLS, REACH_CELLS, REACH_PX};
use crate::scene::frustum::{Bounds, Frustum};
use crate::scene::view::{Part, Rig, View};
use crate::tiles::earth_curvature::EarthCurvature;
use crate::tiles::selection::Selection;
use crate::tiles::terrain::Terrain;

/// Cross-fade beyond the range of a level, in octaves: `FADE` of `proposals.wgsl`, and the errors of f32.
pub(super) const BEYOND: f64 = 0.08;
/// Tolerance of the shader's f32 in the position of a mark, in pixels.
const ROUNDING_PX: f32 = 4.0;

/// How blocks are culled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Culling {
    /// Blocks whose marks do not reach the picture are culled.
    #[default]
    ByReach,
    /// No block is culled: the reference.
    #[cfg(test)]
    Nothing,
    /// Plants an error: blocks are culled even if their marks reach into the picture.
    #[cfg(test)]
    WithoutReach,
}

/// The properties of an eye by which blocks are culled.
struct Eye {
    /// The frustum of the picture with a border of [`REACH_PX`].
    frustum: Frustum,
    /// Direction in which it looks.
    forward: DVec3,
    /// Position relative to the rig's origin, in metres.
    at_m: DVec3,
    /// Pixels per radian of the rig, divided by those of the eye.
    focal_ratio: f64,
}

/// The land around a rig from which marks may reach into its pictures.
#[derive(Default)]
pub(super) struct Reach {
    culling: Culling,
    eyes: Vec<Eye>,
    origin_m: DVec3,
    earth: EarthCurvature,
    /// The least and the greatest height of the land in the world, in metres.
    range_m: [f64; 2],
    /// Last column and row of the grid.
    last: DVec2,
    /// Distance between samples, in metres.
    spacing_m: f64,
    /// Distance at which a cell of level 0 is one spacing of marks wide on the picture, in metres.
    cells_m: f64,
    greatest_level: i32,
}

impl Reach {
    /// Sets the rig and the land that it sees.
    pub(super) fn set(&mut self, terrain: &Terrain, selection: &Selection, rig: &Rig, culling: Culling) {
        let focal_px = rig.eyes.iter().map(View::focal_px).fold(0.0, f64::max);
        let border_px = (REACH_PX + ROUNDING_PX).ceil() as u32;
        #[cfg(test)]
        let border_px = if culling == Culling::WithoutReach { 0 } else { border_px };
        self.eyes.clear();
        self.eyes.extend(rig.eyes.iter().map(|eye| {
            let part = Part {
                origin_px: eye.part.origin_px.map(|at| at - border_px as i32),
                size_px: eye.part.size_px.map(|side| side + 2 * border_px),
            };
            Eye {
                frustum: View { part, ..*eye }.frustum(),
                forward: eye.pose.forward,
                at_m: eye.pose.position_m - rig.origin_m,
                // `View::focal_px` is the larger of the two directions: in the other one a cell is narrower.
                focal_ratio: focal_px / eye.least_focal_px(),
            }
        }));
        let size = terrain.store().levels()[0];
        let known_m = terrain.range_m().map(f64::from);
        // The store may only have an estimate of its range.
        let drawn_m = selection.range_m.unwrap_or(known_m);
        self.culling = culling;
        self.origin_m = rig.origin_m;
        self.earth = terrain.earth_curvature(rig.origin_m.z);
        self.range_m = [known_m[0].min(drawn_m[0]), known_m[1].max(drawn_m[1])];
        self.last = DVec2::new(f64::from(size.width - 1), f64::from(size.height - 1));
        self.spacing_m = terrain.grid_projection().spacing_m();
    }

    /// Sets the distance at which a cell of level 0 is one spacing of marks wide on the picture, in metres, and the level
    /// of the block that covers the grid.
    pub(super) fn set_spacing(&mut self, cells_m: f64, greatest_level: i32) {
        (self.cells_m, self.greatest_level) = (cells_m, greatest_level);
    }

    /// Returns the levels that are visible on land between two distances, in metres.
    pub(super) fn levels(&self, near_m: f64, far_m: f64) -> std::ops::RangeInclusive<i32> {
        // The level that is visible at a distance: its cells are between one and two spacings wide.
        let level_at = |distance_m: f64| 1.0 - (self.cells_m / distance_m.max(1e-3)).log2();
        let finest = (level_at(near_m) - 1.0 - BEYOND).floor() as i32 + 1;
        let coarsest = (level_at(far_m) + BEYOND).ceil() as i32 - 1;
        let [finest, coarsest] = [finest, coarsest].map(|level| level.clamp(MIN_LEVEL, self.greatest_level));
        finest..=coarsest
    }

    /// Returns the last column and row of the blocks of a level.
    pub(super) fn last_block(&self, level: i32) -> i32 {
        f64::from(self.greatest_level - level).exp2() as i32 - 1
    }

    /// Returns whether a mark of the blocks may be proposed. Conservative: never `false` if one would be.
    pub(super) fn may_draw(&self, terrain: &Terrain, blocks: Blocks) -> bool {
        #[cfg(test)]
        if self.culling == Culling::Nothing {
            return true;
        }
        let cell = f64::from(blocks.level).exp2();
        let corner = |[x, y]: [i32; 2], next: f64| {
            let corner = (DVec2::new(f64::from(x), f64::from(y)) + next) * (f64::from(CELLS) * cell);
            // The projection is valid inside the grid only. Beyond it there is no land on which a mark could be seen.
            corner.clamp(DVec2::ZERO, self.last)
        };
        let (low, high) = terrain.grid_projection().bounds(corner(blocks.low, 0.0), corner(blocks.high, 1.0));
        let flat = Bounds {
            low_m: low.extend(self.range_m[0]) - self.origin_m,
            high_m: high.extend(self.range_m[1]) - self.origin_m,
        };
        // The level is visible between these distances only.
        let level_m = |octaves: f64| self.cells_m * (f64::from(blocks.level) + octaves).exp2();
        let nearest_m = if blocks.level > MIN_LEVEL { level_m(-1.0 - BEYOND) } else { 0.0 };
        let farthest_m = if blocks.level < self.greatest_level { level_m(BEYOND) } else { f64::INFINITY };
        if flat.distance_m() > farthest_m || flat.farthest_m() < nearest_m {
            return false;
        }
        let visible = Bounds {
            low_m: flat.low_m.max(DVec3::splat(-farthest_m)),
            high_m: flat.high_m.min(DVec3::splat(farthest_m)),
        };
        self.is_near_view(&visible, nearest_m.max(flat.distance_m()), cell * self.spacing_m)
    }

    /// Returns whether part of a box of the flat map, relative to the origin, may be within reach of the picture of an
    /// eye. Its marks are at least `nearest_m` away, and its cells have sides of `cell_m`.
    fn is_near_view(&self, flat: &Bounds, nearest_m: f64, cell_m: f64) -> bool {
        let reach_m = f64::from(REACH_CELLS) * cell_m;
        let Some(bent) = self.earth.bend_bounds(flat) else {
            // Marks may come from behind the horizon.
            let around = DVec3::new(reach_m, reach_m, 0.0);
            let flat = Bounds { low_m: flat.low_m - around, high_m: flat.high_m + around };
            return self.earth.bend_bounds(&flat).is_some();
        };
        // The shader takes the width of cells on the picture from the distance on the flat map, but projects by the
        // distance along the axis: the reach is that in cells, times the second distance, divided by the first.
        let wide_m = flat.low_m.truncate().abs().max(flat.high_m.truncate().abs()).length();
        let k = self.earth.inverse_radius;
        let raised = k * self.range_m[0].abs().max(self.range_m[1].abs());
        let bent_ratio = 1.0 + raised + 0.5 * (1.0 + raised) * k * wide_m;
        self.eyes.iter().any(|eye| {
            let aside_m = eye.at_m.length();
            let eye_ratio = if aside_m > 0.0 { aside_m / nearest_m } else { 0.0 };
            let seen = Bounds { low_m: bent.low_m - eye.at_m, high_m: bent.high_m - eye.at_m };
            // The middle of a mark is in front of the eye.
            let foremost = DVec3::select(eye.forward.cmpge(DVec3::ZERO), seen.high_m, seen.low_m);
            let axial_m = eye.forward.dot(foremost);
            let reach_m = reach_m * eye.focal_ratio * (bent_ratio + eye_ratio).min(axial_m / nearest_m);
            #[cfg(test)]
            let reach_m = if self.culling == Culling::WithoutReach { 0.0 } else { reach_m };
            axial_m >= 0.0 && eye.frustum.may_see_within(&seen, reach_m)
        })
    }
}
