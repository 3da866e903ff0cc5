//! The curvature of the meshes, written over that of the land. See `shaders/surface/meshes/curvature.wgsl`, and
//! [`crate::mesh::curvature`] for how it is estimated.

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

/// Curvature of each vertex of the meshes.
const SHAPES: BufferKind = BufferKind::storage("mesh shapes");

/// Inputs and outputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    pub meshes: &'a DrawnMeshes,
    /// Size of a feature, in pixels.
    pub feature_px: f32,
    /// Surface ids, which identify the triangles.
    pub surface_id: &'a Target,
    pub distance: &'a Target,
    pub normal: &'a Target,
    /// Written at the pixels of meshes.
    pub shapes: &'a Shapes,
}

/// The curvature at the vertices of a world's meshes.
struct MeshShapes {
    placed: Arc<Placed>,
    shapes: Buffer,
}

/// Returns the shapes in the order of the vertices.
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

/// Writes the curvature where a mesh is seen. The curvature at vertices is computed in the background, if pipelines are
/// built there.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let placed = &inputs.meshes.meshes.placed;
    let theirs = Arc::clone(placed);
    let made = recorder.cached_in_background(
        |known: &MeshShapes| Arc::ptr_eq(&known.placed, placed),
        move |gpu| {
            let shapes = Buffer::with(gpu, &SHAPES, &packed(&theirs));
            MeshShapes { placed: theirs, shapes }
        },
    );
    let Some(made) = made else {
        // The pipeline can be compiled meanwhile.
        if recorder.prewarms() {
            recorder.pixels("surface/meshes/curvature", inputs.shapes.normal.size_px(), &[]);
        }
        return;
    };
    let rules = CurvatureRules { feature_px: inputs.feature_px };
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("curvature_rules", recorder.uniform("curvature rules", &rules)),
        ("surface_id", inputs.surface_id.into()),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
        ("mesh_shapes", made.shapes.binding()),
    ];
    resources.extend(inputs.shapes.resources());
    resources.extend(inputs.meshes.resources());
    recorder.pixels("surface/meshes/curvature", inputs.shapes.normal.size_px(), &resources);
}
