//! Which mesh patches are drawn, and how far each morphs: level of detail by measured error.
//!
//! A patch (level j, column x, row y) covers samples 16·2^j·x to 16·2^j·(x+1) with 16 × 16 quads; negative levels are
//! finer than the data and are evaluated, not loaded. A patch is split while its measured mesh error, seen from the
//! nearest point of its box, is more than the allowed error in pixels. What is left covers the view once.
//!
//! Each leaf has a continuous level: its own, plus how far it is on the way to its parent's error. At that way's end
//! all four siblings have the shape of their parent, so nothing pops. Where two leaves meet, both take the coarser of
//! their continuous levels on the shared edge (`shaders/surface/vertices.wgsl` morphs to it): there is no crack and no
//! rule that neighbours differ by one level at most. The only rule is that a leaf's corners exist on its neighbours'
//! levels, hence at most `MAX_LEVEL_STEP`.
//!
//! Patches are visited from near to far, and what is hidden behind nearer land (`horizon`) is left out.
//!
//! What is known of patches comes with tiles. Where it has not come yet, a patch stays whole; when it comes, the patch's
//! children begin in their parent's shape and fade in.

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};
use rustc_hash::{FxHashMap, FxHashSet};

use super::bending::Bending;
use super::frustum::{Bounds, Frustum};
use super::horizon::Horizon;
use super::patches::{Known, Patches};
use super::warp::Warp;
use crate::pyramid::statistics::{PatchStatistics, Voids};
use crate::pyramid::{LevelSize, PATCH_QUADS};

/// Log2 of the grid units in a sample: positions of vertices are whole numbers of these. 4096 to a sample, or fewer in
/// a world so wide that its patches would not fit into 31 bits.
pub fn units_log2(finest: LevelSize) -> i32 {
    let side = finest.width.max(finest.height).next_power_of_two();
    (30 - side.ilog2() as i32).min(12)
}

/// A neighbour may be this many levels coarser: 2^3 < 16 quads.
const MAX_LEVEL_STEP: i32 = 3;
/// Parts of a continuous level: enough to be smooth, few enough for a difference of levels in f32.
const LEVEL_STEPS: f64 = 4096.0;

/// Where in the quadtree of patches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct PatchKey {
    /// Log2 of samples between vertices; negative is finer than the data.
    pub level: i32,
    /// Column, in patches of this level.
    pub x: i64,
    /// Row.
    pub y: i64,
}

impl PatchKey {
    fn children(self) -> [Self; 4] {
        let child = |dx, dy| Self { level: self.level - 1, x: 2 * self.x + dx, y: 2 * self.y + dy };
        [child(0, 0), child(1, 0), child(0, 1), child(1, 1)]
    }

    fn parent(self) -> Self {
        Self { level: self.level + 1, x: self.x >> 1, y: self.y >> 1 }
    }

    /// First sample and side in samples.
    fn area(self) -> (DVec2, f64) {
        let side = f64::from(PATCH_QUADS) * f64::from(self.level).exp2();
        (DVec2::new(self.x as f64, self.y as f64) * side, side)
    }
}

/// `Patch` in `shaders/shared/patch.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable, PartialEq)]
pub struct PatchInstance {
    /// First sample, in grid units relative to the anchor.
    pub origin_units: [i32; 2],
    /// Log2 of the units between vertices.
    pub stride_exponent: u32,
    /// What the surface id target gets; never 0.
    pub id: u32,
    /// Levels above the patch's own at its first column, last column, first row, last row.
    pub edge_levels: [f32; 4],
    /// The same inside.
    pub inner_level: f32,
    pub(crate) padding: [f32; 3],
}

crate::gpu::shared::describe!(PatchInstance as "Patch" in "surface/vertices": origin_units, stride_exponent, id, edge_levels, inner_level, padding);

/// What the selection is made for.
#[derive(Clone, Debug)]
pub struct Viewpoint {
    /// In the world.
    pub camera_m: DVec3,
    /// What is in view; several eyes or parts of a picture each have one.
    pub frusta: Vec<Frustum>,
    /// Pixels per radian.
    pub focal_px: f64,
    /// Allowed mesh error.
    pub error_px: f64,
    /// The earth.
    pub bending: Bending,
    /// Whether near land hides far land: the camera stands above the ground. From below one sees through.
    pub is_above_ground: bool,
    /// No part of the surface is nearer than this: half the camera's height above ground.
    pub nearest_m: f64,
}

/// The patches of a frame.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Patches without holes, nearest first.
    pub solid: Vec<PatchInstance>,
    /// Patches that have void samples, nearest first.
    pub with_holes: Vec<PatchInstance>,
    /// The leaves in the order of `solid`, then `with_holes`.
    pub leaves: Vec<PatchKey>,
}

impl Selection {
    /// Triangles drawn.
    pub fn triangles(&self) -> u64 {
        (self.solid.len() + self.with_holes.len()) as u64 * 2 * u64::from(PATCH_QUADS) * u64::from(PATCH_QUADS)
    }
}

#[derive(Clone, Copy)]
struct Leaf {
    distance_m: f64,
    /// Continuous, absolute.
    level: f64,
    holes: bool,
}

/// Chooses the patches for a viewpoint.
pub fn select(patches: &dyn Patches, warp: &Warp, anchor: DVec2, viewpoint: &Viewpoint) -> Selection {
    let finest_level = -units_log2(patches.size());
    let mut walk = Walk {
        patches,
        warp,
        viewpoint,
        finest_level,
        leaves: FxHashMap::default(),
        pinned: FxHashSet::default(),
        horizon: Horizon::default(),
    };
    let top = patches.strides() as i32 - 1;
    walk.visit(PatchKey { level: top, x: 0, y: 0 }, f64::INFINITY);
    walk.limit_steps();
    walk.finish(anchor)
}

struct Walk<'a> {
    patches: &'a dyn Patches,
    warp: &'a Warp,
    viewpoint: &'a Viewpoint,
    /// These have a vertex at every grid unit.
    finest_level: i32,
    leaves: FxHashMap<PatchKey, Leaf>,
    /// Leaves that may not be split: their children are not known, or they are coarse for the sake of such a one.
    pinned: FxHashSet<PatchKey>,
    /// What the patches that were chosen so far hide.
    horizon: Horizon,
}

/// A patch that may be drawn.
struct Seen {
    key: PatchKey,
    statistics: PatchStatistics,
    bounds: Bounds,
    /// Levels that it has to stay above its own while it fades in.
    above: f64,
}

impl Walk<'_> {
    fn visit(&mut self, key: PatchKey, parent_allowed_m: f64) {
        if let Some(seen) = self.seen(key).filter(|seen| !self.horizon.hides(&seen.bounds)) {
            self.visit_seen(seen, parent_allowed_m);
        }
    }

    fn visit_seen(&mut self, seen: Seen, parent_allowed_m: f64) {
        let allowed_m = self.allowed_m(&seen);
        let error_m = self.mesh_error_m(seen.key);
        if error_m > allowed_m && seen.key.level > self.finest_level {
            if self.children_are_known(seen.key, error_m / allowed_m) {
                for child in self.nearest_first(seen.key.children()) {
                    self.visit(child, allowed_m);
                }
                return;
            }
            self.pinned.insert(seen.key);
        }
        self.add_leaf(&seen, parent_allowed_m);
        if seen.statistics.voids == Voids::None && self.viewpoint.is_above_ground {
            // The patch as drawn may lie below its lowest sample by as much as it may be wrong, on either level.
            let land_m = seen.bounds.low_m.z - 2.0 * allowed_m.max(error_m);
            self.horizon.add(&seen.bounds, self.corners_m(seen.key), land_m);
        }
    }

    /// Of a patch, camera-relative.
    fn corners_m(&self, key: PatchKey) -> [DVec2; 4] {
        let (first, side) = key.area();
        let size = self.patches.size();
        let end = (first + side).min(DVec2::new(f64::from(size.width - 1), f64::from(size.height - 1)));
        let corners = [first, end, DVec2::new(first.x, end.y), DVec2::new(end.x, first.y)];
        corners.map(|corner| self.warp.world_from_grid(corner) - self.viewpoint.camera_m.truncate())
    }

    /// Near patches hide far ones.
    fn nearest_first(&self, mut patches: [PatchKey; 4]) -> [PatchKey; 4] {
        let camera = self.warp.grid_from_world(self.viewpoint.camera_m.truncate());
        patches.sort_by(|a, b| {
            let distance = |key: &PatchKey| {
                let (first, side) = key.area();
                (camera.clamp(first, first + side) - camera).length_squared()
            };
            distance(a).total_cmp(&distance(b))
        });
        patches
    }

    fn allowed_m(&self, seen: &Seen) -> f64 {
        let distance_m = seen.bounds.distance_m().max(self.viewpoint.nearest_m);
        self.viewpoint.error_px * distance_m / self.viewpoint.focal_px
    }

    /// Whether a patch can be split; if not, what is missing is asked for.
    fn children_are_known(&self, key: PatchKey, urgency: f64) -> bool {
        key.children().into_iter().all(|child| match self.known(child) {
            Known::Patch { .. } | Known::Nothing => true,
            Known::Missing => {
                // Children of a patch come with one tile.
                self.patches.ask(child.level.max(0) as u32, child.x as u32, child.y as u32, urgency);
                false
            }
        })
    }

    /// A patch, if it exists, is known, has data, and may be in view.
    fn seen(&self, key: PatchKey) -> Option<Seen> {
        let Known::Patch { statistics, above } = self.known(key) else { return None };
        let bounds = self.bounds(key, &statistics)?;
        let seen = statistics.voids != Voids::All && self.viewpoint.frusta.iter().any(|view| view.may_see(&bounds));
        // Finer than the data, nothing has to come.
        let above = if key.level < 0 { 0.0 } else { above };
        seen.then_some(Seen { key, statistics, bounds, above })
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
        // A quad is flat and the earth is not: the sagitta of its diagonal.
        let quad_m = self.warp.spacing_m() * f64::from(key.level).exp2();
        error_m + 0.25 * quad_m * quad_m * self.viewpoint.bending.inverse_radius
    }

    fn bounds(&self, key: PatchKey, statistics: &PatchStatistics) -> Option<Bounds> {
        let (first, side) = key.area();
        let size = self.patches.size();
        let last = DVec2::new(f64::from(size.width - 1), f64::from(size.height - 1));
        if first.cmpge(last).any() {
            return None;
        }
        let end = (first + side).min(last);
        let (low, high) = self.warp.bounds(first, end);
        // The surface overshoots its samples.
        let relief_m = f64::from(statistics.max_m - statistics.min_m);
        let camera_m = self.viewpoint.camera_m;
        let low_m = low.extend(f64::from(statistics.min_m) - 0.15 * relief_m) - camera_m;
        let high_m = high.extend(f64::from(statistics.max_m) + 0.15 * relief_m) - camera_m;
        self.viewpoint.bending.bend_bounds(&Bounds { low_m, high_m })
    }

    fn add_leaf(&mut self, seen: &Seen, parent_allowed_m: f64) {
        let key = seen.key;
        let own_m = self.mesh_error_m(key);
        let parent_m = self.mesh_error_m(key.parent());
        let way = if parent_allowed_m.is_finite() && parent_m > own_m {
            ((parent_allowed_m - own_m) / (parent_m - own_m)).clamp(0.0, 1.0)
        } else {
            0.0
        };
        // In steps that f32 holds exactly: the two patches at an edge count the same level from their own levels, and
        // must come to the same vertices to the bit.
        let level = f64::from(key.level) + (way.max(seen.above) * LEVEL_STEPS).round() / LEVEL_STEPS;
        let distance_m = seen.bounds.distance_m().max(self.viewpoint.nearest_m);
        self.leaves.insert(key, Leaf { distance_m, level, holes: seen.statistics.voids != Voids::None });
    }

    /// Splits leaves that have neighbours too much finer than themselves; where one cannot be split, its neighbours are
    /// merged instead.
    fn limit_steps(&mut self) {
        loop {
            let too_far_apart: Vec<_> = self
                .leaves
                .keys()
                .flat_map(|key| neighbours(*key).map(move |neighbour| (*key, neighbour)))
                .filter_map(|(key, neighbour)| {
                    let (coarse, _) = self.leaf_over(neighbour)?;
                    (coarse.level > key.level + MAX_LEVEL_STEP).then_some((key, coarse))
                })
                .collect();
            if too_far_apart.is_empty() {
                return;
            }
            for (fine, coarse) in too_far_apart {
                // The same leaf may stand in the list twice.
                if !self.leaves.contains_key(&coarse) || !self.leaves.contains_key(&fine) {
                    continue;
                }
                if self.pinned.contains(&coarse) || !self.children_are_known(coarse, 1.0) {
                    self.pinned.insert(coarse);
                    self.merge(fine, coarse.level - MAX_LEVEL_STEP);
                    continue;
                }
                self.leaves.remove(&coarse);
                for child in coarse.children() {
                    if let Some(seen) = self.seen(child) {
                        self.add_leaf(&seen, f64::INFINITY);
                    }
                }
            }
        }
    }

    /// Draws the ancestor of a leaf instead of it and all others under that ancestor.
    fn merge(&mut self, mut key: PatchKey, level: i32) {
        while key.level < level {
            key = key.parent();
        }
        let is_under = |mut leaf: PatchKey| {
            while leaf.level < key.level {
                leaf = leaf.parent();
            }
            leaf == key
        };
        self.leaves.retain(|leaf, _| !is_under(*leaf));
        self.pinned.insert(key);
        if let Some(seen) = self.seen(key) {
            self.add_leaf(&seen, f64::INFINITY);
        }
    }

    /// The leaf that covers a patch: itself or an ancestor.
    fn leaf_over(&self, mut key: PatchKey) -> Option<(PatchKey, Leaf)> {
        let top = self.patches.strides() as i32 - 1;
        while key.level <= top {
            if let Some(leaf) = self.leaves.get(&key) {
                return Some((key, *leaf));
            }
            key = key.parent();
        }
        None
    }

    fn finish(self, anchor: DVec2) -> Selection {
        let mut keys: Vec<_> = self.leaves.iter().map(|(key, leaf)| (*key, *leaf)).collect();
        // The key breaks ties, so that the order is the same on every run.
        keys.sort_by(|a, b| {
            a.1.holes.cmp(&b.1.holes).then(a.1.distance_m.total_cmp(&b.1.distance_m)).then(a.0.cmp(&b.0))
        });
        let mut selection = Selection::default();
        let units_log2 = -self.finest_level;
        for (key, leaf) in keys {
            let own = f64::from(key.level);
            let [west, east, north, south] = neighbours(key).map(|neighbour| {
                let other = self.leaf_over(neighbour).map_or(leaf.level, |(_, other)| other.level);
                (leaf.level.max(other) - own) as f32
            });
            let (first, _) = key.area();
            let origin = (first - anchor) * f64::from(units_log2).exp2();
            let instance = PatchInstance {
                origin_units: [origin.x as i32, origin.y as i32],
                stride_exponent: (key.level + units_log2) as u32,
                id: patch_id(key),
                edge_levels: [west, east, north, south],
                inner_level: (leaf.level - own) as f32,
                padding: [0.0; 3],
            };
            if leaf.holes { &mut selection.with_holes } else { &mut selection.solid }.push(instance);
            selection.leaves.push(key);
        }
        selection
    }
}

/// The patches of the same level beside the first column, last column, first row and last row.
fn neighbours(key: PatchKey) -> [PatchKey; 4] {
    let beside = |dx, dy| PatchKey { x: key.x + dx, y: key.y + dy, ..key };
    [beside(-1, 0), beside(1, 0), beside(0, -1), beside(0, 1)]
}

/// A number that names a patch from frame to frame: FNV-1a over its key, never 0.
fn patch_id(key: PatchKey) -> u32 {
    let mut hash = 0x811c_9dc5_u32;
    for byte in (key.level as i64).to_le_bytes().iter().chain(&key.x.to_le_bytes()).chain(&key.y.to_le_bytes()) {
        hash = (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193);
    }
    hash.max(1)
}
