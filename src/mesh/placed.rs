//! Meshes in the world.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::levels::{Level, MOST_LEVELS};
use super::{Mesh, MeshError};

/// Vertices of all different meshes, at most. A binding of 128 MiB holds so many positions.
pub const MOST: u64 = 1 << 23;
/// Triangles of all different meshes, at most: 40 bytes each in such a binding. Levels count, too.
pub const MOST_OWN: u64 = (128 << 20) / 40;
/// Meshes that stand in a world, at most.
pub const MOST_STANDING: u64 = 1 << 16;
/// Triangles of all that stands in a world, at most, each level by itself: so many surface ids are for meshes.
pub const MOST_NUMBERS: u64 = 1 << 30;
/// Vertices that a view has room for, where that is not more than all different meshes need twice; triangles with edges,
/// too.
const ROOM: u64 = 1 << 22;

/// A mesh at a place. Several may share a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Standing {
    /// Which of [`Placed::meshes`].
    pub mesh: usize,
    /// Where the mesh's middle is in the world.
    pub middle_m: DVec3,
    /// Turns and scales the mesh, whose vertices count from its middle.
    pub world_from_mesh: DMat3,
    /// World metres for each of the mesh's.
    pub scale: f64,
}

/// All that stands in a world.
#[derive(Clone, Debug, Default)]
pub struct Placed {
    /// Each once.
    pub meshes: Vec<Arc<Mesh>>,
    /// In the order of the scene.
    pub standing: Vec<Standing>,
    /// Of each mesh, finest first.
    coarser: Vec<Vec<Level>>,
    all: Counts,
    limit: Option<Room>,
}

/// Vertices and triangles of all that stands in a world, without levels, and triangles with them.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    vertices: u64,
    triangles: u64,
    numbers: u64,
}

/// What a view has room for, of what stands in the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Room {
    /// Vertices of what is in view.
    pub vertices: u64,
    /// Triangles of which edges are looked for.
    pub triangles: u64,
}

/// How a mesh stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stance {
    /// Where the mesh's origin is in the world.
    pub origin_m: DVec3,
    /// Clockwise from above, in degrees.
    pub yaw_deg: f64,
    /// World metres for each unit of the file.
    pub scale: f64,
    /// Whether the file's z points up; else its y does, and its z to the south.
    pub z_up: bool,
}

impl Stance {
    /// Turns and scales the file's coordinates.
    pub fn world_from_mesh(&self) -> DMat3 {
        let up = if self.z_up { DMat3::IDENTITY } else { DMat3::from_cols(DVec3::X, DVec3::Z, -DVec3::Y) };
        DMat3::from_rotation_z(-self.yaw_deg.to_radians()) * up * self.scale
    }
}

impl Placed {
    /// Adds a mesh; one that stands elsewhere already is shared.
    ///
    /// # Errors
    /// [`MeshError::TooMany`].
    pub fn add(&mut self, mesh: &Arc<Mesh>, stance: &Stance) -> Result<(), MeshError> {
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
        for (what, found, most) in [("places", standing, MOST_STANDING), ("triangles", all.numbers, MOST_NUMBERS)] {
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
            let counts = [("different vertices", vertices, MOST), ("different triangles", triangles, MOST_OWN)];
            counts.into_iter().find(|(_, found, most)| found > most)
        };
        if over(self).is_some() {
            // Whole meshes come first.
            self.coarser.iter_mut().for_each(Vec::clear);
        }
        if let Some((what, found, most)) = over(self) {
            return Err(MeshError::TooMany { what, found, most });
        }
        self.meshes.push(Arc::clone(mesh));
        self.coarser.push(Vec::new());
        Ok(())
    }

    /// Adds a mesh that does not stand anywhere yet, with its coarser levels, finest first: as many as there is room
    /// for.
    ///
    /// # Errors
    /// [`MeshError::TooMany`].
    pub fn add_levels(&mut self, mesh: &Arc<Mesh>, levels: Vec<Level>) -> Result<(), MeshError> {
        self.add_mesh(mesh)?;
        for level in levels.into_iter().take(MOST_LEVELS - 1) {
            let [vertices, triangles] = self.own(&level.mesh);
            if vertices <= MOST && triangles <= MOST_OWN {
                self.coarser.last_mut().into_iter().for_each(|levels| levels.push(level.clone()));
            }
        }
        Ok(())
    }

    /// Vertices and triangles of all different meshes, with their levels and this one.
    fn own(&self, mesh: &Mesh) -> [u64; 2] {
        let meshes = self.meshes.iter().map(|mesh| &**mesh);
        let levels = self.coarser.iter().flatten().map(|level| &level.mesh);
        let all = meshes.chain(levels).chain([mesh]);
        let counts = |mesh: &Mesh| [mesh.vertices_m.len() as u64, mesh.triangles.len() as u64];
        all.map(counts).fold([0, 0], |sum, own| [sum[0] + own[0], sum[1] + own[1]])
    }

    /// The coarser levels of one of [`Placed::meshes`], finest first.
    pub fn coarser(&self, mesh: usize) -> &[Level] {
        &self.coarser[mesh]
    }

    /// Vertices of all that stands here, at its finest levels.
    pub fn vertices(&self) -> u64 {
        self.all.vertices
    }

    /// Gives views less room than they would have.
    pub fn limit_room(&mut self, room: Room) {
        self.limit = Some(room);
    }

    /// What a view has room for: all that stands here, or where that is a lot, twice as much as all different meshes
    /// have.
    pub fn room(&self) -> Room {
        let [vertices, triangles] = self.meshes.iter().fold([0, 0], |[vertices, triangles], mesh| {
            [vertices + mesh.vertices_m.len() as u64, triangles + mesh.triangles.len() as u64]
        });
        let of = |all: u64, own: u64| all.min((2 * own).max(ROOM)).clamp(1, MOST);
        let limit = self.limit.unwrap_or(Room { vertices: u64::MAX, triangles: u64::MAX });
        Room {
            vertices: of(self.all.vertices, vertices).min(limit.vertices),
            triangles: of(self.all.triangles, triangles).min(limit.triangles),
        }
    }

    /// The mesh of one that stands here.
    pub fn mesh(&self, standing: &Standing) -> &Mesh {
        &self.meshes[standing.mesh]
    }

    /// The distance to the nearest of them, as far as contours go: they lie on its far sides too.
    pub fn nearest_m(&self, camera_m: DVec3) -> f64 {
        let distance_m = |standing: &Standing| {
            let radius_m = self.mesh(standing).radius_m * standing.scale;
            (standing.middle_m.distance(camera_m) - radius_m).max(0.2 * radius_m)
        };
        self.standing.iter().map(distance_m).fold(f64::INFINITY, f64::min)
    }
}
