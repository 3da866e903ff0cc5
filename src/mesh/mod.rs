//! Models on the land: triangles with their neighbours, from OBJ files, and their placement.
//!
//! A [`Mesh`] is the content of a file ([`obj`]), welded and joined ([`build`]), with a normal at each corner of each
//! triangle ([`normals`]) and its materials ([`paint`]). [`simplify`] makes meshes with fewer triangles, [`silhouette`]
//! measures how similar they look, and [`deviation`] how far they are from the original; [`levels`] are the levels of
//! detail. [`placed`] puts meshes into the world.
//!
//! Why: `docs/decisions/mesh-passes.md`.

pub(crate) mod build;
pub(crate) mod curvature;
pub(crate) mod deviation;
pub(crate) mod levels;
mod obj_text;
mod mtl;
pub(crate) mod normals;
pub mod obj;
pub(crate) mod paint;
pub(crate) mod placed;
mod sidecar;
pub(crate) mod silhouette;
pub(crate) mod simplify;
mod wrong_line;

use std::path::PathBuf;

use glam::DVec3;

pub(crate) use self::mtl::linear_from_srgb;
use crate::file::message::named;

/// The reason why a mesh cannot be used. The message is one line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshError {
    /// The file is not a mesh, or it is damaged.
    #[error("cannot read the mesh {}: {cause}", named(path))]
    Read {
        path: PathBuf,
        /// The defect, with its line where that is known.
        cause: String,
    },
    /// The meshes have more triangles or vertices than the GPU's buffers can hold, or there are too many of them.
    #[error("the scene's meshes have {found} {what} in all; at most {most} can be drawn")]
    TooMany {
        /// The counted elements: triangles, vertices or placed meshes.
        what: &'static str,
        /// The number in the scene.
        found: u64,
        /// The largest possible number.
        most: u64,
    },
}

/// The neighbour across an edge of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Across {
    /// No neighbour: an open border, which is drawn where it is visible. Also the first occurrence of an edge of three
    /// triangles or more.
    Border,
    /// A further occurrence of an edge of three triangles or more.
    Again,
    /// A neighbouring triangle.
    Triangle {
        /// Index of the neighbouring triangle in the mesh.
        index: u32,
        /// Whether it has the opposite winding, so that its front is on this triangle's back side.
        is_turned: bool,
    },
}

/// A triangle of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangle {
    /// Vertex indices, counterclockwise as seen from the front.
    pub corners: [u32; 3],
    /// Neighbours across the edges from corner 0 to 1, 1 to 2 and 2 to 0.
    pub across: [Across; 3],
    /// Unit normals at the corners.
    pub normals: [DVec3; 3],
    /// Index into [`Mesh::materials`]; 0 where the file names none.
    pub material: u16,
}

/// A material, which is just a colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in the file; empty for the plain material.
    pub name: String,
    /// Red, green and blue in linear light, 0 to 1.
    pub color: [f32; 3],
}

impl Material {
    /// The colour of materials without one: a light grey.
    pub const PLAIN_COLOR: [f32; 3] = [0.5; 3];

    /// Creates a material with a name and the plain colour.
    pub fn plain(name: String) -> Self {
        Self { name, color: Self::PLAIN_COLOR }
    }

    /// Returns the lightness, from [`Material::DARKEST`] to 1, where 1 is bare land; always a little below 1, because
    /// land and models are lit differently. Plain material is as light as the land.
    pub fn lightness(&self) -> f32 {
        let below_one = 1.0 - 0.5 * f32::EPSILON;
        if self.color == Self::PLAIN_COLOR {
            return below_one;
        }
        let [red, green, blue] = self.color.map(f64::from);
        let luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
        // L* of CIE 1976, without the linear segment near black.
        let perceived = (1.16 * luminance.max(0.0).cbrt() - 0.16).clamp(0.0, 1.0);
        ((Self::DARKEST + (1.0 - Self::DARKEST) * perceived) as f32).min(below_one)
    }

    /// The lightness of black, at which forms are still visible.
    pub const DARKEST: f64 = 0.3;
}

/// Defects that the reader found in a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flaws {
    /// Number of triangles that were dropped, because two of their corners are in one place, or as duplicates.
    pub dropped: u64,
    /// Number of edges with one triangle.
    pub borders: u64,
    /// Number of edges with three triangles or more.
    pub crowded: u64,
}

/// A mesh: triangles with their neighbours.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Name of its file.
    pub name: String,
    /// Centre of its bounding box, in the file's coordinates; vertices are relative to it, so that f32 is precise
    /// enough.
    pub middle_m: DVec3,
    /// Vertices relative to `middle_m`, all different.
    pub vertices_m: Vec<[f32; 3]>,
    /// Triangles in the order of the file.
    pub triangles: Vec<Triangle>,
    /// Materials, never empty: the first is plain, for triangles without a material; the others are in the order of
    /// first use.
    pub materials: Vec<Material>,
    /// Largest distance of a vertex from `middle_m`.
    pub radius_m: f64,
    /// Mean length of its edges.
    pub mean_edge_m: f64,
    /// Whether the mesh has neither borders nor neighbours of opposite winding, so that its front faces are on the
    /// outside.
    pub is_solid: bool,
    /// Defects of the file.
    pub flaws: Flaws,
}

impl Mesh {
    /// Returns a corner of a triangle, relative to `middle_m`.
    pub fn corner_m(&self, triangle: usize, corner: usize) -> DVec3 {
        place(self.vertices_m[self.triangles[triangle].corners[corner] as usize])
    }
}

fn place(vertex_m: [f32; 3]) -> DVec3 {
    DVec3::from_array(vertex_m.map(f64::from))
}
