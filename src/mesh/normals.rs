//! Normals at the corners of triangles: those of the file, or smooth ones.
//!
//! Triangles that meet in an edge at less than [`CREASE_DEG`] have one normal at each of its ends, the mean by area of
//! all that hang together there in this way. It is found by joining corners across such edges (union-find), which is
//! linear also where a million triangles meet in one vertex.

use glam::DVec3;

use super::{Across, place};

/// Edges that bend by more stay sharp: 16 sides of a tower are round, 8 are edges.
pub const CREASE_DEG: f64 = 35.0;

/// Normals at the corners, unit. `given` are those of the file, of any length, 0 where there is none.
pub fn of_corners(
    vertices_m: &[[f32; 3]],
    corners: &[[u32; 3]],
    across: &[[Across; 3]],
    given: &[[DVec3; 3]],
) -> Vec<[DVec3; 3]> {
    // As long as the triangle is large.
    let faces: Vec<DVec3> = corners
        .iter()
        .map(|corners| {
            let [a, b, c] = corners.map(|corner| place(vertices_m[corner as usize]));
            (b - a).cross(c - a)
        })
        .collect();
    let mut groups = Groups((0..3 * corners.len() as u32).collect());
    let least_cosine = CREASE_DEG.to_radians().cos();
    for (i, across) in across.iter().enumerate() {
        for (edge, across) in across.iter().enumerate() {
            let Across::Triangle { index, is_turned: false } = *across else { continue };
            let other = index as usize;
            if other < i || faces[i].dot(faces[other]) < least_cosine * faces[i].length() * faces[other].length() {
                continue;
            }
            for own in [edge, (edge + 1) % 3] {
                if let Some(their) = corners[other].iter().position(|corner| *corner == corners[i][own]) {
                    groups.join(3 * i + own, 3 * other + their);
                }
            }
        }
    }
    let mut sums = vec![DVec3::ZERO; 3 * corners.len()];
    for corner in 0..sums.len() {
        sums[groups.first_of(corner)] += faces[corner / 3];
    }
    (0..corners.len())
        .map(|i| {
            std::array::from_fn(|k| {
                let own = given[i][k];
                let own = if own.is_finite() { own.normalize_or_zero() } else { DVec3::ZERO };
                let mut smooth = || sums[groups.first_of(3 * i + k)].normalize_or_zero();
                // A triangle without area has no normal of its own, and needs none.
                let found = if own == DVec3::ZERO { smooth() } else { own };
                if found == DVec3::ZERO { DVec3::Z } else { found }
            })
        })
        .collect()
}

/// Which corners have one normal: each names another of its group, the first of them itself.
struct Groups(Vec<u32>);

impl Groups {
    fn first_of(&mut self, corner: usize) -> usize {
        let mut at = corner;
        while self.0[at] as usize != at {
            // Halving the way keeps ways short.
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
