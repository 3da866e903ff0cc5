//! The leaves of the walk: the patches selected so far, with the level of the edge that each shares with a neighbour,
//! and which of both owns that edge.

use glam::DVec2;
use rustc_hash::FxHashMap;

use super::selection::{PatchInstance, PatchKey, Selection, neighbours, patch_id};

/// Largest difference in level between neighbours: 2^3 < 16 quads.
pub(super) const MAX_LEVEL_STEP: i32 = 3;

/// A patch that is drawn.
#[derive(Clone, Copy)]
pub(super) struct Leaf {
    /// Distance from the camera to the nearest point of its box, in metres.
    pub distance_m: f64,
    /// Distance from the camera to the farthest point of its box, in metres.
    pub farthest_m: f64,
    /// The continuous level of detail, in levels of the pyramid.
    pub level: f64,
    /// Whether it has no-data samples.
    pub holes: bool,
}

/// The leaves by their keys; they do not overlap.
pub(super) struct Leaves {
    leaves: FxHashMap<PatchKey, Leaf>,
    /// The level of the coarsest patch.
    top: i32,
}

impl Leaves {
    /// Creates an empty set for a quadtree whose coarsest patch has the level `top`.
    pub(super) fn new(top: i32) -> Self {
        Self { leaves: FxHashMap::default(), top }
    }

    /// Returns the number of leaves.
    pub(super) fn len(&self) -> usize {
        self.leaves.len()
    }

    /// Returns whether a patch is a leaf.
    pub(super) fn contains(&self, key: PatchKey) -> bool {
        self.leaves.contains_key(&key)
    }

    /// Returns the keys of the leaves, in no particular order.
    pub(super) fn keys(&self) -> impl Iterator<Item = PatchKey> {
        self.leaves.keys().copied()
    }

    /// Adds or replaces a leaf.
    pub(super) fn insert(&mut self, key: PatchKey, leaf: Leaf) {
        self.leaves.insert(key, leaf);
    }

    /// Removes a leaf.
    pub(super) fn remove(&mut self, key: PatchKey) {
        self.leaves.remove(&key);
    }

    /// Removes all leaves under a patch, itself included.
    pub(super) fn remove_under(&mut self, key: PatchKey) {
        let is_under = |mut leaf: PatchKey| {
            while leaf.level < key.level {
                leaf = leaf.parent();
            }
            leaf == key
        };
        self.leaves.retain(|leaf, _| !is_under(*leaf));
    }

    /// Returns the leaf that covers a patch: itself or an ancestor.
    pub(super) fn covering(&self, mut key: PatchKey) -> Option<(PatchKey, Leaf)> {
        while key.level <= self.top {
            if let Some(leaf) = self.leaves.get(&key) {
                return Some((key, *leaf));
            }
            key = key.parent();
        }
        None
    }

    /// Returns the sides of a leaf that own their edge: of two leaves, that of the finer one; of equals, the west and
    /// north sides.
    fn sides(&self, key: PatchKey) -> u32 {
        let mut sides = 0;
        for (side, neighbour) in neighbours(key).into_iter().enumerate() {
            let is_own = match self.covering(neighbour) {
                Some((other, _)) if other.level == key.level => side % 2 == 0,
                Some(_) => true,
                None => !self.has_leaf_at(neighbour, side, MAX_LEVEL_STEP),
            };
            sides |= u32::from(is_own) << side;
        }
        sides
    }

    /// Returns whether a leaf under `key` touches its side that faces side `side` of a neighbour.
    fn has_leaf_at(&self, key: PatchKey, side: usize, depth: i32) -> bool {
        if depth == 0 {
            return false;
        }
        let facing: [usize; 2] = [[1, 3], [0, 2], [2, 3], [0, 1]][side];
        let children = key.children();
        facing
            .into_iter()
            .map(|i| children[i])
            .any(|child| self.leaves.contains_key(&child) || self.has_leaf_at(child, side, depth - 1))
    }

    /// Returns the leaves as the GPU draws them, from near to far, at positions relative to `anchor` in units of
    /// 2^−`units_log2` samples.
    pub(super) fn instances(self, anchor: DVec2, units_log2: i32) -> Selection {
        let mut keys: Vec<_> = self.leaves.iter().map(|(key, leaf)| (*key, *leaf)).collect();
        // The key breaks ties, so that the order is deterministic.
        keys.sort_by(|a, b| {
            a.1.holes.cmp(&b.1.holes).then(a.1.distance_m.total_cmp(&b.1.distance_m)).then(a.0.cmp(&b.0))
        });
        let mut selection = Selection::default();
        for (key, leaf) in keys {
            let own = f64::from(key.level);
            let [west, east, north, south] = neighbours(key).map(|neighbour| {
                let other = self.covering(neighbour).map_or(leaf.level, |(_, other)| other.level);
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
                sides: self.sides(key),
                has_holes: leaf.holes.into(),
                padding: 0.0,
            };
            if leaf.holes { &mut selection.with_holes } else { &mut selection.solid }.push(instance);
            selection.leaves.push(key);
            selection.distances_m.push([leaf.distance_m, leaf.farthest_m]);
        }
        selection
    }
}
