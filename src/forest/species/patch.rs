//! Smooth patches of surface from which trees are assembled: crowns, and limbs (trunks and branches).
//!
//! A vertex normal is the mean of the normals of its triangles, weighted by area. A finer shape's normals on these
//! triangles would not do: contours are drawn where the vertex normals turn away from the eye, and would appear within
//! the triangles. Where a patch bends so sharply that the mean points away from one of its triangles, that triangle's
//! corner has a normal that is tilted toward the triangle.

use std::f64::consts::TAU;

use glam::DVec3;

use super::{Corner, Part};

/// Least cosine between a vertex normal and the triangle's normal.
const MIN_AGREEMENT: f64 = 0.15;

/// A smooth patch of surface, as a mesh.
#[derive(Clone, Debug, Default)]
pub(super) struct Patch {
    /// Positions of the vertices.
    pub places: Vec<DVec3>,
    /// Triangles as indices of vertices, counter-clockwise from outside.
    pub triangles: Vec<[usize; 3]>,
}

impl Patch {
    /// Returns the positions of a triangle's corners.
    pub(super) fn at(&self, triangle: &[usize; 3]) -> [DVec3; 3] {
        triangle.map(|place| self.places[place])
    }

    /// Returns the area-weighted normal of each vertex, not normalised.
    fn normals(&self) -> Vec<DVec3> {
        let mut normals = vec![DVec3::ZERO; self.places.len()];
        for triangle in &self.triangles {
            let face = face(self.at(triangle));
            triangle.iter().for_each(|place| normals[*place] += face);
        }
        normals
    }

    /// Adds the strip between two rings of `sides` vertices, as two triangles per side. `first` and `second` are the
    /// indices of the rings' first vertices; the second ring is above the first, or farther along the limb.
    fn strip(&mut self, first: usize, second: usize, sides: usize) {
        for side in 0..sides {
            let next = (side + 1) % sides;
            self.triangles.push([first + side, first + next, second + next]);
            self.triangles.push([first + side, second + next, second + side]);
        }
    }

    /// Closes a ring by a fan of triangles to the vertex `point`, which is above the ring, or farther along the limb.
    fn close(&mut self, ring: usize, sides: usize, point: usize) {
        self.triangles.extend((0..sides).map(|side| [ring + side, ring + (side + 1) % sides, point]));
    }

    /// Builds a surface through rings of equal size, up to a point.
    pub(super) fn dome(rings: &[Vec<DVec3>], point: DVec3) -> Self {
        let sides = rings[0].len();
        let mut patch = Self { places: rings.concat(), ..Self::default() };
        patch.places.push(point);
        for ring in 1..rings.len() {
            patch.strip((ring - 1) * sides, ring * sides, sides);
        }
        patch.close((rings.len() - 1) * sides, sides, rings.len() * sides);
        patch
    }

    /// Builds a dome that is closed by a point below the first ring.
    pub(super) fn closed(below: DVec3, rings: &[Vec<DVec3>], point: DVec3) -> Self {
        let sides = rings[0].len();
        let mut patch = Self::dome(rings, point);
        patch.places.push(below);
        let last = patch.places.len() - 1;
        patch.triangles.extend((0..sides).map(|side| [(side + 1) % sides, side, last]));
        patch
    }
}

/// Returns the outward normal of a triangle, twice as long as its area.
pub(super) fn face([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Returns vertices around a vertical axis, counter-clockwise from above; `at` receives the angle in radians and the
/// index of the vertex.
pub(super) fn ring(sides: usize, mut at: impl FnMut(f64, usize) -> DVec3) -> Vec<DVec3> {
    (0..sides).map(|side| at(side as f64 / sides as f64 * TAU, side)).collect()
}

/// Returns the horizontal unit vector at an angle in radians.
pub(super) fn level(turn: f64) -> DVec3 {
    let (sin, cos) = turn.sin_cos();
    DVec3::new(cos, sin, 0.0)
}

/// A point on the centre line of a limb, with the limb's radius there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knot {
    pub at: DVec3,
    pub radius: f64,
}

/// Returns rings around knots, which follow the limb's bends without twist.
fn rings(knots: &[Knot], sides: usize) -> Vec<Vec<DVec3>> {
    let mut across = DVec3::ZERO;
    let last = knots.len() - 1;
    (0..=last)
        .map(|i| {
            let along = (knots[(i + 1).min(last)].at - knots[i.saturating_sub(1)].at).normalize();
            across = match i {
                0 => along.any_orthonormal_vector(),
                _ => (across - along * across.dot(along)).normalize(),
            };
            let over = along.cross(across);
            ring(sides, |turn, _| knots[i].at + (across * turn.cos() + over * turn.sin()) * knots[i].radius)
        })
        .collect()
}

/// Builds a limb that ends in a point, its last knot. The other end is open: it is on the ground or inside of another
/// limb.
pub(super) fn pointed_limb(knots: &[Knot], sides: usize) -> Patch {
    let (point, shaft) = (knots[knots.len() - 1], &knots[..knots.len() - 1]);
    let mut rings = rings(knots, sides);
    rings.truncate(shaft.len());
    Patch::dome(&rings, point.at)
}

/// Builds a limb that is broken off at its last knot: the outer wall with a ragged rim, and the hollow inside.
/// `splinter` returns by how much each vertex of the rim protrudes.
pub(super) fn broken_limb(knots: &[Knot], sides: usize, mut splinter: impl FnMut(usize) -> f64) -> [Patch; 2] {
    let mut rings = rings(knots, sides);
    let (end, before) = (knots[knots.len() - 1], knots[knots.len() - 2]);
    let along = (end.at - before.at).normalize();
    let last = rings.len() - 1;
    rings[last].iter_mut().enumerate().for_each(|(side, place)| *place += along * splinter(side));
    let mut wall = Patch { places: rings.concat(), ..Patch::default() };
    (1..rings.len()).for_each(|ring| wall.strip((ring - 1) * sides, ring * sides, sides));
    let hollow = Patch::dome(&rings[last..], end.at - along * end.radius);
    [wall, hollow]
}

/// A tree being assembled.
#[derive(Debug, Default)]
pub(super) struct Growth {
    corners: Vec<Corner>,
}

impl Growth {
    pub(super) fn add(&mut self, patch: &Patch, part: Part) {
        self.add_seen(patch, part, |_| false);
    }

    /// Adds the triangles of a patch that are not hidden.
    pub(super) fn add_seen(&mut self, patch: &Patch, part: Part, is_hidden: impl Fn([DVec3; 3]) -> bool) {
        let normals = patch.normals();
        for triangle in patch.triangles.iter().filter(|triangle| !is_hidden(patch.at(triangle))) {
            let face = face(patch.at(triangle)).normalize();
            self.corners.extend(triangle.map(|place| {
                let mean = normals[place].normalize_or(face);
                let lacks = (MIN_AGREEMENT - mean.dot(face)).max(0.0);
                Corner { at: patch.places[place], normal: (mean + face * lacks).normalize(), part, sway: 0.0 }
            }));
        }
    }

    /// Scales the tree to a height of 1, and sets how far each corner sways in the wind: the sway, 0 to 1, increases
    /// with height, and with distance from the trunk up to `reach` (relative to the tree's height).
    pub(super) fn finish(mut self, reach: f64) -> Vec<Corner> {
        let top = self.corners.iter().fold(0.0, |top: f64, corner| top.max(corner.at.z));
        for corner in &mut self.corners {
            corner.at /= top;
            let out = (corner.at.truncate().length() / reach).min(1.0);
            corner.sway = (corner.at.z.max(0.0) * (0.35 + 0.65 * out) * 1.25).min(1.0);
        }
        self.corners
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn straight(radius: f64) -> Vec<Knot> {
        [0.0, 0.5, 1.0].map(|z| Knot { at: DVec3::Z * z, radius }).to_vec()
    }

    /// Volume of a closed surface.
    fn volume(patches: &[Patch]) -> f64 {
        let of = |patch: &Patch| -> f64 {
            patch.triangles.iter().map(|triangle| patch.at(triangle)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
        };
        patches.iter().map(of).sum()
    }

    #[test]
    fn limbs_hold_the_volume_of_their_knots() {
        // Prisms of twelve sides: the second ends in a hollow pyramid, the third in a point.
        let base = 3.0 * 0.1 * 0.1;
        let broken = broken_limb(&straight(0.1), 12, |_| 0.0);
        assert!((volume(&broken) - (base - base * 0.1 / 3.0)).abs() < 1e-12, "{}", volume(&broken));
        let pointed = pointed_limb(&straight(0.1), 12);
        assert!((volume(&[pointed]) - (base * 0.5 + base * 0.5 / 3.0)).abs() < 1e-12);
        // Planted: without its hollow a limb is open, and with reversed triangles its volume is negative.
        assert!((volume(&broken[..1]) - volume(&broken)).abs() > 1e-3);
        let mut turned = pointed_limb(&straight(0.1), 12);
        turned.triangles.iter_mut().for_each(|triangle| triangle.swap(0, 1));
        assert!(volume(&[turned]) < 0.0);
    }

    #[test]
    fn normals_are_means_by_area_but_agree_with_their_triangles() {
        // A ridge: a large level triangle and a small upright one.
        let places = vec![DVec3::ZERO, DVec3::Y, DVec3::X * -3.0, DVec3::Z * -1.0];
        let ridge = Patch { places, triangles: vec![[0, 1, 2], [0, 3, 1]] };
        let mut growth = Growth::default();
        growth.add(&ridge, Part::Leaf);
        let mean = (face(ridge.at(&[0, 1, 2])) + face(ridge.at(&[0, 3, 1]))).normalize();
        assert!((growth.corners[0].normal - mean).length() < 1e-12, "{:?}", growth.corners[0]);
        // Planted: the unweighted mean of directions.
        assert!((DVec3::new(1.0, 0.0, 1.0).normalize() - mean).length() > 0.1);
        // A fold: the mean alone is almost the normal of the large triangle, which points away from the other one.
        let places = vec![DVec3::ZERO, DVec3::Y, DVec3::X * -3.0, DVec3::new(-0.3, 0.0, -0.1)];
        let fold = Patch { places, triangles: vec![[0, 1, 2], [0, 3, 1]] };
        let under = face(fold.at(&[0, 3, 1]));
        assert!(fold.normals()[0].dot(under) < 0.0);
        let mut growth = Growth::default();
        growth.add(&fold, Part::Leaf);
        assert!(growth.corners[3..].iter().all(|corner| corner.normal.dot(under) > 0.0));
    }
}
