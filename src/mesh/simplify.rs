//! Simplification of meshes, for models that are far away.
//!
//! There are several ways to remove triangles, and which is best depends on the mesh. So all are tried, and the result
//! whose silhouettes agree best with those of the mesh is taken ([`super::silhouette`]):
//!
//! - **Edge collapse** by quadric errors (Garland and Heckbert 1997, as implemented by meshoptimizer), in the order of
//!   the change that they cause; vertices move to where they fit best; loose parts that are too small to matter vanish.
//!   Where two materials meet, both sides collapse together, so their border stays closed. If the shape of the mesh
//!   does not permit as few triangles as required, borders of materials may collapse too.
//! - **Clustering**: the vertices in a cell of a grid become one (meshoptimizer's sloppy mode), for each material
//!   separately. It is coarse, and never exceeds the required number, but may leave nothing of a small material or
//!   mesh.
//! - **Thinning** for foliage, which consists of many small loose parts none of which can lose a triangle: of
//!   neighbouring parts a half, a quarter or an eighth remains, and is enlarged to the area of all (Cook and others,
//!   *Stochastic Simplification of Aggregate Detail*, 2007). The rest collapses as above.
//! - **Remeshing** to a few hundred triangles: a new surface around all parts, from a grid of cells (meshoptimizer's
//!   remesher). It unites intersecting parts, like the tiers of a fir, and collapses to very few triangles. A corner of
//!   it has the material of the triangle with the nearest centroid.
//!
//! A corner of a new triangle has the normal of its vertex that is nearest to that of the triangle, if the two are at
//! most 60° apart; otherwise [`super::normals`] computes a smooth one.

use glam::DVec3;
use meshopt::{RemeshOptions, SimplifyOptions};
use rustc_hash::{FxHashMap, FxHashSet};

use super::build::Soup;
use super::paint::Paint;
use super::silhouette::{overlap, views};
use super::{Mesh, place};

/// Number of directions from which silhouettes are compared, and the angle by which all are rotated, so that none
/// is along the walls of buildings.
const VIEWS: usize = 12;
const VIEWS_ROTATION_RAD: f64 = 0.006;
/// Largest size of a small part, relative to the mesh.
const SMALL_PART: f64 = 0.35;
/// Smallest number of small parts that count as foliage.
const MIN_PARTS: usize = 12;
/// Largest number of triangles for which remeshing is tried.
const FEW_TRIANGLES: usize = 512;
/// Numbers of cells along a side of the grid for remeshing; each is tried.
const REMESH_CELLS: [u32; 3] = [12, 24, 48];
/// Smallest cosine between the normal of a new triangle and one of the original normals at its vertex, for the latter
/// to be used: that of 60°. At larger angles it belongs to another side of an edge.
const MIN_COSINE: f64 = 0.5;

/// Returns a mesh that looks like `mesh`, with the same materials and at most `triangles` triangles (at least one).
/// Returns `mesh` itself if it has no more, or if everything that simplification leaves is degenerate.
pub(crate) fn simplify(mesh: &Mesh, triangles: usize) -> Mesh {
    if mesh.triangles.len() <= triangles.max(1) {
        return mesh.clone();
    }
    let max_triangles = triangles.max(1);
    let whole = Draft::of(mesh);
    let mut drafts: Vec<Draft> =
        [false, true].into_iter().filter_map(|moves| whole.collapsed(max_triangles, moves)).collect();
    drafts.push(whole.clustered(mesh, max_triangles));
    if let Some(parts) = Parts::of(mesh) {
        for one_in in [2, 4, 8] {
            let thin = whole.thinned(mesh, &parts, one_in);
            drafts.extend(thin.collapsed(max_triangles, false));
            drafts.push(thin.clustered(mesh, max_triangles));
        }
    }
    if max_triangles <= FEW_TRIANGLES {
        drafts.extend(REMESH_CELLS.into_iter().filter_map(|cells| whole.remeshed(mesh, cells, max_triangles)));
    }
    let normals = Normals::of(mesh);
    let made = drafts.into_iter().filter(|draft| (1..=max_triangles).contains(&draft.triangles()));
    let made = made.filter_map(|draft| draft.into_mesh(mesh, &normals));
    let scored = made.map(|made| (overlap(mesh, &made, views(VIEWS, VIEWS_ROTATION_RAD)), made));
    let best = scored.reduce(|best, other| if other.0 > best.0 { other } else { best });
    // A mesh of specks may vanish with every method.
    best.map(|(_, made)| made)
        .or_else(|| whole.largest(mesh, max_triangles).into_mesh(mesh, &normals))
        .unwrap_or_else(|| mesh.clone())
}

/// Returns the mesh of at most `triangles` triangles with the smallest `distance` from this one, with that distance.
/// Only edge collapses and clustering are used, which add nothing in place of what they remove. Returns `None` if
/// `triangles` is 0, if the mesh has no more triangles than that, or if no method reaches this number.
pub(crate) fn nearest(mesh: &Mesh, triangles: usize, distance: impl Fn(&Mesh, &Mesh) -> f64) -> Option<(Mesh, f64)> {
    if triangles == 0 || mesh.triangles.len() <= triangles {
        return None;
    }
    let whole = Draft::of(mesh);
    let mut drafts: Vec<Draft> =
        [false, true].into_iter().filter_map(|moves| whole.collapsed(triangles, moves)).collect();
    drafts.push(whole.clustered(mesh, triangles));
    let normals = Normals::of(mesh);
    let made = drafts.into_iter().filter(|draft| (1..=triangles).contains(&draft.triangles()));
    let made = made.filter_map(|draft| draft.into_mesh(mesh, &normals));
    let measured = made.map(|made| {
        let distance = distance(mesh, &made);
        (made, distance)
    });
    measured.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// A mesh before or after simplification, with one vertex for each pair of a mesh vertex and a material.
#[derive(Clone)]
struct Draft {
    places_m: Vec<[f32; 3]>,
    /// The original mesh's vertex from which each vertex comes, and its material.
    origins: Vec<(u32, u16)>,
    /// The vertices of the triangles, three for each.
    corners: Vec<u32>,
}

impl Draft {
    fn of(mesh: &Mesh) -> Self {
        let mut numbers: FxHashMap<(u32, u16), u32> = FxHashMap::default();
        let mut draft = Self { places_m: Vec::new(), origins: Vec::new(), corners: Vec::new() };
        for triangle in &mesh.triangles {
            for vertex in triangle.corners {
                let origin = (vertex, triangle.material);
                let number = *numbers.entry(origin).or_insert_with(|| {
                    draft.places_m.push(mesh.vertices_m[vertex as usize]);
                    draft.origins.push(origin);
                    draft.origins.len() as u32 - 1
                });
                draft.corners.push(number);
            }
        }
        draft
    }

    fn triangles(&self) -> usize {
        self.corners.len() / 3
    }

    fn with(&self, corners: Vec<u32>) -> Self {
        Self { places_m: self.places_m.clone(), origins: self.origins.clone(), corners }
    }

    /// Simplifies by edge collapses; with `moves`, vertices may also move. Returns `None` if the shape does not permit
    /// as few triangles.
    fn collapsed(&self, max_triangles: usize, moves: bool) -> Option<Self> {
        if self.triangles() <= max_triangles {
            return Some(self.clone());
        }
        let strict = SimplifyOptions::Prune;
        [strict, strict | SimplifyOptions::Permissive].into_iter().find_map(|options| {
            let mut draft = self.clone();
            if moves {
                let count = meshopt::simplify_with_update(
                    &mut draft.corners,
                    &mut draft.places_m,
                    &mut [],
                    &[],
                    0,
                    None,
                    3 * max_triangles,
                    f32::MAX,
                    options,
                    None,
                );
                draft.corners.truncate(count);
            } else {
                let (corners, places_m) = (&self.corners, &self.places_m);
                draft.corners =
                    meshopt::simplify_decoder(corners, places_m, 3 * max_triangles, f32::MAX, options, None);
            }
            (1..=max_triangles).contains(&draft.triangles()).then_some(draft)
        })
    }

    /// Simplifies by clustering, each material separately with its share of the triangles.
    fn clustered(&self, mesh: &Mesh, max_triangles: usize) -> Self {
        if self.triangles() <= max_triangles {
            return self.clone();
        }
        let mut corners = Vec::new();
        for material in 0..mesh.materials.len() {
            let is_of = |triangle: &&[u32]| usize::from(self.origins[triangle[0] as usize].1) == material;
            let own: Vec<u32> = self.corners.chunks_exact(3).filter(is_of).flatten().copied().collect();
            if own.is_empty() {
                continue;
            }
            let own_max = own.len() / 3 * max_triangles / self.triangles();
            corners.extend(meshopt::simplify_sloppy_decoder(&own, &self.places_m, 3 * own_max, f32::MAX, None));
        }
        self.with(corners)
    }

    /// Keeps every `one_in`-th small part, enlarged to the area of all.
    fn thinned(&self, mesh: &Mesh, parts: &Parts, one_in: usize) -> Self {
        let mut draft = self.clone();
        let is_left = |part: u32| parts.rank[part as usize].is_none_or(|rank| rank % one_in == one_in / 2);
        let left = self.corners.chunks_exact(3).filter(|triangle| {
            let (vertex, _) = self.origins[triangle[0] as usize];
            is_left(parts.of_vertex[vertex as usize])
        });
        draft.corners = left.flatten().copied().collect();
        let grown = (one_in as f64).sqrt();
        for (place_m, (vertex, _)) in draft.places_m.iter_mut().zip(&draft.origins) {
            let part = parts.of_vertex[*vertex as usize] as usize;
            if parts.rank[part].is_some() {
                let middle_m = parts.middle_m[part];
                let at_m = middle_m + (place(mesh.vertices_m[*vertex as usize]) - middle_m) * grown;
                *place_m = at_m.as_vec3().to_array();
            }
        }
        draft
    }

    /// Builds a surface around all parts on a grid of `cells` cells along a side, and collapses it. Returns `None` if
    /// that fails.
    fn remeshed(&self, mesh: &Mesh, cells: u32, max_triangles: usize) -> Option<Self> {
        let soup = meshopt::remesh_decoder(&self.corners, &self.places_m, cells, RemeshOptions::Solve);
        let mut numbers: FxHashMap<[u32; 3], u32> = FxHashMap::default();
        let mut draft = Self { places_m: Vec::new(), origins: Vec::new(), corners: Vec::new() };
        for place_m in soup {
            if !place_m.iter().all(|value| value.is_finite()) {
                return None;
            }
            let number = *numbers.entry(place_m.map(f32::to_bits)).or_insert_with(|| {
                draft.places_m.push(place_m);
                draft.places_m.len() as u32 - 1
            });
            draft.corners.push(number);
        }
        draft.origins = vec![(0, 0); draft.places_m.len()];
        let mut draft = draft.collapsed(max_triangles, true)?;
        let middles: Vec<DVec3> =
            (0..mesh.triangles.len()).map(|i| (0..3).map(|k| mesh.corner_m(i, k)).sum::<DVec3>() / 3.0).collect();
        let used: FxHashSet<u32> = draft.corners.iter().copied().collect();
        for corner in used {
            let at_m = place(draft.places_m[corner as usize]);
            let distance = |i: usize| middles[i].distance_squared(at_m);
            let nearest = (0..middles.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)))?;
            let triangle = &mesh.triangles[nearest];
            draft.origins[corner as usize] = (triangle.corners[0], triangle.material);
        }
        Some(draft)
    }

    /// Keeps only the `max_triangles` largest triangles.
    fn largest(&self, mesh: &Mesh, max_triangles: usize) -> Self {
        let area = |triangle: &[u32]| {
            let [a, b, c] = [0, 1, 2].map(|k| place(mesh.vertices_m[self.origins[triangle[k] as usize].0 as usize]));
            (b - a).cross(c - a).length()
        };
        let mut triangles: Vec<&[u32]> = self.corners.chunks_exact(3).collect();
        triangles.sort_by(|a, b| area(b).total_cmp(&area(a)));
        self.with(triangles.into_iter().take(max_triangles).flatten().copied().collect())
    }

    /// Converts the draft to a mesh. Returns `None` if all triangles are degenerate.
    fn into_mesh(self, mesh: &Mesh, normals: &Normals) -> Option<Mesh> {
        let mut soup = Soup::default();
        let mut paint = Paint { materials: mesh.materials.clone(), of_triangles: Vec::new() };
        for triangle in self.corners.chunks_exact(3) {
            let corners = [triangle[0], triangle[1], triangle[2]];
            let places_m = corners.map(|corner| place(self.places_m[corner as usize]));
            let [a, b, c] = places_m;
            let face = (b - a).cross(c - a).normalize_or_zero();
            let first = soup.places_m.len() as u32;
            soup.triangles.push([first, first + 1, first + 2]);
            soup.places_m.extend(places_m.map(|place_m| mesh.middle_m + place_m));
            soup.normals.extend(corners.map(|corner| normals.nearest(self.origins[corner as usize].0, face)));
            // Where a border of materials has collapsed, the corners differ.
            let [a, b, c] = corners.map(|corner| self.origins[corner as usize].1);
            paint.of_triangles.push(if b == c { b } else { a });
        }
        soup.into_painted_mesh(mesh.name.clone(), paint).ok()
    }
}

/// The normals that the triangles of a mesh have at each of its vertices.
struct Normals {
    /// Index in `all` of the first normal of each vertex, and the number of all.
    first: Vec<u32>,
    all: Vec<DVec3>,
}

impl Normals {
    fn of(mesh: &Mesh) -> Self {
        let mut first = vec![0; mesh.vertices_m.len() + 1];
        let corners = || mesh.triangles.iter().flat_map(|triangle| triangle.corners.into_iter().zip(triangle.normals));
        corners().for_each(|(vertex, _)| first[vertex as usize + 1] += 1);
        for i in 1..first.len() {
            first[i] += first[i - 1];
        }
        let mut next = first.clone();
        let mut all = vec![DVec3::ZERO; 3 * mesh.triangles.len()];
        for (vertex, normal) in corners() {
            all[next[vertex as usize] as usize] = normal;
            next[vertex as usize] += 1;
        }
        Self { first, all }
    }

    /// Returns the normal at a vertex that is nearest to `face`, the normal of a new triangle. Returns 0, for which a
    /// smooth normal is computed, if it is more than 60° away.
    fn nearest(&self, vertex: u32, face: DVec3) -> DVec3 {
        let of = self.first[vertex as usize] as usize..self.first[vertex as usize + 1] as usize;
        let best = self.all[of].iter().copied().max_by(|a, b| a.dot(face).total_cmp(&b.dot(face)));
        best.filter(|normal| normal.dot(face) >= MIN_COSINE).unwrap_or(DVec3::ZERO)
    }
}

/// The connected parts of a mesh with foliage, which is its small parts.
struct Parts {
    /// The part of each vertex of the mesh.
    of_vertex: Vec<u32>,
    /// Centre of the bounding box of each part.
    middle_m: Vec<DVec3>,
    /// Rank of each small part along a Morton curve, on which neighbours are mostly close to each other; `None` for the
    /// other parts.
    rank: Vec<Option<usize>>,
}

impl Parts {
    /// Finds the connected parts. Returns `None` if there is no foliage.
    fn of(mesh: &Mesh) -> Option<Self> {
        let mut root: Vec<u32> = (0..mesh.vertices_m.len() as u32).collect();
        fn find(root: &mut [u32], mut at: u32) -> u32 {
            while root[at as usize] != at {
                root[at as usize] = root[root[at as usize] as usize];
                at = root[at as usize];
            }
            at
        }
        for [a, b, c] in mesh.triangles.iter().map(|triangle| triangle.corners) {
            for other in [b, c] {
                let (one, other) = (find(&mut root, a), find(&mut root, other));
                root[one.max(other) as usize] = one.min(other);
            }
        }
        let mut numbers: FxHashMap<u32, u32> = FxHashMap::default();
        let mut of_vertex = Vec::with_capacity(root.len());
        let mut boxes: Vec<(DVec3, DVec3)> = Vec::new();
        for vertex in 0..root.len() as u32 {
            let number = *numbers.entry(find(&mut root, vertex)).or_insert(boxes.len() as u32);
            if number as usize == boxes.len() {
                boxes.push((DVec3::INFINITY, DVec3::NEG_INFINITY));
            }
            let (low_m, high_m) = &mut boxes[number as usize];
            let at_m = place(mesh.vertices_m[vertex as usize]);
            (*low_m, *high_m) = (low_m.min(at_m), high_m.max(at_m));
            of_vertex.push(number);
        }
        let is_small = |(low_m, high_m): &(DVec3, DVec3)| low_m.distance(*high_m) < SMALL_PART * 2.0 * mesh.radius_m;
        let middle_m: Vec<DVec3> = boxes.iter().map(|(low_m, high_m)| (*low_m + *high_m) * 0.5).collect();
        let mut small: Vec<usize> = (0..boxes.len()).filter(|&part| is_small(&boxes[part])).collect();
        small.sort_by_key(|&part| morton_code(middle_m[part] / mesh.radius_m));
        let mut rank = vec![None; boxes.len()];
        small.iter().enumerate().for_each(|(i, &part)| rank[part] = Some(i));
        (small.len() >= MIN_PARTS).then_some(Self { of_vertex, middle_m, rank })
    }
}

/// Returns the position of a point of the cube from -1 to 1 along the Morton curve, in 2⁷ cells along each axis.
fn morton_code(at: DVec3) -> u32 {
    let cell = ((at + 1.0) * 64.0).clamp(DVec3::ZERO, DVec3::splat(127.0));
    let spread = |value: f64| (0..7).map(|bit| ((value as u32 >> bit) & 1) << (3 * bit)).sum::<u32>();
    spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2
}
