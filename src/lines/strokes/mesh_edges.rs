//! Finds the edges of the meshes that are near enough. See `shaders/lines/strokes/mesh_edges.wgsl`, and
//! `mesh_sides.wgsl` for what each triangle knows of itself before.

use super::scan::Ordered;
use super::{Lists, mesh_sides};
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Cx;
use crate::surface::mesh_vertices::{SeenMeshes, groups};

/// Adds the edges to the list.
pub fn run(cx: &mut Cx<'_>, lists: &Lists, view: &Resource, meshes: &SeenMeshes) {
    if meshes.near_triangles == 0 && !cx.rehearses() {
        return;
    }
    let sides = mesh_sides::run(cx, view, meshes);
    let mut resources = vec![
        ("view", view.clone()),
        ("mesh_sides", sides.binding()),
        lists.strokes(),
        ("edges", lists.edges.binding()),
        ("edge_draw", lists.edge_draw.binding()),
    ];
    resources.extend(meshes.resources());
    let groups = groups(meshes.near_triangles);
    Ordered { shader: "lines/strokes/mesh_edges", stages: 3, groups, kept: 0 }.run(cx, &resources);
}
