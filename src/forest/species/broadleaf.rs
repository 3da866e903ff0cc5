//! An oak or a beech: a trunk that forks into limbs, and a wide crown of clumps with a scalloped outline.
//!
//! Clumps are placed on a spiral over the crown (spherical Fibonacci points) with random offsets, as far out as the
//! crown reaches there; up close there are more and smaller ones. Triangles inside of other clumps are left out.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::blob::Blob;
use super::patch::{Growth, Knot, Patch, level, pointed_limb};
use super::random::Random;
use super::{Corner, Detail, Part};

const CROWN_MIDDLE: DVec3 = DVec3::new(0.0, 0.0, 0.63);
/// Mean radii of the crown, to the ends of clumps.
const CROWN_RADII: DVec3 = DVec3::new(0.425, 0.375, 0.335);
const LIMBS: u32 = 4;
const FORK: DVec3 = DVec3::new(0.01, -0.01, 0.24);
/// Radius of the crown, for sway.
const REACH: f64 = 0.5;

/// Returns how far the crown reaches in a direction, relative to its radii; it has masses with bays between them.
fn crown(way: DVec3) -> f64 {
    let waves = DVec3::new(3.4 * way.x + 1.0, 3.9 * way.y + 2.0 * way.z, 4.2 * way.z - 2.0 * way.x + 2.2);
    1.0 + 0.065 * waves.to_array().map(f64::sin).iter().sum::<f64>()
}

/// Returns the inside of the crown, followed by the clumps on it.
fn clumps(detail: Detail) -> Vec<Blob> {
    let mut random = Random::new(5);
    let inside = Blob { at: CROWN_MIDDLE, radii: CROWN_RADII * 0.74, turn: DQuat::IDENTITY };
    let mut clumps = vec![inside];
    let (count, sizes, depth) = detail.pick((36, (0.095, 0.135), 1.0), (17, (0.145, 0.17), 0.92));
    for number in 0..count {
        // From the top down; the crown is open below.
        let z = 1.0 - 1.65 * (f64::from(number) + 0.5) / f64::from(count);
        let turn = f64::from(number) * 2.399_963 + random.between(-0.12, 0.12);
        let way = level(turn) * (1.0 - z * z).sqrt() + DVec3::Z * z;
        let size = random.between(sizes.0, sizes.1);
        let radii = DVec3::new(1.0, 1.0, 0.85) * DVec3::from([0, 1, 2].map(|_| size * random.between(0.93, 1.07)));
        let out = CROWN_RADII * crown(way) * random.between(0.97, 1.03) - DVec3::splat(size * depth);
        clumps.push(Blob {
            at: CROWN_MIDDLE + way * out,
            radii,
            turn: DQuat::from_axis_angle(random.direction(), random.unit() * TAU),
        });
    }
    clumps
}

/// Whether a triangle is hidden, because all of it is inside of other blobs than its own.
fn is_hidden(blobs: &[Blob], divisions: u32, own: Option<usize>, [a, b, c]: [DVec3; 3]) -> bool {
    [a, b, c, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, (a + b + c) / 3.0]
        .iter()
        .all(|place| blobs.iter().enumerate().any(|(other, blob)| own != Some(other) && blob.holds(*place, divisions)))
}

/// Returns the trunk and its limbs, whose ends are inside of the crown.
fn limbs(detail: Detail) -> Vec<Patch> {
    let knot = |at, radius| Knot { at, radius };
    let up = |z: f64| DVec3::Z * z;
    let trunk = [knot(up(0.0), 0.06), knot(up(0.05), 0.042), knot(FORK, 0.037), knot(FORK + up(0.2), 0.0)];
    let mut patches = vec![match detail {
        Detail::Near => pointed_limb(&trunk, 8),
        Detail::Middle => pointed_limb(&[trunk[0], knot(up(0.44), 0.0)], 5),
    }];
    for limb in 0..LIMBS {
        let out = level(f64::from(limb) / f64::from(LIMBS) * TAU + 0.5);
        let [root, bend, rise, end] = [
            knot(FORK - up(0.05), 0.027),
            knot(FORK + out * 0.09 + up(0.06), 0.023),
            knot(FORK + out * 0.19 + up(0.2), 0.016),
            knot(FORK + out * 0.24 + up(0.34), 0.0),
        ];
        patches.push(match detail {
            Detail::Near => pointed_limb(&[root, bend, rise, end], 5),
            Detail::Middle => pointed_limb(&[root, end], 3),
        });
    }
    patches
}

/// Grows the tree: three corners to a triangle, counter-clockwise from outside.
pub(super) fn grow(detail: Detail) -> Vec<Corner> {
    let (blobs, divisions) = (clumps(detail), detail.pick(1, 0));
    let mut growth = Growth::default();
    for patch in limbs(detail) {
        growth.add_seen(&patch, Part::Bark, |corners| is_hidden(&blobs, divisions, None, corners));
    }
    for (number, blob) in blobs.iter().enumerate() {
        let patch = blob.patch(divisions);
        growth.add_seen(&patch, Part::Leaf, |corners| is_hidden(&blobs, divisions, Some(number), corners));
    }
    growth.finish(REACH)
}
