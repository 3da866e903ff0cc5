//! The coordinate reference system that GeoTIFF keys describe: a code, or units and an ellipsoid.

use super::super::crs_catalogue::{self as catalogue, Kind};
use super::super::geokeys::{self as key, GeoKeys, USER_DEFINED};
use super::{Crs, GeoreferenceError, WGS84};

/// Returns the CRS that the keys describe.
pub(super) fn crs_from_keys(keys: &GeoKeys, file: &str) -> Result<Crs, GeoreferenceError> {
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
pub(in crate::source) fn warn_of_vertical_unit(keys: &GeoKeys, file: &str) {
    let is_unknown = |code: &u16| *code != 0 && catalogue::metres_per_linear_unit(*code).is_none();
    if let Some(code) = keys.short(key::VERTICAL_UNITS).filter(is_unknown) {
        tracing::warn!("{file}: the size of its vertical unit (code {code}) is unknown; metres are assumed");
    }
}

/// Returns metres per unit of height, if the keys give a known unit.
pub(in crate::source) fn vertical_unit_m(keys: &GeoKeys) -> Option<f64> {
    match keys.short(key::VERTICAL_UNITS) {
        Some(unit) => catalogue::metres_per_linear_unit(unit),
        None => keys.short(key::VERTICAL_CRS).and_then(catalogue::metres_per_unit_of_vertical_crs),
    }
}

/// Returns metres per unit of height, if the keys give a known unit other than metres.
pub(in crate::source) fn vertical_metres_per_unit(keys: &GeoKeys) -> Option<f64> {
    vertical_unit_m(keys).filter(|&unit| unit != 1.0)
}

/// Returns the display name of a CRS: its code, or else the first line of a citation.
fn name(code: Option<u16>, keys: &GeoKeys) -> String {
    let citation = || [key::PROJECTED_CITATION, key::CITATION, key::GEOGRAPHIC_CITATION].into_iter();
    let Some(code) = code else {
        let own = citation()
            .filter_map(|id| keys.ascii(id))
            .map(|text| text.lines().next().unwrap_or("").trim())
            .find(|text| !text.is_empty() && !["unknown", "unnamed"].contains(&&*text.to_ascii_lowercase()));
        return own.map(str::to_owned).or_else(|| utm_name(keys)).unwrap_or_else(|| "unnamed".to_owned());
    };
    format!("EPSG:{code}")
}

/// Returns the number of the zone of UTM that the keys name as a projection without a code, and whether it is south of
/// the equator.
pub(in crate::source) fn utm_zone(keys: &GeoKeys) -> Option<(u16, bool)> {
    match keys.short(key::PROJECTION)? {
        north @ 16_001..=16_060 => Some((north - 16_000, false)),
        south @ 16_101..=16_160 => Some((south - 16_100, true)),
        _ => None,
    }
}

/// Returns a name for a zone of UTM, such as `UTM zone 10N on NAD27`.
fn utm_name(keys: &GeoKeys) -> Option<String> {
    let (zone, is_south) = utm_zone(keys)?;
    let base = keys.short(key::GEOGRAPHIC_CRS).and_then(catalogue::text).and_then(|text| text.split('"').nth(1));
    let base = base.map_or_else(String::new, |base| format!(" on {base}"));
    Some(format!("UTM zone {zone}{}{base}", if is_south { 'S' } else { 'N' }))
}
