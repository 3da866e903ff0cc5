//! A conifer of few triangles: a trunk, and a crown of whorls whose rims are jagged.

use std::f64::consts::TAU;

use glam::DVec3;

/// A corner of a triangle of a tree that is 1 tall and stands at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Where it is.
    pub at: DVec3,
    /// Of the surface there; of length 1.
    pub normal: DVec3,
}

const TRUNK_RADIUS: f64 = 0.015;
const TRUNK_TOP: f64 = 0.25;
const CROWN_BOTTOM: f64 = 0.1;
const CROWN_RADIUS: f64 = 0.17;
const WHORLS: u32 = 5;
/// How far a whorl reaches into the one above it, by its own height.
const OVERLAP: f64 = 0.55;
/// Along a rim, outer and inner corners in turns.
const RIM: u32 = 12;
const INNER: f64 = 0.68;
/// How far branches hang, by the whorl's height.
const DROOP: f64 = 0.18;

/// Three corners to a triangle, counterclockwise from outside.
pub fn grow() -> Vec<Corner> {
    let mut corners = Vec::new();
    let around = |turn: f64, radius: f64, z: f64| DVec3::new(radius * turn.cos(), radius * turn.sin(), z);
    let mut triangle = |places: [DVec3; 3], normals: [DVec3; 3]| {
        corners.extend((0..3).map(|i| Corner { at: places[i], normal: normals[i].normalize() }));
    };
    for side in 0..5 {
        let [a, b] = [side, side + 1].map(|side| f64::from(side) / 5.0 * TAU);
        let [low_a, low_b] = [a, b].map(|turn| around(turn, TRUNK_RADIUS, 0.0));
        let [high_a, high_b] = [a, b].map(|turn| around(turn, TRUNK_RADIUS, TRUNK_TOP));
        let [out_a, out_b] = [a, b].map(|turn| around(turn, 1.0, 0.0));
        triangle([low_a, low_b, high_b], [out_a, out_b, out_b]);
        triangle([low_a, high_b, high_a], [out_a, out_b, out_a]);
    }
    let height = (1.0 - CROWN_BOTTOM) / f64::from(WHORLS);
    for whorl in 0..WHORLS {
        let bottom = CROWN_BOTTOM + height * f64::from(whorl);
        let top = (bottom + height * (1.0 + OVERLAP)).min(1.0);
        let radius = CROWN_RADIUS * (1.0 - f64::from(whorl) / f64::from(WHORLS)).powf(0.8);
        let apex = DVec3::Z * top;
        let middle = DVec3::Z * (bottom + 0.3 * height);
        let rim = |i: u32| {
            let is_outer = i.is_multiple_of(2);
            // Each whorl is turned against the one below it.
            let turn = (f64::from(i % RIM) / f64::from(RIM) + 0.37 * f64::from(whorl)) * TAU;
            let (by, hangs) = if is_outer { (1.0, DROOP) } else { (INNER, 0.0) };
            (around(turn, radius * by, bottom - hangs * height), around(turn, 1.0, 0.55))
        };
        for i in 0..RIM {
            let ((a, out_a), (b, out_b)) = (rim(i), rim(i + 1));
            triangle([a, b, apex], [out_a, out_b, out_a + out_b]);
            triangle([b, a, middle], [-DVec3::Z + out_b * 0.3, -DVec3::Z + out_a * 0.3, -DVec3::Z]);
        }
    }
    corners
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_conifer_is_one_tall_and_looks_outward() {
        let corners = grow();
        assert!(corners.len().is_multiple_of(3) && corners.len() < 600, "{}", corners.len());
        let (low, high) = corners.iter().fold((f64::MAX, f64::MIN), |(low, high), corner| {
            assert!(
                (corner.normal.length() - 1.0).abs() < 1e-9 && corner.at.truncate().length() <= CROWN_RADIUS + 1e-9
            );
            (low.min(corner.at.z), high.max(corner.at.z))
        });
        assert!(low == 0.0 && (high - 1.0).abs() < 1e-9, "{low} {high}");
        for triangle in corners.chunks_exact(3) {
            let face = (triangle[1].at - triangle[0].at).cross(triangle[2].at - triangle[0].at);
            // Planted by hand once: a triangle the other way round.
            assert!(triangle.iter().all(|corner| corner.normal.dot(face) > 0.0), "{triangle:?}");
        }
    }
}
