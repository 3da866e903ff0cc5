//! Position and normal of the meshes, over those of the land. See `shaders/surface/mesh_resolve.wgsl`.

use super::mesh_vertices::SeenMeshes;
use crate::gpu::bind::Resource;
use crate::gpu::recorder::Cx;
use crate::gpu::target::Target;

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// The meshes and their vertices.
    pub meshes: &'a SeenMeshes,
    /// Which triangle.
    pub surface_id: &'a Target,
    /// As it was rasterised.
    pub depth: &'a Target,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
}

/// Writes `position` and `normal` where a mesh is seen.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
    if inputs.meshes.triangles.is_empty() && !cx.rehearses() {
        return;
    }
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("surface_id", inputs.surface_id.into()),
        ("depth", inputs.depth.into()),
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
    ];
    resources.extend(inputs.meshes.resources());
    cx.pixels("surface/mesh_resolve", inputs.position.size_px(), &resources);
}
