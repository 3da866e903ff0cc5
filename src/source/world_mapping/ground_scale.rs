//! The scale of a projection against the ground: how many metres of a map are one metre on the ellipsoid.
//!
//! The scale of a projection depends on the place and, unless the projection is conformal, on the direction. Its two
//! principal values at a place are the semi-axes of Tissot's indicatrix (J. P. Snyder, "Map projections: a working
//! manual", USGS 1987, section 4).

use glam::{DMat2, DVec2};
use serde::Serialize;

/// Number of places along a side of the extent at which the scale is computed.
const PLACES_PER_SIDE: u32 = 9;

/// Half the length of the steps over which positions are differentiated, in radians of arc: about 30 m on the earth.
const STEP_RAD: f64 = 5e-6;

/// Scale factors over an extent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(crate) struct ScaleRange {
    /// Scale at the centre: the geometric mean of both principal directions.
    pub centre: f64,
    /// Smallest scale over the extent, in any direction.
    pub min: f64,
    /// Largest scale over the extent, in any direction.
    pub max: f64,
}

impl ScaleRange {
    /// Returns the largest departure from 1 over the extent.
    pub(crate) fn departure(&self) -> f64 {
        (self.max - 1.0).max(1.0 - self.min)
    }

    /// Returns the scales of a map over the rectangle of samples from (0, 0) to `last`. `place` returns longitude and
    /// latitude in radians at a (column, row); `plane_from` returns the position on the map in metres at a longitude and
    /// latitude in radians. Returns `None` if the centre or too many other places have no position.
    pub(super) fn over(
        last: DVec2,
        ellipsoid: [f64; 2],
        place: impl Fn(DVec2) -> DVec2,
        plane_from: impl Fn(DVec2) -> DVec2,
    ) -> Option<Self> {
        let scales = |grid: DVec2| principal_scales(ellipsoid, place(grid), &plane_from);
        let [small, large] = scales(0.5 * last)?;
        let mut range = Self { centre: (small * large).sqrt(), min: small, max: large };
        let mut found = 0;
        for (i, k) in (0..PLACES_PER_SIDE).flat_map(|k| (0..PLACES_PER_SIDE).map(move |i| (i, k))) {
            let part = DVec2::new(f64::from(i), f64::from(k)) / f64::from(PLACES_PER_SIDE - 1);
            if let Some([small, large]) = scales(part * last) {
                range = Self { centre: range.centre, min: range.min.min(small), max: range.max.max(large) };
                found += 1;
            }
        }
        // Corners of a grid may be beyond the poles, but a projection without most of the places is none for the grid.
        (found > PLACES_PER_SIDE * PLACES_PER_SIDE / 2).then_some(range)
    }
}

/// Returns the lengths on the ground of one radian of longitude and of latitude, in metres.
pub(super) fn metres_per_radian([axis_m, inverse_flattening]: [f64; 2], latitude_rad: f64) -> DVec2 {
    let flattening = if inverse_flattening == 0.0 { 0.0 } else { 1.0 / inverse_flattening };
    let squared_eccentricity = flattening * (2.0 - flattening);
    let below = 1.0 - squared_eccentricity * latitude_rad.sin().powi(2);
    let across_m = axis_m / below.sqrt();
    let along_m = axis_m * (1.0 - squared_eccentricity) / below.powf(1.5);
    DVec2::new(across_m * latitude_rad.cos(), along_m)
}

/// Returns the derivative of a map at a longitude and latitude: metres on the map per metre on the ground, east (first
/// column) and north. Returns `None` at the poles and where the map has no positions.
pub(super) fn map_from_ground(
    ellipsoid: [f64; 2],
    longitude_latitude_rad: DVec2,
    plane_from: impl Fn(DVec2) -> DVec2,
) -> Option<DMat2> {
    let metres = metres_per_radian(ellipsoid, longitude_latitude_rad.y);
    // Near a pole a step in longitude is short on the ground, so that it is made longer, up to a thousandth of a turn.
    let steps_rad = DVec2::new((STEP_RAD * metres.y / metres.x.max(1e-9)).min(6e-3), STEP_RAD);
    let slope = |way: DVec2| {
        let step = way * steps_rad;
        (plane_from(longitude_latitude_rad + step) - plane_from(longitude_latitude_rad - step))
            / (2.0 * (step * metres).length())
    };
    let derivative = DMat2::from_cols(slope(DVec2::X), slope(DVec2::Y));
    (metres.x > 1.0 && derivative.is_finite()).then_some(derivative)
}

/// Returns the smallest and the largest scale at a place.
fn principal_scales(
    ellipsoid: [f64; 2],
    longitude_latitude_rad: DVec2,
    plane_from: impl Fn(DVec2) -> DVec2,
) -> Option<[f64; 2]> {
    let derivative = map_from_ground(ellipsoid, longitude_latitude_rad, plane_from)?;
    // Singular values of a 2 × 2 matrix, from the sums and differences of its similarity and its mirrored part.
    let [a, c, b, d] = derivative.to_cols_array();
    let (similar, mirrored) = (f64::hypot(a + d, c - b), f64::hypot(a - d, c + b));
    let (small, large) = (0.5 * (similar - mirrored).abs(), 0.5 * (similar + mirrored));
    (small > 0.0 && large.is_finite()).then_some([small, large])
}
