//! A clump of forest seen from far away: a mound with the tops of a few crowns on it.
//!
//! It is drawn widened, and many clumps overlap; what is visible is the outline of each against the next.

use std::f64::consts::TAU;

use glam::DVec3;

use super::patch::{Growth, Knot, Patch, level, pointed_limb, ring};
use super::random::Random;
use super::{Corner, Grown, Part};

/// Height of the lower edge; it is below the ground, because the ground is not level.
const SKIRT: f64 = -0.35;

/// Radius of the mound's shoulder, and its height relative to the mound's height.
const SHOULDER: (f64, f64) = (0.55, 0.6);

/// Returns the mound under the crowns.
fn mound(height: f64) -> Patch {
    let at = |out: f64, z: f64| ring(5, |turn, _| level(turn) * out + DVec3::Z * z);
    Patch::dome(&[at(1.0, SKIRT), at(SHOULDER.0, SHOULDER.1 * height)], DVec3::Z * height)
}

/// A crown on the mound.
struct Stand {
    /// Foot of the crown, on the mound.
    foot: DVec3,
    /// Height of its top.
    top: f64,
    radius: f64,
    spin: f64,
}

/// The arrangement of crowns on a mound.
struct CrownLayout {
    mound: f64,
    /// For the inner and the outer ring: the number of crowns, and their distance from the centre.
    rings: [(u32, f64); 2],
    /// Smallest and largest radius of a crown.
    radius: (f64, f64),
    /// Lowest and highest top of the outer crowns; the inner ones reach up to 1.
    top: (f64, f64),
}

impl CrownLayout {
    fn all(&self, random: &mut Random) -> Vec<Stand> {
        let mut layout: Vec<Stand> = Vec::new();
        for (of, (count, out)) in self.rings.into_iter().enumerate() {
            for number in 0..count {
                let turn = (f64::from(number) + random.between(-0.18, 0.18)) / f64::from(count) * TAU;
                let out = out * random.between(0.92, 1.05);
                let (foot, top) = match of {
                    0 => (self.mound * (1.0 - 0.4 * out) - 0.1, random.between(self.top.1, 0.97)),
                    // Crowns at the edge reach down to the ground.
                    _ => (-0.12, random.between(self.top.0, self.top.1)),
                };
                layout.push(Stand {
                    foot: level(turn) * out + DVec3::Z * foot,
                    top: if layout.is_empty() { 1.0 } else { top },
                    radius: random.between(self.radius.0, self.radius.1),
                    spin: random.unit() * TAU,
                });
            }
        }
        layout
    }
}

impl Stand {
    /// Returns a point by azimuth, by distance relative to the radius, and by height relative to the crown's.
    fn place(&self, turn: f64, out: f64, up: f64) -> DVec3 {
        self.foot + level(turn + self.spin) * out * self.radius + DVec3::Z * (self.top - self.foot.z) * up
    }

    /// Returns two tiers with ragged rims.
    fn spire(&self, random: &mut Random) -> [Patch; 2] {
        [(1.0, 0.0, 0.7), (0.66, 0.42, 1.0)].map(|(by, from, to)| {
            let rim = ring(5, |turn, _| {
                let out = random.between(0.75, 1.08) * by;
                self.place(turn + from, out, from + 0.16 * (1.0 - out / by))
            });
            Patch::dome(&[rim], self.place(0.0, 0.0, to))
        })
    }

    /// Returns a rounded crown.
    fn lobe(&self, sides: usize, random: &mut Random) -> Patch {
        let rings = [(1.0, 0.12, 0.0), (0.8, 0.78, 0.5)].map(|(by, up, twist)| {
            let twist = -twist * TAU / sides as f64;
            ring(sides, |turn, _| self.place(turn + twist, by * random.between(0.92, 1.06), up))
        });
        Patch::dome(&rings, self.place(0.0, 0.0, 1.0))
    }

    /// Returns a bare trunk with a branch.
    fn spike(&self, random: &mut Random) -> [Patch; 2] {
        let lean = level(random.unit() * TAU) * 0.04;
        let [foot, bend, tip] =
            [(0.0, 0.0), (0.5, 1.6), (1.0, 1.0)].map(|(up, by)| self.place(0.0, 0.0, up) + lean * by);
        let fork = bend.lerp(tip, random.between(0.0, 0.5));
        let end = fork + level(self.spin) * 0.13 + DVec3::Z * 0.12;
        let limb = |knots: &[(DVec3, f64)]| {
            let knots: Vec<Knot> = knots.iter().map(|&(at, radius)| Knot { at, radius }).collect();
            pointed_limb(&knots, 3)
        };
        [
            limb(&[(foot, self.radius), (bend, self.radius * 0.7), (tip, 0.0)]),
            limb(&[(fork, self.radius * 0.5), (end, 0.0)]),
        ]
    }
}

/// Builds a clump of forest: its footprint has radius 1, its top is at 1, and its skirt reaches 0.35 below the ground.
pub(crate) fn canopy(of: Grown) -> Vec<Corner> {
    let mut growth = Growth::default();
    let mut random = Random::new(41);
    let layout = match of {
        Grown::Conifer => {
            CrownLayout { mound: 0.28, rings: [(4, 0.36), (8, 0.74)], radius: (0.23, 0.29), top: (0.55, 0.8) }
        }
        Grown::Broadleaf => {
            CrownLayout { mound: 0.4, rings: [(3, 0.36), (5, 0.66)], radius: (0.27, 0.33), top: (0.45, 0.8) }
        }
        Grown::Birch => {
            CrownLayout { mound: 0.36, rings: [(3, 0.28), (6, 0.7)], radius: (0.25, 0.31), top: (0.55, 0.82) }
        }
        Grown::Snag => {
            CrownLayout { mound: 0.15, rings: [(3, 0.25), (6, 0.65)], radius: (0.03, 0.04), top: (0.55, 0.85) }
        }
    };
    growth.add(&mound(layout.mound), Part::Leaf);
    for stand in layout.all(&mut random) {
        match of {
            Grown::Conifer => stand.spire(&mut random).iter().for_each(|tier| growth.add(tier, Part::Leaf)),
            Grown::Broadleaf => growth.add(&stand.lobe(6, &mut random), Part::Leaf),
            Grown::Birch => growth.add(&stand.lobe(5, &mut random), Part::Leaf),
            Grown::Snag => stand.spike(&mut random).iter().for_each(|limb| growth.add(limb, Part::Bark)),
        }
    }
    growth.finish(1.0)
}
