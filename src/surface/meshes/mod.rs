//! Meshes that stand on the land.
//!
//! The CPU hands over what stands where, once for a world. What an eye sees of it ([`cull`]) is found on the GPU in
//! each frame: the passes after it are dispatched and drawn indirectly, so a frame costs the CPU the same for one hut
//! and for a town.
//!
//! Why: `docs/decisions/mesh-passes.md`.

pub mod cull;
pub mod edges;
mod instances;
pub mod raster;
pub mod resolve;
mod sides;
pub mod vertices;

pub(crate) use self::instances::MeshInstance;
use std::convert::Infallible;
use std::sync::Arc;

use self::instances::{packed, standings};
use crate::gpu::Gpu;
use crate::gpu::bind::Named;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Cx;
use crate::mesh::placed::Placed;

/// Vertices of the meshes themselves.
const VERTICES: BufferKind = BufferKind::storage("mesh vertices");
/// [`MeshTriangle`]s of the meshes themselves.
const TRIANGLES: BufferKind = BufferKind::storage("mesh triangles");
/// [`Standing`]s.
const STANDINGS: BufferKind = BufferKind::storage("mesh standings");
/// `MeshInstance`s of an eye.
pub const INSTANCES: BufferKind = BufferKind::storage("mesh instances");
/// What is dispatched and drawn: see [`cull`].
const DRAWS: BufferKind = BufferKind::indirect("mesh draws");
/// Vertices of all that stands in the world, metres from the rig's origin; those of what is not in view mean nothing.
pub const POSITIONS: BufferKind = BufferKind::storage("mesh positions");

/// The meshes of a world on the GPU.
struct MeshBuffers {
    placed: Arc<Placed>,
    vertices: Buffer,
    triangles: Buffer,
    standings: Buffer,
}

impl MeshBuffers {
    fn new(gpu: &Gpu, placed: &Arc<Placed>) -> Self {
        let vertices: Vec<_> = placed.meshes.iter().flat_map(|mesh| &mesh.vertices_m).collect();
        let vertices: Vec<_> = vertices.into_iter().map(|[x, y, z]| [*x, *y, *z, 1.0]).collect();
        let triangles: Vec<_> = placed.meshes.iter().flat_map(|mesh| packed(mesh)).collect();
        Self {
            placed: Arc::clone(placed),
            vertices: Buffer::with(gpu, &VERTICES, &vertices),
            triangles: Buffer::with(gpu, &TRIANGLES, &triangles),
            standings: Buffer::with(gpu, &STANDINGS, &standings(placed)),
        }
    }
}

/// The meshes of a frame.
pub struct DrawnMeshes {
    meshes: Arc<MeshBuffers>,
    /// As many as stand in the world: the shaders ask how many there are.
    instances: Buffer,
    positions: Buffer,
    draws: Buffer,
}

impl DrawnMeshes {
    /// Of a world; what they are on the GPU is made when they are others than before.
    pub fn of(cx: &mut Cx<'_>, placed: &Arc<Placed>) -> Self {
        let meshes = cx.kept(
            |known: &MeshBuffers| Arc::ptr_eq(&known.placed, placed),
            |gpu| Ok::<_, Infallible>(MeshBuffers::new(gpu, placed)),
        );
        let Ok(meshes) = meshes;
        let bytes = (placed.standing.len().max(1) * size_of::<MeshInstance>()) as u64;
        Self {
            instances: cx.buffer(&INSTANCES, bytes).slice(0, bytes),
            positions: cx.buffer(&POSITIONS, placed.vertices() * size_of::<[f32; 4]>() as u64),
            draws: cx.buffer(&DRAWS, size_of::<cull::MeshDraws>() as u64),
            meshes,
        }
    }

    /// What stands in the world.
    fn placed(&self) -> &Placed {
        &self.meshes.placed
    }

    /// What `shaders/shared/meshes.wgsl` declares, for the passes after [`vertices`].
    pub fn resources(&self) -> [Named; 3] {
        [
            ("mesh_instances", self.instances.binding()),
            ("mesh_triangles", self.meshes.triangles.binding()),
            ("mesh_places", self.positions.binding()),
        ]
    }
}
