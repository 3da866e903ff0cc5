//! Meshes placed on the land.
//!
//! The CPU uploads the meshes and their instances once per world. The visible instances and their levels of detail are
//! found on the GPU in each frame ([`cull`]), and the later passes are dispatched and drawn indirectly, so a frame
//! costs the CPU the same for one hut and for a town. Visible instances are listed in the order of the scene, and
//! vertex slots are allocated in that order, so memory depends on what is in view ([`Placed::room`]).
//!
//! **Surface ids.** A triangle of an instance has a number that never changes: the triangles of all levels of all
//! instances of the world are numbered consecutively, instance by instance and level by level. So while an instance
//! keeps its level, its triangles and the keys of its edges are the same from frame to frame, whatever else comes into
//! view; an instance that returns to a level has the same numbers as before; and both eyes of a rig, which choose
//! levels by their common origin, have the same numbers.
//!
//! Why: `docs/decisions/mesh-passes.md`.

pub(crate) mod cull;
pub(crate) mod curvature;
pub(crate) mod edges;
mod instances;
pub(crate) mod raster;
pub(crate) mod resolve;
mod sides;
pub(crate) mod vertices;

pub(crate) use self::instances::MeshInstance;
use std::convert::Infallible;
use std::sync::Arc;

use self::instances::{levels, levels_of, packed, standings};
use crate::gpu::Gpu;
use crate::gpu::bind::Named;
use crate::gpu::buffer::{Buffer, BufferKind};
use crate::gpu::recorder::Recorder;
use crate::mesh::placed::{Placed, Room};

/// Vertices of the meshes, in mesh space.
const VERTICES: BufferKind = BufferKind::storage("mesh vertices");
/// [`MeshTriangle`]s of the meshes.
const TRIANGLES: BufferKind = BufferKind::storage("mesh triangles");
/// [`Standing`]s.
const STANDINGS: BufferKind = BufferKind::storage("mesh standings");
const LEVELS: BufferKind = BufferKind::storage("mesh levels");
/// `MeshInstance`s in view, in the order of the scene; the first one holds their number.
pub(crate) const INSTANCES: BufferKind = BufferKind::storage("mesh instances");
/// Arguments of the indirect dispatches and draws: see [`cull`].
pub(crate) const DRAWS: BufferKind = BufferKind::indirect("mesh draws");
/// Vertices of the instances in view, in metres from the rig's origin, in the order of [`INSTANCES`].
pub(crate) const POSITIONS: BufferKind = BufferKind::storage("mesh positions");

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

/// The meshes of one frame.
pub(crate) struct DrawnMeshes {
    meshes: Arc<MeshBuffers>,
    /// Has room for all instances of the world.
    instances: Buffer,
    positions: Buffer,
    draws: Buffer,
}

impl DrawnMeshes {
    /// Allocates the buffers of a frame; the meshes are uploaded if `placed` is another world's than before.
    pub(crate) fn of(recorder: &mut Recorder<'_>, placed: &Arc<Placed>) -> Self {
        let meshes = recorder.cached(
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

    /// Returns the number of instances in the world.
    fn standing(&self) -> u32 {
        self.meshes.placed.standing.len() as u32
    }

    /// Returns whether the world has more vertices than a view has room for.
    fn may_lack_room(&self) -> bool {
        self.meshes.placed.vertices() > self.meshes.room.vertices
    }

    /// Returns the capacity of a view.
    fn room(&self) -> Room {
        self.meshes.room
    }

    /// Returns the bindings of `shaders/shared/meshes.wgsl`, for the passes after [`vertices`].
    pub(crate) fn resources(&self) -> [Named; 3] {
        [
            ("mesh_instances", self.instances.binding()),
            ("mesh_triangles", self.meshes.triangles.binding()),
            ("mesh_places", self.positions.binding()),
        ]
    }
}
