//! How the meshes bend, over what the land says. See `shaders/surface/meshes/curvature.wgsl`, and
//! [`crate::mesh::curvature`] for how it is found.

use std::sync::Arc;

use super::DrawnMeshes;
use super::instances::levels_of;
use crate::gpu::bind::Resource;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::gpu::wgsl::surface::meshes::curvature::{CurvatureRules, VertexShape};
use crate::mesh::curvature::shapes_of;
use crate::mesh::placed::Placed;
use crate::surface::curvature::Shapes;

/// Of each vertex of the meshes themselves.
const SHAPES: BufferKind = BufferKind::storage("mesh shapes");

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// The meshes and their vertices.
    pub meshes: &'a DrawnMeshes,
    /// Size of a feature, in pixels.
    pub feature_px: f32,
    /// Which triangle.
    pub surface_id: &'a Target,
    /// Of the surface.
    pub position: &'a Target,
    /// Of the surface.
    pub normal: &'a Target,
    /// Out, at the pixels of meshes.
    pub shapes: &'a Shapes,
}

/// How the vertices of a world's meshes bend.
struct MeshShapes {
    placed: Arc<Placed>,
    shapes: Buffer,
}

/// In the order of the vertices.
fn packed(placed: &Placed) -> Vec<VertexShape> {
    let levels = (0..placed.meshes.len()).flat_map(|mesh| levels_of(placed, mesh));
    let of_vertex = |shape: crate::mesh::curvature::VertexShape| VertexShape {
        normal: shape.normal.as_vec3().to_array(),
        bend: shape.bend.map(|part| part as f32),
        change: shape.change.map(|part| part as f32),
        ..bytemuck::Zeroable::zeroed()
    };
    levels.flat_map(|level| shapes_of(level.mesh)).map(of_vertex).collect()
}

/// Writes the shapes where a mesh is seen. Those of its vertices are found beside the frame, where pipelines are built
/// there.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let placed = &inputs.meshes.meshes.placed;
    let theirs = Arc::clone(placed);
    let made = recorder.cached_in_background(
        |known: &MeshShapes| Arc::ptr_eq(&known.placed, placed),
        move |gpu| {
            let shapes = Buffer::with(gpu, &SHAPES, &packed(&theirs));
            MeshShapes { placed: theirs, shapes }
        },
    );
    let Some(made) = made else { return };
    let rules = CurvatureRules { feature_px: inputs.feature_px };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("curvature_rules", recorder.uniform("curvature rules", &rules)),
        ("surface_id", inputs.surface_id.into()),
        ("position", inputs.position.into()),
        ("normal", inputs.normal.into()),
        ("mesh_shapes", made.shapes.binding()),
    ];
    resources.extend(inputs.shapes.resources());
    resources.extend(inputs.meshes.resources());
    recorder.pixels("surface/meshes/curvature", inputs.shapes.normal.size_px(), &resources);
}
