//! A birch: a slender, slightly bent trunk with thin rising limbs; small clumps of leaves hang from their ends.
//!
//! A clump is rounded above and ragged below, like hanging twigs; the crown is open between clumps.

use std::f64::consts::TAU;

use glam::DVec3;

use super::patch::{Growth, Knot, Patch, level, pointed_limb, ring};
use super::random::Random;
use super::{Corner, Detail, Part};

const CLUMPS: u32 = 12;
const TRUNK_RADIUS: f64 = 0.015;
/// Radius of the crown.
const REACH: f64 = 0.25;
/// Number of vertices along the fringe of a clump, alternately tips and gaps.
const FRINGE: usize = 7;

/// Returns the centre line of the trunk at height `z`.
fn trunk(z: f64) -> DVec3 {
    DVec3::new(0.05 * z * z, 0.035 * (z * 4.0).sin() * z, z)
}

/// A hanging clump of leaves.
#[derive(Clone, Copy)]
struct Clump {
    /// Centre of its widest ring.
    at: DVec3,
    radius: f64,
    /// Length from there to the tips.
    hangs: f64,
    turn: f64,
    /// Point where its limb leaves the trunk.
    root: DVec3,
}

fn clumps() -> Vec<Clump> {
    let mut random = Random::new(23);
    (0..CLUMPS)
        .map(|number| {
            let up = (f64::from(number) + 0.5) / f64::from(CLUMPS);
            let z = 0.42 + 0.53 * up.powf(0.9);
            // Widest below the middle of the crown.
            let out = 0.15 * (1.0 - up.powi(3)) * (0.5 + 0.5 * (up * 6.0).min(1.0)) * random.between(0.8, 1.1);
            let turn = f64::from(number) * 2.399_963 + random.between(-0.3, 0.3);
            let radius = (0.1 - 0.045 * up) * random.between(0.88, 1.12);
            Clump {
                at: trunk(z) + level(turn) * out,
                radius,
                hangs: radius * random.between(1.3, 1.8),
                turn: random.unit() * TAU,
                root: trunk(z - 0.13 - 0.25 * out),
            }
        })
        .collect()
}

impl Clump {
    fn place(&self, turn: f64, out: f64, z: f64) -> DVec3 {
        self.at + level(turn + self.turn) * out * self.radius + DVec3::Z * z
    }

    /// Returns the three clumps that replace it up close: one above the other two.
    fn parts(&self, random: &mut Random) -> [Self; 3] {
        [0.0, 1.0, 2.0].map(|number| {
            let size = random.between(0.56, 0.7);
            let aside = level(self.turn + number / 3.0 * TAU) * (1.0 - size) * 1.15 * self.radius;
            let z = if number == 0.0 { 0.35 } else { random.between(-0.45, -0.05) };
            Self {
                at: self.at + aside + DVec3::Z * z * self.radius,
                radius: self.radius * size,
                hangs: self.hangs * random.between(0.7, 0.95),
                turn: random.unit() * TAU,
                root: self.root,
            }
        })
    }

    /// Returns a surface that is rounded above, with a fringe below.
    fn fringed(&self, random: &mut Random) -> Patch {
        let rings = [
            ring(FRINGE, |turn, side| {
                let reach = if side % 2 == 0 { random.between(0.8, 1.2) } else { random.between(0.45, 0.65) };
                self.place(turn, 0.8, -self.hangs * reach)
            }),
            ring(FRINGE, |turn, _| self.place(turn - 0.2, random.between(0.95, 1.1), -0.1 * self.hangs)),
            ring(FRINGE, |turn, _| self.place(turn - 0.4, random.between(0.65, 0.8), 0.55 * self.radius)),
        ];
        Patch::closed(self.place(0.0, 0.0, -0.3 * self.hangs), &rings, self.place(0.0, 0.0, 0.9 * self.radius))
    }

    /// Returns a simple surface of 20 triangles.
    fn plain(&self) -> Patch {
        let rings = [
            ring(5, |turn, _| self.place(turn, 0.9, -0.6 * self.hangs)),
            ring(5, |turn, _| self.place(turn - TAU / 10.0, 1.04, 0.25 * self.radius)),
        ];
        Patch::closed(self.place(0.0, 0.0, -1.1 * self.hangs), &rings, self.place(0.0, 0.0, 0.98 * self.radius))
    }
}

/// Grows the tree: three corners to a triangle, counter-clockwise from outside.
pub(super) fn grow(detail: Detail) -> Vec<Corner> {
    let mut growth = Growth::default();
    let heights: &[f64] = detail.pick(&[0.0, 0.03, 0.25, 0.5, 0.75, 0.97], &[0.0, 0.03, 0.4, 0.97]);
    let knots: Vec<Knot> = heights
        .iter()
        .map(|z| {
            // The foot is level.
            let at = if *z < 0.1 { DVec3::Z * *z } else { trunk(*z) };
            Knot { at, radius: TRUNK_RADIUS * if *z == 0.0 { 1.4 } else { 1.0 - z } }
        })
        .collect();
    growth.add(&pointed_limb(&knots, detail.pick(7, 4)), Part::Bark);
    let mut random = Random::new(29);
    for clump in clumps() {
        if detail == Detail::Middle {
            growth.add(&clump.plain(), Part::Leaf);
            continue;
        }
        let bend = clump.root.lerp(clump.at, 0.55) + DVec3::Z * 0.02;
        let knots = [(clump.root, 0.006), (bend, 0.005), (clump.at, 0.0)].map(|(at, radius)| Knot { at, radius });
        growth.add(&pointed_limb(&knots, 3), Part::Bark);
        for part in clump.parts(&mut random) {
            growth.add(&part.fringed(&mut random), Part::Leaf);
        }
    }
    growth.finish(REACH)
}
