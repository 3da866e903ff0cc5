//! Lists the trees that are drawn, from front to back. See `shaders/surface/trees/list.wgsl`.

use super::place::MAX_TREES;
use super::{DrawnTrees, lists};
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::scan::{self, Count};
use crate::gpu::wgsl::shared::dispatch::GROUPS_IN_ROW;
pub(super) use crate::gpu::wgsl::surface::trees::list::BlockPlaces;
use crate::gpu::wgsl::surface::trees::list::TreeLists;

/// The [`BlockPlaces`] of each block.
const BLOCK_PLACES: BufferKind = BufferKind::storage("tree block places");

/// Fills the lists of `trees` from its keys. `counts` has for each list the number of instances of each block, and room
/// for one number more.
pub(super) fn run(recorder: &mut Recorder<'_>, trees: &DrawnTrees, counts: &Buffer, places: &[BlockPlaces]) {
    let (blocks, lists) = (places.len() as u32, lists(trees.species()));
    scan::run(recorder, Count::Of(blocks * lists), counts);
    let uniform = TreeLists { blocks, lists, capacity: MAX_TREES, padding: 0 };
    let resources = [
        ("tree_lists", recorder.uniform("tree lists", &uniform)),
        ("tree_keys", trees.keys.binding()),
        ("block_places", recorder.upload(&BLOCK_PLACES, places).binding()),
        ("tree_counts", counts.binding()),
        ("tree_order", trees.order.binding()),
        ("tree_draws", trees.draws.binding()),
    ];
    recorder.groups("surface/trees/list", [blocks.min(GROUPS_IN_ROW), blocks.div_ceil(GROUPS_IN_ROW)], &resources);
}
