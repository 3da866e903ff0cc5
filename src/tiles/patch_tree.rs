//! The quadtree of patches as a walk sees it, kept from frame to frame.
//!
//! A walk visits thousands of patches, and nearly all of them were visited in the frame before. So each node keeps what
//! does not depend on the camera: its box in the world, its statistics, and its neighbours. A node's statistics are read
//! again when its tile has left the GPU or has come.
//!
//! Why: `docs/decisions/level-of-detail.md`.

use glam::{DVec2, DVec3};

use super::grid_projection::GridProjection;
use super::patches::{PatchState, Patches};
use super::selection::PatchKey;
use super::skyline::Skyline;
use crate::pyramid::surface::bicubic::OVERSHOOT;
use crate::pyramid::surface::statistics::PatchStatistics;
use crate::scene::frustum::Bounds;

/// The index of a node.
pub(super) type NodeId = u32;

/// The index of no node, or of no leaf.
const NONE: u32 = u32::MAX;
/// The number of nodes from which on the tree is built again: more than any budget of patches needs.
const MAX_NODES: usize = 1 << 18;
/// The side on the other side of an edge: west and east, north and south.
const OPPOSITE: [usize; 4] = [1, 0, 3, 2];

/// A patch, and what is known about its land.
struct Node {
    key: PatchKey,
    state: PatchState,
    /// The box of its land in the world, in metres; `None` beyond the last sample.
    box_m: Option<Bounds>,
}

/// The place of a node among the others.
#[derive(Clone, Copy)]
struct Links {
    parent: NodeId,
    /// The first of four children, which follow each other.
    first_child: NodeId,
    /// The neighbours of the same level, as far as they have been found: west, east, north, south.
    neighbours: [NodeId; 4],
}

/// The state of a node in the last walk that touched it.
#[derive(Clone, Copy)]
struct Mark {
    walk: u32,
    leaf: u32,
    is_pinned: bool,
}

/// The quadtree. Its lists are parallel: links and marks are looked up far more often than the rest, and stay in the
/// processor's cache if they are apart from it.
#[derive(Default)]
pub(crate) struct PatchTree {
    nodes: Vec<Node>,
    links: Vec<Links>,
    marks: Vec<Mark>,
    walk: u32,
    /// A skyline of an earlier walk, for its memory.
    used_skyline: Option<Skyline>,
}

impl PatchTree {
    /// Begins a walk from the root at level `top`, and returns the root.
    pub(super) fn begin(&mut self, top: i32) -> NodeId {
        let root = PatchKey { level: top, x: 0, y: 0 };
        if self.nodes.len() > MAX_NODES || self.nodes.first().is_none_or(|node| node.key != root) {
            self.nodes.clear();
            self.links.clear();
            self.marks.clear();
            self.push(root, NONE);
        }
        self.walk = self.walk.wrapping_add(1);
        0
    }

    /// Returns a skyline that blocks nothing, like [`Skyline::new`], in the memory of that of [`PatchTree::reuse`].
    pub(super) fn empty_skyline(&mut self, focal_px: f64, is_layered: bool) -> Skyline {
        let used = self.used_skyline.take();
        used.map_or_else(|| Skyline::new(focal_px, is_layered), |used| used.emptied(focal_px, is_layered))
    }

    /// Keeps a skyline that is no longer needed, so that the next walk can use its memory.
    pub(super) fn reuse(&mut self, skyline: Skyline) {
        self.used_skyline = Some(skyline);
    }

    fn push(&mut self, key: PatchKey, parent: NodeId) {
        self.nodes.push(Node { key, state: PatchState::NotLoaded, box_m: None });
        self.links.push(Links { parent, first_child: NONE, neighbours: [NONE; 4] });
        self.marks.push(Mark { walk: self.walk.wrapping_sub(1), leaf: NONE, is_pinned: false });
    }

    fn node(&self, id: NodeId) -> &Node {
        &self.nodes[id as usize]
    }

    fn links(&self, id: NodeId) -> Links {
        self.links[id as usize]
    }

    /// Returns a mark as this walk has left it.
    fn mark(&mut self, id: NodeId) -> &mut Mark {
        let walk = self.walk;
        let mark = &mut self.marks[id as usize];
        if mark.walk != walk {
            *mark = Mark { walk, leaf: NONE, is_pinned: false };
        }
        mark
    }

    pub(super) fn key(&self, id: NodeId) -> PatchKey {
        self.node(id).key
    }

    pub(super) fn parent(&self, id: NodeId) -> Option<NodeId> {
        Some(self.links(id).parent).filter(|parent| *parent != NONE)
    }

    /// Returns the four children of a node.
    pub(super) fn children(&mut self, id: NodeId) -> [NodeId; 4] {
        let mut first = self.links(id).first_child;
        if first == NONE {
            first = self.nodes.len() as u32;
            self.key(id).children().into_iter().for_each(|child| self.push(child, id));
            self.links[id as usize].first_child = first;
        }
        [first, first + 1, first + 2, first + 3]
    }

    /// Returns the state of a patch, with its statistics if its tile is loaded.
    pub(super) fn state(&mut self, id: NodeId, patches: &dyn Patches, grid: &GridProjection) -> PatchState {
        let node = self.node(id);
        match &node.state {
            PatchState::Loaded { arrival, .. } if patches.is_current(arrival) => return node.state,
            PatchState::Absent => return PatchState::Absent,
            _ => {}
        }
        let key = node.key;
        let up = (-key.level).max(0);
        let state = match (u32::try_from(key.x >> up), u32::try_from(key.y >> up)) {
            (Ok(x), Ok(y)) => patches.patch(key.level.max(0) as u32, x, y),
            _ => PatchState::Absent,
        };
        let box_m = match state {
            PatchState::Loaded { statistics, .. } => box_m(key, &statistics, patches, grid),
            _ => None,
        };
        let node = &mut self.nodes[id as usize];
        (node.state, node.box_m) = (state, box_m);
        state
    }

    /// Returns the box of a patch's land in the world, in metres, as of its last [`PatchTree::state`]; `None` if it has
    /// none.
    pub(super) fn box_m(&self, id: NodeId) -> Option<Bounds> {
        self.node(id).box_m
    }

    /// Returns the index of a patch's leaf in this walk, or `None` if it is not a leaf.
    pub(super) fn leaf(&self, id: NodeId) -> Option<usize> {
        let mark = self.marks[id as usize];
        (mark.walk == self.walk && mark.leaf != NONE).then_some(mark.leaf as usize)
    }

    /// Makes a patch a leaf, or no leaf.
    pub(super) fn set_leaf(&mut self, id: NodeId, leaf: Option<usize>) {
        self.mark(id).leaf = leaf.map_or(NONE, |leaf| leaf as u32);
    }

    pub(super) fn is_pinned(&self, id: NodeId) -> bool {
        let mark = self.marks[id as usize];
        mark.walk == self.walk && mark.is_pinned
    }

    pub(super) fn pin(&mut self, id: NodeId) {
        self.mark(id).is_pinned = true;
    }

    /// Returns the neighbour of the same level, if it has been visited by any walk. Sides are west, east, north, south.
    pub(super) fn neighbour(&mut self, id: NodeId, side: usize) -> Option<NodeId> {
        let Links { neighbours, parent, .. } = self.links(id);
        if neighbours[side] != NONE {
            return Some(neighbours[side]);
        }
        if parent == NONE {
            return None;
        }
        let place = id - self.links(parent).first_child;
        let (column, row) = (place % 2, place / 2);
        let (is_inner, mirrored) = match side {
            0 => (column == 1, row * 2 + 1 - column),
            1 => (column == 0, row * 2 + 1 - column),
            2 => (row == 1, (1 - row) * 2 + column),
            _ => (row == 0, (1 - row) * 2 + column),
        };
        let of = if is_inner { parent } else { self.neighbour(parent, side)? };
        let first = self.links(of).first_child;
        if first == NONE {
            return None;
        }
        let found = first + mirrored;
        self.links[id as usize].neighbours[side] = found;
        self.links[found as usize].neighbours[OPPOSITE[side]] = id;
        Some(found)
    }

    /// Returns the leaf across a side of a patch, if one covers all of that side: the neighbour of the same level or an
    /// ancestor of it.
    pub(super) fn leaf_across(&mut self, id: NodeId, side: usize) -> Option<NodeId> {
        let mut from = id;
        loop {
            if let Some(neighbour) = self.neighbour(from, side) {
                let mut across = Some(neighbour);
                while let Some(at) = across {
                    if self.leaf(at).is_some() {
                        return Some(at);
                    }
                    across = self.parent(at);
                }
                return None;
            }
            from = self.parent(from)?;
        }
    }

    /// Returns whether a leaf, up to `depth` levels finer, touches a side of a patch from across.
    pub(super) fn has_finer_leaf_across(&mut self, id: NodeId, side: usize, depth: i32) -> bool {
        self.neighbour(id, side).is_some_and(|across| self.has_leaf_at(across, side, depth))
    }

    fn has_leaf_at(&self, id: NodeId, side: usize, depth: i32) -> bool {
        let first = self.links(id).first_child;
        if depth == 0 || first == NONE {
            return false;
        }
        let facing: [u32; 2] = [[1, 3], [0, 2], [2, 3], [0, 1]][side];
        facing.into_iter().any(|i| self.leaf(first + i).is_some() || self.has_leaf_at(first + i, side, depth - 1))
    }
}

/// Returns the box of a patch's land in the world; `None` if it is beyond the last sample.
fn box_m(key: PatchKey, statistics: &PatchStatistics, patches: &dyn Patches, grid: &GridProjection) -> Option<Bounds> {
    let (first, side) = key.area();
    let size = patches.size();
    let last = DVec2::new(f64::from(size.width - 1), f64::from(size.height - 1));
    if first.cmpge(last).any() {
        return None;
    }
    let end = (first + side).min(last);
    let (low, high) = grid.bounds(first, end);
    // The surface may exceed its samples.
    let overshoot_m = f64::from(OVERSHOOT) * f64::from(statistics.max_m - statistics.min_m);
    let low_m: DVec3 = low.extend(f64::from(statistics.min_m) - overshoot_m);
    let high_m = high.extend(f64::from(statistics.max_m) + overshoot_m);
    Some(Bounds { low_m, high_m })
}
