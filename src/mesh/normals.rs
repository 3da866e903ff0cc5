//! Normals at the corners of triangles: those of the file, or smooth ones.
//!
//! Triangles that meet in an edge at less than [`CREASE_DEG`] share a normal at each of its ends: the area-weighted
//! mean of all triangles that are connected there in this way. The groups are found by joining corners across such
//! edges (union-find), which is linear even where a million triangles meet in one vertex.

use glam::DVec3;

use super::{Across, Triangle, place};

/// Sharper edges are creases: a tower of 16 sides is round, one of 8 has edges.
pub(crate) const CREASE_DEG: f64 = 35.0;

/// Sets the unit normals at the corners. `given` returns the file's normal for a triangle and a corner, of any length,
/// 0 where there is none.
pub(super) fn fill(vertices_m: &[[f32; 3]], triangles: &mut [Triangle], given: impl Fn(usize, usize) -> DVec3) {
    // The length is proportional to the triangle's area.
    let face = |triangle: &Triangle| {
        let [a, b, c] = triangle.corners.map(|corner| place(vertices_m[corner as usize]));
        (b - a).cross(c - a)
    };
    let own = |triangle: usize, corner: usize| {
        let own = given(triangle, corner);
        if own.is_finite() { own.normalize_or_zero() } else { DVec3::ZERO }
    };
    // If the file has all normals, groups and their memory are not needed.
    if (0..triangles.len()).all(|i| (0..3).all(|k| own(i, k) != DVec3::ZERO)) {
        for (i, triangle) in triangles.iter_mut().enumerate() {
            triangle.normals = std::array::from_fn(|k| own(i, k));
        }
        return;
    }
    let mut groups = Groups((0..3 * triangles.len() as u32).collect());
    let min_cosine = CREASE_DEG.to_radians().cos();
    for (i, triangle) in triangles.iter().enumerate() {
        let own_face = face(triangle);
        for (edge, across) in triangle.across.into_iter().enumerate() {
            let Across::Triangle { index, is_turned: false } = across else { continue };
            let other = index as usize;
            if other < i {
                continue;
            }
            let other_face = face(&triangles[other]);
            if own_face.dot(other_face) < min_cosine * own_face.length() * other_face.length() {
                continue;
            }
            for own in [edge, (edge + 1) % 3] {
                let their = triangles[other].corners.iter().position(|corner| *corner == triangle.corners[own]);
                if let Some(their) = their {
                    groups.join(3 * i + own, 3 * other + their);
                }
            }
        }
    }
    // Sums are stored at the first corners of the groups, which get their own normals last.
    for corner in 0..3 * triangles.len() {
        let face = face(&triangles[corner / 3]);
        let first = groups.first_of(corner);
        triangles[first / 3].normals[first % 3] += face;
    }
    for is_first in [false, true] {
        for corner in 0..3 * triangles.len() {
            let first = groups.first_of(corner);
            if (first == corner) != is_first {
                continue;
            }
            let own = own(corner / 3, corner % 3);
            let smooth = || triangles[first / 3].normals[first % 3].normalize_or_zero();
            // A triangle without area has no normal of its own, and any will do.
            let found = if own == DVec3::ZERO { smooth() } else { own };
            triangles[corner / 3].normals[corner % 3] = if found == DVec3::ZERO { DVec3::Z } else { found };
        }
    }
}

/// Groups of corners with a common normal: each corner refers to another of its group, the first one to itself.
struct Groups(Vec<u32>);

impl Groups {
    fn first_of(&mut self, corner: usize) -> usize {
        let mut at = corner;
        while self.0[at] as usize != at {
            // Path halving keeps paths short.
            self.0[at] = self.0[self.0[at] as usize];
            at = self.0[at] as usize;
        }
        at
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.first_of(a), self.first_of(b));
        self.0[a.max(b)] = a.min(b) as u32;
    }
}
