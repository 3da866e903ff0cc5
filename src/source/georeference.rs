//! The georeference of a grid of samples (its coordinate reference system and its transform), read from the tags of a
//! GeoTIFF.

mod keys;

use serde::{Deserialize, Serialize};

use super::crs_catalogue::{self as catalogue, Kind};
use super::geokeys::GeoKeys;
use keys::crs_from_keys;
pub(super) use keys::{utm_zone, vertical_metres_per_unit, vertical_unit_m, warn_of_vertical_unit};

/// The EPSG code of longitudes and latitudes on WGS 84.
const EPSG_WGS84: u16 = 4326;
/// The semi-major axis in metres and the inverse flattening of WGS 84.
const WGS84: [f64; 2] = [6_378_137.0, 298.257_223_563];

/// Smallest distance between samples, in units of the CRS: 10⁻¹² degrees are a ten-thousandth of a millimetre.
const MIN_STEP: f64 = 1e-12;

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
    /// The text is neither a code nor Well-Known Text that hachure understands.
    #[error("its coordinate reference system is unknown; convert it to EPSG:4326")]
    UnknownText,
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

    /// Returns the georeference of a grid with this transform for sample centres ([`Georeference::crs_from_grid`]).
    /// `crs` is a code such as `EPSG:2056`, or Well-Known Text; without it, coordinates are in metres and the grid has no
    /// position on the earth. Errors and warnings call the grid `name`.
    ///
    /// # Errors
    /// The reference system is unknown or geocentric, or the samples coincide, are on a line, or are infinitely far
    /// apart.
    pub fn of_transform(crs_from_grid: [f64; 6], crs: Option<&str>, name: &str) -> Result<Self, GeoreferenceError> {
        let keys = match crs {
            None => {
                check_transform(&crs_from_grid)?;
                return Ok(Self { crs_from_grid, crs: Crs::Local, geokeys: GeoKeys::default() });
            }
            Some(code) if code.trim().to_ascii_uppercase().starts_with("EPSG:") => super::place::keys_of_code(code)
                .ok_or_else(|| match code.trim()[5..].trim().parse() {
                    Ok(epsg) => GeoreferenceError::UnknownCrs { epsg },
                    Err(_) => GeoreferenceError::UnknownText,
                })?,
            Some(text) => super::wkt::keys(text).ok_or(GeoreferenceError::UnknownText)?,
        };
        from_transform(crs_from_grid, keys, name)
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

    /// Returns the same for a reference system as text: `EPSG:n`, or Well-Known Text in a file called `file`.
    ///
    /// # Errors
    /// The reference system is unknown or geocentric.
    pub(crate) fn of_text(text: &str, file: &str) -> Result<Self, GeoreferenceError> {
        if let Some(code) = text.strip_prefix("EPSG:") {
            let epsg: u32 = code.parse().map_err(|_| GeoreferenceError::UnknownText)?;
            let known = u16::try_from(epsg).map_err(|_| GeoreferenceError::UnknownCrs { epsg })?;
            return Self::of_coordinates(Some(known));
        }
        let keys = super::wkt::keys(text).ok_or(GeoreferenceError::UnknownText)?;
        from_transform([0.0, 1.0, 0.0, 0.0, 0.0, 1.0], keys, file)
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
    check_transform(&crs_from_grid)?;
    let crs = crs_from_keys(&geokeys, file)?;
    Ok(Georeference { crs_from_grid, crs, geokeys })
}

/// Checks that a transform places the samples apart from each other.
fn check_transform(crs_from_grid: &[f64; 6]) -> Result<(), GeoreferenceError> {
    let [_, a, b, _, c, d] = *crs_from_grid;
    let (determinant, scale) = (a * d - b * c, a.hypot(c) * b.hypot(d));
    let is_finite = crs_from_grid.iter().all(|value| value.is_finite());
    let smallest = a.hypot(c).min(b.hypot(d));
    if !is_finite || smallest < MIN_STEP || determinant.abs() < 1e-9 * scale {
        return Err(GeoreferenceError::PixelSize);
    }
    Ok(())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::geokeys::{self as key, USER_DEFINED};
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
        // A user-defined unit needs a size, and 9999 does not name a unit.
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
        for scale in
            [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [f64::NAN, 1.0, 0.0], [1.0, f64::INFINITY, 0.0], [1e-231, 400.0, 0.0]]
        {
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
