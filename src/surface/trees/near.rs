//! Selects the trees that have strokes, in an order that does not depend on timing. See
//! `shaders/surface/trees/near.wgsl`.

use super::DrawnTrees;
use super::place::MAX_TREES;
use crate::gpu::bind::Resource;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::wgsl::surface::trees::near::{NEAR_GROUPS, NearTrees};

/// Largest number of trees that have strokes; the nearest ones have them.
pub(crate) const MAX_NEAR: u32 = 1 << 12;

/// Number of trees, then their instance numbers, from near to far.
const NEAR_ORDER: BufferKind = BufferKind::storage("near trees");
/// Arguments of an indirect dispatch, then the total number of workgroups.
const NEAR_DISPATCH: BufferKind = BufferKind::indirect("near tree groups");

/// The trees that have strokes.
pub(crate) struct Near {
    /// Number of trees, then their instance numbers, from near to far.
    pub(super) order: Buffer,
    /// Workgroup counts (x, y, z) for the trees' edges, then the total number of workgroups.
    pub(super) dispatch: Buffer,
}

/// Selects the trees, for a pass that has `groups_of_tree` workgroups per tree.
pub(crate) fn run(recorder: &mut Recorder<'_>, view: &Resource, trees: &DrawnTrees, groups_of_tree: u32) -> Near {
    let uniform = NearTrees { species: trees.species(), capacity: MAX_TREES, room: MAX_NEAR, groups_of_tree };
    let order = recorder.buffer(&NEAR_ORDER, 4 * (1 + u64::from(MAX_NEAR)));
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
