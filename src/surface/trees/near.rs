//! Which trees have strokes, in an order that does not depend on timing. See `shaders/surface/trees/near.wgsl`.

use super::DrawnTrees;
use super::place::MOST_TREES;
use crate::gpu::bind::Resource;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::wgsl::surface::trees::near::{NEAR_GROUPS, NearTrees};

/// Trees that have strokes, at most: those that are nearest.
pub const MOST_NEAR: u32 = 1 << 12;

/// How many there are, then the numbers of their instances, from near to far.
const NEAR_ORDER: BufferKind = BufferKind::storage("near trees");
/// An indirect dispatch, and how many workgroups it has.
const NEAR_DISPATCH: BufferKind = BufferKind::indirect("near tree groups");

/// The trees that have strokes.
pub struct Near {
    /// How many there are, then the numbers of their instances.
    pub(super) order: Buffer,
    /// Workgroups for their edges: x, y, z, and how many.
    pub(super) dispatch: Buffer,
}

/// Finds them, for a pass that has `groups_of_tree` workgroups for each.
pub fn run(recorder: &mut Recorder<'_>, view: &Resource, trees: &DrawnTrees, groups_of_tree: u32) -> Near {
    let uniform =
        NearTrees { species: trees.shared.species.len() as u32, capacity: MOST_TREES, room: MOST_NEAR, groups_of_tree };
    let order = recorder.buffer(&NEAR_ORDER, 4 * (1 + u64::from(MOST_NEAR)));
    let dispatch = recorder.buffer(&NEAR_DISPATCH, 16);
    let resources = [
        ("view", view.clone()),
        ("near_trees", recorder.uniform("near trees", &uniform)),
        ("tree_instances", trees.instances.binding()),
        ("tree_order", trees.order.binding()),
        ("tree_draws", trees.draws.binding()),
        ("near_order", order.binding()),
        ("near_dispatch", dispatch.binding()),
    ];
    recorder.groups("surface/trees/near", [NEAR_GROUPS, 1], &resources);
    Near { order, dispatch }
}
