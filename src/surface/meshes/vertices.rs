//! The vertices of the meshes in view. See `shaders/surface/meshes/vertices.wgsl`.

use super::DrawnMeshes;
use super::cull::VERTEX_GROUPS;
use crate::gpu::bind::Named;
use crate::gpu::recorder::Recorder;

/// Computes the positions of the vertices in view, into [`POSITIONS`](super::POSITIONS). `terrain` is the terrain
/// uniform, for the curvature of the earth.
pub(crate) fn run(recorder: &mut Recorder<'_>, meshes: &DrawnMeshes, terrain: Named) {
    let resources = [
        ("mesh_instances", meshes.instances.binding()),
        ("mesh_vertices", meshes.meshes.vertices.binding()),
        ("mesh_positions", meshes.positions.binding()),
        terrain,
    ];
    recorder.indirect("surface/meshes/vertices", &meshes.draws, VERTEX_GROUPS, &resources);
}
