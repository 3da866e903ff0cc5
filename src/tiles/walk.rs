//! The walk through the quadtree of patches that makes a [`Selection`]: from near to far, splitting patches whose error
//! would be visible, skipping those that are hidden behind nearer land.

use glam::DVec2;
use rustc_hash::FxHashSet;

use super::grid_projection::GridProjection;
use super::leaves::{Leaf, Leaves, MAX_LEVEL_STEP};
use super::patches::{Known, Patches};
use super::selection::{PatchKey, Selection, Viewpoint, neighbours, units_log2};
use super::skyline::Skyline;
use crate::pyramid::TileAddress;
use crate::pyramid::surface::bicubic::OVERSHOOT;
use crate::pyramid::surface::occluder_minima::{BLOCK_SAMPLES, TILE_BLOCKS};
use crate::pyramid::surface::statistics::{PatchStatistics, Voids};
use crate::pyramid::tile::PATCH_QUADS;
use crate::scene::frustum::Bounds;

/// Number of steps of a continuous level: enough to be smooth, few enough for differences of levels to be exact in f32.
const LEVEL_STEPS: f64 = 4096.0;
/// Quads no wider than this fraction of the allowed error in height are not split: the position of land is then
/// accurate to a fraction of that error sideways, however steep it is.
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
    /// The level whose patches have a vertex at every grid unit.
    finest_level: i32,
    leaves: Leaves,
    /// Leaves that may not be split, because their children are not loaded, or because they limit the level step to
    /// such a leaf.
    pinned: FxHashSet<PatchKey>,
    /// The skyline of the patches selected so far.
    skyline: Skyline,
    spacing_m: f64,
    /// The largest number of patches.
    most_patches: usize,
    visits: usize,
}

/// The allowed and the visible error of a patch's parent.
#[derive(Clone, Copy)]
pub(super) struct Over {
    allowed_m: f64,
    /// Visible error in metres, from [`Walk::shown_error_m`].
    error_m: f64,
}

impl Over {
    /// The parent of a patch that begins in its own shape.
    pub(super) const NONE: Self = Self { allowed_m: f64::INFINITY, error_m: 0.0 };
}

/// A patch that may be drawn.
struct VisiblePatch {
    key: PatchKey,
    statistics: PatchStatistics,
    bounds: Bounds,
    /// Number of levels by which it stays above its own level while it fades in.
    above: f64,
}

impl<'a> Walk<'a> {
    /// Creates a walk that has selected nothing. It ends early if it would select more than `most_patches`.
    pub(super) fn new(
        patches: &'a dyn Patches,
        grid_projection: &'a GridProjection,
        viewpoint: &'a Viewpoint,
        most_patches: usize,
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
            most_patches,
            visits: 0,
        }
    }

    /// Returns whether the walk exceeded the largest number of patches, selected or visited, so that the selection is
    /// incomplete.
    pub(super) fn is_over(&self) -> bool {
        self.leaves.len() > self.most_patches || self.visits / VISITS_PER_PATCH > self.most_patches
    }

    /// Selects from a patch and its descendants.
    pub(super) fn visit(&mut self, key: PatchKey, parent: Over) {
        self.visits += 1;
        if self.is_over() {
            return;
        }
        if let Some(seen) = self.seen(key).filter(|seen| !self.skyline.hides(&seen.bounds)) {
            self.visit_seen(seen, parent);
        }
    }

    fn visit_seen(&mut self, seen: VisiblePatch, parent: Over) {
        let allowed_m = self.allowed_m(&seen);
        let shown_m = self.shown_error_m(&seen);
        if shown_m > allowed_m && seen.key.level > self.finest_level {
            if self.children_are_known(seen.key, shown_m / allowed_m) {
                for child in self.nearest_first(seen.key.children()) {
                    self.visit(child, Over { allowed_m, error_m: shown_m });
                }
                return;
            }
            self.pinned.insert(seen.key);
        }
        self.add_leaf(&seen, parent);
        let error_m = self.mesh_error_m(seen.key);
        if seen.statistics.voids == Voids::None && self.viewpoint.is_above_ground {
            // The patch as drawn may be below the land by its error, on either level.
            self.close(&seen, 2.0 * allowed_m.max(error_m));
        }
    }

    /// Adds a patch to the skyline.
    fn close(&mut self, seen: &VisiblePatch, slack_m: f64) {
        let key = seen.key;
        let (first, side) = key.area();
        let size = self.patches.size();
        let last = DVec2::new(f64::from(size.width - 1), f64::from(size.height - 1));
        let parts = self.skyline.parts(&seen.bounds);
        let place = |x: usize, y: usize| {
            let grid = (first + DVec2::new(x as f64, y as f64) * (side / parts as f64)).min(last);
            self.grid_projection.world_from_grid(grid) - self.viewpoint.camera_m.truncate()
        };
        let places: [[DVec2; 5]; 5] =
            std::array::from_fn(|y| std::array::from_fn(|x| place(x.min(parts), y.min(parts))));
        let relief_m = f64::from(seen.statistics.max_m - seen.statistics.min_m);
        let lowest_m = f64::from(seen.statistics.min_m) - f64::from(OVERSHOOT) * relief_m;
        for (x, y) in (0..parts).flat_map(|y| (0..parts).map(move |x| (x, y))) {
            let corners = [places[y][x], places[y + 1][x + 1], places[y][x + 1], places[y + 1][x]];
            let land_m = self.low_m(key, parts, x, y).map_or(lowest_m, |low_m| lowest_m.max(low_m));
            let z_m = land_m - slack_m - self.viewpoint.camera_m.z;
            let low_m = corners.into_iter().fold(DVec2::INFINITY, DVec2::min).extend(z_m);
            let high_m = corners.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max).extend(z_m);
            if let Some(bent) = self.viewpoint.earth_curvature.bend_bounds(&Bounds { low_m, high_m }) {
                self.skyline.add(&bent, corners, bent.low_m.z);
            }
        }
    }

    /// Returns a lower bound of the land's height in one of `parts` × `parts` parts of a patch, in metres.
    fn low_m(&self, key: PatchKey, parts: usize, x: usize, y: usize) -> Option<f64> {
        let level = key.level.max(0);
        // In blocks of the level, of which a patch covers 4 × 4 or, finer than the data, less than one.
        let blocks = i64::from(PATCH_QUADS / BLOCK_SAMPLES);
        let span = |patch: i64, part: usize| {
            let (parts, part) = (parts as i64, part as i64);
            let begin = |part: i64| patch * blocks * parts + part * blocks;
            let block = |place: i64| (place >> (level - key.level)).div_euclid(parts);
            (block(begin(part)), block(begin(part + 1) - 1))
        };
        let ((left, right), (top, bottom)) = (span(key.x, x), span(key.y, y));
        let tile = |block: i64| u32::try_from(block / i64::from(TILE_BLOCKS)).ok();
        let address = TileAddress { level: level as u32, x: tile(left)?, y: tile(top)? };
        let occluder_minima = self.patches.occluder_minima(address)?;
        let inside = |block: i64| (block % i64::from(TILE_BLOCKS)) as u32;
        let mut low_m = f32::INFINITY;
        for (x, y) in (top..=bottom).flat_map(|y| (left..=right).map(move |x| (x, y))) {
            low_m = low_m.min(occluder_minima.get(inside(x), inside(y)));
        }
        Some(low_m.into())
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

    fn allowed_m(&self, seen: &VisiblePatch) -> f64 {
        self.viewpoint.error_px * self.distance_m(seen) / self.viewpoint.focal_px
    }

    /// Returns whether a patch can be split; if not, requests the missing tile.
    fn children_are_known(&self, key: PatchKey, urgency: f64) -> bool {
        key.children().into_iter().all(|child| match self.known(child) {
            Known::Patch { .. } | Known::Nothing => true,
            Known::Missing => {
                // All children of a patch come with the same tile.
                self.patches.request(child.level.max(0) as u32, child.x as u32, child.y as u32, urgency);
                false
            }
        })
    }

    /// Returns a patch if it exists, is loaded, has data, and may be in view.
    fn seen(&self, key: PatchKey) -> Option<VisiblePatch> {
        let Known::Patch { statistics, above } = self.known(key) else { return None };
        let bounds = self.bounds(key, &statistics)?;
        let seen = statistics.voids != Voids::All && self.viewpoint.frusta.iter().any(|view| view.may_see(&bounds));
        // Patches finer than the data have nothing to load.
        let above = if key.level < 0 { 0.0 } else { above };
        seen.then_some(VisiblePatch { key, statistics, bounds, above })
    }

    fn known(&self, key: PatchKey) -> Known {
        let up = (-key.level).max(0);
        let (Ok(x), Ok(y)) = (u32::try_from(key.x >> up), u32::try_from(key.y >> up)) else { return Known::Nothing };
        self.patches.patch(key.level.max(0) as u32, x, y)
    }

    fn mesh_error_m(&self, key: PatchKey) -> f64 {
        let Known::Patch { statistics, .. } = self.known(key) else { return 0.0 };
        // Halving the quads of a smooth surface quarters the error.
        let error_m = f64::from(statistics.mesh_error_m) * f64::from(2 * key.level.min(0)).exp2();
        // A quad is flat and the earth is curved: add the sagitta of its diagonal.
        let quad_m = self.quad_m(key);
        (error_m + 0.25 * quad_m * quad_m * self.viewpoint.earth_curvature.inverse_radius).min(LARGEST_ERROR_M)
    }

    fn quad_m(&self, key: PatchKey) -> f64 {
        self.spacing_m * f64::from(key.level).exp2()
    }

    /// Returns the mesh error of a patch, in metres, limited as described at [`FINEST_QUAD`]: from twice that width on
    /// the error fades out, so that no patch appears suddenly.
    fn shown_error_m(&self, seen: &VisiblePatch) -> f64 {
        let quad_px = self.quad_m(seen.key) * self.viewpoint.focal_px / self.distance_m(seen);
        let finest_px = FINEST_QUAD * self.viewpoint.error_px;
        self.mesh_error_m(seen.key) * (quad_px / finest_px - 1.0).clamp(0.0, 1.0)
    }

    fn distance_m(&self, seen: &VisiblePatch) -> f64 {
        seen.bounds.distance_m().max(self.viewpoint.nearest_m)
    }

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

    fn add_leaf(&mut self, seen: &VisiblePatch, parent: Over) {
        let key = seen.key;
        let own_m = self.shown_error_m(seen);
        let way = if parent.allowed_m.is_finite() && parent.error_m > own_m {
            ((parent.allowed_m - own_m) / (parent.error_m - own_m)).clamp(0.0, 1.0)
        } else {
            0.0
        };
        // In steps that f32 represents exactly: the two patches at an edge compute the same level from their own
        // levels, and must get bit-identical vertices.
        let level = f64::from(key.level) + (way.max(seen.above) * LEVEL_STEPS).round() / LEVEL_STEPS;
        let distance_m = self.distance_m(seen);
        let (farthest_m, holes) = (seen.bounds.farthest_m(), seen.statistics.voids != Voids::None);
        self.leaves.insert(key, Leaf { distance_m, farthest_m, level, holes });
    }

    /// Splits leaves whose neighbours are too much finer than themselves; where one cannot be split, its neighbours are
    /// merged instead.
    pub(super) fn limit_steps(&mut self) {
        loop {
            let too_far_apart: Vec<_> = self
                .leaves
                .keys()
                .flat_map(|key| neighbours(key).map(move |neighbour| (key, neighbour)))
                .filter_map(|(key, neighbour)| {
                    let (coarse, _) = self.leaves.over(neighbour)?;
                    (coarse.level > key.level + MAX_LEVEL_STEP).then_some((key, coarse))
                })
                .collect();
            if too_far_apart.is_empty() || self.is_over() {
                return;
            }
            for (fine, coarse) in too_far_apart {
                // The same leaf may be in the list twice.
                if !self.leaves.contains(coarse) || !self.leaves.contains(fine) {
                    continue;
                }
                if self.pinned.contains(&coarse) || !self.children_are_known(coarse, 1.0) {
                    self.pinned.insert(coarse);
                    self.merge(fine, coarse.level - MAX_LEVEL_STEP);
                    continue;
                }
                self.leaves.remove(coarse);
                // Its error did not require the split, so its children begin in its shape, as after an ordinary split.
                let over = self.seen(coarse).map_or(Over::NONE, |seen| {
                    // A patch whose error is invisible still has a shape of its own.
                    let least_m = if self.mesh_error_m(coarse) > 0.0 { f64::MIN_POSITIVE } else { 0.0 };
                    Over { allowed_m: self.allowed_m(&seen), error_m: self.shown_error_m(&seen).max(least_m) }
                });
                for child in coarse.children() {
                    if let Some(seen) = self.seen(child) {
                        self.add_leaf(&seen, over);
                    }
                }
            }
        }
    }

    /// Replaces a leaf, and all others under the same ancestor, by that ancestor.
    fn merge(&mut self, mut key: PatchKey, level: i32) {
        while key.level < level {
            key = key.parent();
        }
        self.leaves.remove_under(key);
        self.pinned.insert(key);
        if let Some(seen) = self.seen(key) {
            self.add_leaf(&seen, Over::NONE);
        }
    }

    /// Returns the selection, at positions relative to `anchor`.
    pub(super) fn finish(self, anchor: DVec2) -> Selection {
        self.leaves.instances(anchor, -self.finest_level)
    }
}
