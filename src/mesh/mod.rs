//! Models that stand on the land: triangles with their neighbours, from OBJ files, and where they stand.
//!
//! A [`Mesh`] is what a file holds ([`obj`]), welded and joined ([`build`]), with a normal at each corner of each
//! triangle ([`normals`]) and what it is made of ([`paint`]). [`simplify`] makes meshes of fewer triangles,
//! [`silhouette`] says how much they look like the first, and [`deviation`] how far they lie from it; [`levels`] are what
//! is drawn of them. [`placed`] puts meshes into the world.
//!
//! Why: `docs/decisions/mesh-passes.md`.

mod beside;
pub mod build;
pub mod curvature;
pub mod deviation;
pub mod levels;
mod lines;
mod mtl;
pub mod normals;
pub mod obj;
pub mod paint;
pub mod placed;
pub mod silhouette;
pub mod simplify;
mod wrong_line;

use std::path::PathBuf;

use glam::DVec3;

pub(crate) use self::mtl::linear_from_srgb;
use crate::file::message::named;

/// Why there is no mesh. One line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MeshError {
    /// A file that is no mesh, or a damaged one.
    #[error("cannot read the mesh {}: {cause}", named(path))]
    Read {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        cause: String,
    },
    /// More than the GPU's buffers hold.
    #[error("the scene's meshes have {found} {what} in all, and at most {most} can be drawn")]
    TooMany {
        /// Triangles or vertices.
        what: &'static str,
        /// So many.
        found: u64,
        /// That many would do.
        most: u64,
    },
}

/// What lies across an edge of a triangle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Across {
    /// Nothing: an open border, to be drawn where it is seen. Also an edge of three triangles or more, at the first of
    /// them.
    Border,
    /// The same border again, at the other triangles of such an edge.
    Again,
    /// Another triangle.
    Triangle {
        /// Which.
        index: u32,
        /// Whether it winds the other way round: then its front is where this one has its back.
        is_turned: bool,
    },
}

/// A triangle of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Triangle {
    /// Its vertices, counterclockwise as seen from its front.
    pub corners: [u32; 3],
    /// Across the edges from corner 0 to 1, 1 to 2 and 2 to 0.
    pub across: [Across; 3],
    /// At each corner; unit.
    pub normals: [DVec3; 3],
    /// Which of [`Mesh::materials`]; 0 where the file names none.
    pub material: u16,
}

/// What triangles are made of: a colour.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// As the file has it; empty for the plain one.
    pub name: String,
    /// Red, green and blue in linear light, 0 to 1.
    pub color: [f32; 3],
}

impl Material {
    /// The colour of what has none: a light grey.
    pub const PLAIN_COLOR: [f32; 3] = [0.5; 3];

    /// What has a name and nothing else.
    pub fn plain(name: String) -> Self {
        Self { name, color: Self::PLAIN_COLOR }
    }

    /// How light it is, from [`Material::DARKEST`] to 1, where bare land is 1; always a little below, for land and models
    /// are not lit alike. What has no colour is as light as the land.
    pub fn lightness(&self) -> f32 {
        let below_one = 1.0 - 0.5 * f32::EPSILON;
        if self.color == Self::PLAIN_COLOR {
            return below_one;
        }
        let [red, green, blue] = self.color.map(f64::from);
        let luminance = 0.2126 * red + 0.7152 * green + 0.0722 * blue;
        // L* of CIE 1976, but for the straight piece next to black.
        let perceived = (1.16 * luminance.max(0.0).cbrt() - 0.16).clamp(0.0, 1.0);
        ((Self::DARKEST + (1.0 - Self::DARKEST) * perceived) as f32).min(below_one)
    }

    /// The lightness of black: its form is still seen.
    pub const DARKEST: f64 = 0.3;
}

/// What the reader left out or found open.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Flaws {
    /// Triangles that were dropped: two of their corners are one place, or they lie where another one lies.
    pub dropped: u64,
    /// Edges that one triangle has.
    pub borders: u64,
    /// Edges that three triangles have, or more.
    pub crowded: u64,
}

/// Triangles and how they hang together.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Of its file.
    pub name: String,
    /// The middle of its box, in the file's coordinates; vertices count from here, so that f32 holds them.
    pub middle_m: DVec3,
    /// Different places, each.
    pub vertices_m: Vec<[f32; 3]>,
    /// In the order of the file.
    pub triangles: Vec<Triangle>,
    /// Never empty: the first is plain, for triangles without a material. The others as the file first uses them.
    pub materials: Vec<Material>,
    /// No vertex is farther from the middle.
    pub radius_m: f64,
    /// The mean length of its edges.
    pub mean_edge_m: f64,
    /// Whether it has neither borders nor turned neighbours: its fronts are outside.
    pub is_solid: bool,
    /// What is wrong with it.
    pub flaws: Flaws,
}

impl Mesh {
    /// A corner of a triangle, from the middle.
    pub fn corner_m(&self, triangle: usize, corner: usize) -> DVec3 {
        place(self.vertices_m[self.triangles[triangle].corners[corner] as usize])
    }
}

fn place(vertex_m: [f32; 3]) -> DVec3 {
    DVec3::from_array(vertex_m.map(f64::from))
}
