//! Contours, open borders and creases of the meshes that are near enough → the edge list. See
//! `shaders/surface/meshes/edges.wgsl`, and `sides.wgsl`, which computes the facing of each triangle first.

use super::DrawnMeshes;
use super::cull::NEAR_GROUPS;
use super::sides;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Recorder;
use crate::gpu::scan::{Groups, Ordered};
use crate::surface::edges::EdgeList;

/// Threads of a workgroup.
const WORKGROUP: u64 = 64;

/// Adds the edges to the list.
pub(crate) fn run(recorder: &mut Recorder<'_>, edges: &EdgeList, view: &Resource, meshes: &DrawnMeshes) {
    let sides = sides::run(recorder, view, meshes);
    let mut resources = vec![("view", view.clone()), ("mesh_sides", sides.binding())];
    resources.extend(edges.resources());
    resources.extend(meshes.resources());
    let most = meshes.room().triangles.div_ceil(WORKGROUP) as u32;
    let groups = Groups::Counted { arguments: &meshes.draws, offset: NEAR_GROUPS, max_groups: most };
    Ordered { shader: "surface/meshes/edges".into(), first_stage_shader: None, groups, words_per_group: 0 }
        .run(recorder, &resources);
}
