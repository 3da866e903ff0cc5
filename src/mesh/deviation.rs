//! The deviation of two meshes: the largest distance from a point on either to the other (the Hausdorff distance). From
//! any viewpoint, no outline of one is farther than that from an outline of the other.
//!
//! The points are vertices, and more points on wide triangles; of a large mesh only every n-th vertex. So the result is
//! a measurement, not a bound, although edge collapses remove only vertices.

use glam::DVec3;

use super::{Mesh, place};

/// Distance of points on triangles, as a fraction of the mesh's radius.
const STEP: f64 = 1.0 / 24.0;
/// Largest number of steps along a triangle's longest edge.
const MAX_STEPS: u32 = 8;
/// Approximate largest number of vertices, or triangles, of which points are taken.
const MAX_SAMPLES: usize = 1 << 15;
/// Number of triangles in a leaf of the tree.
const LEAF: usize = 4;

type Corners = [DVec3; 3];

/// Returns the distance between two versions of a mesh, in their unit.
pub(crate) fn deviation(one: &Mesh, other: &Mesh) -> f64 {
    let step_m = one.radius_m * STEP;
    let (ones, others) = (corners(one), corners(other));
    let (from_one, from_other) = (samples(&ones, step_m), samples(&others, step_m));
    let (one, other) = (Tree::new(ones), Tree::new(others));
    farthest(&from_one, &other).max(farthest(&from_other, &one))
}

fn corners(mesh: &Mesh) -> Vec<Corners> {
    let at = |vertex: u32| mesh.middle_m + place(mesh.vertices_m[vertex as usize]);
    mesh.triangles.iter().map(|triangle| triangle.corners.map(at)).collect()
}

/// Returns points on triangles: their corners, and a grid on wide ones.
fn samples(triangles: &[Corners], step_m: f64) -> Vec<DVec3> {
    let each = triangles.len().div_ceil(MAX_SAMPLES);
    let mut points = Vec::new();
    for [a, b, c] in triangles.iter().step_by(each) {
        let longest_m = a.distance(*b).max(b.distance(*c)).max(c.distance(*a));
        let steps = ((longest_m / step_m.max(f64::MIN_POSITIVE)).ceil() as u32).clamp(1, MAX_STEPS);
        for i in 0..=steps {
            for j in 0..=steps - i {
                let (by_b, by_c) = (f64::from(i) / f64::from(steps), f64::from(j) / f64::from(steps));
                points.push(*a + (*b - *a) * by_b + (*c - *a) * by_c);
            }
        }
    }
    points
}

/// Returns the largest distance of points from a mesh.
fn farthest(points: &[DVec3], tree: &Tree) -> f64 {
    // Distances below the largest so far need not be exact.
    points.iter().fold(0.0_f64, |max_m2, point| max_m2.max(tree.distance2(*point, max_m2))).sqrt()
}

/// A bounding volume hierarchy of triangles.
struct Tree {
    triangles: Vec<Corners>,
    nodes: Vec<Node>,
}

struct Node {
    low: DVec3,
    high: DVec3,
    /// The first triangle of the node.
    first: u32,
    count: u32,
    /// The second child; the first one follows this node. 0 for a leaf.
    second: u32,
}

impl Tree {
    fn new(triangles: Vec<Corners>) -> Self {
        let count = triangles.len();
        let mut tree = Self { triangles, nodes: Vec::new() };
        tree.split(0, count);
        tree
    }

    fn split(&mut self, first: usize, end: usize) {
        let number = self.nodes.len();
        let own = &mut self.triangles[first..end];
        let low = own.iter().flatten().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = own.iter().flatten().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        self.nodes.push(Node { low, high, first: first as u32, count: (end - first) as u32, second: 0 });
        if end - first <= LEAF {
            return;
        }
        let size = high - low;
        let axis = if size.x >= size.max_element() {
            0
        } else if size.y >= size.max_element() {
            1
        } else {
            2
        };
        let along = |corners: &Corners| corners.iter().map(|corner| corner[axis]).sum::<f64>();
        let half = own.len() / 2;
        own.select_nth_unstable_by(half, |a, b| along(a).total_cmp(&along(b)));
        self.split(first, first + half);
        self.nodes[number].second = self.nodes.len() as u32;
        self.split(first + half, end);
    }

    /// Returns the squared distance to the nearest triangle, or any value up to `enough` if it is not more than that.
    fn distance2(&self, point: DVec3, enough: f64) -> f64 {
        let mut best = f64::INFINITY;
        let mut open = vec![0_u32];
        while let Some(number) = open.pop() {
            let Node { low, high, first, count, second } = self.nodes[number as usize];
            if best <= enough {
                break;
            }
            if point.distance_squared(point.clamp(low, high)) >= best {
                continue;
            }
            if second == 0 {
                let own = &self.triangles[first as usize..(first + count) as usize];
                best = own.iter().map(|corners| distance2(point, corners)).fold(best, f64::min);
                continue;
            }
            let away = |node: u32| {
                let Node { low, high, .. } = self.nodes[node as usize];
                point.distance_squared(point.clamp(low, high))
            };
            // The nearer child is visited first.
            let (near, far) =
                if away(number + 1) <= away(second) { (number + 1, second) } else { (second, number + 1) };
            open.extend([far, near]);
        }
        best
    }
}

/// Returns the squared distance of a point from a triangle (Ericson, *Real-Time Collision Detection*, 2005, section
/// 5.1.5).
fn distance2(p: DVec3, [a, b, c]: &Corners) -> f64 {
    let (ab, ac, ap) = (*b - *a, *c - *a, p - *a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return ap.length_squared();
    }
    let bp = p - *b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return bp.length_squared();
    }
    let cp = p - *c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return cp.length_squared();
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (ap - ab * (d1 / (d1 - d3))).length_squared();
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (ap - ac * (d2 / (d2 - d6))).length_squared();
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return (bp - (*c - *b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))).length_squared();
    }
    let whole = va + vb + vc;
    (ap - ab * (vb / whole) - ac * (vc / whole)).length_squared()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::obj;

    fn square(side: f64, z: f64) -> Mesh {
        let text = format!("v 0 0 {z}\nv {side} 0 {z}\nv {side} {side} {z}\nv 0 {side} {z}\nf 1 2 3 4\n");
        obj::parse("a".to_owned(), text.as_bytes()).unwrap()
    }

    #[test]
    fn distances_are_those_of_squares() {
        let same = deviation(&square(1.0, 0.0), &square(1.0, 0.0));
        assert!(same < 1e-9, "{same}");
        assert!((deviation(&square(1.0, 0.0), &square(1.0, 0.3)) - 0.3).abs() < 1e-6);
        // The farthest point is a corner of the larger square, whichever comes first.
        for (one, other) in [(1.0, 2.0), (2.0, 1.0)] {
            let found = deviation(&square(one, 0.0), &square(other, 0.0));
            assert!((found - 2.0_f64.sqrt()).abs() < 1e-6, "{found}");
        }
    }

    #[test]
    fn the_tree_finds_the_nearest_of_all_triangles() {
        let random = |i: u64| {
            let z = (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5555).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            (z >> 11) as f64 / (1_u64 << 53) as f64
        };
        let at = |i: u64| DVec3::new(random(3 * i), random(3 * i + 1), random(3 * i + 2));
        let triangles: Vec<Corners> =
            (0..300).map(|i| [at(3 * i), at(3 * i) + 0.1 * at(3 * i + 1), at(3 * i) + 0.1 * at(3 * i + 2)]).collect();
        let tree = Tree::new(triangles.clone());
        for i in 0..200 {
            let point = at(5000 + i) * 1.4 - 0.2;
            let brute = triangles.iter().map(|corners| distance2(point, corners)).fold(f64::INFINITY, f64::min);
            assert!((tree.distance2(point, 0.0) - brute).abs() < 1e-12);
            // Brute force: points on the triangle.
            let [a, b, c] = triangles[i as usize];
            let on = |i: i32, j: i32| a + (b - a) * (f64::from(i) / 40.0) + (c - a) * (f64::from(j) / 40.0);
            let near = (0..=40).flat_map(|i| (0..=40 - i).map(move |j| on(i, j).distance(point)));
            let (near, found) = (near.fold(f64::INFINITY, f64::min), distance2(point, &triangles[i as usize]).sqrt());
            assert!(found <= near + 1e-9 && near < found + 0.01, "{found} {near}");
        }
    }
}
