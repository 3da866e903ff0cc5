//! A spruce: whorls of sprays that droop from a straight trunk, with random lengths, so that the outline is as ragged
//! as a pen would draw it.
//!
//! A spray is a thin solid along its branch, with a ridge on top. Up close, a branch has two sprays with three points
//! each; in the middle distance it is one tetrahedron that covers both.

use std::f64::consts::TAU;

use glam::DVec3;

use super::patch::{Growth, Knot, Patch, level, pointed_limb};
use super::random::Random;
use super::{Corner, Detail, Part};

const WHORLS: u32 = 14;
/// Length of the lowest sprays.
const REACH: f64 = 0.2;
const TRUNK_RADIUS: f64 = 0.014;

/// A branch with its needles.
struct Spray {
    root: DVec3,
    turn: f64,
    length: f64,
    half_width: f64,
    /// Distance by which the tip hangs down, relative to the length.
    droop: f64,
}

fn branches() -> Vec<Spray> {
    let mut random = Random::new(11);
    let mut branches = Vec::new();
    for whorl in 0..WHORLS {
        let up = f64::from(whorl) / f64::from(WHORLS - 1);
        let count = (6.8 - 3.2 * up).round();
        let reach = REACH * (1.0 - up).powf(0.92) + 0.03;
        // Whorls are closer together toward the top.
        let z = 0.18 + 0.78 * (1.0 - (1.0 - up).powf(1.25));
        for number in 0..count as u32 {
            let turn = (f64::from(number) + random.between(-0.2, 0.2)) / count * TAU + f64::from(whorl) * 2.4;
            let length = reach * random.between(0.72, 1.1);
            branches.push(Spray {
                root: DVec3::Z * (z + random.between(-0.026, 0.026) * (1.0 - 0.7 * up)),
                turn,
                length,
                half_width: length * (0.5 - 0.08 * up) * random.between(0.85, 1.1),
                droop: 0.68 - 0.2 * up * up + random.between(-0.1, 0.1),
            });
        }
    }
    branches
}

impl Spray {
    /// Returns the two sprays that replace the branch up close; one of them is as long as the branch.
    fn halves(&self, random: &mut Random) -> [Self; 2] {
        let longer = if random.unit() < 0.5 { 1.0 } else { -1.0 };
        [1.0, -1.0].map(|side: f64| {
            let by = if side * longer > 0.0 { 1.04 } else { random.between(0.86, 0.98) };
            Self {
                root: self.root + DVec3::Z * random.between(-0.03, 0.03) * self.length,
                turn: self.turn + side * self.half_width / self.length * 0.52,
                length: self.length * by,
                half_width: self.half_width * 0.66,
                droop: self.droop + random.between(-0.05, 0.05),
            }
        })
    }

    /// Returns a point by distances along the spray and above the branch, relative to its length, and across it,
    /// relative to its half width.
    fn place(&self, along: f64, across: f64, above: f64) -> DVec3 {
        let out = level(self.turn);
        let side = DVec3::new(-out.y, out.x, 0.0);
        // Branches bend up again at their ends, and twigs hang from their sides.
        let sinks = self.droop * along * (1.8 - 0.8 * along) + 0.32 * across.abs() * self.half_width / self.length;
        let in_lengths = out * along + DVec3::Z * (above - sinks);
        self.root + in_lengths * self.length + side * across * self.half_width
    }

    /// Returns the upper and the lower side, which meet in a sharp rim.
    fn patches(&self, detail: Detail) -> [Patch; 2] {
        // Points on the middle line (near, the last is the underside of the root, because the branch sags below a
        // straight line), and on the left part of the rim, of which the right part is the mirror image.
        let (middle, left): (&[_], &[_]) = match detail {
            Detail::Near => (&[(0.0, 0.34), (0.5, 0.17), (1.0, 0.0), (0.0, -0.12)], &[(0.58, 0.95), (0.72, 0.5)]),
            Detail::Middle => (&[(0.0, 0.34), (1.0, 0.0)], &[(0.55, 0.86)]),
        };
        let mut places: Vec<DVec3> = middle.iter().map(|(along, above)| self.place(*along, 0.0, *above)).collect();
        for side in [1.0, -1.0] {
            places.extend(left.iter().map(|(along, across)| self.place(*along, side * across, 0.0)));
        }
        let both = |left_triangles: &[[usize; 3]]| -> Vec<[usize; 3]> {
            let mirrored = |place: usize| if place < middle.len() { place } else { place + left.len() };
            left_triangles.iter().flat_map(|&[a, b, c]| [[a, b, c], [a, c, b].map(mirrored)]).collect()
        };
        let (upper, lower) = match detail {
            Detail::Near => (both(&[[0, 1, 4], [1, 5, 4], [1, 2, 5]]), both(&[[0, 4, 3], [3, 4, 5], [3, 5, 2]])),
            Detail::Middle => (both(&[[0, 1, 2]]), vec![[0, 2, 3], [2, 1, 3]]),
        };
        [Patch { places: places.clone(), triangles: upper }, Patch { places, triangles: lower }]
    }
}

/// Grows the tree: three corners to a triangle, counter-clockwise from outside.
pub(super) fn grow(detail: Detail) -> Vec<Corner> {
    let mut growth = Growth::default();
    let knots: &[(f64, f64)] = detail.pick(&[(0.0, 1.5), (0.04, 1.0), (1.0, 0.0)], &[(0.0, 1.2), (1.0, 0.0)]);
    let knots: Vec<Knot> = knots.iter().map(|(z, by)| Knot { at: DVec3::Z * *z, radius: TRUNK_RADIUS * by }).collect();
    growth.add(&pointed_limb(&knots, detail.pick(7, 4)), Part::Bark);
    let mut random = Random::new(13);
    for branch in branches() {
        let halves = branch.halves(&mut random);
        let sprays: &[Spray] = detail.pick(&halves, std::slice::from_ref(&branch));
        for patch in sprays.iter().flat_map(|spray| spray.patches(detail)) {
            growth.add(&patch, Part::Leaf);
        }
    }
    growth.finish(REACH)
}
