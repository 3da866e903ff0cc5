//! Adds segments where the land ends on the picture but no edge was found, so that outlines have no gaps. See
//! `shaders/lines/strokes/outlines.wgsl`.
//!
//! Why: `docs/decisions/chosen-lines.md`.

use super::Lists;
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::{Recorder, WORKGROUP_PX};
use crate::gpu::scan::{Groups, Ordered};
use crate::gpu::target::Target;
use crate::surface::edges::EdgeList;

/// Inputs of the pass.
pub(crate) struct Inputs<'a> {
    /// The view uniform with which the edges were drawn.
    pub view: &'a Resource,
    /// Depth of the surface.
    pub depth: &'a Target,
    /// The reference image whose edges have become segments.
    pub ids: &'a Target,
    pub surface_id: &'a Target,
    /// Whether the land in view may have holes, whose rims are no outlines.
    pub has_holes: bool,
}

/// Appends the missing segments to those of the edges.
pub(crate) fn run(recorder: &mut Recorder<'_>, lists: &Lists, edges: &EdgeList, inputs: &Inputs<'_>) {
    let Inputs { view, depth, ids, surface_id, has_holes } = *inputs;
    let resources = [
        ("view", view.clone()),
        lists.strokes(),
        ("depth", depth.into()),
        ("ids", ids.into()),
        ("surface_id", surface_id.into()),
        ("segments", lists.segments.binding()),
        lists.counts(),
        edges.edges(),
    ];
    let groups = Groups::Of(depth.size_px().map(|side| side.div_ceil(WORKGROUP_PX)));
    for holes in [false, true] {
        // A prewarming run requests both variants, since a later frame may show other land.
        if holes == has_holes || recorder.prewarms() {
            let definitions: &[&str] = if holes { &["HOLES"] } else { &[] };
            let shader = Compute { name: "lines/strokes/outlines", definitions };
            Ordered { shader, first_stage_shader: None, groups, words_per_group: 0 }.run(recorder, &resources);
        }
    }
}
