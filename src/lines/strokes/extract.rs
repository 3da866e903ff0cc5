//! The ID reference image → the list of visible pieces. See `shaders/lines/strokes/extract.wgsl`.

use super::Lists;
use super::scan::Ordered;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::{Cx, WORKGROUP_PX};
use crate::gpu::target::Target;

/// Reads the edges and `ids`, the reference image; writes the pieces and their number.
pub fn run(cx: &mut Cx<'_>, lists: &Lists, view: &Resource, ids: &Target) {
    let resources = [
        ("view", view.clone()),
        lists.strokes(),
        ("edges", lists.edges.binding()),
        ("ids", ids.into()),
        ("pieces", lists.pieces.binding()),
        lists.counts(),
    ];
    let groups = ids.size_px().map(|side| side.div_ceil(WORKGROUP_PX));
    Ordered { shader: "lines/strokes/extract", stages: 2, groups, kept: 0 }.run(cx, &resources);
}
