//! Distances between samples.

/// How far apart the samples of a DEM are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Spacing {
    /// A plane, or a cylinder if the columns wrap: distances of samples along rows and along columns, in metres.
    Metres([f64; 2]),
    /// Longitude and latitude on an ellipsoid.
    ///
    /// Of two samples, the nearer one is the one that is nearer in a straight line through the ellipsoid. On the Earth
    /// and up to 1000 km, that is the nearer one on the surface as well, unless the distances differ by less than 0.002
    /// %.
    ///
    /// The distance on the surface is that of the arc over the straight line whose radius is the ellipsoid's radius of
    /// curvature in the direction of the line at its middle latitude (Euler's formula). On a sphere it is exact. On the
    /// Earth its relative error, compared with Vincenty's formula at random places, is less than 10⁻⁷ up to 1000 km,
    /// less than 0.0003 % up to 3000 km, and less than 0.04 % up to 10 000 km; near the antipode it is 5 %.
    Degrees {
        /// Latitude of the first row.
        north: f64,
        /// Degrees of longitude from one column to the next, and of latitude from one row to the next one to the south.
        step: [f64; 2],
        /// Equatorial and polar radius in metres. They differ by less than 10 %, as those of all planets do.
        radii_m: [f64; 2],
    },
}

/// Equatorial and polar radius of WGS 84 in metres.
#[cfg(test)]
pub(crate) const WGS_84_RADII_M: [f64; 2] = [6_378_137.0, 6_356_752.314_245];
/// Latitudes beyond the poles by less than this are rounding errors, in degrees.
const POLE_TOLERANCE: f64 = 1e-6;
/// What bounds are multiplied by, so that rounding errors of sines cannot make them exceed what they bound.
const ROUNDING: f64 = 1.0 - 1e-12;

/// Compares the distances of samples on a DEM. Columns and rows may be outside of the DEM.
///
/// All distances are compared by *nearness*: `across + scale · spread`, where `across` and `scale` depend on the two
/// rows and `spread` on the difference of the columns. In metres it is the square of the distance. On an ellipsoid it
/// is the square of the length of the straight line, (ρ₁ − ρ₂)² + (z₁ − z₂)² + 4 ρ₁ ρ₂ sin²(Δλ/2), where ρ is the
/// distance from the axis and z that from the plane of the equator.
#[derive(Clone, Copy, Debug)]
pub(super) struct Metric {
    spacing: Spacing,
    /// Number of columns after which a place is reached again.
    period: Option<f64>,
}

/// A row, seen from a sample.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowTerms {
    pub across: f64,
    pub scale: f64,
}

/// A sample from which distances are measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin {
    metric: Metric,
    pub column: i64,
    pub row: i64,
    /// Distance from the axis and from the plane of the equator, in metres.
    meridian_m: [f64; 2],
}

impl Metric {
    pub(super) fn new(spacing: Spacing, columns: usize, wraps: bool) -> Self {
        let period = match spacing {
            Spacing::Metres(_) => wraps.then_some(columns as f64),
            Spacing::Degrees { step, .. } => Some((360.0 / step[0]).abs()),
        };
        Self { spacing, period }
    }

    /// Returns whether a row is on the ellipsoid.
    pub(super) fn has_row(&self, row: i64) -> bool {
        match self.spacing {
            Spacing::Metres(_) => true,
            Spacing::Degrees { north, step, .. } => (north - row as f64 * step[1]).abs() <= 90.0 + POLE_TOLERANCE,
        }
    }

    /// Returns the sample of a column and a row as an origin.
    pub(super) fn origin(self, column: i64, row: i64) -> Origin {
        Origin { metric: self, column, row, meridian_m: self.meridian_m(row) }
    }

    fn latitude(&self, row: f64) -> f64 {
        match self.spacing {
            Spacing::Metres(_) => 0.0,
            Spacing::Degrees { north, step, .. } => (north - row * step[1]).clamp(-90.0, 90.0).to_radians(),
        }
    }

    /// Returns the distance of a row from the axis and from the plane of the equator.
    fn meridian_m(&self, row: i64) -> [f64; 2] {
        match self.spacing {
            Spacing::Metres(_) => [0.0; 2],
            Spacing::Degrees { radii_m: [equator_m, pole_m], .. } => {
                let (sine, cosine) = self.latitude(row as f64).sin_cos();
                // The radius of curvature across the meridian is a² / √(a² cos² φ + b² sin² φ).
                let scale = 1.0 / (equator_m * cosine).hypot(pole_m * sine);
                [equator_m * equator_m * scale * cosine.max(0.0), pole_m * pole_m * scale * sine]
            }
        }
    }
}

impl Origin {
    /// Returns the difference of a column from that of the origin, the shorter way around.
    pub(super) fn columns_to(&self, column: i64) -> f64 {
        let away = (column - self.column).abs() as f64;
        self.metric.period.map_or(away, |period| away.min((period - away).abs()))
    }

    /// Returns the least difference of columns from first to last from that of the origin.
    fn columns_to_range(&self, [first, last]: [i64; 2]) -> f64 {
        if (first..=last).contains(&self.column) {
            return 0.0;
        }
        // Columns come nearer again beyond half of the period, so the nearest one is at an end.
        self.columns_to(first).min(self.columns_to(last))
    }

    /// Returns the terms of a row.
    pub(super) fn row_terms(&self, row: i64) -> RowTerms {
        match self.metric.spacing {
            Spacing::Metres([x_m, y_m]) => {
                let across = (row - self.row) as f64 * y_m;
                RowTerms { across: across * across, scale: x_m * x_m }
            }
            Spacing::Degrees { .. } => {
                let [axis_m, equator_m] = self.metric.meridian_m(row);
                let [own_axis_m, own_equator_m] = self.meridian_m;
                let [x, y] = [axis_m - own_axis_m, equator_m - own_equator_m];
                RowTerms { across: x * x + y * y, scale: 4.0 * axis_m * own_axis_m }
            }
        }
    }

    /// Returns the nearness of a sample that many columns away in a row.
    pub(super) fn nearness(&self, row: RowTerms, columns: f64) -> f64 {
        let spread = match self.metric.spacing {
            Spacing::Metres(_) => columns * columns,
            Spacing::Degrees { step, .. } => {
                let sine = (0.5 * (columns * step[0]).to_radians()).sin();
                sine * sine
            }
        };
        row.across + row.scale * spread
    }

    /// Returns a lower bound of the nearness of the samples in columns and rows from first to last; the nearness itself
    /// if there is only one.
    ///
    /// Along a meridian, samples are the farther away the more their latitudes differ, and the distance from the axis
    /// is least at one end of a range of latitudes. So each term has its minimum where it is evaluated.
    pub(super) fn bound(&self, columns: [i64; 2], rows: [i64; 2]) -> f64 {
        let away = self.columns_to_range(columns);
        let nearest = self.row_terms(self.row.clamp(rows[0], rows[1]));
        if columns[0] == columns[1] && rows[0] == rows[1] {
            return self.nearness(nearest, away);
        }
        let scale = rows.map(|row| self.row_terms(row).scale);
        self.nearness(RowTerms { scale: scale[0].min(scale[1]), ..nearest }, away) * ROUNDING
    }

    /// Returns the distance in metres of a sample in a row, from its nearness.
    pub(super) fn distance_m(&self, row: i64, nearness: f64) -> f64 {
        let line_m = nearness.sqrt();
        let Spacing::Degrees { radii_m: [equator_m, pole_m], .. } = self.metric.spacing else { return line_m };
        if line_m == 0.0 {
            return 0.0;
        }
        let (sine, cosine) = self.metric.latitude(0.5 * (self.row + row) as f64).sin_cos();
        let root = (equator_m * cosine).hypot(pole_m * sine);
        let across_meridian_m = equator_m * equator_m / root;
        let along_meridian_m = (equator_m * pole_m / root).powi(2) / root;
        let along = (self.row_terms(row).across / nearness).min(1.0);
        let radius_m = 1.0 / (along / along_meridian_m + (1.0 - along) / across_meridian_m);
        2.0 * radius_m * (0.5 * line_m / radius_m).min(1.0).asin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a metric with latitudes in units of a step, from the north pole on.
    fn metric(step: f64, radii_m: [f64; 2]) -> Metric {
        Metric::new(Spacing::Degrees { north: 90.0, step: [step; 2], radii_m }, (360.0 / step) as usize, true)
    }

    fn distance_m(metric: Metric, from: [i64; 2], to: [i64; 2]) -> f64 {
        let origin = metric.origin(from[0], from[1]);
        origin.distance_m(to[1], origin.nearness(origin.row_terms(to[1]), origin.columns_to(to[0])))
    }

    #[test]
    fn distances_are_those_of_geodesics() {
        // Flinders Peak to Buninyong, 54 972.271 m on GRS 80 (Geocentric Datum of Australia Technical Manual).
        let degrees = |degrees: f64, minutes: f64, seconds: f64| degrees + minutes / 60.0 + seconds / 3600.0;
        let step = 1e-8;
        let row = |south: f64| ((90.0 + south) / step).round() as i64;
        let column = |east: f64| (east / step).round() as i64;
        let flinders = [column(degrees(144.0, 25.0, 29.524_40)), row(degrees(37.0, 57.0, 3.720_30))];
        let buninyong = [column(degrees(143.0, 55.0, 35.383_90)), row(degrees(37.0, 39.0, 10.156_10))];
        let earth = metric(step, WGS_84_RADII_M);
        let measured_m = distance_m(earth, flinders, buninyong);
        assert!((measured_m - 54_972.271).abs() < 0.1, "{measured_m}");
        // A quadrant of a meridian has 10 001 965.729 m.
        let earth = metric(1.0, WGS_84_RADII_M);
        let measured_m = distance_m(earth, [0, 0], [0, 90]);
        assert!((measured_m / 10_001_965.729 - 1.0).abs() < 3e-5, "{measured_m}");
        // On a sphere, arcs are exact; the far side is reached either way.
        let sphere = metric(1.0, [1000.0; 2]);
        let arc_m = |degrees: f64| 1000.0 * degrees.to_radians();
        for (to, degrees) in [([170, 90], 170.0), ([350, 90], 10.0), ([180, 100], 170.0), ([180, 20], 70.0 + 90.0)] {
            let measured_m = distance_m(sphere, [0, 90], to);
            let expected_m = if degrees == 160.0 { arc_m(110.0) } else { arc_m(degrees) };
            assert!((measured_m - expected_m).abs() < 1e-6 * expected_m, "{to:?}: {measured_m} {expected_m}");
        }
        // Half a turn around the pole is over it.
        let measured_m = distance_m(sphere, [0, 10], [180, 20]);
        assert!((measured_m - arc_m(30.0)).abs() < 1e-6, "{measured_m}");
    }

    #[test]
    fn bounds_are_below_all_samples() {
        let metrics = [
            metric(7.5, WGS_84_RADII_M),
            metric(7.5, [3000.0, 2700.0]),
            Metric::new(Spacing::Metres([3.0, 2.0]), 48, true),
            Metric::new(Spacing::Metres([3.0, 2.0]), 48, false),
        ];
        let ranges =
            |end: i64| (0..end).step_by(5).flat_map(move |first| [0, 1, 4, 9].map(|more| [first, first + more]));
        let (mut exact, mut wrong) = (0, 0);
        for metric in metrics {
            for origin in [[0, 0], [3, 1], [11, 12], [40, 22], [47, 24]].map(|[x, y]| metric.origin(x, y)) {
                for (columns, rows) in ranges(40).flat_map(|x| ranges(16).map(move |y| (x, y))) {
                    let places = (rows[0]..=rows[1]).flat_map(|row| (columns[0]..=columns[1]).map(move |x| [x, row]));
                    let all = places.map(|[x, row]| origin.nearness(origin.row_terms(row), origin.columns_to(x)));
                    let least = all.fold(f64::INFINITY, f64::min);
                    let bound = origin.bound(columns, rows);
                    assert!(bound <= least, "{origin:?} {columns:?} {rows:?}: {bound} > {least}");
                    exact += i32::from(bound > 0.999 * least);
                    // Planted: the scale of the nearest row isn't a bound.
                    let terms = origin.row_terms(origin.row.clamp(rows[0], rows[1]));
                    wrong += i32::from(origin.nearness(terms, origin.columns_to_range(columns)) > least);
                }
            }
        }
        assert!(exact > 1000 && wrong > 100, "{exact} {wrong}");
    }
}
