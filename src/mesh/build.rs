//! Building a mesh from separate triangles: welding, cleaning, joining.
//!
//! - Vertices are welded where they are bit-identical in f32: everything drawn at one place is one vertex. A tolerance
//!   would have to depend on the size of the model, which files do not state.
//! - Triangles with two corners in one place are dropped, and so are duplicates of another triangle: foliage often has
//!   both sides of a sheet, which becomes one sheet with borders here. Degenerate triangles between three different
//!   places on a line stay: exporters close gaps with them, and without them there would be borders that are invisible
//!   in the model.
//! - Edges are sorted by their ends. An edge of two triangles joins them; an edge of one is a border, and an edge of
//!   more is treated as borders, because it is unknown which two belong together.
//! - A closed mesh that is inside out is reversed.

use glam::DVec3;
use rustc_hash::{FxHashMap, FxHashSet};

use super::paint::Paint;
use super::{Across, Flaws, Mesh, Triangle, normals, place};

/// Largest coordinate in metres, the same as for cameras.
pub(crate) const LARGEST_COORDINATE_M: f64 = 1e8;

/// Number of triangles that are welded between two progress reports.
const TOLD_EACH: usize = 1 << 18;

/// The triangles of a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Soup {
    /// The vertices, in the file's unit.
    pub places_m: Vec<DVec3>,
    /// The vertex indices of the corners of each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// A normal for each vertex, of any length; 0 where there is none. May be empty.
    pub normals: Vec<DVec3>,
}

impl Soup {
    /// Builds a mesh with the plain material.
    ///
    /// # Errors
    /// Returns a message if there is nothing to draw, a vertex is not finite or too far away, or an index is out of
    /// range.
    #[cfg(test)]
    pub(crate) fn into_mesh(self, name: String) -> Result<Mesh, String> {
        self.join(name, Paint::default(), &|_| ())
    }

    /// Builds a mesh with materials.
    ///
    /// # Errors
    /// The errors of [`Soup::into_mesh`].
    pub(crate) fn into_painted_mesh(self, name: String, paint: Paint) -> Result<Mesh, String> {
        self.join(name, paint, &|_| ())
    }

    /// Builds a mesh, and reports the finished fraction to `progress`. Data that is no longer needed is dropped at
    /// once, because all this takes more memory than the text of a long file.
    pub(super) fn join(self, name: String, paint: Paint, progress: &dyn Fn(f64)) -> Result<Mesh, String> {
        self.check()?;
        let Self { places_m, triangles: read, normals: read_normals } = self;
        let used = || read.iter().flatten().map(|&corner| places_m[corner as usize]);
        let low_m = used().fold(DVec3::INFINITY, DVec3::min);
        let high_m = used().fold(DVec3::NEG_INFINITY, DVec3::max);
        let middle_m = (low_m + high_m) * 0.5;

        // One vertex for each place. Adding 0 turns −0 into 0.
        let mut numbers: FxHashMap<[u32; 3], u32> = FxHashMap::default();
        let mut vertices_m: Vec<[f32; 3]> = Vec::new();
        let mut vertex_of = |corner: u32| {
            let at_m = (places_m[corner as usize] - middle_m).as_vec3().to_array().map(|v| v + 0.0);
            *numbers.entry(at_m.map(f32::to_bits)).or_insert_with(|| {
                vertices_m.push(at_m);
                vertices_m.len() as u32 - 1
            })
        };
        let mut flaws = Flaws::default();
        let mut known: FxHashSet<[u32; 3]> = FxHashSet::default();
        let mut corners: Vec<[u32; 3]> = Vec::with_capacity(read.len());
        let mut materials: Vec<u16> = Vec::with_capacity(paint.of_triangles.len());
        // The file's vertices at the corners, by which its normals are found.
        let mut given: Vec<[u32; 3]> = Vec::with_capacity(if read_normals.is_empty() { 0 } else { read.len() });
        for (i, triangle) in read.iter().enumerate() {
            if i % TOLD_EACH == 0 {
                progress(0.5 * i as f64 / read.len() as f64);
            }
            let welded = triangle.map(&mut vertex_of);
            let mut sorted = welded;
            sorted.sort_unstable();
            if sorted[0] == sorted[1] || sorted[1] == sorted[2] || !known.insert(sorted) {
                flaws.dropped += 1;
                continue;
            }
            corners.push(welded);
            if !read_normals.is_empty() {
                given.push(*triangle);
            }
            if !paint.of_triangles.is_empty() {
                materials.push(paint.of_triangles.get(i).copied().unwrap_or(0));
            }
        }
        drop((known, numbers, read, places_m, paint.of_triangles));
        if corners.is_empty() {
            return Err("all of its triangles are without area".to_owned());
        }
        progress(0.5);
        let mut across = join(&corners, &mut flaws);
        progress(0.7);
        let is_solid =
            across.iter().flatten().all(|across| matches!(across, Across::Triangle { is_turned: false, .. }));
        if is_solid && is_inside_out(&vertices_m, &corners) {
            // The edge from corner 0 to 1 is now the former edge from 2 to 0, and vice versa.
            corners.iter_mut().for_each(|corners| corners.swap(1, 2));
            given.iter_mut().for_each(|vertices| vertices.swap(1, 2));
            across.iter_mut().for_each(|across| across.swap(0, 2));
        }
        let whole = |i: usize, (corners, across): ([u32; 3], [Across; 3])| {
            let material = materials.get(i).copied().unwrap_or(0);
            Triangle { corners, across, normals: [DVec3::ZERO; 3], material }
        };
        let mut triangles: Vec<Triangle> =
            corners.into_iter().zip(across).enumerate().map(|(i, parts)| whole(i, parts)).collect();
        drop(materials);
        progress(0.8);
        normals::fill(&vertices_m, &mut triangles, |triangle, corner| {
            let vertex = given.get(triangle).map(|vertices| vertices[corner]);
            vertex.and_then(|vertex| read_normals.get(vertex as usize)).copied().unwrap_or_default()
        });
        let (mut sum_m, mut edges) = (0.0, 0_u64);
        for (i, triangle) in triangles.iter().enumerate() {
            let [a, b, c] = triangle.corners;
            for (across, [a, b]) in triangle.across.into_iter().zip([[a, b], [b, c], [c, a]]) {
                // Count each edge once.
                let is_first = match across {
                    Across::Triangle { index, .. } => i < index as usize,
                    Across::Border => true,
                    Across::Again => false,
                };
                if is_first {
                    sum_m += place(vertices_m[a as usize]).distance(place(vertices_m[b as usize]));
                    edges += 1;
                }
            }
        }
        progress(1.0);
        Ok(Mesh {
            name,
            middle_m,
            radius_m: vertices_m.iter().map(|&at_m| place(at_m).length()).fold(0.0, f64::max),
            mean_edge_m: sum_m / edges.max(1) as f64,
            triangles,
            vertices_m,
            materials: paint.materials,
            is_solid,
            flaws,
        })
    }

    fn check(&self) -> Result<(), String> {
        if self.triangles.is_empty() {
            return Err("it has no faces".to_owned());
        }
        if let Some(corner) = self.triangles.iter().flatten().find(|&&corner| corner as usize >= self.places_m.len()) {
            return Err(format!("a face uses vertex {corner}, but there are {}", self.places_m.len()));
        }
        // Vertices that no face uses may have any value.
        for place_m in self.triangles.iter().flatten().map(|&corner| self.places_m[corner as usize]) {
            if !place_m.is_finite() {
                return Err("a vertex is not finite".to_owned());
            }
            if place_m.abs().max_element() > LARGEST_COORDINATE_M {
                return Err(format!("a vertex is farther than {LARGEST_COORDINATE_M:e} m from its origin"));
            }
        }
        Ok(())
    }
}

/// Returns whether the volume that closed triangles enclose is negative.
fn is_inside_out(vertices_m: &[[f32; 3]], corners: &[[u32; 3]]) -> bool {
    let volume: f64 = corners
        .iter()
        .map(|corners| {
            let [a, b, c] = corners.map(|corner| place(vertices_m[corner as usize]));
            a.dot(b.cross(c))
        })
        .sum();
    volume < 0.0
}

/// Finds the neighbour across each edge of each triangle.
fn join(corners: &[[u32; 3]], flaws: &mut Flaws) -> Vec<[Across; 3]> {
    // Lesser end, greater end, triangle × 3 + edge: files are too small for 2³² edges.
    let mut edges: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * corners.len());
    for (i, [a, b, c]) in corners.iter().enumerate() {
        for (edge, (from, to)) in [(a, b), (b, c), (c, a)].into_iter().enumerate() {
            edges.push((*from.min(to), *from.max(to), 3 * i as u32 + edge as u32));
        }
    }
    edges.sort_unstable();
    let mut across = vec![[Across::Border; 3]; corners.len()];
    let place = |number: u32| ((number / 3) as usize, (number % 3) as usize);
    for same in edges.chunk_by(|a, b| a.0 == b.0 && a.1 == b.1) {
        match same {
            [_] => flaws.borders += 1,
            [one, other] => {
                let ((a, a_edge), (b, b_edge)) = (place(one.2), place(other.2));
                // Neighbours of the same winding traverse their edge in opposite directions.
                let is_turned = corners[a][a_edge] == corners[b][b_edge];
                across[a][a_edge] = Across::Triangle { index: b as u32, is_turned };
                across[b][b_edge] = Across::Triangle { index: a as u32, is_turned };
            }
            [_, others @ ..] => {
                flaws.crowded += 1;
                for other in others {
                    let (triangle, edge) = place(other.2);
                    across[triangle][edge] = Across::Again;
                }
            }
            [] => {}
        }
    }
    across
}
