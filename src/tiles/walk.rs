//! The walk through the quadtree of patches that makes a [`Selection`]: from near to far, splitting patches whose error
//! would be visible, skipping those that are hidden behind nearer land.

use glam::DVec2;
use rustc_hash::FxHashSet;

use super::grid_projection::GridProjection;
use super::leaves::{Leaf, Leaves, MAX_LEVEL_STEP};
use super::patches::{PatchState, Patches};
use super::selection::{PatchKey, Selection, Viewpoint, neighbours, units_log2};
use super::skyline::Skyline;
use crate::pyramid::TileAddress;
use crate::pyramid::surface::bicubic::OVERSHOOT;
use crate::pyramid::surface::occluder_minima::{BLOCK_SAMPLES, TILE_BLOCKS};
use crate::pyramid::surface::statistics::{PatchStatistics, Voids};
use crate::pyramid::tile::PATCH_QUADS;
use crate::scene::frustum::Bounds;

/// Steps between two levels to which a patch's fractional level (for geomorphing) is rounded: enough to be smooth, few
/// enough for differences of levels to be exact in f32.
const LEVEL_STEPS: f64 = 4096.0;
/// Patches are not split if their quads are narrower than this fraction of the allowed error: horizontally the land is
/// then accurate to that width, however steep it is.
const FINEST_QUAD: f64 = 0.25;
/// Larger errors are clamped to this, in metres: an infinite error would never be small enough.
const LARGEST_ERROR_M: f64 = 1e38;
/// Number of patches that may be visited for each patch that may be selected.
const VISITS_PER_PATCH: usize = 16;

/// A walk in progress: its inputs, and the patches selected and the skyline so far.
pub(super) struct Walk<'a> {
    patches: &'a dyn Patches,
    grid_projection: &'a GridProjection,
    viewpoint: &'a Viewpoint,
    /// The lowest level, 0 or negative: its patches have a vertex at every grid unit, of which a sample has 2ⁿ
    /// ([`units_log2`]).
    finest_level: i32,
    leaves: Leaves,
    /// Leaves that may not be split: their children are not loaded, or a neighbour that cannot be split would then be
    /// too coarse for them.
    pinned: FxHashSet<PatchKey>,
    /// The skyline of the patches selected so far.
    skyline: Skyline,
    spacing_m: f64,
    /// The largest number of patches.
    max_patches: usize,
    visits: usize,
}

/// The errors of a patch's parent, between which the patch morphs out of its parent's shape.
#[derive(Clone, Copy)]
pub(super) struct ParentError {
    /// The allowed error at the parent's distance.
    allowed_m: f64,
    /// The visible error, from [`Walk::visible_error_m`].
    visible_m: f64,
}

impl ParentError {
    /// For a patch that does not morph out of its parent's shape.
    pub(super) const NONE: Self = Self { allowed_m: f64::INFINITY, visible_m: 0.0 };
}

/// A patch that may be drawn.
struct VisiblePatch {
    key: PatchKey,
    statistics: PatchStatistics,
    bounds: Bounds,
    /// Number of levels, 0 to 1, by which it is drawn coarser than its own level while it fades in.
    coarser_by: f64,
}

impl<'a> Walk<'a> {
    /// Creates a walk that has selected nothing. It ends early if it would select more than `max_patches`.
    pub(super) fn new(
        patches: &'a dyn Patches,
        grid_projection: &'a GridProjection,
        viewpoint: &'a Viewpoint,
        max_patches: usize,
    ) -> Self {
        Self {
            patches,
            grid_projection,
            viewpoint,
            finest_level: -units_log2(patches.size()),
            leaves: Leaves::new(patches.strides() as i32 - 1),
            pinned: FxHashSet::default(),
            skyline: Skyline::new(viewpoint.focal_px),
            spacing_m: grid_projection.spacing_m(),
            max_patches,
            visits: 0,
        }
    }

    /// Returns whether the walk exceeded the largest number of patches, selected or visited. The selection is then
    /// incomplete, and callers discard it.
    pub(super) fn has_exceeded_limit(&self) -> bool {
        self.leaves.len() > self.max_patches || self.visits / VISITS_PER_PATCH > self.max_patches
    }

    /// Selects from a patch and its descendants.
    pub(super) fn visit(&mut self, key: PatchKey, parent: ParentError) {
        self.visits += 1;
        if self.has_exceeded_limit() {
            return;
        }
        if let Some(patch) = self.visible(key).filter(|patch| !self.skyline.hides(&patch.bounds)) {
            self.visit_visible(&patch, parent);
        }
    }

    fn visit_visible(&mut self, patch: &VisiblePatch, parent: ParentError) {
        let allowed_m = self.allowed_m(patch);
        let visible_m = self.visible_error_m(patch);
        if visible_m > allowed_m && patch.key.level > self.finest_level {
            if self.request_children(patch.key, visible_m / allowed_m) {
                for child in self.nearest_first(patch.key.children()) {
                    self.visit(child, ParentError { allowed_m, visible_m });
                }
                return;
            }
            self.pinned.insert(patch.key);
        }
        self.add_leaf(patch, parent);
        let error_m = self.mesh_error_m(patch.key);
        if patch.statistics.voids == Voids::None && self.viewpoint.is_above_ground {
            // As drawn, between its own level and its parent's, the patch may be below the land by the errors of both.
            self.add_to_skyline(patch, 2.0 * allowed_m.max(error_m));
        }
    }

    /// Adds a patch to the skyline, lowered by `slack_m`.
    fn add_to_skyline(&mut self, patch: &VisiblePatch, slack_m: f64) {
        let key = patch.key;
        let (first, side) = key.area();
        let size = self.patches.size();
        let last = DVec2::new(f64::from(size.width - 1), f64::from(size.height - 1));
        let parts = self.skyline.parts(&patch.bounds);
        let corner = |x: usize, y: usize| {
            let grid = (first + DVec2::new(x as f64, y as f64) * (side / parts as f64)).min(last);
            self.grid_projection.world_from_grid(grid) - self.viewpoint.camera_m.truncate()
        };
        // Corners of the parts, relative to the camera; there are at most 4 × 4 parts.
        let grid_corners: [[DVec2; 5]; 5] =
            std::array::from_fn(|y| std::array::from_fn(|x| corner(x.min(parts), y.min(parts))));
        let relief_m = f64::from(patch.statistics.max_m - patch.statistics.min_m);
        let lowest_m = f64::from(patch.statistics.min_m) - f64::from(OVERSHOOT) * relief_m;
        for (x, y) in (0..parts).flat_map(|y| (0..parts).map(move |x| (x, y))) {
            let corners =
                [grid_corners[y][x], grid_corners[y + 1][x + 1], grid_corners[y][x + 1], grid_corners[y + 1][x]];
            let land_m = self.part_minimum_m(key, parts, x, y).map_or(lowest_m, |minimum_m| lowest_m.max(minimum_m));
            let z_m = land_m - slack_m - self.viewpoint.camera_m.z;
            let low_m = corners.into_iter().fold(DVec2::INFINITY, DVec2::min).extend(z_m);
            let high_m = corners.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max).extend(z_m);
            if let Some(bent) = self.viewpoint.earth_curvature.bend_bounds(&Bounds { low_m, high_m }) {
                self.skyline.add(&bent, corners, bent.low_m.z);
            }
        }
    }

    /// Returns a lower bound of the land's height in one of `parts` × `parts` parts of a patch, in metres; `None` if
    /// its tile is not loaded.
    fn part_minimum_m(&self, key: PatchKey, parts: usize, x: usize, y: usize) -> Option<f64> {
        let level = key.level.max(0);
        // A patch covers 4 × 4 blocks of its level, or, if it is finer than the data, less than one of level 0.
        let blocks = i64::from(PATCH_QUADS / BLOCK_SAMPLES);
        // First and last block of a part along one axis.
        let span = |patch: i64, part: usize| {
            let (parts, part) = (parts as i64, part as i64);
            let begin = |part: i64| patch * blocks * parts + part * blocks;
            let block = |position: i64| (position >> (level - key.level)).div_euclid(parts);
            (block(begin(part)), block(begin(part + 1) - 1))
        };
        let ((left, right), (top, bottom)) = (span(key.x, x), span(key.y, y));
        // A patch is in one tile, so all blocks are.
        let tile = |block: i64| u32::try_from(block / i64::from(TILE_BLOCKS)).ok();
        let address = TileAddress { level: level as u32, x: tile(left)?, y: tile(top)? };
        let occluder_minima = self.patches.occluder_minima(address)?;
        let inside = |block: i64| (block % i64::from(TILE_BLOCKS)) as u32;
        let mut minimum_m = f32::INFINITY;
        for (x, y) in (top..=bottom).flat_map(|y| (left..=right).map(move |x| (x, y))) {
            minimum_m = minimum_m.min(occluder_minima.get(inside(x), inside(y)));
        }
        Some(minimum_m.into())
    }

    /// Sorts patches from near to far, because near patches hide far ones.
    fn nearest_first(&self, mut patches: [PatchKey; 4]) -> [PatchKey; 4] {
        let camera = self.grid_projection.grid_from_world(self.viewpoint.camera_m.truncate());
        patches.sort_by(|a, b| {
            let distance = |key: &PatchKey| {
                let (first, side) = key.area();
                (camera.clamp(first, first + side) - camera).length_squared()
            };
            distance(a).total_cmp(&distance(b))
        });
        patches
    }

    /// Returns the allowed error at a patch's distance.
    fn allowed_m(&self, patch: &VisiblePatch) -> f64 {
        self.viewpoint.error_px * self.distance_m(patch) / self.viewpoint.focal_px
    }

    /// Returns whether the children of a patch are loaded, so that it can be split; requests their tile if not.
    fn request_children(&self, key: PatchKey, urgency: f64) -> bool {
        key.children().into_iter().all(|child| match self.state(child) {
            PatchState::Loaded { .. } | PatchState::Absent => true,
            PatchState::NotLoaded => {
                // All children of a patch come with the same tile.
                self.patches.request(child.level.max(0) as u32, child.x as u32, child.y as u32, urgency);
                false
            }
        })
    }

    /// Returns a patch if it exists, is loaded, has data, and may be in view.
    fn visible(&self, key: PatchKey) -> Option<VisiblePatch> {
        let PatchState::Loaded { statistics, coarser_by } = self.state(key) else { return None };
        let bounds = self.bounds(key, &statistics)?;
        let is_visible =
            statistics.voids != Voids::All && self.viewpoint.frusta.iter().any(|view| view.may_see(&bounds));
        // Patches finer than the data have nothing to load.
        let coarser_by = if key.level < 0 { 0.0 } else { coarser_by };
        is_visible.then_some(VisiblePatch { key, statistics, bounds, coarser_by })
    }

    fn state(&self, key: PatchKey) -> PatchState {
        let up = (-key.level).max(0);
        let (Ok(x), Ok(y)) = (u32::try_from(key.x >> up), u32::try_from(key.y >> up)) else {
            return PatchState::Absent;
        };
        self.patches.patch(key.level.max(0) as u32, x, y)
    }

    /// Returns the largest vertical distance between a patch's mesh and the land, in metres.
    fn mesh_error_m(&self, key: PatchKey) -> f64 {
        let PatchState::Loaded { statistics, .. } = self.state(key) else { return 0.0 };
        // Halving the quads of a smooth surface quarters the error.
        let error_m = f64::from(statistics.mesh_error_m) * f64::from(2 * key.level.min(0)).exp2();
        // A quad is flat and the earth is curved: add the sagitta of its diagonal.
        let quad_m = self.quad_m(key);
        (error_m + 0.25 * quad_m * quad_m * self.viewpoint.earth_curvature.inverse_radius).min(LARGEST_ERROR_M)
    }

    /// Returns the width of a patch's quads.
    fn quad_m(&self, key: PatchKey) -> f64 {
        self.spacing_m * f64::from(key.level).exp2()
    }

    /// Returns the mesh error of a patch, in metres, or less if its quads are narrow: between twice the width of
    /// [`FINEST_QUAD`] and that width the result fades to 0, so that no patch appears suddenly.
    fn visible_error_m(&self, patch: &VisiblePatch) -> f64 {
        let quad_px = self.quad_m(patch.key) * self.viewpoint.focal_px / self.distance_m(patch);
        let finest_px = FINEST_QUAD * self.viewpoint.error_px;
        self.mesh_error_m(patch.key) * (quad_px / finest_px - 1.0).clamp(0.0, 1.0)
    }

    /// Returns a lower bound of the distance from the camera to a patch.
    fn distance_m(&self, patch: &VisiblePatch) -> f64 {
        patch.bounds.distance_m().max(self.viewpoint.nearest_m)
    }

    /// Returns the camera-relative box of a patch; `None` if it is beyond the last sample.
    fn bounds(&self, key: PatchKey, statistics: &PatchStatistics) -> Option<Bounds> {
        let (first, side) = key.area();
        let size = self.patches.size();
        let last = DVec2::new(f64::from(size.width - 1), f64::from(size.height - 1));
        if first.cmpge(last).any() {
            return None;
        }
        let end = (first + side).min(last);
        let (low, high) = self.grid_projection.bounds(first, end);
        // The surface may exceed its samples.
        let relief_m = f64::from(statistics.max_m - statistics.min_m);
        let camera_m = self.viewpoint.camera_m;
        let low_m = low.extend(f64::from(statistics.min_m) - f64::from(OVERSHOOT) * relief_m) - camera_m;
        let high_m = high.extend(f64::from(statistics.max_m) + f64::from(OVERSHOOT) * relief_m) - camera_m;
        self.viewpoint.earth_curvature.bend_bounds(&Bounds { low_m, high_m })
    }

    /// Adds a patch to the selection, morphed toward its parent's shape as far as the error that is allowed there
    /// permits.
    fn add_leaf(&mut self, patch: &VisiblePatch, parent: ParentError) {
        let key = patch.key;
        let own_m = self.visible_error_m(patch);
        // 0 is the patch's own shape, 1 its parent's: the errors of both are interpolated to the allowed one.
        let morph = if parent.allowed_m.is_finite() && parent.visible_m > own_m {
            ((parent.allowed_m - own_m) / (parent.visible_m - own_m)).clamp(0.0, 1.0)
        } else {
            0.0
        };
        // In steps that f32 represents exactly: the two patches at an edge compute the same level from their own
        // levels, and must get bit-identical vertices.
        let level = f64::from(key.level) + (morph.max(patch.coarser_by) * LEVEL_STEPS).round() / LEVEL_STEPS;
        let distance_m = self.distance_m(patch);
        let (farthest_m, holes) = (patch.bounds.farthest_m(), patch.statistics.voids != Voids::None);
        self.leaves.insert(key, Leaf { distance_m, farthest_m, level, holes });
    }

    /// Splits leaves that are more than [`MAX_LEVEL_STEP`] coarser than a neighbour; where one cannot be split, merges
    /// its neighbours instead.
    pub(super) fn limit_steps(&mut self) {
        loop {
            let too_far_apart: Vec<_> = self
                .leaves
                .keys()
                .flat_map(|key| neighbours(key).map(move |neighbour| (key, neighbour)))
                .filter_map(|(key, neighbour)| {
                    let (coarse, _) = self.leaves.covering(neighbour)?;
                    (coarse.level > key.level + MAX_LEVEL_STEP).then_some((key, coarse))
                })
                .collect();
            if too_far_apart.is_empty() || self.has_exceeded_limit() {
                return;
            }
            for (fine, coarse) in too_far_apart {
                // The same leaf may be in the list twice.
                if !self.leaves.contains(coarse) || !self.leaves.contains(fine) {
                    continue;
                }
                if self.pinned.contains(&coarse) || !self.request_children(coarse, 1.0) {
                    self.pinned.insert(coarse);
                    self.merge(fine, coarse.level - MAX_LEVEL_STEP);
                    continue;
                }
                self.leaves.remove(coarse);
                // The error of `coarse` did not require the split, so its children morph out of its shape, as after an
                // ordinary split.
                let parent = self.visible(coarse).map_or(ParentError::NONE, |patch| {
                    // A patch whose error is invisible still has a shape of its own.
                    let smallest_visible_m = if self.mesh_error_m(coarse) > 0.0 { f64::MIN_POSITIVE } else { 0.0 };
                    let visible_m = self.visible_error_m(&patch).max(smallest_visible_m);
                    ParentError { allowed_m: self.allowed_m(&patch), visible_m }
                });
                for child in coarse.children() {
                    if let Some(patch) = self.visible(child) {
                        self.add_leaf(&patch, parent);
                    }
                }
            }
        }
    }

    /// Replaces a leaf, and all others under its ancestor at `level`, by that ancestor.
    fn merge(&mut self, mut key: PatchKey, level: i32) {
        while key.level < level {
            key = key.parent();
        }
        self.leaves.remove_under(key);
        self.pinned.insert(key);
        if let Some(patch) = self.visible(key) {
            self.add_leaf(&patch, ParentError::NONE);
        }
    }

    /// Returns the selection, with positions relative to `anchor`.
    pub(super) fn finish(self, anchor: DVec2) -> Selection {
        self.leaves.instances(anchor, -self.finest_level)
    }
}
