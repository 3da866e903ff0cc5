//! The similarity of two meshes' silhouettes: the pixels that both cover, divided by the pixels that at least one
//! covers (intersection over union).
//!
//! The image has 64 × 64 pixels, without perspective, and is as large as the first mesh: the scale of a tree on a
//! distant slope. A pixel is covered if a triangle covers its centre, from either side.

use glam::{DVec2, DVec3};

use super::Mesh;

/// Number of pixels along a side.
pub(crate) const SIDE_PX: usize = 64;

/// The covered pixels, a bit for each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Silhouette([u64; SIDE_PX]);

/// Returns directions that are evenly distributed on the sphere (a golden-angle spiral), rotated by `turned` radians
/// about the axis.
pub(crate) fn views(count: usize, turned: f64) -> impl Iterator<Item = DVec3> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    (0..count).map(move |i| {
        let z = 1.0 - (2 * i + 1) as f64 / count as f64;
        let (sin, cos) = (golden * i as f64 + turned).sin_cos();
        DVec3::new(cos, sin, 0.0) * (1.0 - z * z).max(0.0).sqrt() + DVec3::Z * z
    })
}

impl Silhouette {
    /// Rasterises a mesh seen along `forward`, in an image of the ball `ball_m` (centre and radius).
    pub(crate) fn of(mesh: &Mesh, forward: DVec3, ball_m: (DVec3, f64)) -> Self {
        let (middle_m, radius_m) = ball_m;
        let (right, up) = forward.any_orthonormal_pair();
        let half_px = SIDE_PX as f64 / 2.0;
        let seen: Vec<DVec2> = mesh
            .vertices_m
            .iter()
            .map(|&at_m| {
                let from_m = mesh.middle_m + super::place(at_m) - middle_m;
                (DVec2::new(from_m.dot(right), from_m.dot(up)) / radius_m + 1.0) * half_px
            })
            .collect();
        let mut rows = [0; SIDE_PX];
        for triangle in &mesh.triangles {
            cover(&mut rows, triangle.corners.map(|corner| seen[corner as usize]));
        }
        Self(rows)
    }

    /// Returns the intersection over union; 1 for two that cover nothing.
    pub(crate) fn overlap(&self, other: &Self) -> f64 {
        let count = |of: fn(u64, u64) -> u64| -> u32 {
            self.0.iter().zip(&other.0).map(|(&a, &b)| of(a, b).count_ones()).sum()
        };
        let (both, either) = (count(|a, b| a & b), count(|a, b| a | b));
        if either == 0 { 1.0 } else { f64::from(both) / f64::from(either) }
    }
}

/// Returns the mean overlap of a mesh with a simplified one, over several views.
pub(crate) fn overlap(mesh: &Mesh, other: &Mesh, views: impl Iterator<Item = DVec3>) -> f64 {
    let ball_m = (mesh.middle_m, mesh.radius_m.max(f64::MIN_POSITIVE));
    let (mut sum, mut count) = (0.0, 0);
    for forward in views {
        sum += Silhouette::of(mesh, forward, ball_m).overlap(&Silhouette::of(other, forward, ball_m));
        count += 1;
    }
    sum / f64::from(count.max(1))
}

/// Sets the bits that a triangle covers.
pub(crate) fn cover(rows: &mut [u64; SIDE_PX], [a, b, c]: [DVec2; 3]) {
    let first = |low: f64| (low - 0.5).ceil().max(0.0) as usize;
    let end = |high: f64| ((high - 0.5).floor() + 1.0).clamp(0.0, SIDE_PX as f64) as usize;
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    for (y, row) in rows.iter_mut().enumerate().take(end(high.y)).skip(first(low.y)) {
        // The line through the pixels' centres crosses the sides there.
        let y = y as f64 + 0.5;
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            if (from.y <= y) == (to.y <= y) {
                continue;
            }
            let x = from.x + (to.x - from.x) * (y - from.y) / (to.y - from.y);
            (left, right) = (left.min(x), right.max(x));
        }
        if left > right {
            continue;
        }
        let (from, to) = (first(left), end(right));
        if from < to {
            *row |= (u64::MAX >> (SIDE_PX - (to - from))) << from;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::obj;

    #[test]
    fn a_square_covers_what_it_should() {
        // Seen from above, the square is half as wide as the image.
        let square = obj::parse("a".to_owned(), b"v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n").unwrap();
        let bits = |silhouette: &Silhouette| silhouette.0.iter().map(|row| row.count_ones()).sum::<u32>();
        let seen = Silhouette::of(&square, DVec3::Z, (DVec3::ZERO, 2.0));
        assert_eq!(bits(&seen), 32 * 32);
        // From the side it is a line; outside the image nothing is covered.
        assert_eq!(bits(&Silhouette::of(&square, DVec3::X, (DVec3::new(0.0, 0.0, 0.01), 2.0))), 0);
        assert_eq!(bits(&Silhouette::of(&square, DVec3::Z, (DVec3::splat(9.0), 2.0))), 0);
        let small = obj::parse("a".to_owned(), b"v -1 -1 0\nv 1 -1 0\nv 1 0 0\nv -1 0 0\nf 1 2 3 4\n").unwrap();
        let small = Silhouette::of(&small, DVec3::Z, (DVec3::ZERO, 2.0));
        assert!((seen.overlap(&small) - 0.5).abs() < 1e-9 && seen.overlap(&seen) == 1.0);
        let sum: DVec3 = views(20, 0.3).sum();
        assert!(sum.length() < 0.5 && views(20, 0.0).all(|view| view.is_normalized()), "{sum}");
    }
}
