//! The georeference of a grid of samples (its coordinate reference system and its transform), read from the tags of a
//! GeoTIFF.

use serde::{Deserialize, Serialize};

use super::crs_catalogue::{self as catalogue, Kind};
use super::geokeys::{self as key, GeoKeys, USER_DEFINED};

/// The position of a height grid. Grid coordinates are (column, row) of sample *centres*: sample (0, 0) is the first of
/// the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Georeference {
    /// GDAL's geotransform, but of sample centres: `[x0, dx/dcolumn, dx/drow, y0, dy/dcolumn, dy/drow]` in units of the
    /// CRS.
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
    /// No CRS; the coordinates are in metres, by declaration or by assumption.
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
fn format_degrees(angle_deg: f64) -> String {
    if angle_deg.abs() < 1e6 { format!("{angle_deg:.6}") } else { format!("{angle_deg:e}") }
}

/// The reason why a grid has no usable georeference.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GeoreferenceError {
    /// The code is not in the catalogue, and the file does not give its unit or ellipsoid.
    #[error("its coordinate reference system EPSG:{epsg} is unknown; reproject it with gdalwarp -t_srs EPSG:4326")]
    UnknownCrs { epsg: u32 },
    /// The code is of another kind of CRS than the file declares.
    #[error(
        "its coordinate reference system EPSG:{epsg} is not {declared}, as the file declares; assign the right one \
         with gdal_edit -a_srs"
    )]
    WrongKind {
        epsg: u32,
        /// `projected` or `geographic`.
        declared: &'static str,
    },
    /// The CRS is geocentric (earth-centred coordinates).
    #[error(
        "its coordinates are geocentric, which cannot be used for a height grid; reproject it with gdalwarp -t_srs \
         EPSG:4326"
    )]
    Geocentric,
    /// The samples coincide, are on a line, or are infinitely far apart.
    #[error("its pixel size is zero or not finite")]
    PixelSize,
    /// A unit or an axis has an impossible value.
    #[error("its {what} is {value:?}, which is impossible; correct the georeference")]
    Impossible { what: &'static str, value: f64 },
    /// The grid reaches beyond a pole.
    #[error(
        "its latitudes run from {}° to {}°, beyond ±90°",
        format_degrees(*south_degrees), format_degrees(*north_degrees)
    )]
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
    /// Returns [`Georeference::crs_from_grid`], if the tags give a transform.
    pub(super) fn crs_from_grid(&self) -> Option<[f64; 6]> {
        transform_from_tags(self)
    }

    /// Returns whether there are ground control points: several tie points without a pixel scale.
    fn has_control_points(&self) -> bool {
        self.pixel_scale.is_empty() && self.tie_points.len() >= 12
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
        None => Ok(assumed_with_warning(&tags, file)),
    }
}

/// Returns the georeference that is assumed for a file whose tags give no transform, with a warning.
pub(super) fn assumed_with_warning(tags: &GeoTags, file: &str) -> Georeference {
    if tags.has_control_points() {
        tracing::warn!(
            "{file}: ground control points are not supported, and a sample spacing of 1 m is assumed; apply them with \
             gdalwarp"
        );
    } else {
        tracing::warn!("{file}: has no georeference; a sample spacing of 1 m is assumed");
    }
    assumed()
}

/// Returns the georeference that is assumed where there is none: a spacing of 1 m, with the first sample at the origin.
pub(super) fn assumed() -> Georeference {
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

/// Returns [`Georeference::crs_from_grid`]; `None` if the tags give no transform. Of several tie points next to a pixel
/// scale only the first counts.
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

/// Returns the CRS that the keys describe.
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
        (_, None, None) => match LINEAR.read(keys, file)? {
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
    let metres_per_unit = match (LINEAR.read(keys, file)?, definition, code) {
        (Some(unit), ..) => unit,
        (None, Some(definition), _) if definition.kind == Kind::Projected => definition.unit,
        (None, Some(_), Some(epsg)) => {
            return Err(GeoreferenceError::WrongKind { epsg: epsg.into(), declared: "projected" });
        }
        (None, None, Some(epsg)) => return Err(GeoreferenceError::UnknownCrs { epsg: epsg.into() }),
        (None, _, None) => {
            tracing::warn!("{file}: its coordinates have no unit; metres are assumed");
            1.0
        }
    };
    Ok(Crs::Projected { metres_per_unit, name: name(code, keys) })
}

fn geographic_crs(code: Option<u16>, keys: &GeoKeys, file: &str) -> Result<Crs, GeoreferenceError> {
    let code = code.filter(|&code| code != USER_DEFINED);
    let known = code.and_then(catalogue::look_up);
    let definition = known.filter(|definition| definition.kind != Kind::Projected);
    if definition.is_some_and(|definition| definition.kind == Kind::Geocentric) {
        return Err(GeoreferenceError::Geocentric);
    }
    // A code defines its ellipsoid, and the file's keys count only without a code. Units are often changed next to the
    // code, so there the keys take precedence.
    let ellipsoid = match (definition.and_then(|definition| definition.ellipsoid), ellipsoid_from_keys(keys)?, code) {
        (Some(known), ..) => known,
        (None, Some(own), _) => own,
        (None, None, Some(epsg)) if known.is_some_and(|known| known.kind == Kind::Projected) => {
            return Err(GeoreferenceError::WrongKind { epsg: epsg.into(), declared: "geographic" });
        }
        (None, None, Some(epsg)) => return Err(GeoreferenceError::UnknownCrs { epsg: epsg.into() }),
        (None, None, None) => {
            tracing::warn!("{file}: has no ellipsoid; WGS 84 is assumed");
            WGS84
        }
    };
    let own_unit = ANGULAR.read(keys, file)?;
    let radians_per_unit = own_unit.or(definition.map(|it| it.unit)).unwrap_or(1f64.to_radians());
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

/// How the keys give a kind of unit.
struct UnitKeys {
    /// The key with the EPSG code of the unit.
    code: u16,
    /// The key with the size of a user-defined unit, in metres or radians.
    size: u16,
    /// Returns the size of the unit with a code.
    size_of: fn(u16) -> Option<f64>,
    kind: &'static str,
    /// For messages about an impossible size.
    kind_in_si: &'static str,
    /// The unit that is assumed if nothing gives one.
    default: &'static str,
}

const LINEAR: UnitKeys = UnitKeys {
    code: key::LINEAR_UNITS,
    size: key::LINEAR_UNIT_SIZE,
    size_of: catalogue::metres_per_linear_unit,
    kind: "linear unit",
    kind_in_si: "linear unit in metres",
    default: "metres",
};
const ANGULAR: UnitKeys = UnitKeys {
    code: key::ANGULAR_UNITS,
    size: key::ANGULAR_UNIT_SIZE,
    size_of: catalogue::radians_per_angular_unit,
    kind: "angular unit",
    kind_in_si: "angular unit in radians",
    default: "degrees",
};

impl UnitKeys {
    /// Returns the size of the file's own unit, in metres or radians. An unknown unit counts as none, with a warning.
    fn read(&self, keys: &GeoKeys, file: &str) -> Result<Option<f64>, GeoreferenceError> {
        // 0 is "undefined" in GeoTIFF.
        let Some(code) = keys.short(self.code).filter(|&code| code != 0) else { return Ok(None) };
        let size = if code == USER_DEFINED { keys.double(self.size) } else { (self.size_of)(code) };
        match size {
            Some(value) if !(value.is_finite() && value > 0.0) => {
                Err(GeoreferenceError::Impossible { what: self.kind_in_si, value })
            }
            Some(value) => Ok(Some(value)),
            None => {
                let Self { kind, default, .. } = self;
                tracing::warn!(
                    "{file}: the size of its {kind} (code {code}) is unknown; the unit of its EPSG code, or {default}, \
                     is assumed"
                );
                Ok(None)
            }
        }
    }
}

/// Warns if the keys give a unit of height whose size is unknown, so that heights are taken as metres.
pub(super) fn warn_of_vertical_unit(keys: &GeoKeys, file: &str) {
    let is_unknown = |code: &u16| *code != 0 && catalogue::metres_per_linear_unit(*code).is_none();
    if let Some(code) = keys.short(key::VERTICAL_UNITS).filter(is_unknown) {
        tracing::warn!("{file}: the size of its vertical unit (code {code}) is unknown; metres are assumed");
    }
}

/// Returns metres per unit of height, if the keys give a known unit other than metres.
pub(super) fn vertical_metres_per_unit(keys: &GeoKeys) -> Option<f64> {
    let unit = match keys.short(key::VERTICAL_UNITS) {
        Some(unit) => catalogue::metres_per_linear_unit(unit),
        None => keys.short(key::VERTICAL_CRS).and_then(catalogue::metres_per_unit_of_vertical_crs),
    };
    unit.filter(|&unit| unit != 1.0)
}

/// Returns the display name of a CRS: its code, or else the first line of a citation.
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
    use crate::tests::common::log::with_warnings;

    /// Returns the keys of a directory of short values.
    fn short_keys(keys: &[[u16; 2]]) -> GeoKeys {
        let entries = keys.iter().flat_map(|&[id, value]| [id, 0, 1, value]);
        let directory: Vec<u16> = [1, 1, 0, keys.len() as u16].into_iter().chain(entries).collect();
        GeoKeys::parse(&directory, &[], "")
    }

    #[test]
    fn ground_control_points_are_a_warning() {
        let points = |count: usize| {
            let tags = GeoTags { tie_points: vec![1.0; 6 * count], ..GeoTags::default() };
            with_warnings(|| from_tags(tags, "a.tif").unwrap())
        };
        let (georeference, warnings) = points(3);
        assert_eq!(georeference, assumed());
        assert!(warnings.contains("a.tif: ground control points are not supported"), "{warnings}");
        let (georeference, warnings) = points(0);
        assert_eq!(georeference, assumed());
        assert!(warnings.contains("a.tif: has no georeference"), "{warnings}");
    }

    #[test]
    fn unknown_units_are_a_warning() {
        let crs = |keys: &[[u16; 2]]| with_warnings(|| crs_from_keys(&short_keys(keys), "a.tif").unwrap());
        let (model, projected, geographic) = (key::MODEL_TYPE, key::PROJECTED_CRS, key::GEOGRAPHIC_CRS);
        // A user-defined unit needs a size, and 9999 is no unit.
        for code in [9999, USER_DEFINED] {
            let (linear, warnings) = crs(&[[model, 1], [projected, 26730], [key::LINEAR_UNITS, code]]);
            let foot = 1200.0 / 3937.0;
            assert!(matches!(linear, Crs::Projected { metres_per_unit, .. } if (metres_per_unit - foot).abs() < 1e-12));
            assert!(warnings.contains(&format!("linear unit (code {code}) is unknown")), "{warnings}");
            let (angular, warnings) = crs(&[[model, 2], [geographic, 4326], [key::ANGULAR_UNITS, code]]);
            let degree = 1f64.to_radians();
            assert!(matches!(angular, Crs::Geographic { radians_per_unit, .. } if radians_per_unit == degree));
            assert!(warnings.contains(&format!("angular unit (code {code}) is unknown")), "{warnings}");
            let keys = short_keys(&[[key::VERTICAL_UNITS, code]]);
            let (_, warnings) = with_warnings(|| warn_of_vertical_unit(&keys, "a.tif"));
            assert!(warnings.contains(&format!("vertical unit (code {code}) is unknown; metres")), "{warnings}");
        }
        let (_, warnings) = crs(&[[model, 1], [projected, 32610], [key::LINEAR_UNITS, key::METRE]]);
        assert_eq!(warnings, "", "a known unit");
        let (_, warnings) = crs(&[[model, 2], [geographic, 4326], [key::ANGULAR_UNITS, key::DEGREE]]);
        assert_eq!(warnings, "", "a known unit");
        let (_, warnings) =
            with_warnings(|| warn_of_vertical_unit(&short_keys(&[[key::VERTICAL_UNITS, 9003]]), "a.tif"));
        assert_eq!(warnings, "", "a known unit");
    }

    #[test]
    fn a_code_of_another_kind_is_not_unknown() {
        let error = |keys: &[[u16; 2]]| crs_from_keys(&short_keys(keys), "a.tif").unwrap_err();
        let geographic = error(&[[key::MODEL_TYPE, 2], [key::GEOGRAPHIC_CRS, 32610]]);
        assert_eq!(geographic, GeoreferenceError::WrongKind { epsg: 32610, declared: "geographic" });
        let projected = error(&[[key::MODEL_TYPE, 1], [key::PROJECTED_CRS, 4326]]);
        assert_eq!(projected, GeoreferenceError::WrongKind { epsg: 4326, declared: "projected" });
        let unknown = error(&[[key::MODEL_TYPE, 2], [key::GEOGRAPHIC_CRS, 1]]);
        assert_eq!(unknown, GeoreferenceError::UnknownCrs { epsg: 1 });
    }

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
