//! A smooth hill that is known exactly: its height is a formula, and rays are intersected by sphere tracing in f64.

use glam::{DVec2, DVec3};
use hachure::source::HeightGrid;

use super::grid_of;

/// Gaussians: (east m, north m, height m, width σ m).
const BUMPS: [(f64, f64, f64, f64); 3] =
    [(0.0, 0.0, 200.0, 420.0), (520.0, -380.0, 90.0, 260.0), (-600.0, 250.0, 60.0, 300.0)];

/// Bound on the slope: the sum of the steepest slopes of the Gaussians, each height / (σ √e).
const STEEPEST: f64 = 0.2889 + 0.2100 + 0.1214;

/// Bound on the second derivative: the sum of height / σ².
const MAX_BEND_PER_M: f64 = 0.001_134 + 0.001_332 + 0.000_667;

/// The hill with its position in the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hill {
    pub middle_m: DVec2,
}

impl Hill {
    /// Returns the height above the plain, in metres.
    pub(crate) fn height_m(&self, x_m: f64, y_m: f64) -> f64 {
        let at = DVec2::new(x_m, y_m) - self.middle_m;
        BUMPS
            .iter()
            .map(|&(x, y, height, width)| {
                height * (-(at - DVec2::new(x, y)).length_squared() / (2.0 * width * width)).exp()
            })
            .sum()
    }

    fn slope(&self, x_m: f64, y_m: f64) -> DVec2 {
        let at = DVec2::new(x_m, y_m) - self.middle_m;
        let mut slope = DVec2::ZERO;
        for (x, y, height, width) in BUMPS {
            let from = at - DVec2::new(x, y);
            slope -= from / (width * width) * height * (-from.length_squared() / (2.0 * width * width)).exp();
        }
        slope
    }

    /// Returns the hill on a square grid centred at the origin.
    pub(crate) fn square(samples: u32, spacing_m: f64) -> (Self, HeightGrid) {
        let hill = Self { middle_m: DVec2::ZERO };
        (hill, grid_of(samples, samples, spacing_m, |x, y| hill.height_m(x, y)))
    }

    /// Returns the hill near the western end of a strip of land, `away_m` from the origin.
    pub(crate) fn far(away_m: f64, spacing_m: f64) -> (Self, HeightGrid) {
        let hill = Self { middle_m: DVec2::new(-away_m, 0.0) };
        let width = (2.0 * (away_m + 1600.0) / spacing_m) as u32 + 1;
        let height = (3200.0 / spacing_m) as u32 + 1;
        (hill, grid_of(width, height, spacing_m, |x, y| hill.height_m(x, y)))
    }

    /// Returns the distance, in units of `ray`, at which the ray hits the hill or the plain, or `None` if it does not
    /// within `half_m` (east, north) of the origin. No step passes through the surface: each is the largest that the
    /// bounds on slope and second derivative allow.
    pub(crate) fn hit(&self, from_m: DVec3, ray: DVec3, half_m: DVec2) -> Option<f64> {
        let across = ray.truncate().length();
        let closing = STEEPEST * across + (-ray.z).max(0.0);
        let rising = ray.z.max(0.0) - STEEPEST * across;
        let least = 1e-9;
        let mut t = 0.0;
        for _ in 0..20_000 {
            let at = from_m + ray * t;
            let clear_m = at.z - self.height_m(at.x, at.y);
            if clear_m <= least * (1.0 + t) {
                return (at.truncate().abs().cmple(half_m).all()).then_some(t);
            }
            if rising > 0.0 || at.z > 360.0 && ray.z >= 0.0 {
                return None;
            }
            // Outside the land, moving away from it.
            if (at.x.abs() > half_m.x && at.x * ray.x > 0.0) || (at.y.abs() > half_m.y && at.y * ray.y > 0.0) {
                return None;
            }
            // clear + opening t − bend t² / 2 is below the true clearance, and so is clear − closing t.
            let opening = ray.z - self.slope(at.x, at.y).dot(ray.truncate());
            let bend = MAX_BEND_PER_M * across * across;
            let root = (opening * opening + 2.0 * bend * clear_m).sqrt();
            let curved = if opening > 0.0 { (opening + root) / bend } else { 2.0 * clear_m / (root - opening) };
            t += curved.max(clear_m / closing).max(1e-7 * (1.0 + t));
        }
        None
    }
}
