//! A dead tree: a slightly leaning trunk with a broken top, and bare branches that fork.

use glam::DVec3;

use super::patch::{Growth, Knot, broken_limb, level, pointed_limb};
use super::random::Random;
use super::{Corner, Detail, Part};

const BRANCHES: u32 = 9;
/// Length of the longest branches.
const REACH: f64 = 0.3;

/// Returns the centre line and the radius of the trunk at height `z`.
fn trunk(z: f64) -> Knot {
    let at = DVec3::new(0.05 * z * z + 0.018 * (z * 10.0).sin() * z, 0.024 * (z * 8.0).sin() * z, z);
    Knot { at, radius: 0.036 - 0.022 * z }
}

/// A branch with the ones that fork off it.
struct Branch {
    main: [Knot; 4],
    forks: Vec<[Knot; 3]>,
}

fn branches() -> Vec<Branch> {
    let mut random = Random::new(31);
    (0..BRANCHES)
        .map(|number| {
            let up = (f64::from(number) + 0.5) / f64::from(BRANCHES);
            let z = 0.3 + 0.6 * up;
            let turn = f64::from(number) * 2.399_963 + 1.0;
            let length = (0.32 - 0.17 * up) * random.between(0.6, 1.15);
            let foot = trunk(z);
            let thick = foot.radius * 0.44;
            let (out, rise) = (level(turn), random.between(0.2, 0.6));
            // The branch bends aside, and up toward its end.
            let aside = level(turn + 1.57) * random.between(-0.22, 0.22);
            let at = |along: f64| {
                let way = out * along + aside * (along * 5.0).sin() + DVec3::Z * (rise * along + 0.35 * along * along);
                foot.at + way * length
            };
            let knot = |along: f64, by: f64| Knot { at: at(along), radius: thick * by };
            let main = [knot(0.0, 1.2), knot(0.38, 0.8), knot(0.7, 0.5), knot(1.0, 0.0)];
            let forks = [(0.38, 0.55, 1.0), (0.7, 0.36, -1.0)]
                .map(|(from, by, side)| {
                    let way =
                        (level(turn + side * random.between(0.6, 1.0)) + DVec3::Z * random.between(0.1, 0.9)) * by;
                    let end = at(from) + way * length;
                    let bend = at(from).lerp(end, 0.5) + aside * 0.15 * length;
                    [(at(from), 0.5), (bend, 0.35), (end, 0.0)].map(|(at, by)| Knot { at, radius: thick * by })
                })
                .to_vec();
            Branch { main, forks }
        })
        .collect()
}

/// Grows the tree: three corners to a triangle, counter-clockwise from outside.
pub(super) fn grow(detail: Detail) -> Vec<Corner> {
    let mut random = Random::new(37);
    let mut growth = Growth::default();
    let heights: &[f64] =
        detail.pick(&[0.0, 0.03, 0.15, 0.3, 0.45, 0.6, 0.75, 0.86, 0.94], &[0.0, 0.03, 0.45, 0.75, 0.94]);
    let knots: Vec<Knot> = heights
        .iter()
        .map(|z| match *z {
            // The foot is level, and wider.
            0.0 => Knot { at: DVec3::ZERO, radius: 0.055 },
            z if z < 0.1 => Knot { at: DVec3::Z * z, radius: 0.038 },
            z => trunk(z),
        })
        .collect();
    let sides = detail.pick(9, 5);
    for patch in broken_limb(&knots, sides, |side| if side == 1 { 0.06 } else { 0.02 * random.between(-1.0, 1.2) }) {
        growth.add(&patch, Part::Bark);
    }
    for branch in branches() {
        let main = detail.pick(branch.main.to_vec(), vec![branch.main[0], branch.main[2], branch.main[3]]);
        growth.add(&pointed_limb(&main, detail.pick(5, 3)), Part::Bark);
        for fork in &branch.forks {
            let fork = detail.pick(fork.to_vec(), vec![fork[0], fork[2]]);
            growth.add(&pointed_limb(&fork, detail.pick(4, 3)), Part::Bark);
        }
    }
    growth.finish(REACH)
}
