//! The curvature of the earth: boxes and places on a curved earth; the CPU counterpart of `shaders/shared/earth.wgsl`.
//!
//! Why: `docs/decisions/earth-curvature.md`.

use glam::{DVec2, DVec3};

use crate::scene::frustum::Bounds;

/// The earth as a camera sees it: flat in the map, curved around the vertical through the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EarthCurvature {
    /// One over the effective radius, per metre; 0 is flat.
    pub inverse_radius: f64,
    /// Height of the camera in the world, in metres.
    pub camera_z_m: f64,
    /// Lowest height of the land in the world, in metres.
    pub lowest_m: f64,
}

/// The smallest radius, in metres, however low the camera is: otherwise near ground would look like a ball.
const SMALLEST_RADIUS_M: f64 = 60_000.0;

impl EarthCurvature {
    /// Returns this or a smaller globe, on which the horizon of the lowest land is `horizon_rad` below level for this
    /// camera: from high above, far land is then seen behind near land (a panorama after Berann).
    #[must_use]
    pub fn with_horizon(self, horizon_rad: f64) -> Self {
        let cos = horizon_rad.cos();
        // cos = (R + lowest) / (R + camera).
        let radius_m = (cos * self.camera_z_m - self.lowest_m) / (1.0 - cos);
        if radius_m.is_nan() {
            return self;
        }
        Self { inverse_radius: self.inverse_radius.max(1.0 / radius_m.max(SMALLEST_RADIUS_M)), ..self }
    }

    /// Returns the place on the curved earth of a place of the flat map, both camera-relative, in metres.
    pub fn bend(&self, flat_m: DVec3) -> DVec3 {
        let k = self.inverse_radius;
        if k == 0.0 {
            return flat_m;
        }
        let angle = flat_m.truncate().length() * k;
        let taller = 1.0 + (flat_m.z + self.camera_z_m) * k;
        (flat_m.truncate() * sinc(angle) * taller).extend(flat_m.z - taller * versine(angle) / k)
    }

    /// Inverts [`EarthCurvature::bend`]: returns the place on the flat map.
    pub fn unbend(&self, at_m: DVec3) -> DVec3 {
        let k = self.inverse_radius;
        if k == 0.0 {
            return at_m;
        }
        let camera = 1.0 + self.camera_z_m * k;
        let (across, up) = (at_m.truncate().length() * k, camera + at_m.z * k);
        let angle = across.atan2(up);
        let z_m = (across * across / k + 2.0 * camera * at_m.z + at_m.z * at_m.z * k) / (across.hypot(up) + camera);
        let flat = if across == 0.0 { at_m.truncate() / up } else { at_m.truncate() * (angle / across) };
        flat.extend(z_m)
    }

    /// Returns a box around the places on the curved earth of a flat box, both camera-relative, or `None` if the earth
    /// hides it.
    pub fn bend_bounds(&self, flat: &Bounds) -> Option<Bounds> {
        let k = self.inverse_radius;
        if k == 0.0 {
            return Some(*flat);
        }
        let (low, high) = (flat.low_m.truncate(), flat.high_m.truncate());
        let nearest = Arc::of_square(DVec2::ZERO.clamp(low, high).length_squared() * (k * k));
        let farthest = Arc::of_square(low.abs().max(high.abs()).length_squared() * (k * k));
        if self.is_beyond_horizon(&nearest, flat.high_m.z) {
            return None;
        }
        let (min_taller, max_taller) =
            (1.0 + (flat.low_m.z + self.camera_z_m) * k, 1.0 + (flat.high_m.z + self.camera_z_m) * k);
        let least = farthest.sinc * min_taller.min(max_taller).max(0.0);
        let most = nearest.sinc * max_taller;
        let shrink = |v: f64, is_low: bool| if (v > 0.0) == is_low { v * least } else { v * most };
        let bent = |v: DVec2, is_low: bool| DVec2::new(shrink(v.x, is_low), shrink(v.y, is_low));
        let radius_m = 1.0 / k;
        Some(Bounds {
            low_m: bent(low, true).extend(flat.low_m.z - max_taller * farthest.versine * radius_m),
            high_m: bent(high, false).extend(flat.high_m.z - min_taller.max(0.0) * nearest.versine * radius_m),
        })
    }

    /// Returns whether the earth hides everything within `radius_m` of a place of the flat map, camera-relative.
    pub fn hides_sphere(&self, flat_m: DVec3, radius_m: f64) -> bool {
        let nearest = (flat_m.truncate().length() - radius_m).max(0.0) * self.inverse_radius;
        self.inverse_radius > 0.0 && self.is_beyond_horizon(&Arc::of_square(nearest * nearest), flat_m.z + radius_m)
    }

    /// Returns whether the earth itself, at the lowest height of the land, hides everything from an arc on, up to the
    /// camera-relative height `high_m`.
    fn is_beyond_horizon(&self, arc: &Arc, high_m: f64) -> bool {
        let ground = 1.0 / self.inverse_radius + self.lowest_m;
        let cos_of_dip = |height_m: f64| (ground / (ground + height_m.max(0.0))).clamp(-1.0, 1.0);
        let of_camera = cos_of_dip(self.camera_z_m - self.lowest_m);
        // Nearly all land is nearer than the horizon of the lowest land, and needs no arccosine.
        if 1.0 - arc.versine >= of_camera {
            return false;
        }
        let of_top = cos_of_dip(self.camera_z_m + high_m - self.lowest_m);
        arc.angle_rad() > of_camera.acos() + of_top.acos() + 1e-6
    }
}

/// An angle at the centre of the earth, at most a half turn.
struct Arc {
    /// The square of the angle in radians.
    square: f64,
    /// The sine divided by the angle.
    sinc: f64,
    /// 1 − the cosine.
    versine: f64,
}

/// The square of the angle up to which [`Arc::of_square`] uses series, of which the next term is below the precision of
/// f64. The arc is 640 km on the earth.
const SHORT_SQUARE: f64 = 0.01;

impl Arc {
    #[inline]
    fn of_square(square: f64) -> Self {
        if square < SHORT_SQUARE {
            let x = square;
            let sinc = 1.0 - x / 6.0 * (1.0 - x / 20.0 * (1.0 - x / 42.0 * (1.0 - x / 72.0)));
            let versine = 0.5 * x * (1.0 - x / 12.0 * (1.0 - x / 30.0 * (1.0 - x / 56.0 * (1.0 - x / 90.0))));
            return Self { square, sinc, versine };
        }
        let angle = square.sqrt().min(std::f64::consts::PI);
        Self { square, sinc: sinc(angle), versine: versine(angle) }
    }

    fn angle_rad(&self) -> f64 {
        self.square.sqrt()
    }
}

fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

/// Returns 1 − cos(x), without cancellation.
fn versine(x: f64) -> f64 {
    2.0 * (0.5 * x).sin().powi(2)
}

#[cfg(test)]
mod tests {
    use super::*;

    const EARTH: EarthCurvature =
        EarthCurvature { inverse_radius: 1.0 / 6_371_008.8, camera_z_m: 1500.0, lowest_m: 0.0 };

    #[test]
    fn the_drop_at_100_km_is_785_m() {
        let earth = EarthCurvature { camera_z_m: 0.0, ..EARTH };
        let drop_m = earth.bend(DVec3::new(60_000.0, 80_000.0, 0.0)).z;
        assert!((drop_m + 784.8).abs() < 0.1, "{drop_m}");
    }

    #[test]
    fn the_earth_is_bent_to_reach_a_requested_horizon() {
        let dip_rad = |camera_z_m: f64, horizon_rad: f64| {
            let earth = EarthCurvature { camera_z_m, lowest_m: -400.0, ..EARTH }.with_horizon(horizon_rad);
            let radius_m = 1.0 / earth.inverse_radius;
            ((radius_m - 400.0) / (radius_m + camera_z_m)).acos()
        };
        assert!((dip_rad(9000.0, 0.3) - 0.3).abs() < 1e-9);
        // The earth's own horizon is lower than that.
        assert!(dip_rad(9000.0, 1e-3) > 0.05 && dip_rad(9000.0, 0.0) > 0.05);
        // A low camera does not see a ball.
        let low = EarthCurvature { camera_z_m: 100.0, ..EARTH }.with_horizon(0.5);
        assert!((1.0 / low.inverse_radius - SMALLEST_RADIUS_M).abs() < 1e-6);
    }

    #[test]
    fn series_and_functions_agree() {
        for i in 0..2000 {
            let angle = 1e-9 * 1.0105_f64.powi(i);
            let arc = Arc::of_square(angle * angle);
            let angle = angle.min(std::f64::consts::PI);
            assert!((arc.sinc - sinc(angle)).abs() < 1e-15, "{angle}");
            assert!((arc.versine / versine(angle) - 1.0).abs() < 1e-14, "{angle}");
        }
    }

    #[test]
    fn there_and_back() {
        for flat in [DVec3::new(1.0, -2.0, 3.0), DVec3::new(-3e5, 4e5, 2500.0), DVec3::new(5e6, 1e6, -1000.0), DVec3::Z]
        {
            let back = EARTH.unbend(EARTH.bend(flat));
            assert!((back - flat).length() < 1e-6 * flat.length().max(1.0), "{flat} {back}");
        }
    }

    #[test]
    fn boxes_hold_their_places_and_the_far_side_is_hidden() {
        let flat = Bounds { low_m: DVec3::new(-3e4, 1e5, -1400.0), high_m: DVec3::new(5e4, 2e5, 3000.0) };
        let bent = EARTH.bend_bounds(&flat).unwrap();
        for i in 0..343 {
            let t = DVec3::new(f64::from(i % 7), f64::from(i / 7 % 7), f64::from(i / 49)) / 6.0;
            let place = EARTH.bend(flat.low_m + (flat.high_m - flat.low_m) * t);
            assert!(place.cmpge(bent.low_m - 1e-6).all() && place.cmple(bent.high_m + 1e-6).all(), "{place} {bent:?}");
        }
        // From 1500 m, land of 0 to 1000 m height ends at 251 km (138 + 113).
        let slab =
            |y_m: f64| Bounds { low_m: DVec3::new(-1.0, y_m, -1500.0), high_m: DVec3::new(1.0, y_m + 1.0, -500.0) };
        assert!(EARTH.bend_bounds(&slab(250e3)).is_some());
        assert!(EARTH.bend_bounds(&slab(252.5e3)).is_none());
    }
}
