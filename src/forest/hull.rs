//! Convex hulls of the trees in the frames of impostors. Hulls are drawn instead of whole frames, so that no fragment
//! shader runs for the empty corners of a frame.
//!
//! A hull has [`SIDES`] sides. It begins as the convex hull of all points whose interpolated coverage is at least half;
//! then the side whose removal adds the least area is removed, until [`SIDES`] are left. A vertex of the polygon that
//! is drawn is the intersection of two sides, which the shader moves out as far as the eye's direction differs from the
//! frame's (`shaders/surface/trees/impostor.wgsl`): so sides are stored, and not vertices.

use glam::DVec2;

use super::impostor::{FRAMES, Level};
use crate::gpu::wgsl::surface::trees::impostor::{SIDES, TreeHull};

/// Margin around the places with coverage, in texels: GPUs interpolate between texels with 8 bits.
const MARGIN_TEXELS: f64 = 1.0 / 32.0;
/// Margin of the depths, in radii of the bounding sphere: they are stored with 11 bits.
const MARGIN_DEPTH: f64 = 0.004;

/// Least sine of the angle between neighbouring sides.
const LEAST_TURN: f64 = 0.004;

/// Returns the hulls of all frames of a level, row by row.
pub(crate) fn hulls(level: &Level) -> Vec<TreeHull> {
    use rayon::prelude::*;
    (0..FRAMES * FRAMES).into_par_iter().map(|frame| of_frame(level, [frame % FRAMES, frame / FRAMES])).collect()
}

/// Returns the hull of a frame. A frame in which nothing is seen has a hull whose nearest depth is below its farthest.
fn of_frame(level: &Level, frame: [u32; 2]) -> TreeHull {
    let Seen { corners, depths: [far, near] } = seen(level, frame);
    let mut hull = TreeHull { sides: [[0.0; 4]; SIDES as usize], near: -1.0, far: 1.0, padding: [0.0; 2] };
    if corners.is_empty() {
        return hull;
    }
    let margin = 2.0 * MARGIN_TEXELS / f64::from(level.frame_px);
    let sides = simplified(sides_of(&convex(corners)));
    for (side, own) in sides.iter().zip(&mut hull.sides) {
        *own = [side.normal.x, side.normal.y, side.reach + margin, 0.0].map(|value| value as f32);
    }
    (hull.near, hull.far) = ((near + MARGIN_DEPTH) as f32, (far - MARGIN_DEPTH) as f32);
    hull
}

/// The part of a frame in which something is seen.
struct Seen {
    /// Points whose convex hull contains it: right and up, −1 to 1.
    corners: Vec<DVec2>,
    /// Least and greatest depth toward the eye.
    depths: [f64; 2],
}

/// Finds where the coverage, interpolated between the centres of texels, is at least half.
fn seen(level: &Level, frame: [u32; 2]) -> Seen {
    let px = level.frame_px as usize;
    let side = FRAMES as usize * px;
    let [left, top] = frame.map(|at| at as usize * px);
    let texel = |x: usize, y: usize| level.outlines[(top + y) * side + left + x].map(f64::from);
    // Beyond the outermost centres a frame continues unchanged. So there is a centre on its border.
    let clamped = |at: usize| at.saturating_sub(1).min(px - 1);
    let along = |at: usize| (at as f64 - 0.5).clamp(0.0, px as f64);
    let mut seen = Seen { corners: Vec::new(), depths: [f64::INFINITY, f64::NEG_INFINITY] };
    for y in 0..=px {
        // The visible part between two rows of centres.
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for x in 0..=px {
            let four =
                [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[dx, dy]| (texel(clamped(x + dx), clamped(y + dy)), [dx, dy]));
            if four.iter().all(|([_, covered], _)| *covered < 0.5) {
                continue;
            }
            for ([depth, covered], _) in four.iter().filter(|([_, covered], _)| *covered > 0.0) {
                seen.depths = [seen.depths[0].min(depth / covered), seen.depths[1].max(depth / covered)];
            }
            let place = |[dx, dy]: [f64; 2]| {
                let between = |at: usize, part: f64| along(at) + part * (along(at + 1) - along(at));
                DVec2::new(between(x, dx), between(y, dy))
            };
            // Along a side of this cell coverage is linear. Within the cell it is half nowhere farther to any side than
            // on its sides, because the line along which it is half is a hyperbola with asymptotes along the sides.
            for (a, b) in [(0, 1), (2, 3), (0, 2), (1, 3)] {
                let (([_, of_a], at_a), ([_, of_b], at_b)) = (four[a], four[b]);
                let at = |part: f64| {
                    let mix = |i: usize| at_a[i] as f64 + part * (at_b[i] as f64 - at_a[i] as f64);
                    place([mix(0), mix(1)])
                };
                let mut hold = |part: f64| (low, high) = (low.min(at(part)), high.max(at(part)));
                if of_a >= 0.5 {
                    hold(0.0);
                }
                if of_b >= 0.5 {
                    hold(1.0);
                }
                if (of_a >= 0.5) != (of_b >= 0.5) {
                    hold((of_a - 0.5) / (of_a - of_b));
                }
            }
        }
        if low.x <= high.x {
            let to_radii = |at: DVec2| DVec2::new(at.x, px as f64 - at.y) * (2.0 / px as f64) - 1.0;
            seen.corners.extend([low, DVec2::new(high.x, low.y), high, DVec2::new(low.x, high.y)].map(to_radii));
        }
    }
    seen
}

/// Returns the convex hull of points, counterclockwise (Andrew 1979, monotone chain).
fn convex(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let chain = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && (b - a).perp_dot(point - b) <= 1e-12
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut hull = chain(&mut points.iter().copied());
    hull.extend(chain(&mut points.iter().rev().copied()));
    hull
}

/// A side of a convex polygon: the points whose product with the outward unit normal is at most `reach` are within.
#[derive(Clone, Copy, Debug)]
struct Side {
    normal: DVec2,
    reach: f64,
}

impl Side {
    /// Returns where two sides meet.
    fn meets(self, other: Self) -> DVec2 {
        let across = self.normal.perp_dot(other.normal);
        DVec2::new(
            self.reach * other.normal.y - other.reach * self.normal.y,
            other.reach * self.normal.x - self.reach * other.normal.x,
        ) / across
    }
}

fn sides_of(hull: &[DVec2]) -> Vec<Side> {
    let next = hull.iter().cycle().skip(1);
    hull.iter()
        .zip(next)
        .map(|(a, b)| {
            let normal = DVec2::new(b.y - a.y, a.x - b.x).normalize();
            Side { normal, reach: normal.dot(*a) }
        })
        .collect()
}

/// Returns [`SIDES`] sides around the same polygon.
fn simplified(mut sides: Vec<Side>) -> Vec<Side> {
    // Sides that are nearly parallel would meet anywhere.
    let is_parallel = |sides: &[Side]| {
        let count = sides.len();
        (0..count).any(|number| sides[number].normal.perp_dot(sides[(number + 1) % count].normal).abs() < LEAST_TURN)
    };
    while sides.len() > SIDES as usize || sides.len() > 4 && is_parallel(&sides) {
        let count = sides.len();
        // The area that is added if a side goes and its neighbours meet.
        let added = |number: usize| {
            let [before, own, after] = [count - 1, 0, 1].map(|step| sides[(number + step) % count]);
            if before.normal.perp_dot(after.normal) < 1e-3 {
                return f64::INFINITY;
            }
            let (a, b, apex) = (before.meets(own), own.meets(after), before.meets(after));
            0.5 * (apex - b).perp_dot(a - b).abs()
        };
        let least = (0..count).min_by(|a, b| added(*a).total_cmp(&added(*b))).unwrap_or(0);
        sides.remove(least);
    }
    // A side more at the widest corner has no length, and changes nothing.
    while sides.len() < SIDES as usize {
        let count = sides.len();
        let turn = |number: &usize| sides[*number].normal.dot(sides[(*number + 1) % count].normal);
        let sharpest = (0..count).min_by(|a, b| turn(a).total_cmp(&turn(b))).unwrap_or(0);
        let (own, after) = (sides[sharpest], sides[(sharpest + 1) % count]);
        let normal = (own.normal + after.normal).normalize();
        sides.insert(sharpest + 1, Side { normal, reach: normal.dot(own.meets(after)) });
    }
    sides
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;
    use crate::forest::impostor::{Impostor, ImpostorCorner};
    use crate::forest::species::{Detail, Grown};

    fn pictured(grown: Grown, frame_px: u32) -> Impostor {
        let corners: Vec<ImpostorCorner> = grown
            .grow(Detail::Near)
            .iter()
            .map(|corner| ImpostorCorner { at: corner.at, normal: corner.normal, lightness: 0.5, color_index: 0 })
            .collect();
        Impostor::draw(&corners, frame_px)
    }

    /// Reads coverage and depth as the shader does.
    fn look(level: &Level, frame: [u32; 2], p: DVec2) -> [f64; 2] {
        let px = f64::from(level.frame_px);
        let at = ((DVec2::new(p.x, -p.y) * 0.5 + 0.5) * px - 0.5).clamp(DVec2::ZERO, DVec2::splat(px - 1.0));
        let (whole, part) = (at.floor(), at.fract());
        let side = (FRAMES * level.frame_px) as usize;
        let texel = |dx: f64, dy: f64| {
            let [x, y] = [(whole.x + dx).min(px - 1.0), (whole.y + dy).min(px - 1.0)].map(|along| along as usize);
            let [left, top] = frame.map(|at| (at * level.frame_px) as usize);
            let [depth, covered] = level.outlines[(top + y) * side + left + x].map(f64::from);
            DVec2::new(depth, covered)
        };
        let row = |dy: f64| texel(0.0, dy).lerp(texel(1.0, dy), part.x);
        let [depth, covered] = row(0.0).lerp(row(1.0), part.y).to_array();
        [depth / covered.max(1e-3), covered]
    }

    /// Returns how many of the places with a tree are outside of the hulls, and the mean areas of the trees and of the
    /// hulls as shares of a frame.
    fn compared(impostor: &Impostor, shrunk: f32) -> (u32, f64, f64) {
        let (mut outside, mut tree, mut within, mut all) = (0, 0_u32, 0_u32, 0_u32);
        for level in &impostor.levels {
            let hulls = hulls(level);
            for number in (0..hulls.len()).step_by(37) {
                let frame = [number as u32 % FRAMES, number as u32 / FRAMES];
                let hull = hulls[number];
                let normals = hull.sides.map(|side| DVec2::new(side[0].into(), side[1].into()));
                assert!((0..8).all(|i| normals[i].perp_dot(normals[(i + 1) % 8]) > 1e-4), "{normals:?}");
                for i in 0..100 * 100 {
                    let p = (DVec2::new(f64::from(i % 100), f64::from(i / 100)) + 0.37) / 50.0 - 1.0;
                    let [depth, covered] = look(level, frame, p);
                    let is_within = normals
                        .iter()
                        .zip(hull.sides)
                        .all(|(normal, side)| normal.dot(p) <= f64::from(side[2] - shrunk));
                    let is_tree = covered >= 0.5;
                    let is_deep = (f64::from(hull.far)..=f64::from(hull.near)).contains(&depth);
                    outside += u32::from(is_tree && !(is_within && is_deep));
                    (tree, within, all) = (tree + u32::from(is_tree), within + u32::from(is_within), all + 1);
                }
            }
        }
        (outside, f64::from(tree) / f64::from(all), f64::from(within) / f64::from(all))
    }

    #[test]
    fn hulls_hold_their_trees_and_little_else() {
        for grown in [Grown::Conifer, Grown::Broadleaf, Grown::Snag] {
            let impostor = pictured(grown, 32);
            let (outside, tree, within) = compared(&impostor, 0.0);
            assert_eq!(outside, 0, "{grown:?}");
            assert!(within < 0.6, "{grown:?}: hulls cover {within}, trees {tree} of a frame");
            // Planted error: a texel less on each side.
            assert!(compared(&impostor, 2.0 / 32.0).0 > 100);
        }
    }

    #[test]
    fn a_hull_of_many_sides_is_simplified_outward() {
        let circle: Vec<DVec2> =
            (0..60).map(|i| DVec2::from_angle(f64::from(i) / 60.0 * std::f64::consts::TAU)).collect();
        let sides = simplified(sides_of(&convex(circle.clone())));
        assert_eq!(sides.len(), 8);
        let is_within =
            |sides: &[Side]| circle.iter().all(|p| sides.iter().all(|s| s.normal.dot(*p) <= s.reach + 1e-9));
        assert!(is_within(&sides));
        let area = (0..8).map(|i| {
            let [a, b] = [sides[i].meets(sides[(i + 1) % 8]), sides[(i + 1) % 8].meets(sides[(i + 2) % 8])];
            0.5 * a.perp_dot(b)
        });
        let area = area.sum::<f64>();
        assert!(area > 3.1 && area < 3.45, "{area}");
        // A triangle gets sides without length.
        let triangle = [DVec2::new(-1.0, -1.0), DVec2::new(1.0, -1.0), DVec2::new(0.0, 1.0)];
        let sides = simplified(sides_of(&triangle));
        assert!(sides.len() == 8 && triangle.iter().all(|p| sides.iter().all(|s| s.normal.dot(*p) <= s.reach + 1e-9)));
        // Planted error: a side that cuts.
        let cut: Vec<Side> = sides.iter().map(|side| Side { reach: side.reach - 0.01, ..*side }).collect();
        assert!(!is_within(&cut));
    }
}
