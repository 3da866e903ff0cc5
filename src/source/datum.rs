//! Datums: how a reference system is placed on the earth, against WGS 84, and which meridian its longitudes start from.

use super::crs_catalogue as catalogue;
use super::geokeys::{self as key, GeoKeys, USER_DEFINED};

/// The shift of NAD27 to WGS 84 as three translations, for the contiguous United States (EPSG:1173, within about 10 m;
/// about 30 m in Alaska and Canada). The usual definition names grids of corrections, which hachure does not have.
const NAD27: &str = "+ellps=clrk66 +towgs84=-8,160,176,0,0,0,0";

/// Prime meridians: GeoTIFF's code (GeogPrimeMeridianGeoKey) and the longitude in degrees east of Greenwich.
const PRIME_MERIDIANS: [(u16, f64); 13] = [
    (8901, 0.0),
    (8902, -9.131_906_111),
    (8903, 2.337_229_167),
    (8904, -74.080_916_667),
    (8905, -3.687_938_889),
    (8906, 12.452_333_333),
    (8907, 7.439_583_333),
    (8908, 106.807_719_444),
    (8909, -17.666_666_667),
    (8910, 4.367_975),
    (8911, 18.058_277_778),
    (8912, 23.716_337_5),
    (8913, 10.722_916_667),
];

/// The relation of a datum to WGS 84.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DatumShift {
    /// The same within about 2 m: WGS 84, ETRS89, NAD83 and others of the last decades.
    None,
    /// A known shift.
    Known,
    /// Coordinates may be off by some hundred metres.
    Unknown,
}

/// Returns the value of a parameter of a PROJ string.
pub(super) fn parameter<'a>(text: &'a str, name: &str) -> Option<&'a str> {
    text.split_whitespace().find_map(|word| word.strip_prefix('+')?.strip_prefix(name)?.strip_prefix('='))
}

/// Returns how the datum of a PROJ string is related to WGS 84.
pub(super) fn datum_shift(text: &str) -> DatumShift {
    if let Some(shift) = parameter(text, "towgs84") {
        let is_zero = shift.split(',').all(|number| number.trim().parse() == Ok(0.0));
        return if is_zero { DatumShift::None } else { DatumShift::Known };
    }
    match (parameter(text, "datum"), parameter(text, "nadgrids"), parameter(text, "ellps")) {
        (Some("WGS84" | "NAD83"), ..) | (_, Some("@null"), _) => DatumShift::None,
        (Some(_), ..) => DatumShift::Known,
        (None, None, Some("GRS80" | "WGS84")) => DatumShift::None,
        _ => DatumShift::Unknown,
    }
}

/// Returns the PROJ string of a code, with a datum shift that needs no further files.
pub(super) fn definition(epsg: u16) -> Option<String> {
    Some(crs_definitions::from_code(epsg)?.proj4.replace("+datum=NAD27", NAD27))
}

/// The geographic CRS on which a projected CRS is based.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct GeographicBase {
    /// Ellipsoid and datum, as parameters of a PROJ string.
    pub datum: String,
    /// Degrees in a unit of its angles.
    pub degrees_per_unit: f64,
    /// Longitude of its prime meridian in degrees east of Greenwich.
    pub prime_meridian_deg: f64,
}

impl GeographicBase {
    /// Returns the base that GeoKeys describe: by the code of a geographic CRS, or by unit, prime meridian and
    /// ellipsoid. `ellipsoid` is the semi-major axis in metres and the inverse flattening (0 for a sphere), for keys
    /// without a code. Returns `None` if a unit or meridian is unknown.
    pub(super) fn of(keys: &GeoKeys, ellipsoid: [f64; 2]) -> Option<Self> {
        let code = keys.short(key::GEOGRAPHIC_CRS).filter(|&code| code != 0 && code != USER_DEFINED);
        let known = code.and_then(catalogue::look_up);
        let text = code.and_then(definition);
        let degrees_per_unit = match keys.short(key::ANGULAR_UNITS).filter(|&unit| unit != 0) {
            Some(USER_DEFINED) => keys.double(key::ANGULAR_UNIT_SIZE)?.to_degrees(),
            Some(unit) => catalogue::radians_per_angular_unit(unit)?.to_degrees(),
            None => known.map_or(1.0, |known| known.unit.to_degrees()),
        };
        // Texts give the degree as a rounded number of radians.
        let degrees_per_unit = if (degrees_per_unit - 1.0).abs() < 1e-9 { 1.0 } else { degrees_per_unit };
        if let Some(text) = text {
            let parts = ["datum", "ellps", "a", "b", "R", "rf", "towgs84", "nadgrids"];
            let words = text.split_whitespace().filter(|word| {
                let name = word.trim_start_matches('+').split('=').next().unwrap_or("");
                parts.contains(&name)
            });
            let prime_meridian_deg = parameter(&text, "pm").map_or(Some(0.0), meridian_deg)?;
            return Some(Self { datum: words.collect::<Vec<_>>().join(" "), degrees_per_unit, prime_meridian_deg });
        }
        let own = keys.double(key::PRIME_MERIDIAN_LONGITUDE).map(|longitude| longitude * degrees_per_unit);
        let prime_meridian_deg = match keys.short(key::PRIME_MERIDIAN).filter(|&code| code != 0) {
            Some(code) if code != USER_DEFINED => {
                PRIME_MERIDIANS.into_iter().find(|(known, _)| *known == code).map(|(_, longitude)| longitude).or(own)?
            }
            _ => own.unwrap_or(0.0),
        };
        Some(Self { datum: ellipsoid_text(ellipsoid), degrees_per_unit, prime_meridian_deg })
    }
}

/// Returns an ellipsoid as parameters of a PROJ string: semi-major axis in metres and inverse flattening (0 for a
/// sphere). Ellipsoids of modern datums get the name by which [`datum_shift`] knows them.
pub(super) fn ellipsoid_text([axis_m, inverse_flattening]: [f64; 2]) -> String {
    let is = |known: f64| axis_m == 6_378_137.0 && (inverse_flattening - known).abs() < 1e-5;
    match inverse_flattening {
        0.0 => format!("+R={axis_m}"),
        _ if is(298.257_223_563) => "+ellps=WGS84".to_owned(),
        _ if is(298.257_222_101) => "+ellps=GRS80".to_owned(),
        inverse => format!("+a={axis_m} +rf={inverse}"),
    }
}

/// Returns the longitude of a prime meridian of a PROJ string, by name or in degrees.
fn meridian_deg(text: &str) -> Option<f64> {
    let names = ["greenwich", "lisbon", "paris", "bogota", "madrid", "rome", "bern", "jakarta", "ferro", "brussels"];
    let names = names.into_iter().chain(["stockholm", "athens", "oslo"]);
    let named = names.zip(PRIME_MERIDIANS).find(|(name, _)| *name == text).map(|(_, (_, longitude))| longitude);
    named.or_else(|| text.parse().ok())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    #[test]
    fn shifts_are_known_unknown_or_not_needed() {
        let of = |code: u16| datum_shift(&definition(code).unwrap());
        for code in [4326, 4258, 4269, 4283, 32632, 3857, 2154] {
            assert_eq!(of(code), DatumShift::None, "EPSG:{code}");
        }
        for code in [4267, 26710, 4230, 4807, 27700, 21781] {
            assert_eq!(of(code), DatumShift::Known, "EPSG:{code}");
        }
        assert_eq!(datum_shift("+proj=longlat +ellps=clrk80 +no_defs"), DatumShift::Unknown);
        assert_eq!(datum_shift(&ellipsoid_text([6_378_249.2, 293.466])), DatumShift::Unknown);
        assert_eq!(datum_shift(&ellipsoid_text([6_378_137.0, 298.257_222_101])), DatumShift::None);
    }

    #[test]
    fn a_base_has_its_unit_and_its_meridian() {
        let base = |keys: Vec<key::GeoKey>| GeographicBase::of(&GeoKeys::from_keys(keys), [6_378_249.2, 293.466]);
        let paris = base(vec![key::GeoKey::short(key::GEOGRAPHIC_CRS, 4807)]).unwrap();
        assert!((paris.prime_meridian_deg - 2.337_229_167).abs() < 1e-9, "{paris:?}");
        assert!((paris.degrees_per_unit - 0.9).abs() < 1e-12, "{paris:?}");
        assert!(paris.datum.contains("+towgs84=-168,-60,320"), "{paris:?}");
        let by_code = base(vec![key::GeoKey::short(key::PRIME_MERIDIAN, 8911)]).unwrap();
        assert!((by_code.prime_meridian_deg - 18.058_277_778).abs() < 1e-9);
        let by_number = base(vec![key::GeoKey::double(key::PRIME_MERIDIAN_LONGITUDE, 5.5)]).unwrap();
        assert!((by_number.prime_meridian_deg - 5.5).abs() < 1e-12);
        assert_eq!(
            base(vec![key::GeoKey::short(key::PRIME_MERIDIAN, 9999)]),
            None,
            "an unknown meridian is no Greenwich"
        );
    }
}
