//! Draws the meshes in view: depth and surface id, over those of the land. See `shaders/surface/meshes.wgsl`.

use super::mesh_vertices::SeenMeshes;
use super::terrain::{DEPTH_FORMAT, ID_FORMAT};
use crate::gpu::bind::Resource;
use crate::gpu::pipelines::{Draw, replaced};
use crate::gpu::recorder::{Attachments, Cx};
use crate::gpu::target::Target;

/// Of a surface id: a mesh. The rest is the triangle's number among those of all that stands in the world.
pub const IS_MESH: u32 = 1 << 31;

const DRAW: Draw = Draw {
    name: "surface/meshes",
    fragment: "fragment",
    colors: [replaced(ID_FORMAT), None],
    depth: Some(DEPTH_FORMAT),
    topology: wgpu::PrimitiveTopology::TriangleList,
};

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// The meshes and their vertices.
    pub meshes: &'a SeenMeshes,
    /// [`DEPTH`](super::terrain::DEPTH).
    pub depth: &'a Target,
    /// [`SURFACE_ID`](super::terrain::SURFACE_ID).
    pub surface_id: &'a Target,
}

/// Draws them.
pub fn run(cx: &mut Cx<'_>, inputs: &Inputs<'_>) {
    let seen = &inputs.meshes.triangles;
    if seen.is_empty() && !cx.rehearses() {
        return;
    }
    let mut resources = vec![("view", inputs.view.clone())];
    resources.extend(inputs.meshes.resources());
    let drawing = cx.drawing(&DRAW, &resources);
    let on = Attachments { colors: &[inputs.surface_id], depth: Some(inputs.depth), is_cleared: false };
    cx.render("surface/meshes", &[&drawing], on, |pass| {
        drawing.set(pass);
        for (instance, triangles) in (0_u32..).zip(seen) {
            pass.draw(0..3 * triangles, instance..instance + 1);
        }
    });
}
