//! Which triangles of the meshes face the eye. See `shaders/lines/strokes/mesh_sides.wgsl`.

use crate::gpu::bind::Resource;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Cx;
use crate::surface::mesh_vertices::{SeenMeshes, groups};

/// For each triangle its normal and its side.
const SIDES: BufferKind = BufferKind::storage("mesh sides");
/// Bytes of both.
const SIDE_BYTES: u64 = 16;

/// Decides for each triangle that is near enough.
pub fn run(cx: &mut Cx<'_>, view: &Resource, meshes: &SeenMeshes) -> Buffer {
    let sides = cx.buffer(&SIDES, (u64::from(meshes.near_triangles) * SIDE_BYTES).next_power_of_two());
    let mut resources = vec![("mesh_sides", sides.binding()), ("view", view.clone())];
    resources.extend(meshes.resources());
    cx.groups("lines/strokes/mesh_sides", groups(meshes.near_triangles), &resources);
    sides
}
