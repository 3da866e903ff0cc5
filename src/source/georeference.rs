//! The georeference of a grid of samples (its coordinate reference system and its transform), read from the tags of a
//! GeoTIFF.

use serde::{Deserialize, Serialize};

use super::crs_catalogue::{self as catalogue, Kind};
use super::geokeys::{self as key, GeoKeys, USER_DEFINED};

/// The position of a height grid. Grid coordinates are (column, row) of sample *centres*: sample (0, 0) is the first of
/// the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Georeference {
    /// The transform `[x0, dx/dcolumn, dx/drow, y0, dy/dcolumn, dy/drow]` in units of the CRS.
    pub crs_from_grid: [f64; 6],
    /// The coordinate reference system.
    pub crs: Crs,
    /// The GeoTIFF keys of the CRS, for writing the same reference system elsewhere. Empty if the file has none.
    #[serde(default)]
    pub geokeys: GeoKeys,
}

/// The parts of a coordinate reference system that the world's frame needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Crs {
    /// The file gives no CRS: its units are taken as metres.
    Local,
    /// Eastings and northings.
    Projected {
        /// Metres per unit: 1 for metres, 0.3048006… for US survey feet.
        metres_per_unit: f64,
        /// Display name: `EPSG:32610`, or the citation in the file.
        name: String,
    },
    /// Longitudes and latitudes.
    Geographic {
        /// Radians per unit: π/180 for degrees.
        radians_per_unit: f64,
        /// Semi-major axis of the ellipsoid in metres.
        semi_major_axis_m: f64,
        /// Inverse flattening of the ellipsoid; 0 for a sphere.
        inverse_flattening: f64,
        /// Display name: `EPSG:4326`, or the citation in the file.
        name: String,
    },
}

/// Formats degrees for messages, including the values with hundreds of digits of damaged files.
fn degrees(degrees: f64) -> String {
    if degrees.abs() < 1e6 { format!("{degrees:.6}") } else { format!("{degrees:e}") }
}

/// The reason why a grid has no usable georeference.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GeoreferenceError {
    /// The code is not in the catalogue, and the file does not give its units.
    #[error("its coordinate reference system EPSG:{epsg} is unknown; reproject it with gdalwarp -t_srs")]
    UnknownCrs { epsg: u32 },
    /// The CRS is geocentric (earth-centred coordinates).
    #[error(
        "its coordinates are geocentric, which cannot be used for a height grid; reproject it with gdalwarp -t_srs"
    )]
    Geocentric,
    /// The samples coincide, are on a line, or are infinitely far apart.
    #[error("its pixel size is zero or not finite")]
    PixelSize,
    /// A unit or an axis has an impossible value.
    #[error("its {what} is {value:?}, which is impossible; correct the georeference")]
    Impossible { what: &'static str, value: f64 },
    /// The grid reaches beyond a pole.
    #[error("its latitudes run from {}° to {}°, beyond ±90°", degrees(*south_degrees), degrees(*north_degrees))]
    BeyondPole {
        /// Latitude of the southernmost sample.
        south_degrees: f64,
        /// Latitude of the northernmost sample.
        north_degrees: f64,
    },
    /// The projection to the world's metres cannot be set up.
    #[error("no projection to metres can be set up: {reason}")]
    Projection {
        /// The message of the projection library.
        reason: String,
    },
}

/// The georeferencing tags of a GeoTIFF, as they are in the file.
#[derive(Clone, Debug, Default)]
pub(super) struct GeoTags {
    /// Tag 33550: ModelPixelScale.
    pub pixel_scale: Vec<f64>,
    /// Tag 33922: six numbers per tie point.
    pub tie_points: Vec<f64>,
    /// Tag 34264: a 4×4 matrix by rows.
    pub transformation: Vec<f64>,
    /// Tags 34735 to 34737: the GeoKeys.
    pub geokeys: GeoKeys,
}

impl GeoTags {
    /// Returns `crs_from_grid` for sample centres, if the tags give a transform.
    pub(super) fn crs_from_grid(&self) -> Option<[f64; 6]> {
        transform_from_tags(self)
    }
}

impl Georeference {
    /// Returns the georeference of a grid of `width` × `height` samples in metres, `spacing_m` apart, whose first row
    /// is in the north. Its centre is the origin, and it has no position on the earth.
    pub fn local(width: u32, height: u32, spacing_m: f64) -> Self {
        let [half_x_m, half_y_m] = [width, height].map(|count| 0.5 * f64::from(count.saturating_sub(1)) * spacing_m);
        let crs_from_grid = [-half_x_m, spacing_m, 0.0, half_y_m, 0.0, -spacing_m];
        Self { crs_from_grid, crs: Crs::Local, geokeys: GeoKeys::default() }
    }

    /// Returns the georeference in which column and row are the coordinates x and y themselves (x first). Without a
    /// code these are longitudes and latitudes on WGS 84.
    ///
    /// # Errors
    /// Returns [`GeoreferenceError::UnknownCrs`] or [`GeoreferenceError::Geocentric`].
    pub(crate) fn of_coordinates(epsg: Option<u16>) -> Result<Self, GeoreferenceError> {
        let code = epsg.unwrap_or(EPSG_WGS84);
        let definition = catalogue::look_up(code).ok_or(GeoreferenceError::UnknownCrs { epsg: code.into() })?;
        let name = format!("EPSG:{code}");
        let crs = match definition.kind {
            Kind::Geocentric => return Err(GeoreferenceError::Geocentric),
            Kind::Projected => Crs::Projected { metres_per_unit: definition.unit, name },
            Kind::Geographic => {
                let [semi_major_axis_m, inverse_flattening] = definition.ellipsoid.unwrap_or(WGS84);
                Crs::Geographic { radians_per_unit: definition.unit, semi_major_axis_m, inverse_flattening, name }
            }
        };
        Ok(Self { crs_from_grid: [0.0, 1.0, 0.0, 0.0, 0.0, 1.0], crs, geokeys: GeoKeys::default() })
    }
}

/// Returns the georeference that the tags describe. Missing information is replaced by the simplest assumption (metres,
/// 1 m spacing), with a warning that names `file`.
///
/// # Errors
/// Fails if the CRS is unknown or geocentric, or if units, axes or pixel sizes are impossible.
pub(super) fn from_tags(tags: GeoTags, file: &str) -> Result<Georeference, GeoreferenceError> {
    match tags.crs_from_grid() {
        Some(crs_from_grid) => from_transform(crs_from_grid, tags.geokeys, file),
        None => Ok(nowhere(file)),
    }
}

/// Returns the georeference of a file that has none, with a warning.
pub(super) fn nowhere(file: &str) -> Georeference {
    tracing::warn!("{file}: has no georeference; a sample spacing of 1 m is assumed");
    local_without_warning()
}

/// Returns the same georeference as [`nowhere`] without a warning.
pub(super) fn local_without_warning() -> Georeference {
    let crs_from_grid = [0.0, 1.0, 0.0, 0.0, 0.0, -1.0];
    Georeference { crs_from_grid, crs: Crs::Local, geokeys: GeoKeys::default() }
}

/// Returns the georeference of a transform for sample centres and the keys of its CRS.
///
/// # Errors
/// The same as [`from_tags`].
pub(super) fn from_transform(
    crs_from_grid: [f64; 6],
    geokeys: GeoKeys,
    file: &str,
) -> Result<Georeference, GeoreferenceError> {
    let [_, a, b, _, c, d] = crs_from_grid;
    let (determinant, scale) = (a * d - b * c, a.hypot(c) * b.hypot(d));
    let is_finite = crs_from_grid.iter().all(|value| value.is_finite());
    if !is_finite || determinant == 0.0 || determinant.abs() < 1e-9 * scale {
        return Err(GeoreferenceError::PixelSize);
    }
    let crs = crs_from_keys(&geokeys, file)?;
    Ok(Georeference { crs_from_grid, crs, geokeys })
}

/// Returns `crs_from_grid` for sample centres; `None` without any transform.
fn transform_from_tags(tags: &GeoTags) -> Option<[f64; 6]> {
    let [x0, a, b, y0, c, d] = match (&*tags.pixel_scale, &*tags.tie_points, &*tags.transformation) {
        ([sx, sy, ..], [i, j, _, x, y, _, ..], _) if *sx != 0.0 && *sy != 0.0 => {
            // The standard has positive scales and rows that run south; other orientations need a matrix.
            let sy = sy.abs();
            [x - i * sx, *sx, 0.0, y + j * sy, 0.0, -sy]
        }
        (_, _, [a, b, _, x0, c, d, _, y0, ..]) => [*x0, *a, *b, *y0, *c, *d],
        // A scale of zero without a matrix to replace it is an error later.
        ([sx, sy, ..], [_, _, _, x, y, _, ..], _) => [*x, *sx, 0.0, *y, 0.0, -sy],
        _ => return None,
    };
    // Raster space has its origin at the corner of the first sample if a pixel is an area (the default), and at its
    // centre if a pixel is a point.
    let to_centre = if tags.geokeys.raster_type == Some(2) { 0.0 } else { 0.5 };
    Some([x0 + to_centre * (a + b), a, b, y0 + to_centre * (c + d), c, d])
}

fn crs_from_keys(keys: &GeoKeys, file: &str) -> Result<Crs, GeoreferenceError> {
    let projected = keys.short(key::PROJECTED_CRS).filter(|&code| code != 0);
    let geographic = keys.short(key::GEOGRAPHIC_CRS).filter(|&code| code != 0);
    match (keys.model_type, projected, geographic) {
        (Some(3), ..) => Err(GeoreferenceError::Geocentric),
        (Some(1), code, _) => projected_crs(code, keys, file),
        (Some(2), _, code) => geographic_crs(code, keys, file),
        // Without a model type, or with one that the standard does not define, the codes decide.
        (_, Some(code), _) => projected_crs(Some(code), keys, file),
        (_, None, Some(code)) => geographic_crs(Some(code), keys, file),
        (_, None, None) => match linear_unit(keys)? {
            Some(metres_per_unit) if metres_per_unit != 1.0 => {
                Ok(Crs::Projected { metres_per_unit, name: name(None, keys) })
            }
            Some(_) => Ok(Crs::Local),
            None => {
                tracing::warn!("{file}: has no coordinate reference system; its units are taken as metres");
                Ok(Crs::Local)
            }
        },
    }
}

fn projected_crs(code: Option<u16>, keys: &GeoKeys, file: &str) -> Result<Crs, GeoreferenceError> {
    let code = code.filter(|&code| code != USER_DEFINED);
    let definition = code.and_then(catalogue::look_up);
    if definition.is_some_and(|definition| definition.kind == Kind::Geocentric) {
        return Err(GeoreferenceError::Geocentric);
    }
    // The file's own unit takes precedence over that of the code: State Plane files in feet are often labelled with the
    // code of the metric CRS, and GDAL reads them in the same way.
    let metres_per_unit = match (linear_unit(keys)?, definition, code) {
        (Some(unit), ..) => unit,
        (None, Some(definition), _) if definition.kind == Kind::Projected => definition.unit,
        (None, _, Some(epsg)) => return Err(GeoreferenceError::UnknownCrs { epsg: epsg.into() }),
        (None, _, None) => {
            tracing::warn!("{file}: its coordinates have no unit; metres are assumed");
            1.0
        }
    };
    Ok(Crs::Projected { metres_per_unit, name: name(code, keys) })
}

fn geographic_crs(code: Option<u16>, keys: &GeoKeys, file: &str) -> Result<Crs, GeoreferenceError> {
    let code = code.filter(|&code| code != USER_DEFINED);
    let definition = code.and_then(catalogue::look_up).filter(|definition| definition.kind != Kind::Projected);
    if definition.is_some_and(|definition| definition.kind == Kind::Geocentric) {
        return Err(GeoreferenceError::Geocentric);
    }
    let ellipsoid = match (definition.and_then(|definition| definition.ellipsoid), ellipsoid_from_keys(keys)?, code) {
        (Some(known), ..) => known,
        (None, Some(own), _) => own,
        (None, None, Some(epsg)) => return Err(GeoreferenceError::UnknownCrs { epsg: epsg.into() }),
        (None, None, None) => {
            tracing::warn!("{file}: has no ellipsoid; WGS 84 is assumed");
            WGS84
        }
    };
    let own_unit = match keys.short(key::ANGULAR_UNITS) {
        Some(USER_DEFINED) => keys.double(key::ANGULAR_UNIT_SIZE),
        Some(unit) => catalogue::radians_per_angular_unit(unit),
        None => None,
    };
    let radians_per_unit = own_unit.or(definition.map(|it| it.unit)).unwrap_or(1f64.to_radians());
    if !(radians_per_unit.is_finite() && radians_per_unit > 0.0) {
        return Err(GeoreferenceError::Impossible { what: "angular unit in radians", value: radians_per_unit });
    }
    // Catalogues and files round π/180 to various numbers of digits. With the exact value, equal systems are equal.
    let degree = 1f64.to_radians();
    let radians_per_unit = if (radians_per_unit / degree - 1.0).abs() < 1e-9 { degree } else { radians_per_unit };
    let [semi_major_axis_m, inverse_flattening] = ellipsoid;
    Ok(Crs::Geographic { radians_per_unit, semi_major_axis_m, inverse_flattening, name: name(code, keys) })
}

/// The EPSG code of longitudes and latitudes on WGS 84.
const EPSG_WGS84: u16 = 4326;
const WGS84: [f64; 2] = [6_378_137.0, 298.257_223_563];

/// Returns the semi-major axis in metres and the inverse flattening, if the keys give the axis.
fn ellipsoid_from_keys(keys: &GeoKeys) -> Result<Option<[f64; 2]>, GeoreferenceError> {
    let Some(major) = keys.double(key::SEMI_MAJOR_AXIS) else { return Ok(None) };
    // The range reaches from the smallest round moon to beyond the largest planet.
    if !(1e5..1e8).contains(&major) {
        return Err(GeoreferenceError::Impossible { what: "semi-major axis in metres", value: major });
    }
    let inverse = match (keys.double(key::INVERSE_FLATTENING), keys.double(key::SEMI_MINOR_AXIS)) {
        (Some(inverse), _) => inverse,
        (None, Some(minor)) if minor != major => major / (major - minor),
        (None, Some(_)) => 0.0,
        (None, None) => WGS84[1],
    };
    // 0 denotes a sphere; below 2 the short axis would be less than half of the long one.
    if inverse != 0.0 && !(inverse.is_finite() && inverse > 2.0) {
        return Err(GeoreferenceError::Impossible { what: "inverse flattening", value: inverse });
    }
    Ok(Some([major, inverse]))
}

/// Returns metres per unit from the file's own keys.
fn linear_unit(keys: &GeoKeys) -> Result<Option<f64>, GeoreferenceError> {
    let unit = match keys.short(key::LINEAR_UNITS) {
        Some(USER_DEFINED) => keys.double(key::LINEAR_UNIT_SIZE),
        Some(unit) => catalogue::metres_per_linear_unit(unit),
        None => None,
    };
    match unit {
        Some(value) if !(value.is_finite() && value > 0.0) => {
            Err(GeoreferenceError::Impossible { what: "linear unit in metres", value })
        }
        unit => Ok(unit),
    }
}

/// Returns metres per unit of height, if the keys give a unit other than metres.
pub(super) fn vertical_metres_per_unit(keys: &GeoKeys) -> Option<f64> {
    let unit = match keys.short(key::VERTICAL_UNITS) {
        Some(unit) => catalogue::metres_per_linear_unit(unit),
        None => keys.short(key::VERTICAL_CRS).and_then(catalogue::metres_per_unit_of_vertical_crs),
    };
    unit.filter(|&unit| unit != 1.0)
}

fn name(code: Option<u16>, keys: &GeoKeys) -> String {
    let citation = || [key::PROJECTED_CITATION, key::CITATION, key::GEOGRAPHIC_CITATION].into_iter();
    match code {
        Some(code) => format!("EPSG:{code}"),
        None => citation()
            .filter_map(|id| keys.ascii(id))
            .map(|text| text.lines().next().unwrap_or("").trim())
            .find(|text| !text.is_empty())
            .unwrap_or("unnamed")
            .to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(pixel_scale: [f64; 3]) -> Result<Georeference, GeoreferenceError> {
        let (pixel_scale, tie_points) = (pixel_scale.to_vec(), vec![0.0, 0.0, 0.0, 5.0, 7.0, 0.0]);
        from_tags(GeoTags { pixel_scale, tie_points, ..GeoTags::default() }, "test")
    }

    #[test]
    fn pixel_sizes_must_be_sizes() {
        assert_eq!(place([2.0, 4.0, 0.0]).unwrap().crs_from_grid, [6.0, 2.0, 0.0, 5.0, 0.0, -4.0]);
        assert_eq!(place([2.0, -4.0, 0.0]), place([2.0, 4.0, 0.0]), "rows run south");
        for scale in [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [f64::NAN, 1.0, 0.0], [1.0, f64::INFINITY, 0.0]] {
            assert_eq!(place(scale), Err(GeoreferenceError::PixelSize), "{scale:?}");
        }
    }

    #[test]
    fn axes_and_units_must_be_possible() {
        let keys = |directory: &[u16], doubles: &[f64]| GeoKeys::parse(directory, doubles, "");
        // A user-defined geographic CRS with its axis in the doubles.
        let directory = [1, 1, 0, 3, 1024, 0, 1, 2, 2048, 0, 1, 32767, 2057, 34736, 1, 0];
        let crs = crs_from_keys(&keys(&directory, &[3_396_190.0]), "test").unwrap();
        assert!(matches!(crs, Crs::Geographic { semi_major_axis_m: 3_396_190.0, .. }), "{crs:?}");
        let negative = crs_from_keys(&keys(&directory, &[-12_345_678.0]), "test");
        assert!(matches!(negative, Err(GeoreferenceError::Impossible { .. })), "{negative:?}");
        let directory = [1, 1, 0, 3, 1024, 0, 1, 2, 2054, 0, 1, 32767, 2055, 34736, 1, 0];
        let zero = crs_from_keys(&keys(&directory, &[0.0]), "test");
        assert!(matches!(zero, Err(GeoreferenceError::Impossible { .. })), "{zero:?}");
    }
}
