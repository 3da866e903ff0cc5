//! The walk through the quadtree of patches that makes a [`Selection`]: from near to far, splitting patches whose error
//! would be visible, skipping those that are hidden behind nearer land.

mod occluders;

use glam::DVec2;

use super::grid_projection::GridProjection;
use super::patch_tree::{NodeId, PatchTree};
use super::patches::{PatchState, Patches};
use super::selection::{PatchInstance, PatchKey, Selection, Viewpoint, patch_id, units_log2};
use super::skyline::Skyline;
use crate::pyramid::surface::statistics::{PatchStatistics, Voids};
use crate::scene::frustum::Bounds;

/// Largest difference in level between neighbours: 2^3 < 16 quads.
const MAX_LEVEL_STEP: i32 = 3;
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

/// A patch that is drawn.
#[derive(Clone, Copy)]
struct Leaf {
    node: NodeId,
    key: PatchKey,
    /// Distances from the camera to the nearest and the farthest point of its box, in metres.
    distance_m: f64,
    farthest_m: f64,
    /// The continuous level of detail, in levels of the pyramid.
    level: f64,
    /// Whether it has no-data samples.
    holes: bool,
    /// Whether it has been split or merged after all.
    is_removed: bool,
    /// The leaf across each side, if one covers all of it; known when the steps are limited.
    across: [Option<u32>; 4],
}

/// A walk in progress: its inputs, and the patches selected and the skyline so far.
pub(super) struct Walk<'a> {
    tree: &'a mut PatchTree,
    patches: &'a dyn Patches,
    grid_projection: &'a GridProjection,
    viewpoint: &'a Viewpoint,
    /// The camera's position on the grid, in samples.
    camera: DVec2,
    /// The lowest level, 0 or negative: its patches have a vertex at every grid unit, of which a sample has 2ⁿ
    /// ([`units_log2`]).
    finest_level: i32,
    /// The leaves, also those that have been removed.
    leaves: Vec<Leaf>,
    removed: usize,
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
    node: NodeId,
    key: PatchKey,
    statistics: PatchStatistics,
    bounds: Bounds,
    /// A lower bound of its distance from the camera, in metres.
    distance_m: f64,
    /// The largest vertical distance between its mesh and the land, in metres.
    mesh_error_m: f64,
    /// Number of levels, 0 to 1, by which it is drawn coarser than its own level while it fades in.
    coarser_by: f64,
}

impl<'a> Walk<'a> {
    /// Creates a walk that has selected nothing, with the root of the quadtree. It ends early if it would select more
    /// than `max_patches`. A layered skyline knows the distances of its land.
    pub(super) fn new(
        tree: &'a mut PatchTree,
        patches: &'a dyn Patches,
        grid_projection: &'a GridProjection,
        viewpoint: &'a Viewpoint,
        max_patches: usize,
        is_layered: bool,
    ) -> (Self, NodeId) {
        let root = tree.begin(patches.strides() as i32 - 1);
        let skyline = tree.empty_skyline(viewpoint.focal_px, is_layered);
        let walk = Self {
            tree,
            patches,
            grid_projection,
            viewpoint,
            camera: grid_projection.grid_from_world(viewpoint.camera_m.truncate()),
            finest_level: -units_log2(patches.size()),
            leaves: Vec::new(),
            removed: 0,
            skyline,
            spacing_m: grid_projection.spacing_m(),
            max_patches,
            visits: 0,
        };
        (walk, root)
    }

    /// Returns whether the walk exceeded the largest number of patches, selected or visited. The selection is then
    /// incomplete, and callers discard it.
    pub(super) fn has_exceeded_limit(&self) -> bool {
        self.leaves.len() - self.removed > self.max_patches || self.visits / VISITS_PER_PATCH > self.max_patches
    }

    /// Selects from a patch and its descendants.
    pub(super) fn visit(&mut self, node: NodeId, parent: ParentError) {
        self.visits += 1;
        if self.has_exceeded_limit() {
            return;
        }
        if let Some(patch) = self.visible(node).filter(|patch| !self.skyline.hides(&patch.bounds)) {
            self.visit_visible(&patch, parent);
        }
    }

    fn visit_visible(&mut self, patch: &VisiblePatch, parent: ParentError) {
        let allowed_m = self.allowed_m(patch);
        let visible_m = self.visible_error_m(patch);
        if visible_m > allowed_m && patch.key.level > self.finest_level {
            if self.request_children(patch.node, visible_m / allowed_m) {
                for child in self.nearest_first(patch.node) {
                    self.visit(child, ParentError { allowed_m, visible_m });
                }
                return;
            }
            self.tree.pin(patch.node);
        }
        self.add_leaf(patch, parent);
        if patch.statistics.voids == Voids::None && self.viewpoint.is_above_ground {
            // As drawn, between its own level and its parent's, the patch may be below the land by the errors of both.
            self.add_to_skyline(patch, 2.0 * allowed_m.max(patch.mesh_error_m));
        }
    }

    /// Returns the children of a patch from near to far, because near patches hide far ones.
    fn nearest_first(&mut self, node: NodeId) -> [NodeId; 4] {
        let (first, side) = self.tree.key(node).area();
        let half = 0.5 * side;
        let children = self.tree.children(node);
        let distance = |i: usize| {
            let low = first + DVec2::new((i % 2) as f64, (i / 2) as f64) * half;
            (self.camera.clamp(low, low + half) - self.camera).length_squared()
        };
        let distances: [f64; 4] = std::array::from_fn(distance);
        let mut order = [0, 1, 2, 3];
        order.sort_by(|a, b| distances[*a].total_cmp(&distances[*b]));
        order.map(|i| children[i])
    }

    /// Returns the allowed error at a patch's distance.
    fn allowed_m(&self, patch: &VisiblePatch) -> f64 {
        self.viewpoint.error_px * patch.distance_m / self.viewpoint.focal_px
    }

    /// Returns whether the children of a patch are loaded, so that it can be split; requests their tile if not.
    fn request_children(&mut self, node: NodeId, urgency: f64) -> bool {
        self.tree.children(node).into_iter().all(|child| {
            match self.tree.state(child, self.patches, self.grid_projection) {
                PatchState::Loaded { .. } | PatchState::Absent => true,
                PatchState::NotLoaded => {
                    // All children of a patch come with the same tile.
                    let key = self.tree.key(child);
                    self.patches.request(key.level.max(0) as u32, key.x as u32, key.y as u32, urgency);
                    false
                }
            }
        })
    }

    /// Returns a patch if it exists, is loaded, has data, and may be in view.
    fn visible(&mut self, node: NodeId) -> Option<VisiblePatch> {
        let PatchState::Loaded { statistics, arrival } = self.tree.state(node, self.patches, self.grid_projection)
        else {
            return None;
        };
        let box_m = self.tree.box_m(node)?;
        let camera_m = self.viewpoint.camera_m;
        let flat = Bounds { low_m: box_m.low_m - camera_m, high_m: box_m.high_m - camera_m };
        let bounds = self.viewpoint.earth_curvature.bend_bounds(&flat)?;
        if statistics.voids == Voids::All || !self.viewpoint.frusta.iter().any(|view| view.may_see(&bounds)) {
            return None;
        }
        let key = self.tree.key(node);
        let distance_m = bounds.distance_m().max(self.viewpoint.nearest_m);
        // Patches finer than the data have nothing to load.
        let coarser_by = if key.level < 0 { 0.0 } else { self.patches.coarser_by(&arrival) };
        let mesh_error_m = self.mesh_error_m(key, &statistics);
        Some(VisiblePatch { node, key, statistics, bounds, distance_m, mesh_error_m, coarser_by })
    }

    /// Returns the largest vertical distance between a patch's mesh and the land, in metres.
    fn mesh_error_m(&self, key: PatchKey, statistics: &PatchStatistics) -> f64 {
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
        let quad_px = self.quad_m(patch.key) * self.viewpoint.focal_px / patch.distance_m;
        let finest_px = FINEST_QUAD * self.viewpoint.error_px;
        patch.mesh_error_m * (quad_px / finest_px - 1.0).clamp(0.0, 1.0)
    }

    /// Adds a patch to the selection, morphed toward its parent's shape as far as the error that is allowed there
    /// permits.
    fn add_leaf(&mut self, patch: &VisiblePatch, parent: ParentError) {
        let own_m = self.visible_error_m(patch);
        // 0 is the patch's own shape, 1 its parent's: the errors of both are interpolated to the allowed one.
        let morph = if parent.allowed_m.is_finite() && parent.visible_m > own_m {
            ((parent.allowed_m - own_m) / (parent.visible_m - own_m)).clamp(0.0, 1.0)
        } else {
            0.0
        };
        // In steps that f32 represents exactly: the two patches at an edge compute the same level from their own
        // levels, and must get bit-identical vertices.
        let level = f64::from(patch.key.level) + (morph.max(patch.coarser_by) * LEVEL_STEPS).round() / LEVEL_STEPS;
        self.tree.set_leaf(patch.node, Some(self.leaves.len()));
        self.leaves.push(Leaf {
            node: patch.node,
            key: patch.key,
            distance_m: patch.distance_m,
            farthest_m: patch.bounds.farthest_m(),
            level,
            holes: patch.statistics.voids != Voids::None,
            is_removed: false,
            across: [None; 4],
        });
    }

    fn remove_leaf(&mut self, node: NodeId) {
        if let Some(leaf) = self.tree.leaf(node) {
            self.leaves[leaf].is_removed = true;
            self.removed += 1;
            self.tree.set_leaf(node, None);
        }
    }

    /// Splits leaves that are more than [`MAX_LEVEL_STEP`] coarser than a neighbour; where one cannot be split, merges
    /// its neighbours instead. Finds the leaves across the sides of each.
    pub(super) fn limit_steps(&mut self) {
        loop {
            let mut too_far_apart = Vec::new();
            for leaf in 0..self.leaves.len() {
                let Leaf { node, key, is_removed, .. } = self.leaves[leaf];
                for side in (0..4).filter(|_| !is_removed) {
                    let across = self.tree.leaf_across(node, side);
                    let index = across.and_then(|across| self.tree.leaf(across));
                    self.leaves[leaf].across[side] = index.map(|index| index as u32);
                    if let (Some(coarse), Some(index)) = (across, index)
                        && self.leaves[index].key.level > key.level + MAX_LEVEL_STEP
                    {
                        too_far_apart.push((node, coarse));
                    }
                }
            }
            if too_far_apart.is_empty() || self.has_exceeded_limit() {
                return;
            }
            for (fine, coarse) in too_far_apart {
                // The same leaf may be in the list twice.
                if self.tree.leaf(coarse).is_some() && self.tree.leaf(fine).is_some() {
                    self.bring_closer(fine, coarse);
                }
            }
        }
    }

    /// Splits a leaf that is too coarse for its neighbour, or merges the neighbour.
    fn bring_closer(&mut self, fine: NodeId, coarse: NodeId) {
        if self.tree.is_pinned(coarse) || !self.request_children(coarse, 1.0) {
            self.tree.pin(coarse);
            self.merge(fine, self.tree.key(coarse).level - MAX_LEVEL_STEP);
            return;
        }
        self.remove_leaf(coarse);
        // The error of `coarse` did not require the split, so its children morph out of its shape, as after an ordinary
        // split.
        let parent = self.visible(coarse).map_or(ParentError::NONE, |patch| {
            // A patch whose error is invisible still has a shape of its own.
            let smallest_visible_m = if patch.mesh_error_m > 0.0 { f64::MIN_POSITIVE } else { 0.0 };
            let visible_m = self.visible_error_m(&patch).max(smallest_visible_m);
            ParentError { allowed_m: self.allowed_m(&patch), visible_m }
        });
        for child in self.tree.children(coarse) {
            if let Some(patch) = self.visible(child) {
                self.add_leaf(&patch, parent);
            }
        }
    }

    /// Replaces a leaf, and all others under its ancestor at `level`, by that ancestor.
    fn merge(&mut self, leaf: NodeId, level: i32) {
        let mut ancestor = leaf;
        while self.tree.key(ancestor).level < level
            && let Some(parent) = self.tree.parent(ancestor)
        {
            ancestor = parent;
        }
        let key = self.tree.key(ancestor);
        for i in 0..self.leaves.len() {
            let Leaf { node, key: under, is_removed, .. } = self.leaves[i];
            let up = key.level - under.level;
            if !is_removed && up >= 0 && (under.x >> up, under.y >> up) == (key.x, key.y) {
                self.remove_leaf(node);
            }
        }
        self.tree.pin(ancestor);
        if let Some(patch) = self.visible(ancestor) {
            self.add_leaf(&patch, ParentError::NONE);
        }
    }

    /// Returns the leaves as the GPU draws them, from near to far, at positions relative to `anchor` in grid units, and
    /// the skyline of all of them.
    pub(super) fn finish(mut self, anchor: DVec2) -> (Selection, Skyline) {
        let units_log2 = -self.finest_level;
        let leaves = self.leaves.iter().enumerate().filter(|(_, leaf)| !leaf.is_removed);
        // Distances are positive, so their bits have their order. The key breaks ties, so that the order is deterministic.
        let mut order: Vec<(bool, u64, PatchKey, u32)> =
            leaves.map(|(i, leaf)| (leaf.holes, leaf.distance_m.to_bits(), leaf.key, i as u32)).collect();
        order.sort_unstable();
        let count = order.len();
        let mut selection = Selection {
            solid: Vec::with_capacity(count),
            with_holes: Vec::new(),
            leaves: Vec::with_capacity(count),
            distances_m: Vec::with_capacity(count),
            range_m: None,
        };
        for (.., leaf) in order {
            let leaf = self.leaves[leaf as usize];
            let (edge_levels, sides) = self.edges(&leaf);
            let (first, _) = leaf.key.area();
            let origin = (first - anchor) * f64::from(units_log2).exp2();
            let instance = PatchInstance {
                origin_units: [origin.x as i32, origin.y as i32],
                stride_exponent: (leaf.key.level + units_log2) as u32,
                id: patch_id(leaf.key),
                edge_levels,
                inner_level: (leaf.level - f64::from(leaf.key.level)) as f32,
                sides,
                has_holes: leaf.holes.into(),
                padding: 0.0,
            };
            if leaf.holes { &mut selection.with_holes } else { &mut selection.solid }.push(instance);
            selection.leaves.push(leaf.key);
            selection.distances_m.push([leaf.distance_m, leaf.farthest_m]);
            if let Some(box_m) = self.tree.box_m(leaf.node) {
                let [low_m, high_m] = [box_m.low_m.z, box_m.high_m.z];
                let range_m = selection.range_m.get_or_insert([low_m, high_m]);
                *range_m = [range_m[0].min(low_m), range_m[1].max(high_m)];
            }
        }
        self.skyline.finish();
        (selection, self.skyline)
    }

    /// Returns the levels of a leaf's four edges above its own level, and the set of those that it owns: of two leaves,
    /// the finer one owns their edge; of equals, the eastern and the southern one.
    fn edges(&mut self, leaf: &Leaf) -> ([f32; 4], u32) {
        let own = f64::from(leaf.key.level);
        let (mut edge_levels, mut sides) = ([0.0; 4], 0);
        for (side, edge_level) in edge_levels.iter_mut().enumerate() {
            let other = leaf.across[side].map(|other| self.leaves[other as usize]);
            *edge_level = (leaf.level.max(other.map_or(leaf.level, |other| other.level)) - own) as f32;
            let is_own = match other {
                Some(other) if other.key.level == leaf.key.level => side % 2 == 0,
                Some(_) => true,
                None => !self.tree.has_finer_leaf_across(leaf.node, side, MAX_LEVEL_STEP),
            };
            sides |= u32::from(is_own) << side;
        }
        (edge_levels, sides)
    }
}
