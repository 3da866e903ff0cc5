//! Meshes in the world.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::{Mesh, MeshError};

/// Vertices of all that stands in a world, at most; triangles too. A binding of 128 MiB holds so many positions.
pub const MOST: u64 = 1 << 23;
/// Triangles of all different meshes, at most: 36 bytes each in such a binding.
pub const MOST_OWN: u64 = (128 << 20) / 36;
/// Meshes that stand in a world, at most.
pub const MOST_STANDING: u64 = 1 << 16;

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
    /// The numbers of its vertices and triangles among those of all that stands begin here.
    pub first_vertex: u32,
    /// As [`Standing::first_vertex`].
    pub first_triangle: u32,
}

/// All that stands in a world.
#[derive(Clone, Debug, Default)]
pub struct Placed {
    /// Each once.
    pub meshes: Vec<Arc<Mesh>>,
    /// In the order of the scene.
    pub standing: Vec<Standing>,
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
        let known = self.meshes.iter().position(|known| Arc::ptr_eq(known, mesh));
        let number = known.unwrap_or_else(|| {
            self.meshes.push(Arc::clone(mesh));
            self.meshes.len() - 1
        });
        let (first_vertex, first_triangle) = (self.vertices(), self.triangles());
        let standing = self.standing.len() as u64 + 1;
        let own = self.meshes.iter().map(|mesh| mesh.triangles.len() as u64).sum();
        let counts = [
            ("places", standing, MOST_STANDING),
            ("vertices", first_vertex + mesh.vertices_m.len() as u64, MOST),
            ("triangles", first_triangle + mesh.triangles.len() as u64, MOST),
            ("different triangles", own, MOST_OWN),
        ];
        if let Some((what, found, most)) = counts.into_iter().find(|(_, found, most)| found > most) {
            return Err(MeshError::TooMany { what, found, most });
        }
        let world_from_mesh = stance.world_from_mesh();
        self.standing.push(Standing {
            mesh: number,
            middle_m: stance.origin_m + world_from_mesh * mesh.middle_m,
            world_from_mesh,
            scale: stance.scale,
            first_vertex: first_vertex as u32,
            first_triangle: first_triangle as u32,
        });
        Ok(())
    }

    /// The mesh of one that stands here.
    pub fn mesh(&self, standing: &Standing) -> &Mesh {
        &self.meshes[standing.mesh]
    }

    /// Of all that stands here.
    pub fn vertices(&self) -> u64 {
        self.standing.last().map_or(0, |last| u64::from(last.first_vertex) + self.mesh(last).vertices_m.len() as u64)
    }

    /// Of all that stands here.
    pub fn triangles(&self) -> u64 {
        self.standing.last().map_or(0, |last| u64::from(last.first_triangle) + self.mesh(last).triangles.len() as u64)
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
