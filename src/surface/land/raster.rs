//! Draws the selected patches: depth and surface id. See `shaders/surface/land/raster.wgsl`.

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
    name: "surface/land/raster",
    definitions: &[],
    fragment: "solid",
    colors: [replaced(ID_FORMAT), None, None, None, None],
    depth: Some(DEPTH_FORMAT),
    writes_depth: true,
    topology: wgpu::PrimitiveTopology::TriangleList,
};
const WITH_HOLES: Draw = Draw { fragment: "with_holes", ..SOLID };

/// What the pass reads and where it writes.
pub struct Inputs<'a> {
    /// `View`.
    pub view: &'a Resource,
    /// What `shaders/shared/terrain.wgsl` and `shared/surface.wgsl` declare.
    pub terrain: &'a [Named],
    /// The patches and their vertices.
    pub mesh: &'a PatchMesh,
    /// Of the mesh.
    pub batch: [u32; 2],
    /// Whether the pictures are cleared before.
    pub clears: bool,
    /// [`DEPTH`](crate::surface::DEPTH).
    pub depth: &'a Target,
    /// [`SURFACE_ID`](crate::surface::SURFACE_ID).
    pub surface_id: &'a Target,
}

/// Draws a batch of patches.
pub fn run(recorder: &mut Recorder<'_>, inputs: &Inputs<'_>) {
    let mut resources = vec![("view", inputs.view.clone())];
    resources.extend(inputs.mesh.resources(inputs.batch));
    // The fragments of patches without holes read nothing.
    let solid = recorder.drawing(&SOLID, &resources);
    resources.extend(inputs.terrain.iter().cloned());
    let with_holes = recorder.drawing(&WITH_HOLES, &resources);
    let indices = indices(recorder);
    let [first, count] = inputs.batch;
    let on = Attachments {
        colors: &[inputs.surface_id],
        depth: Some(inputs.depth),
        clears: if inputs.clears { Clears::All } else { Clears::Nothing },
    };
    let solid_count = inputs.mesh.solid.saturating_sub(first).min(count);
    recorder.render(SOLID.name, &[&solid, &with_holes], on, |pass| {
        pass.set_index_buffer(indices.0.buffer().slice(..), wgpu::IndexFormat::Uint16);
        let index_count = 6 * PATCH_QUADS * PATCH_QUADS;
        solid.set(pass);
        pass.draw_indexed(0..index_count, 0, 0..solid_count);
        with_holes.set(pass);
        pass.draw_indexed(0..index_count, 0, solid_count..count);
    });
}

/// The indices of a patch on the GPU.
struct Indices(GrowingBuffer);

fn indices(recorder: &mut Recorder<'_>) -> std::sync::Arc<Indices> {
    let made = recorder.kept(
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

/// Both triangles of each quad, split along its (0, 0) to (1, 1) diagonal: the one that mesh errors are measured with.
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
