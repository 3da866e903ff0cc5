//! Meshes that stand on the land.
//!
//! The CPU hands over what stands where, once for a world. What an eye sees of it ([`cull`]), and at which level of
//! detail, is found on the GPU in each frame: the passes after it are dispatched and drawn indirectly, so a frame costs
//! the CPU the same for one hut and for a town. What is in view comes into a list in the order of the scene, and places of
//! vertices are given out in that order, so memory follows what is in view ([`Placed::room`]).
//!
//! **Surface ids.** A triangle of an instance has a number that never changes: the levels of all that stands in the world
//! are counted through, instance by instance and level by level. So while an instance keeps its level, its triangles and
//! the keys of its edges are the same from frame to frame, whatever else comes into view; a level that is left and taken
//! up again has the numbers that it had; and both eyes of a rig, which choose levels by their common origin, have the same.
//!
//! Why: `docs/decisions/mesh-passes.md`.

pub mod cull;
pub mod curvature;
pub mod edges;
mod instances;
pub mod raster;
pub mod resolve;
mod sides;
pub mod vertices;

pub(crate) use self::instances::MeshInstance;
use std::convert::Infallible;
use std::sync::Arc;

use self::instances::{levels, levels_of, packed, standings};
use crate::gpu::Gpu;
use crate::gpu::bind::Named;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::mesh::placed::{Placed, Room};

/// Vertices of the meshes themselves.
const VERTICES: BufferKind = BufferKind::storage("mesh vertices");
/// [`MeshTriangle`]s of the meshes themselves.
const TRIANGLES: BufferKind = BufferKind::storage("mesh triangles");
/// [`Standing`]s.
const STANDINGS: BufferKind = BufferKind::storage("mesh standings");
/// `MeshLevel`s.
const LEVELS: BufferKind = BufferKind::storage("mesh levels");
/// `MeshInstance`s of what an eye sees, in the order of the scene; the first one has their number.
pub const INSTANCES: BufferKind = BufferKind::storage("mesh instances");
/// What is dispatched and drawn: see [`cull`].
pub const DRAWS: BufferKind = BufferKind::indirect("mesh draws");
/// Vertices of what is in view, metres from the rig's origin, in the order of the list.
pub const POSITIONS: BufferKind = BufferKind::storage("mesh positions");

/// The meshes of a world on the GPU.
struct MeshBuffers {
    placed: Arc<Placed>,
    vertices: Buffer,
    triangles: Buffer,
    levels: Buffer,
    standings: Buffer,
    room: Room,
}

impl MeshBuffers {
    fn new(gpu: &Gpu, placed: &Arc<Placed>) -> Self {
        let all = || (0..placed.meshes.len()).flat_map(|mesh| levels_of(placed, mesh));
        let vertices: Vec<_> = all().flat_map(|level| level.vertices().collect::<Vec<_>>()).collect();
        let triangles: Vec<_> = all().flat_map(|level| packed(level.mesh)).collect();
        let (levels, firsts) = levels(placed);
        Self {
            placed: Arc::clone(placed),
            vertices: Buffer::with(gpu, &VERTICES, &vertices),
            triangles: Buffer::with(gpu, &TRIANGLES, &triangles),
            standings: Buffer::with(gpu, &STANDINGS, &standings(placed, &levels, &firsts)),
            levels: Buffer::with(gpu, &LEVELS, &levels),
            room: placed.room(),
        }
    }
}

/// The meshes of a frame.
pub struct DrawnMeshes {
    meshes: Arc<MeshBuffers>,
    /// Room for as many as stand in the world.
    instances: Buffer,
    positions: Buffer,
    draws: Buffer,
}

impl DrawnMeshes {
    /// Of a world; what they are on the GPU is made when they are others than before.
    pub fn of(recorder: &mut Recorder<'_>, placed: &Arc<Placed>) -> Self {
        let meshes = recorder.kept(
            |known: &MeshBuffers| Arc::ptr_eq(&known.placed, placed),
            |gpu| Ok::<_, Infallible>(MeshBuffers::new(gpu, placed)),
        );
        let Ok(meshes) = meshes;
        let bytes = (placed.standing.len().max(1) * size_of::<MeshInstance>()) as u64;
        Self {
            instances: recorder.buffer(&INSTANCES, bytes).slice(0, bytes),
            positions: recorder.buffer(&POSITIONS, meshes.room.vertices * size_of::<[f32; 4]>() as u64),
            draws: recorder.buffer(&DRAWS, size_of::<cull::MeshDraws>() as u64),
            meshes,
        }
    }

    /// How many stand in the world.
    fn standing(&self) -> u32 {
        self.meshes.placed.standing.len() as u32
    }

    /// Whether there are more vertices in the world than a view has room for.
    fn may_lack_room(&self) -> bool {
        self.meshes.placed.vertices() > self.meshes.room.vertices
    }

    /// What a view has room for.
    fn room(&self) -> Room {
        self.meshes.room
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
