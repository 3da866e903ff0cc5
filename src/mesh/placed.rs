//! Meshes and their placement in the world.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::levels::{Level, MAX_LEVELS};
use super::{Mesh, MeshError};

/// Largest number of vertices of all different meshes: as many positions as a binding of 128 MiB holds.
pub(crate) const MAX_VERTICES: u64 = 1 << 23;
/// Largest number of triangles of all different meshes, levels included: 40 bytes each in such a binding.
pub(crate) const MAX_TRIANGLES: u64 = (128 << 20) / 40;
/// Largest number of mesh instances in a world.
pub(crate) const MAX_INSTANCES: u64 = 1 << 16;
/// Largest number of triangles of all instances, each level counted separately: the number of surface ids for meshes.
pub(crate) const MAX_SURFACE_IDS: u64 = 1 << 30;
/// Number of vertices, and of triangles with edges, that a view has room for, unless twice those of all different
/// meshes is more.
const ROOM: u64 = 1 << 22;

/// An instance of a mesh. Several may share a mesh.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Standing {
    /// Index into [`Placed::meshes`].
    pub mesh: usize,
    /// Position of the mesh's centre in the world, in metres.
    pub middle_m: DVec3,
    /// Rotation and scale of the mesh, whose vertices are relative to its centre.
    pub world_from_mesh: DMat3,
    /// World metres per unit of the mesh.
    pub scale: f64,
}

/// The mesh instances of a world.
#[derive(Clone, Debug, Default)]
pub(crate) struct Placed {
    /// The different meshes.
    pub meshes: Vec<Arc<Mesh>>,
    /// The instances, in the order of the scene.
    pub standing: Vec<Standing>,
    /// The coarser levels of each mesh, finest first.
    coarser: Vec<Vec<Level>>,
    all: Counts,
    limit: Option<Room>,
}

/// Numbers of vertices and triangles of all instances without levels, and of triangles with levels.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    vertices: u64,
    triangles: u64,
    numbers: u64,
}

/// The capacity of a view for mesh geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Room {
    /// Number of vertices in view.
    pub vertices: u64,
    /// Number of triangles whose edges are found.
    pub triangles: u64,
}

/// The placement of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stance {
    /// Position of the mesh's origin in the world, in metres.
    pub origin_m: DVec3,
    /// Rotation clockwise as seen from above, in degrees.
    pub yaw_deg: f64,
    /// World metres per unit of the file.
    pub scale: f64,
    /// Whether the file's z axis points up; otherwise its y axis points up and its z axis to the south.
    pub z_up: bool,
}

impl Stance {
    /// Returns the rotation and scale of the file's coordinates.
    pub(crate) fn world_from_mesh(&self) -> DMat3 {
        let up = if self.z_up { DMat3::IDENTITY } else { DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y) };
        DMat3::from_rotation_z(-self.yaw_deg.to_radians()) * up * self.scale
    }
}

impl Placed {
    /// Adds an instance; a mesh that has been placed already is shared.
    ///
    /// # Errors
    /// [`MeshError::TooMany`] if a limit is exceeded.
    pub(crate) fn add(&mut self, mesh: &Arc<Mesh>, stance: &Stance) -> Result<(), MeshError> {
        let number = match self.meshes.iter().position(|known| Arc::ptr_eq(known, mesh)) {
            Some(number) => number,
            None => {
                self.add_mesh(mesh)?;
                self.meshes.len() - 1
            }
        };
        let levels = self.coarser[number].iter().map(|level| level.mesh.triangles.len() as u64);
        let all = Counts {
            vertices: self.all.vertices + mesh.vertices_m.len() as u64,
            triangles: self.all.triangles + mesh.triangles.len() as u64,
            numbers: self.all.numbers + mesh.triangles.len() as u64 + levels.sum::<u64>(),
        };
        let standing = self.standing.len() as u64 + 1;
        for (what, found, most) in [("places", standing, MAX_INSTANCES), ("triangles", all.numbers, MAX_SURFACE_IDS)] {
            if found > most {
                return Err(MeshError::TooMany { what, found, most });
            }
        }
        self.all = all;
        let world_from_mesh = stance.world_from_mesh();
        self.standing.push(Standing {
            mesh: number,
            middle_m: stance.origin_m + world_from_mesh * mesh.middle_m,
            world_from_mesh,
            scale: stance.scale,
        });
        Ok(())
    }

    fn add_mesh(&mut self, mesh: &Arc<Mesh>) -> Result<(), MeshError> {
        let over = |placed: &Self| {
            let [vertices, triangles] = placed.own(mesh);
            let counts =
                [("different vertices", vertices, MAX_VERTICES), ("different triangles", triangles, MAX_TRIANGLES)];
            counts.into_iter().find(|(_, found, most)| found > most)
        };
        if over(self).is_some() {
            // Full meshes have priority over coarser levels.
            self.coarser.iter_mut().for_each(Vec::clear);
        }
        if let Some((what, found, most)) = over(self) {
            return Err(MeshError::TooMany { what, found, most });
        }
        self.meshes.push(Arc::clone(mesh));
        self.coarser.push(Vec::new());
        Ok(())
    }

    /// Adds a mesh without an instance, with its coarser levels, finest first, as many as fit.
    ///
    /// # Errors
    /// [`MeshError::TooMany`] if a limit is exceeded.
    pub(crate) fn add_levels(&mut self, mesh: &Arc<Mesh>, levels: Vec<Level>) -> Result<(), MeshError> {
        self.add_mesh(mesh)?;
        for level in levels.into_iter().take(MAX_LEVELS - 1) {
            let [vertices, triangles] = self.own(&level.mesh);
            if vertices <= MAX_VERTICES && triangles <= MAX_TRIANGLES {
                self.coarser.last_mut().into_iter().for_each(|levels| levels.push(level.clone()));
            }
        }
        Ok(())
    }

    /// Returns the numbers of vertices and triangles of all different meshes, with their levels and `mesh`.
    fn own(&self, mesh: &Mesh) -> [u64; 2] {
        let meshes = self.meshes.iter().map(|mesh| &**mesh);
        let levels = self.coarser.iter().flatten().map(|level| &level.mesh);
        let all = meshes.chain(levels).chain([mesh]);
        let counts = |mesh: &Mesh| [mesh.vertices_m.len() as u64, mesh.triangles.len() as u64];
        all.map(counts).fold([0, 0], |sum, own| [sum[0] + own[0], sum[1] + own[1]])
    }

    /// Returns the coarser levels of one of [`Placed::meshes`], finest first.
    pub(crate) fn coarser(&self, mesh: usize) -> &[Level] {
        &self.coarser[mesh]
    }

    /// Returns the number of vertices of all instances, at their finest levels.
    pub(crate) fn vertices(&self) -> u64 {
        self.all.vertices
    }

    /// Limits the capacity of views.
    #[cfg(test)]
    pub(crate) fn limit_room(&mut self, room: Room) {
        self.limit = Some(room);
    }

    /// Returns the capacity of a view: for all instances, or where these are many, for twice the geometry of all
    /// different meshes.
    pub(crate) fn room(&self) -> Room {
        let [vertices, triangles] = self.meshes.iter().fold([0, 0], |[vertices, triangles], mesh| {
            [vertices + mesh.vertices_m.len() as u64, triangles + mesh.triangles.len() as u64]
        });
        let of = |all: u64, own: u64| all.min((2 * own).max(ROOM)).clamp(1, MAX_VERTICES);
        let limit = self.limit.unwrap_or(Room { vertices: u64::MAX, triangles: u64::MAX });
        Room {
            vertices: of(self.all.vertices, vertices).min(limit.vertices),
            triangles: of(self.all.triangles, triangles).min(limit.triangles),
        }
    }

    /// Returns the mesh of an instance.
    pub(crate) fn mesh(&self, standing: &Standing) -> &Mesh {
        &self.meshes[standing.mesh]
    }

    /// Returns the distance in metres to the nearest instance's contours, which are on its far sides too.
    pub(crate) fn nearest_m(&self, camera_m: DVec3) -> f64 {
        let distance_m = |standing: &Standing| {
            let radius_m = self.mesh(standing).radius_m * standing.scale;
            (standing.middle_m.distance(camera_m) - radius_m).max(0.2 * radius_m)
        };
        self.standing.iter().map(distance_m).fold(f64::INFINITY, f64::min)
    }
}
