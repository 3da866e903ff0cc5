//! Transformations from the samples of one grid to those of another, through their reference systems if these differ.

use proj4rs::Proj;
use proj4rs::transform::transform;

use super::super::datum::{DatumShift, datum_shift, parameter};
use super::super::georeference::{Crs, Georeference};
use super::super::{GeoKey, GeoKeyValue, earth_projection};

/// Offsets from a whole number of samples below this count as zero.
pub(super) const ALIGNED_SAMPLES: f64 = 1e-3;

/// The reason why a file without a reference system does not fit one that has one.
pub(super) const NO_CRS: &str = "has no coordinate reference system, but other files of the same world have one; assign \
                                 it (as gdal_edit.py -a_srs EPSG:CODE does) or leave the file out";

/// The transformation from the samples of one grid to those of another.
#[derive(Debug)]
pub(crate) enum SampleTransform {
    /// Sample (0, 0) of the target coincides with this sample of the grid.
    Shift([i64; 2]),
    /// Affine coefficients `[x0, dx/dcolumn, dx/drow, y0, dy/dcolumn, dy/drow]`: target coordinates from grid
    /// coordinates.
    Affine([f64; 6]),
    /// A transformation through both reference systems. Coordinates x of the target repeat themselves after `turn`; they
    /// are taken as close as possible to the second number.
    Projected { from: Box<GridCrs>, to: Box<GridCrs>, turn: Option<[f64; 2]> },
}

/// A grid with its reference system.
#[derive(Debug)]
pub(crate) struct GridCrs {
    crs_from_grid: [f64; 6],
    proj: Proj,
    /// Factor from a unit of the CRS to the unit of `proj`, radians or metres.
    per_unit: f64,
}

impl SampleTransform {
    /// Returns the transformation from the grid at `from` to that at `to`. If the reference systems differ and longitudes
    /// or eastings of `to` repeat themselves, they are taken as close as possible to `middle`, in units of its CRS.
    ///
    /// # Errors
    /// Fails, with one line, if one of them has no reference system, or if no transformation between them is known.
    pub(crate) fn between(from: &Georeference, to: &Georeference, middle: Option<f64>) -> Result<Self, String> {
        if !same(from, to) {
            return Self::projected(
                from,
                to,
                middle.and_then(|middle| Some([earth_projection::turn_in_crs(to)?, middle])),
            );
        }
        let back = inverse(to.crs_from_grid);
        let ([fx, a, b, fy, c, d], [bx, e, f, by, g, h]) = (from.crs_from_grid, back);
        let ways =
            [bx + e * fx + f * fy, e * a + f * c, e * b + f * d, by + g * fx + h * fy, g * a + h * c, g * b + h * d];
        // Over 10⁵ samples the error must not add up to a visible fraction of a sample.
        let unit = [1.0, 0.0, 0.0, 1.0];
        let is_unit =
            [ways[1], ways[2], ways[4], ways[5]].iter().zip(unit).all(|(way, unit)| (way - unit).abs() < 1e-8);
        let shift = [-ways[0], -ways[3]];
        if is_unit && shift.iter().all(|c| (c - c.round()).abs() < ALIGNED_SAMPLES) {
            return Ok(Self::Shift(shift.map(|c| c.round() as i64)));
        }
        Ok(Self::Affine(ways))
    }

    /// Returns the transformation from coordinates or samples at `from` to the grid of `size` at `to`. Longitudes that
    /// differ from those of the grid by a whole turn are on it: −179° is on a grid from 170° to 190°.
    ///
    /// # Errors
    /// The same as [`Self::between`].
    pub(crate) fn to_grid(from: &Georeference, to: &Georeference, size: [u32; 2]) -> Result<Self, String> {
        let middle = middle_x(to, size);
        let beyond = |turn: &f64| {
            let [column, row] = size.map(|count| f64::from(count - 1));
            let ends = [[0.0, 0.0], [column, 0.0], [0.0, row], [column, row]];
            ends.into_iter().any(|[x, y]| apply(to.crs_from_grid, x, y)[0].abs() > 0.5 * turn * (1.0 + 1e-6))
        };
        match earth_projection::turn_in_crs(to).filter(beyond) {
            Some(turn) => Self::projected(from, to, Some([turn, middle])),
            None => Self::between(from, to, Some(middle)),
        }
    }

    fn projected(from: &Georeference, to: &Georeference, turn: Option<[f64; 2]>) -> Result<Self, String> {
        let back = inverse(to.crs_from_grid);
        let (from, to) = (GridCrs::new(from)?, GridCrs::new(to)?);
        Ok(Self::Projected { from: Box::new(from), to: Box::new(GridCrs { crs_from_grid: back, ..to }), turn })
    }

    /// Returns the target's (column, row) of a position; NaN where a projection cannot represent it.
    pub(crate) fn map(&self, column: f64, row: f64) -> [f64; 2] {
        match self {
            Self::Shift([x, y]) => [column - *x as f64, row - *y as f64],
            Self::Affine(by) => apply(*by, column, row),
            Self::Projected { from, to, turn } => {
                let [x, y] = apply(from.crs_from_grid, column, row).map(|c| c * from.per_unit);
                let mut point = (x, y, 0.0);
                match transform(&from.proj, &to.proj, &mut point) {
                    Ok(()) => {
                        let x = point.0 / to.per_unit;
                        let x = turn.map_or(x, |[turn, middle]| x - turn * ((x - middle) / turn).round());
                        apply(to.crs_from_grid, x, point.1 / to.per_unit)
                    }
                    Err(_) => [f64::NAN; 2],
                }
            }
        }
    }
}

impl GridCrs {
    pub(super) fn new(place: &Georeference) -> Result<Self, String> {
        let (text, per_unit) = match earth_projection::text(place) {
            Err(_) if place.crs == Crs::Local => return Err(NO_CRS.into()),
            found => found?,
        };
        let proj =
            Proj::from_proj_string(&text).map_err(|error| format!("its reference system cannot be set up: {error}"))?;
        Ok(Self { crs_from_grid: place.crs_from_grid, proj, per_unit })
    }
}

/// Returns whether coordinates in one CRS are valid in the other, within about 2 m.
pub(super) fn same(a: &Georeference, b: &Georeference) -> bool {
    match (&a.crs, &b.crs) {
        (
            Crs::Geographic { radians_per_unit: unit_a, semi_major_axis_m: axis_a, name: name_a, .. },
            Crs::Geographic { radians_per_unit: unit_b, semi_major_axis_m: axis_b, name: name_b, .. },
        ) => {
            let code = earth_projection::code;
            let is_one_datum = code(name_a).is_some() && code(name_a) == code(name_b);
            let parts = |place: &Georeference| {
                let (text, _) = earth_projection::text(place).ok()?;
                Some((datum_shift(&text), parameter(&text, "pm").unwrap_or("0").to_owned()))
            };
            let is_alike = || match (parts(a), parts(b)) {
                // A datum is not known by its ellipsoid; but that of two files of one product is the same.
                (Some((shift_a, from_a)), Some((shift_b, from_b))) => {
                    let is_shift = shift_a == shift_b && shift_a != DatumShift::Known;
                    is_shift && from_a == from_b && (axis_a - axis_b).abs() < 1.0
                }
                _ => name_a == name_b,
            };
            unit_a == unit_b && (is_one_datum || is_alike())
        }
        (Crs::Projected { name, .. }, Crs::Projected { .. }) => {
            // Files without a code may all be called "unknown".
            let has_parameters = |key: &&GeoKey| (2048..=2061).contains(&key.id) || (3074..=3095).contains(&key.id);
            let count = |place: &Georeference| place.geokeys.keys.iter().filter(has_parameters).count();
            let are_parameters_alike = || {
                let own = a.geokeys.keys.iter().filter(has_parameters);
                count(a) == count(b) && own.into_iter().all(|key| b.geokeys.keys.iter().any(|other| alike(key, other)))
            };
            a.crs == b.crs && (earth_projection::code(name).is_some() || are_parameters_alike())
        }
        (a, b) => a == b,
    }
}

pub(super) fn has_unknown_datum(place: &Georeference) -> bool {
    earth_projection::text(place).is_ok_and(|(text, _)| datum_shift(&text) == DatumShift::Unknown)
}

/// Returns whether two keys are the same, except for rounding.
fn alike(a: &GeoKey, b: &GeoKey) -> bool {
    match (&a.value, &b.value) {
        (GeoKeyValue::Double(own), GeoKeyValue::Double(other)) => {
            let is_near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-9 * a.abs().max(1.0);
            a.id == b.id && own.len() == other.len() && own.iter().zip(other).all(is_near)
        }
        _ => a == b,
    }
}

/// Returns the coordinate x of the middle of a grid in its CRS.
pub(super) fn middle_x(place: &Georeference, size: [u32; 2]) -> f64 {
    let [column, row] = size.map(|count| f64::from(count - 1) / 2.0);
    apply(place.crs_from_grid, column, row)[0]
}

fn apply([x0, a, b, y0, c, d]: [f64; 6], x: f64, y: f64) -> [f64; 2] {
    [x0 + a * x + b * y, y0 + c * x + d * y]
}

/// Inverts the transform of a georeference, which always has an inverse.
fn inverse([x0, a, b, y0, c, d]: [f64; 6]) -> [f64; 6] {
    let determinant = a * d - b * c;
    let [e, f, g, h] = [d, -b, -c, a].map(|part| part / determinant);
    [-(e * x0 + f * y0), e, f, -(g * x0 + h * y0), g, h]
}
