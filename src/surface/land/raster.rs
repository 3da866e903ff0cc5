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
/// The passes without surface ids.
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

/// Quads across a column of quads. GPUs run vertex shaders for batches of 32 vertices, or remember the last 16: the next
/// row of so narrow a column still finds the vertices of the row before it.
const COLUMN_QUADS: u16 = 4;

/// Returns the indices of both triangles of each quad, split along the diagonal from (0, 0) to (1, 1), with which mesh
/// errors are measured. The quads come column by column.
fn patch_indices() -> Vec<u16> {
    indices_in_columns(COLUMN_QUADS)
}

fn indices_in_columns(column_quads: u16) -> Vec<u16> {
    let (quads, side) = (PATCH_QUADS as u16, PATCH_QUADS as u16 + 1);
    let mut indices = Vec::with_capacity(6 * PATCH_QUADS as usize * PATCH_QUADS as usize);
    for first in (0..quads).step_by(column_quads.into()) {
        for y in 0..quads {
            for x in first..(first + column_quads).min(quads) {
                let here = y * side + x;
                indices.extend([here, here + 1, here + side + 1, here, here + side + 1, here + side]);
            }
        }
    }
    indices
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeSet, VecDeque};

    use super::*;

    /// Returns how many vertices are shaded per triangle by a GPU that remembers the last 16.
    fn by_queue(indices: &[u16]) -> f64 {
        let (mut queue, mut shaded) = (VecDeque::new(), 0);
        for index in indices {
            if !queue.contains(index) {
                queue.push_back(*index);
                shaded += 1;
            }
            if queue.len() > 16 {
                queue.pop_front();
            }
        }
        f64::from(shaded) / (indices.len() / 3) as f64
    }

    /// Returns the same for a GPU that shades batches of triangles with at most 32 vertices and 96 indices.
    fn by_batches(indices: &[u16]) -> f64 {
        let (mut batch, mut triangles, mut shaded) = (BTreeSet::new(), 0, 0);
        for triangle in indices.chunks_exact(3) {
            let mut with = batch.clone();
            with.extend(triangle);
            if with.len() > 32 || triangles == 32 {
                shaded += batch.len();
                (with, triangles) = (triangle.iter().collect(), 0);
            }
            (batch, triangles) = (with, triangles + 1);
        }
        (shaded + batch.len()) as f64 / (indices.len() / 3) as f64
    }

    #[test]
    fn few_vertices_of_a_patch_are_shaded_twice() {
        let [own, by_rows] = [patch_indices(), indices_in_columns(PATCH_QUADS as u16)];
        let triangles = |indices: &[u16]| indices.chunks_exact(3).map(<[u16]>::to_vec).collect::<BTreeSet<_>>();
        assert_eq!(triangles(&own), triangles(&by_rows));
        assert_eq!(triangles(&own).len(), 2 * PATCH_QUADS as usize * PATCH_QUADS as usize);
        let [queue, batches] = [by_queue(&own), by_batches(&own)];
        let [queue_by_rows, batches_by_rows] = [by_queue(&by_rows), by_batches(&by_rows)];
        assert!(queue < 0.7 && batches < 0.85, "{queue} and {batches} vertices per triangle");
        // Planted error: row by row.
        assert!(queue_by_rows > 1.0 && batches_by_rows > 1.0);
    }
}
