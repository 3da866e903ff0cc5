//! The curvature of a mesh at its vertices, and its derivative (Rusinkiewicz 2004, "Estimating Curvatures and Their
//! Derivatives on Triangle Meshes").
//!
//! Along each edge of a triangle the second fundamental form maps the edge to the difference of the normals at its
//! ends. Three edges give six equations for its three coefficients, solved by least squares; a vertex has the mean over
//! its triangles, rotated into its own tangent plane. The derivative is found in the same way from the differences of
//! these forms.
//!
//! Differences from the paper: normals are those of the triangle's corners, so a crease has no curvature and the walls
//! of a house are flat up to their edges; and the weights of a mean are thirds of areas instead of Voronoi areas.

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

use super::Mesh;

/// The curvature of a vertex, in the mesh's own axes and unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct VertexShape {
    /// Unit normal; 0 for a vertex of no triangle.
    pub normal: DVec3,
    /// Second fundamental form uu, uv, vv, in the frame of [`frame_of`] the normal; convex is positive.
    pub bend: [f64; 3],
    /// Derivative of the second fundamental form, uuu, uuv, uvv, vvv.
    pub change: [f64; 4],
}

/// Returns two unit tangents for a unit normal, as `frame_of` in `shaders/shared/curvature.wgsl`.
pub(crate) fn frame_of(n: DVec3) -> [DVec3; 2] {
    let side = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (side + n.z);
    let b = n.x * n.y * a;
    [DVec3::new(1.0 + side * n.x * n.x * a, side * b, -side * n.x), DVec3::new(b, side + n.y * n.y * a, -n.y)]
}

/// A normal with two tangents.
#[derive(Clone, Copy)]
struct Frame {
    normal: DVec3,
    tangents: [DVec3; 2],
}

impl Frame {
    fn of(normal: DVec3) -> Self {
        Self { normal, tangents: frame_of(normal) }
    }

    fn flat(&self, v: DVec3) -> DVec2 {
        DVec2::new(v.dot(self.tangents[0]), v.dot(self.tangents[1]))
    }

    /// Returns its tangents in another frame, after a rotation into that frame's plane about the line that both planes
    /// share.
    fn tangents_in(&self, other: &Self) -> [DVec2; 2] {
        let turn = glam::DQuat::from_rotation_arc(self.normal, other.normal);
        self.tangents.map(|tangent| other.flat(turn * tangent))
    }
}

fn form2(form: [f64; 3], a: DVec2, b: DVec2) -> f64 {
    form[0] * a.x * b.x + form[1] * (a.x * b.y + a.y * b.x) + form[2] * a.y * b.y
}

fn form3(form: [f64; 4], a: DVec2, b: DVec2, c: DVec2) -> f64 {
    let by = |i: usize| form[i] * c.x + form[i + 1] * c.y;
    form2([by(0), by(1), by(2)], a, b)
}

/// Transforms a form of two vectors into the frame `to`.
fn turned2(form: [f64; 3], own: &Frame, to: &Frame) -> [f64; 3] {
    let [u, v] = to.tangents_in(own);
    [form2(form, u, u), form2(form, u, v), form2(form, v, v)]
}

fn turned3(form: [f64; 4], own: &Frame, to: &Frame) -> [f64; 4] {
    let [u, v] = to.tangents_in(own);
    [form3(form, u, u, u), form3(form, u, u, v), form3(form, u, v, v), form3(form, v, v, v)]
}

/// Returns the form that maps three edges to three differences of the normal, by least squares, or `None` for a sliver.
fn bend_of(edges: [DVec2; 3], turns: [DVec2; 3]) -> Option<[f64; 3]> {
    let (mut left, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for (edge, turn) in edges.into_iter().zip(turns) {
        for (row, value) in [(DVec3::new(edge.x, edge.y, 0.0), turn.x), (DVec3::new(0.0, edge.x, edge.y), turn.y)] {
            left += DMat3::from_cols(row * row.x, row * row.y, row * row.z);
            right += row * value;
        }
    }
    let size = edges.iter().map(|edge| edge.length_squared()).sum::<f64>();
    (left.determinant().abs() > 1e-9 * size.powi(3)).then(|| (left.inverse() * right).to_array())
}

/// Returns the derivative in the same way, from differences of the form.
fn change_of(edges: [DVec2; 3], differences: [[f64; 3]; 3]) -> Option<[f64; 4]> {
    let (mut left, mut right) = (DMat4::ZERO, DVec4::ZERO);
    for (edge, difference) in edges.into_iter().zip(differences) {
        for (i, value) in difference.into_iter().enumerate() {
            let mut row = [0.0; 4];
            (row[i], row[i + 1]) = (edge.x, edge.y);
            // The mixed coefficient occurs twice in the form.
            let weight = if i == 1 { 2.0 } else { 1.0 };
            let row = DVec4::from_array(row);
            left += DMat4::from_cols(row * row.x, row * row.y, row * row.z, row * row.w) * weight;
            right += row * value * weight;
        }
    }
    let size = edges.iter().map(|edge| edge.length_squared()).sum::<f64>();
    (left.determinant().abs() > 1e-12 * size.powi(4)).then(|| (left.inverse() * right).to_array())
}

/// Returns a triangle's own frame, its edges in it (each opposite the corner of its number), and its area, or `None` if
/// the area is 0.
fn plane_of(mesh: &Mesh, triangle: usize) -> Option<(Frame, [DVec2; 3], f64)> {
    let [a, b, c] = [0, 1, 2].map(|corner| mesh.corner_m(triangle, corner));
    let face = (b - a).cross(c - a);
    let frame = Frame::of(face.try_normalize()?);
    Some((frame, [c - b, a - c, b - a].map(|edge| frame.flat(edge)), 0.5 * face.length()))
}

/// Computes the curvature of each vertex of a mesh.
pub(crate) fn shapes_of(mesh: &Mesh) -> Vec<VertexShape> {
    let mut shapes = vec![VertexShape::default(); mesh.vertices_m.len()];
    let planes: Vec<_> = (0..mesh.triangles.len()).map(|triangle| plane_of(mesh, triangle)).collect();
    let known = || mesh.triangles.iter().zip(&planes).filter_map(|(triangle, plane)| Some((triangle, plane.as_ref()?)));
    for (triangle, (_, _, area)) in known() {
        for (corner, normal) in triangle.corners.into_iter().zip(triangle.normals) {
            shapes[corner as usize].normal += normal * *area;
        }
    }
    shapes.iter_mut().for_each(|shape| shape.normal = shape.normal.normalize_or_zero());
    let frames: Vec<Frame> = shapes.iter().map(|shape| Frame::of(shape.normal)).collect();

    let mut weights = vec![0.0; shapes.len()];
    for (triangle, (frame, edges, area)) in known() {
        let [a, b, c] = triangle.normals;
        let Some(bend) = bend_of(*edges, [c - b, a - c, b - a].map(|turn| frame.flat(turn))) else { continue };
        for corner in triangle.corners.map(|corner| corner as usize) {
            let own = turned2(bend, frame, &frames[corner]);
            shapes[corner].bend = std::array::from_fn(|i| shapes[corner].bend[i] + area * own[i]);
            weights[corner] += area;
        }
    }
    for (shape, weight) in shapes.iter_mut().zip(&weights).filter(|(_, weight)| **weight > 0.0) {
        shape.bend = shape.bend.map(|sum| sum / weight);
    }

    let mut weights = vec![0.0; shapes.len()];
    let mut sums = vec![[0.0; 4]; shapes.len()];
    for (triangle, (frame, edges, area)) in known() {
        let corners = triangle.corners.map(|corner| corner as usize);
        let [a, b, c] = corners.map(|corner| turned2(shapes[corner].bend, &frames[corner], frame));
        let step = |start: [f64; 3], end: [f64; 3]| std::array::from_fn(|i| end[i] - start[i]);
        let Some(change) = change_of(*edges, [step(b, c), step(c, a), step(a, b)]) else { continue };
        for corner in corners {
            let own = turned3(change, frame, &frames[corner]);
            sums[corner] = std::array::from_fn(|i| sums[corner][i] + area * own[i]);
            weights[corner] += area;
        }
    }
    for ((shape, sum), weight) in shapes.iter_mut().zip(sums).zip(weights).filter(|(_, weight)| *weight > 0.0) {
        shape.change = sum.map(|sum| sum / weight);
    }
    shapes
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::mesh::build::Soup;

    const MAJOR_M: f64 = 3.0;

    /// Returns a torus of tube radius 1.
    fn torus(around: u32, across: u32) -> Mesh {
        let place = |i: u32, j: u32| {
            let (a, b) = (TAU * f64::from(i) / f64::from(around), TAU * f64::from(j) / f64::from(across));
            let out = MAJOR_M + b.cos();
            DVec3::new(out * a.cos(), out * a.sin(), b.sin())
        };
        let places_m = (0..around).flat_map(|i| (0..across).map(move |j| place(i, j))).collect();
        let vertex = |i: u32, j: u32| (i % around) * across + j % across;
        let quads = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
        let triangles = quads.flat_map(|(i, j)| {
            let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            [[a, b, c], [a, c, d]]
        });
        let soup = Soup { places_m, triangles: triangles.collect(), normals: Vec::new() };
        soup.into_mesh("torus".to_owned()).unwrap_or_else(|error| panic!("{error}"))
    }

    /// Returns the larger and the smaller curvature, and the direction of the larger one.
    fn principal(shape: &VertexShape) -> ([f64; 2], DVec3) {
        let [uu, uv, vv] = shape.bend;
        let (mean, half) = (0.5 * (uu + vv), 0.5 * (uu - vv));
        let radius = half.hypot(uv);
        let along = if half >= 0.0 { DVec2::new(radius + half, uv) } else { DVec2::new(uv, radius - half) };
        let along = along.normalize_or(DVec2::X);
        let [u, v] = frame_of(shape.normal);
        ([mean + radius, mean - radius], u * along.x + v * along.y)
    }

    #[test]
    fn a_torus_bends_as_it_should() {
        let mesh = torus(120, 60);
        let shapes = shapes_of(&mesh);
        let (mut worst, mut turned, mut changed) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (shape, vertex) in shapes.iter().zip(&mesh.vertices_m) {
            let at = DVec3::from_array(vertex.map(f64::from)) + mesh.middle_m;
            let out = at.truncate().length();
            let cosine = out - MAJOR_M;
            let round = DVec3::new(-at.y, at.x, 0.0) / out;
            let across = shape.normal.cross(round);
            let ([most, least], way) = principal(shape);
            worst = worst.max((most - 1.0).abs()).max((least - cosine / out).abs());
            turned = turned.max(way.cross(across).length());
            // Around the axis the tube's curvature is cosine / out, which changes across as -sine * MAJOR / out^2.
            let frame = frame_of(shape.normal);
            let flat = |v: DVec3| DVec2::new(v.dot(frame[0]), v.dot(frame[1]));
            let expected = -at.z * MAJOR_M / (out * out);
            let up = DVec3::new(-at.x * at.z / out, -at.y * at.z / out, cosine);
            changed = changed.max((form3(shape.change, flat(round), flat(round), flat(up)) - expected).abs());
        }
        assert!(worst < 0.01 && turned < 0.0175 && changed < 0.03, "{worst} {turned} {changed}");
        // Planted errors: a wrong sign, and no derivative at all.
        assert!(shapes.iter().all(|shape| (-principal(shape).0[0] - 1.0).abs() > 0.5));
        assert!(shapes.iter().any(|shape| shape.change.iter().any(|part| part.abs() > 0.1)));
    }

    #[test]
    fn walls_are_flat_to_their_edges() {
        let places_m = (0..8).map(|i| DVec3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)));
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let soup = Soup { places_m: places_m.collect(), triangles, normals: Vec::new() };
        let cube = soup.into_mesh("cube".to_owned()).unwrap_or_else(|error| panic!("{error}"));
        for shape in shapes_of(&cube) {
            assert!(shape.bend.iter().chain(&shape.change).all(|part| part.abs() < 1e-12), "{shape:?}");
        }
    }
}
