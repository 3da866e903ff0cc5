//! Draws the selected patches: depth, and surface ids if they are wanted. See `shaders/surface/land/raster.wgsl`.

use std::convert::Infallible;

use super::vertices::PatchMesh;
use crate::gpu::bind::{Named, Resource};
use crate::gpu::buffer::GrowingBuffer;
use crate::gpu::pipelines::{Draw, replaced};
use crate::gpu::recorder::{Attachments, Clears, Recorder};
use crate::gpu::target::Target;
use crate::pyramid::tile::PATCH_QUADS;
use crate::surface::{DEPTH_FORMAT, ID_FORMAT};

const SOLID: Draw = Draw {
    fragment: "solid",
    colors: [replaced(ID_FORMAT), None, None, None, None],
    depth: Some(DEPTH_FORMAT),
    writes_depth: true,
    ..Draw::triangles("surface/land/raster")
};
const WITH_HOLES: Draw = Draw { fragment: "with_holes", ..SOLID };
/// The same without surface ids.
const SOLID_DEPTH: Draw = Draw { fragment: "", colors: [None, None, None, None, None], ..SOLID };
const DEPTH_WITH_HOLES: Draw = Draw { fragment: "only_holes", ..SOLID_DEPTH };

/// Inputs and outputs of the pass.
pub(crate) struct Inputs<'a> {
    pub view: &'a Resource,
    /// Bindings of `shaders/shared/terrain.wgsl` and `shared/surface.wgsl`.
    pub terrain: &'a [Named],
    pub mesh: &'a PatchMesh,
    /// First patch and number of patches of the batch whose vertices are in the mesh.
    pub batch: [u32; 2],
    /// Whether the targets are cleared first.
    pub clears: bool,
    pub depth: &'a Target,
    /// `None` if no surface ids are wanted.
    pub surface_id: Option<&'a Target>,
}

/// Draws a batch of patches.
pub(crate) fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let [of_solid, of_holes] =
        if inputs.surface_id.is_some() { [&SOLID, &WITH_HOLES] } else { [&SOLID_DEPTH, &DEPTH_WITH_HOLES] };
    let mut resources = vec![("view", inputs.view.clone())];
    resources.extend(inputs.mesh.resources(inputs.batch));
    // The fragment shader of patches without holes does not read the terrain.
    let solid = recorder.drawing(of_solid, &resources);
    resources.extend(inputs.terrain.iter().cloned());
    let with_holes = recorder.drawing(of_holes, &resources);
    let indices = indices(recorder);
    let [first, count] = inputs.batch;
    let on = Attachments {
        colors: inputs.surface_id.as_slice(),
        depth: Some(inputs.depth),
        clears: if inputs.clears { Clears::All } else { Clears::Nothing },
    };
    let solid_count = inputs.mesh.solid.saturating_sub(first).min(count);
    let has_holes = solid_count < count;
    let drawings: &[_] = if has_holes { &[&solid, &with_holes] } else { &[&solid] };
    recorder.render(SOLID.name, drawings, on, |pass| {
        pass.set_index_buffer(indices.0.buffer().slice(..), wgpu::IndexFormat::Uint16);
        let index_count = 6 * PATCH_QUADS * PATCH_QUADS;
        solid.set(pass);
        pass.draw_indexed(0..index_count, 0, 0..solid_count);
        if has_holes {
            with_holes.set(pass);
            pass.draw_indexed(0..index_count, 0, solid_count..count);
        }
    });
}

/// The index buffer of a patch, which is the same for all patches.
struct Indices(GrowingBuffer);

fn indices(recorder: &mut Recorder<'_>) -> std::sync::Arc<Indices> {
    let made = recorder.cached(
        |_: &Indices| true,
        |gpu| {
            let mut buffer = GrowingBuffer::new(gpu, "patch indices", wgpu::BufferUsages::INDEX);
            buffer.write(gpu, &patch_indices());
            Ok::<_, Infallible>(Indices(buffer))
        },
    );
    let Ok(indices) = made;
    indices
}

/// Returns the indices of both triangles of each quad, split along the diagonal from (0, 0) to (1, 1), with which mesh
/// errors are measured.
fn patch_indices() -> Vec<u16> {
    let side = PATCH_QUADS as u16 + 1;
    let mut indices = Vec::with_capacity(6 * PATCH_QUADS as usize * PATCH_QUADS as usize);
    for y in 0..PATCH_QUADS as u16 {
        for x in 0..PATCH_QUADS as u16 {
            let here = y * side + x;
            indices.extend([here, here + 1, here + side + 1, here, here + side + 1, here + side]);
        }
    }
    indices
}
