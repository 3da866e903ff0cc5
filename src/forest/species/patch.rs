//! Pieces of surface, of which trees are put together, and limbs among them.
//!
//! A normal is the mean of those of the triangles that meet at a place, weighted by their areas: contours are found
//! where places and normals disagree, so a finer shape's normals on these triangles would show as lines. Where a piece
//! bends so sharply that the mean points away from one of its triangles, it is turned towards that triangle there.

use std::f64::consts::TAU;

use glam::DVec3;

use super::{Corner, Part};

/// The least cosine between a normal and that of its triangle.
const LEAST_AGREEMENT: f64 = 0.15;

/// A smooth piece of surface.
#[derive(Clone, Debug, Default)]
pub struct Patch {
    /// Its places.
    pub places: Vec<DVec3>,
    /// Three places each, counterclockwise from outside.
    pub triangles: Vec<[usize; 3]>,
}

impl Patch {
    /// The corners of a triangle.
    pub fn at(&self, triangle: &[usize; 3]) -> [DVec3; 3] {
        triangle.map(|place| self.places[place])
    }

    /// A normal for each place, as long as the area that it is taken from.
    fn normals(&self) -> Vec<DVec3> {
        let mut normals = vec![DVec3::ZERO; self.places.len()];
        for triangle in &self.triangles {
            let face = face(self.at(triangle));
            triangle.iter().for_each(|place| normals[*place] += face);
        }
        normals
    }

    /// Two triangles for each side of a strip between two rings of as many places, the second one above or ahead.
    fn strip(&mut self, first: usize, second: usize, sides: usize) {
        for side in 0..sides {
            let next = (side + 1) % sides;
            self.triangles.push([first + side, first + next, second + next]);
            self.triangles.push([first + side, second + next, second + side]);
        }
    }

    /// A triangle for each side of a ring, to one place above or ahead.
    fn close(&mut self, ring: usize, sides: usize, point: usize) {
        self.triangles.extend((0..sides).map(|side| [ring + side, ring + (side + 1) % sides, point]));
    }

    /// A surface from ring to ring, all of as many places, up to a point.
    pub fn dome(rings: &[Vec<DVec3>], point: DVec3) -> Self {
        let sides = rings[0].len();
        let mut patch = Self { places: rings.concat(), ..Self::default() };
        patch.places.push(point);
        for ring in 1..rings.len() {
            patch.strip((ring - 1) * sides, ring * sides, sides);
        }
        patch.close((rings.len() - 1) * sides, sides, rings.len() * sides);
        patch
    }

    /// The same, closed by a point below the first ring, too.
    pub fn closed(below: DVec3, rings: &[Vec<DVec3>], point: DVec3) -> Self {
        let sides = rings[0].len();
        let mut patch = Self::dome(rings, point);
        patch.places.push(below);
        let last = patch.places.len() - 1;
        patch.triangles.extend((0..sides).map(|side| [(side + 1) % sides, side, last]));
        patch
    }
}

/// Of a triangle, outward, twice as long as its area.
pub fn face([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Places around a vertical axis, counterclockwise from above; `at` has a turn (rad) and the number of the place.
pub fn ring(sides: usize, mut at: impl FnMut(f64, usize) -> DVec3) -> Vec<DVec3> {
    (0..sides).map(|side| at(side as f64 / sides as f64 * TAU, side)).collect()
}

/// Of length 1, level, that way.
pub fn level(turn: f64) -> DVec3 {
    let (sin, cos) = turn.sin_cos();
    DVec3::new(cos, sin, 0.0)
}

/// A place of a limb's middle, and how thick the limb is there.
#[derive(Clone, Copy, Debug)]
pub struct Knot {
    /// Where.
    pub at: DVec3,
    /// Half the thickness.
    pub radius: f64,
}

/// Rings around knots, which follow the limb's bends without a twist.
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

/// A limb that ends in its last knot, a point. Its foot is open: it stands on the ground or inside another limb.
pub fn pointed_limb(knots: &[Knot], sides: usize) -> Patch {
    let (point, shaft) = (knots[knots.len() - 1], &knots[..knots.len() - 1]);
    let mut rings = rings(knots, sides);
    rings.truncate(shaft.len());
    Patch::dome(&rings, point.at)
}

/// A limb that is broken off at its last knot: its wall, whose rim is ragged, and the hollow in it.
pub fn broken_limb(knots: &[Knot], sides: usize, mut splinter: impl FnMut(usize) -> f64) -> [Patch; 2] {
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

/// A tree while it is put together.
#[derive(Debug, Default)]
pub struct Growth {
    corners: Vec<Corner>,
}

impl Growth {
    /// Adds a piece.
    pub fn add(&mut self, patch: &Patch, part: Part) {
        self.add_seen(patch, part, |_| false);
    }

    /// Adds of a piece what is not hidden.
    pub fn add_seen(&mut self, patch: &Patch, part: Part, is_hidden: impl Fn([DVec3; 3]) -> bool) {
        let normals = patch.normals();
        for triangle in patch.triangles.iter().filter(|triangle| !is_hidden(patch.at(triangle))) {
            let face = face(patch.at(triangle)).normalize();
            self.corners.extend(triangle.map(|place| {
                let mean = normals[place].normalize_or(face);
                let lacks = (LEAST_AGREEMENT - mean.dot(face)).max(0.0);
                Corner { at: patch.places[place], normal: (mean + face * lacks).normalize(), part, sway: 0.0 }
            }));
        }
    }

    /// The tree with its top at 1, swaying: what is high moves more than what is low, and what is far from the trunk,
    /// up to `reach`, more than what is near.
    pub fn finish(mut self, reach: f64) -> Vec<Corner> {
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

    /// Of a surface without holes.
    fn volume(patches: &[Patch]) -> f64 {
        let of = |patch: &Patch| -> f64 {
            patch.triangles.iter().map(|triangle| patch.at(triangle)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
        };
        patches.iter().map(of).sum()
    }

    #[test]
    fn limbs_hold_the_volume_of_their_knots() {
        // Prisms of twelve sides, of which the second ends in a hollow pyramid and the third in a point.
        let base = 3.0 * 0.1 * 0.1;
        let broken = broken_limb(&straight(0.1), 12, |_| 0.0);
        assert!((volume(&broken) - (base - base * 0.1 / 3.0)).abs() < 1e-12, "{}", volume(&broken));
        let pointed = pointed_limb(&straight(0.1), 12);
        assert!((volume(&[pointed]) - (base * 0.5 + base * 0.5 / 3.0)).abs() < 1e-12);
        // Planted: without its hollow a limb is open, and inside out it holds less than nothing.
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
        // Planted: the plain mean of directions is another.
        assert!((DVec3::new(1.0, 0.0, 1.0).normalize() - mean).length() > 0.1);
        // A fold: the mean alone would be almost that of the large triangle, from which the other points away.
        let places = vec![DVec3::ZERO, DVec3::Y, DVec3::X * -3.0, DVec3::new(-0.3, 0.0, -0.1)];
        let fold = Patch { places, triangles: vec![[0, 1, 2], [0, 3, 1]] };
        let under = face(fold.at(&[0, 3, 1]));
        assert!(fold.normals()[0].dot(under) < 0.0);
        let mut growth = Growth::default();
        growth.add(&fold, Part::Leaf);
        assert!(growth.corners[3..].iter().all(|corner| corner.normal.dot(under) > 0.0));
    }
}
