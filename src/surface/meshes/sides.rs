//! The facing of the meshes' triangles. See `shaders/surface/meshes/sides.wgsl`.

use super::DrawnMeshes;
use super::cull::NEAR_GROUPS;
use crate::gpu::bind::Resource;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;

/// Normal of each triangle, and 1 if it faces the eye, else −1.
const SIDES: BufferKind = BufferKind::storage("mesh sides");
const SIDE_BYTES: u64 = 16;

/// Computes the normal and facing of each triangle that is near enough.
pub(super) fn run(recorder: &mut Recorder<'_>, view: &Resource, meshes: &DrawnMeshes) -> Buffer {
    let sides = recorder.buffer(&SIDES, meshes.room().triangles * SIDE_BYTES);
    let mut resources = vec![("mesh_sides", sides.binding()), ("view", view.clone())];
    resources.extend(meshes.resources());
    recorder.indirect("surface/meshes/sides", &meshes.draws, NEAR_GROUPS, &resources);
    sides
}
