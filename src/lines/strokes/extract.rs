//! The ID reference image → the list of visible segments. See `shaders/lines/strokes/extract.wgsl`.

use super::Lists;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::{Recorder, WORKGROUP_PX};
use crate::gpu::scan::{Groups, Ordered};
use crate::gpu::target::Target;
use crate::surface::edges::EdgeList;

/// Reads the edges and the reference image `ids`; writes the segments and their number.
pub(crate) fn run(recorder: &mut Recorder<'_>, lists: &Lists, edges: &EdgeList, view: &Resource, ids: &Target) {
    let resources = [
        ("view", view.clone()),
        lists.strokes(),
        edges.edges(),
        ("ids", ids.into()),
        ("segments", lists.segments.binding()),
        lists.counts(),
    ];
    let groups = ids.size_px().map(|side| side.div_ceil(WORKGROUP_PX));
    Ordered {
        shader: "lines/strokes/extract".into(),
        first_stage_shader: None,
        groups: Groups::Of(groups),
        words_per_group: 0,
    }
    .run(recorder, &resources);
}
