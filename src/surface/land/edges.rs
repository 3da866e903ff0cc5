//! The patches' contours, borders and creases → the edge list. See `shaders/surface/land/edges.wgsl`.

use super::vertices::PatchMesh;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::scan::{Groups, Ordered};
use crate::pyramid::tile::PATCH_QUADS;
use crate::surface::edges::EdgeList;

/// Quads of a patch; the pass keeps the edges found in each quad from stage to stage.
const KEPT: u64 = (PATCH_QUADS * PATCH_QUADS) as u64;

/// Inputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// Bindings of `shaders/shared/terrain.wgsl` and `shared/surface.wgsl`.
    pub terrain: &'a [Named],
    pub mesh: &'a PatchMesh,
    /// First patch and number of patches of the batch whose vertices are in the mesh.
    pub batch: [u32; 2],
}

/// Adds the edges of a batch to the list.
pub(crate) fn run(recorder: &mut Recorder<'_>, edges: &EdgeList, inputs: &Inputs<'_>) {
    if inputs.batch[1] == 0 && !recorder.prewarms() {
        return;
    }
    let mut resources = vec![("view", inputs.view.clone())];
    resources.extend(inputs.mesh.resources(inputs.batch));
    resources.extend(edges.resources());
    resources.extend(inputs.terrain.iter().cloned());
    let shader = |definitions| Compute { name: "surface/land/edges", definitions };
    let groups = Groups::Of([inputs.batch[1], 1]);
    for has_holes in [false, true] {
        // A prewarming run requests both variants, since a later frame may show other land.
        if has_holes == inputs.mesh.has_holes() || recorder.prewarms() {
            let find = shader(if has_holes { &["FIND", "HOLES"] } else { &["FIND"] });
            Ordered { shader: shader(&[]), first_stage_shader: Some(find), groups, words_per_group: KEPT }
                .run(recorder, &resources);
        }
    }
}
