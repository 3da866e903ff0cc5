//! Computes the attributes of each pixel of a mesh from its surface id: distance and normal, written over those of the
//! land, and in some styles the local colour. See `shaders/surface/meshes/resolve.wgsl`.

use std::convert::Infallible;
use std::sync::Arc;

use super::DrawnMeshes;
use super::instances::levels_of;
use crate::gpu::bind::Resource;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::pipelines::Compute;
use crate::gpu::recorder::Recorder;
use crate::gpu::target::Target;
use crate::mesh::placed::Placed;
use crate::mesh::{Material, Mesh};
use crate::surface::local_color;

/// Local colour of each triangle of the meshes ([`local_color::packed`]).
const LOCAL_COLORS: BufferKind = BufferKind::storage("mesh colors");

/// Inputs and outputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    pub meshes: &'a DrawnMeshes,
    /// Surface ids, which identify the triangles.
    pub surface_id: &'a Target,
    /// Depth as rasterised.
    pub depth: &'a Target,
    pub distance: &'a Target,
    /// [`NORMAL_AND_LIGHTNESS`](crate::surface::NORMAL_AND_LIGHTNESS).
    pub normal: &'a Target,
    /// Target for local colours, [`LOCAL_COLOR`](local_color::LOCAL_COLOR), if the style needs them.
    pub local_color: Option<&'a Target>,
}

/// The local colours of all triangles of a world's meshes, on the GPU.
struct MeshLocalColors {
    placed: Arc<Placed>,
    colors: Buffer,
}

/// Returns the local colour of each triangle, in their order on the GPU.
fn local_colors_of(placed: &Placed) -> Vec<u32> {
    let of_mesh = |mesh: &Mesh| {
        let colors: Vec<u32> = mesh.materials.iter().map(local_color_of).collect();
        mesh.triangles.iter().map(move |triangle| colors[usize::from(triangle.material)]).collect::<Vec<_>>()
    };
    let levels = (0..placed.meshes.len()).flat_map(|mesh| levels_of(placed, mesh));
    levels.flat_map(|level| of_mesh(level.mesh)).collect()
}

/// Returns the local colour of a material. A material without a colour of its own has none: it is coloured as the land
/// is.
fn local_color_of(material: &Material) -> u32 {
    if material.color == Material::PLAIN_COLOR { local_color::NONE } else { local_color::packed(material.color) }
}

/// Writes `distance` and `normal` where a mesh is seen, and `local_color` if there is one.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut resources = vec![
        ("view", inputs.view.clone()),
        ("surface_id", inputs.surface_id.into()),
        ("depth", inputs.depth.into()),
        ("distance_m", inputs.distance.into()),
        ("normal", inputs.normal.into()),
    ];
    resources.extend(inputs.meshes.resources());
    let mut definitions: &[&str] = &[];
    if let Some(local_color) = inputs.local_color {
        let placed = &inputs.meshes.meshes.placed;
        let made = recorder.cached(
            |known: &MeshLocalColors| Arc::ptr_eq(&known.placed, placed),
            |gpu| {
                let colors = Buffer::with(gpu, &LOCAL_COLORS, &local_colors_of(placed));
                Ok::<_, Infallible>(MeshLocalColors { placed: Arc::clone(placed), colors })
            },
        );
        let Ok(made) = made;
        resources.extend([("mesh_colors", made.colors.binding()), ("local_color", local_color.into())]);
        definitions = &["LOCAL_COLOR"];
    }
    let pass = Compute { name: "surface/meshes/resolve", definitions };
    recorder.pixels(pass, inputs.distance.size_px(), &resources);
}
