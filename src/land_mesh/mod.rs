//! The land as a mesh of few triangles within a stated error, for 3D programs and printers.
//!
//! ```text
//! surface ─▶ heights on a lattice ─▶ triangulation ─▶ triangles over land ─▶ file::glb, file::stl
//! ```
//!
//! Heights are those of the surface that is drawn, on a lattice in the world's metres that is twice as fine as the DEM:
//! so the error that bounds the triangles is measured between the samples too. Where there is no land, there are no
//! triangles. Why: `docs/decisions/land-meshes.md`.

pub(crate) mod lattice;
pub(crate) mod triangulation;

use glam::{DVec2, DVec3};

use self::lattice::Lattice;
use self::triangulation::{TooManyTriangles, triangulate};

/// A mesh of the land, seen from above.
#[derive(Clone, Debug, Default)]
pub(crate) struct LandMesh {
    /// East, north and height in metres, east and north from the middle of the extent.
    pub positions: Vec<DVec3>,
    /// Upward unit normals of the surface.
    pub normals: Vec<DVec3>,
    /// Triangles, anticlockwise as seen from above.
    pub triangles: Vec<[u32; 3]>,
    /// The middle of the extent in the world: east and north in metres.
    pub middle_m: DVec2,
    /// Largest measured distance between the triangles and the surface, along the vertical, in metres.
    pub error_m: f64,
    /// Distance of the points at which it was measured, in metres.
    pub measured_every_m: f64,
}

impl LandMesh {
    /// Builds the mesh of a lattice with an error of at most `max_error_m`.
    ///
    /// # Errors
    /// Fails if more than [`triangulation::MAX_TRIANGLES`] would be needed.
    pub(crate) fn new(lattice: &Lattice, max_error_m: f64) -> Result<Self, TooManyTriangles> {
        let found = triangulate(lattice, max_error_m)?;
        let mut mesh = Self { middle_m: lattice.middle_m(), measured_every_m: lattice.step_m(), ..Self::default() };
        let mut numbers = vec![u32::MAX; found.points.len()];
        for corners in &found.triangles {
            let has_land = |corner: &u32| lattice.height_m(found.points[*corner as usize]).is_some();
            if !corners.iter().all(has_land) {
                continue;
            }
            let [a, b, c] = corners.map(|corner| {
                let number = &mut numbers[corner as usize];
                if *number == u32::MAX {
                    // There are fewer points than triangles, whose number is bounded.
                    *number = mesh.positions.len() as u32;
                    let point = found.points[corner as usize];
                    let at_m = lattice.offset_m(point);
                    mesh.positions.push(at_m.extend(lattice.height_m(point).unwrap_or_default()));
                    mesh.normals.push(lattice.normal(point));
                }
                *number
            });
            // The triangulation's own order is clockwise.
            mesh.triangles.push([a, c, b]);
        }
        mesh.error_m = found.error_m;
        Ok(mesh)
    }

    /// Returns the smallest and the largest position.
    pub(crate) fn bounds_m(&self) -> [DVec3; 2] {
        let all = || self.positions.iter().copied();
        [all().reduce(DVec3::min).unwrap_or_default(), all().reduce(DVec3::max).unwrap_or_default()]
    }

    /// Returns a closed solid: the land, walls along all its borders, and a level bottom at `bottom_m`. Its first
    /// vertices are those of the land.
    pub(crate) fn solid(&self, bottom_m: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let count = self.positions.len() as u32;
        let below = self.positions.iter().map(|at| DVec3::new(at.x, at.y, bottom_m));
        let positions: Vec<DVec3> = self.positions.iter().copied().chain(below).collect();
        let mut triangles = self.triangles.clone();
        triangles.extend(self.triangles.iter().map(|[a, b, c]| [a + count, c + count, b + count]));
        // An edge without a triangle on its other side is a border; `rustc_hash` is fast for such keys.
        let edges = |[a, b, c]: &[u32; 3]| [[*a, *b], [*b, *c], [*c, *a]];
        let all: rustc_hash::FxHashSet<[u32; 2]> = self.triangles.iter().flat_map(edges).collect();
        for [a, b] in self.triangles.iter().flat_map(edges).filter(|[a, b]| !all.contains(&[*b, *a])) {
            triangles.extend([[b, a, a + count], [b, a + count, b + count]]);
        }
        (positions, triangles)
    }
}

#[cfg(test)]
mod tests;
