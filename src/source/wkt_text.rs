//! Converts GeoTIFF keys to Well-Known Text, for the `.prj` of a picture.
//!
//! A CRS with an EPSG code is written as in the catalogue. Others are written in version 1 of the text (OGC 01-009), if
//! their projection is one of a few.

use super::crs_catalogue::{self as catalogue, Kind};
use super::geokeys::{self as key, GeoKeys, USER_DEFINED};
use super::georeference::{Crs, Georeference, utm_zone};

/// GeogPrimeMeridianGeoKey, and the code of Greenwich.
const PRIME_MERIDIAN: u16 = 2051;
const GREENWICH: u16 = 8901;
const WGS84: [f64; 2] = [6_378_137.0, 298.257_223_563];

/// A projection: its code as a key (ProjCoordTrans), its name, and its parameters with their keys.
type Method = (u16, &'static str, &'static [(&'static str, u16)]);

/// The code of transverse Mercator.
const TRANSVERSE_MERCATOR: u16 = 1;

const METHODS: [Method; 5] = [
    (
        TRANSVERSE_MERCATOR,
        "Transverse_Mercator",
        &[
            ("latitude_of_origin", 3081),
            ("central_meridian", 3080),
            ("scale_factor", 3092),
            ("false_easting", 3082),
            ("false_northing", 3083),
        ],
    ),
    (
        7,
        "Mercator_1SP",
        &[("central_meridian", 3080), ("scale_factor", 3092), ("false_easting", 3082), ("false_northing", 3083)],
    ),
    (
        8,
        "Lambert_Conformal_Conic_2SP",
        &[
            ("standard_parallel_1", 3078),
            ("standard_parallel_2", 3079),
            ("latitude_of_origin", 3085),
            ("central_meridian", 3084),
            ("false_easting", 3086),
            ("false_northing", 3087),
        ],
    ),
    (
        10,
        "Lambert_Azimuthal_Equal_Area",
        &[
            ("latitude_of_center", 3089),
            ("longitude_of_center", 3088),
            ("false_easting", 3082),
            ("false_northing", 3083),
        ],
    ),
    (
        11,
        "Albers_Conic_Equal_Area",
        &[
            ("standard_parallel_1", 3078),
            ("standard_parallel_2", 3079),
            ("latitude_of_center", 3081),
            ("longitude_of_center", 3080),
            ("false_easting", 3082),
            ("false_northing", 3083),
        ],
    ),
];

impl Georeference {
    /// Returns the EPSG code of the CRS, if a code describes it completely: a file may give a code and yet have another
    /// unit.
    #[must_use]
    pub fn epsg(&self) -> Option<u16> {
        let named = |name: &str| name.strip_prefix("EPSG:")?.parse().ok();
        let of_keys = self.geokeys.epsg.and_then(|code| u16::try_from(code).ok());
        let is_same = |own: f64, known: f64| (own / known - 1.0).abs() < 1e-9;
        let (code, kind, unit) = match &self.crs {
            Crs::Local => return None,
            Crs::Projected { metres_per_unit, name } => (named(name).or(of_keys)?, Kind::Projected, *metres_per_unit),
            Crs::Geographic { radians_per_unit, name, .. } => {
                (named(name).or(of_keys)?, Kind::Geographic, *radians_per_unit)
            }
        };
        catalogue::look_up(code).filter(|known| known.kind == kind && is_same(unit, known.unit)).map(|_| code)
    }

    /// Returns the CRS in Well-Known Text; `None` for a local CRS and for unsupported projections.
    #[must_use]
    pub fn wkt(&self) -> Option<String> {
        if let Some(text) = self.epsg().and_then(catalogue::text) {
            return Some(text.to_owned());
        }
        match &self.crs {
            Crs::Local => None,
            Crs::Projected { metres_per_unit, name } => projected(&self.geokeys, *metres_per_unit, name),
            Crs::Geographic { radians_per_unit, semi_major_axis_m, inverse_flattening, name } => {
                geographic(&self.geokeys, *radians_per_unit, Some([*semi_major_axis_m, *inverse_flattening]), name)
            }
        }
    }
}

fn projected(keys: &GeoKeys, metres_per_unit: f64, name: &str) -> Option<String> {
    let zone = utm_zone(keys).filter(|_| keys.short(key::PROJECTION_METHOD).is_none());
    let method = if zone.is_some() { TRANSVERSE_MERCATOR } else { keys.short(key::PROJECTION_METHOD)? };
    let (_, projection, parameters) = METHODS.iter().find(|(code, ..)| *code == method)?;
    let own_unit = match keys.short(key::ANGULAR_UNITS) {
        Some(USER_DEFINED) => keys.double(key::ANGULAR_UNIT_SIZE),
        Some(unit) => catalogue::radians_per_angular_unit(unit),
        None => None,
    };
    let base_code = keys.short(key::GEOGRAPHIC_CRS).filter(|&code| code != USER_DEFINED);
    let base = base_code.and_then(catalogue::look_up).filter(|base| base.kind == Kind::Geographic);
    let unit = own_unit.or(base.map(|base| base.unit)).unwrap_or(1f64.to_radians());
    let base_name = keys.ascii(key::GEOGRAPHIC_CITATION).unwrap_or("unnamed");
    let mut text = format!("PROJCS[\"{}\",{}", quoted(name), geographic(keys, unit, None, base_name)?);
    text += &format!(",PROJECTION[\"{projection}\"]");
    for (at, (parameter, id)) in parameters.iter().enumerate() {
        let value = match zone {
            Some((zone, is_south)) => utm_parameters(zone, is_south, metres_per_unit)[at],
            None => keys.double(*id)?,
        };
        text += &format!(",PARAMETER[\"{parameter}\",{value}]");
    }
    Some(text + &format!(",UNIT[\"{}\",{metres_per_unit}]]", unit_name(metres_per_unit)))
}

/// Returns the parameters of a zone of UTM, in the order of [`METHODS`].
fn utm_parameters(zone: u16, is_south: bool, metres_per_unit: f64) -> [f64; 5] {
    let north_m = if is_south { 10_000_000.0 } else { 0.0 };
    [0.0, f64::from(zone) * 6.0 - 183.0, 0.9996, 500_000.0 / metres_per_unit, north_m / metres_per_unit]
}

/// Returns the name of a unit of length.
fn unit_name(metres_per_unit: f64) -> &'static str {
    let is = |metres: f64| (metres_per_unit / metres - 1.0).abs() < 1e-12;
    match () {
        () if metres_per_unit == 1.0 => "metre",
        () if is(0.3048) => "foot",
        () if is(1200.0 / 3937.0) => "US survey foot",
        () => "unit",
    }
}

/// Returns the text of a geographic CRS. `ellipsoid` is its ellipsoid, if that is known from another source than the
/// keys.
fn geographic(keys: &GeoKeys, radians_per_unit: f64, ellipsoid: Option<[f64; 2]>, name: &str) -> Option<String> {
    let code = keys.short(key::GEOGRAPHIC_CRS).filter(|&code| code != USER_DEFINED);
    if let Some(code) = code {
        let text = catalogue::text(code).filter(|text| text.starts_with("GEOGCS["))?;
        let known = catalogue::look_up(code)?;
        return ((known.unit / radians_per_unit - 1.0).abs() < 1e-9).then(|| text.to_owned());
    }
    if keys.short(PRIME_MERIDIAN).is_some_and(|meridian| meridian != GREENWICH) {
        return None;
    }
    let of_keys = || {
        let major = keys.double(key::SEMI_MAJOR_AXIS)?;
        Some([major, keys.double(key::INVERSE_FLATTENING).unwrap_or(WGS84[1])])
    };
    let [major, inverse] = ellipsoid.or_else(of_keys)?;
    let unit_name = if (radians_per_unit / 1f64.to_radians() - 1.0).abs() < 1e-9 { "degree" } else { "unit" };
    Some(format!(
        "GEOGCS[\"{}\",DATUM[\"unknown\",SPHEROID[\"unknown\",{major},{inverse}]],PRIMEM[\"Greenwich\",0],\
         UNIT[\"{unit_name}\",{radians_per_unit}]]",
        quoted(name)
    ))
}

/// Removes characters that must not be in a name: quotes would end it, and readers disagree about characters other than
/// ASCII.
fn quoted(name: &str) -> String {
    name.chars().filter(|c| c.is_ascii_graphic() || *c == ' ').map(|c| if c == '"' { '\'' } else { c }).collect()
}

#[cfg(test)]
mod tests {
    use super::super::world_mapping::WorldMapping;
    use super::super::{GeoKeys, wkt};
    use super::*;
    use glam::DVec2;

    fn place(crs: Crs, geokeys: GeoKeys, crs_from_grid: [f64; 6]) -> Georeference {
        Georeference { crs_from_grid, crs, geokeys }
    }

    fn degrees(name: &str) -> Crs {
        let (semi_major_axis_m, inverse_flattening) = (WGS84[0], WGS84[1]);
        let radians_per_unit = 1f64.to_radians();
        Crs::Geographic { radians_per_unit, semi_major_axis_m, inverse_flattening, name: name.to_owned() }
    }

    #[test]
    fn the_text_of_a_picture_is_read_as_its_keys() {
        let grid = [8.0, 1.0 / 1200.0, 0.0, 47.0, 0.0, -1.0 / 1200.0];
        for name in ["EPSG:4326", "a moon"] {
            let world = place(degrees(name), GeoKeys::default(), grid);
            let mapping = WorldMapping::new(&world, 1201, 1201).unwrap();
            let picture = mapping.picture_georeference(&world, DVec2::new(-500.0, 250.0), 10.0);
            assert_eq!(picture.crs_from_grid, [-500.0, 10.0, 0.0, 250.0, 0.0, -10.0]);
            let text = picture.wkt().unwrap();
            let keys = wkt::keys(&text).unwrap();
            for id in [ORIGIN[0], ORIGIN[1], 3092] {
                assert_eq!(keys.double(id), picture.geokeys.double(id), "{text}");
            }
            assert_eq!((keys.double(ORIGIN[0]), keys.short(key::PROJECTION_METHOD)), (Some(8.5), Some(1)));
            assert_eq!(keys.short(key::GEOGRAPHIC_CRS), picture.geokeys.short(key::GEOGRAPHIC_CRS));
        }
    }

    const ORIGIN: [u16; 2] = [3080, 3081];

    #[test]
    fn wide_worlds_stay_in_degrees() {
        let world = place(degrees("EPSG:4326"), GeoKeys::default(), [-180.0, 1.0, 0.0, 90.0, 0.0, -1.0]);
        let mapping = WorldMapping::new(&world, 361, 181).unwrap();
        let picture = mapping.picture_georeference(&world, DVec2::ZERO, 1000.0);
        let [x, dx, .., y, _, dy] = picture.crs_from_grid;
        let degree_m = WGS84[0] * 1f64.to_radians();
        assert!(x.abs() + y.abs() < 1e-9 && (dx - 1000.0 / degree_m).abs() < 1e-12 && (dx + dy).abs() < 1e-12);
        assert!(picture.wkt().unwrap().starts_with("GEOGCS[\"WGS 84\""));
    }

    #[test]
    fn a_code_with_another_unit_is_no_code() {
        let crs = |metres_per_unit| Crs::Projected { metres_per_unit, name: "EPSG:32610".to_owned() };
        let grid = [0.0, 1.0, 0.0, 0.0, 0.0, -1.0];
        let metres = place(crs(1.0), GeoKeys::default(), grid);
        assert_eq!(metres.epsg(), Some(32610));
        assert!(metres.wkt().unwrap().contains("UTM zone 10N"));
        let feet = place(crs(0.3048), GeoKeys::default(), grid);
        assert_eq!((feet.epsg(), feet.wkt()), (None, None));
        assert_eq!(place(Crs::Local, GeoKeys::default(), grid).wkt(), None);
    }

    #[test]
    fn a_zone_of_utm_without_a_code_is_transverse_mercator() {
        let keys = |zone: u16| {
            let keys = [(key::MODEL_TYPE, 1), (key::PROJECTED_CRS, USER_DEFINED), (key::GEOGRAPHIC_CRS, 4267)];
            let keys = keys.into_iter().chain([(key::PROJECTION, zone), (key::LINEAR_UNITS, 9003)]);
            let unknown = key::GeoKey::ascii(key::CITATION, "unknown");
            GeoKeys::from_keys(keys.map(|(id, code)| key::GeoKey::short(id, code)).chain([unknown]).collect())
        };
        let grid = [0.0, 1.0, 0.0, 0.0, 0.0, -1.0];
        let world = super::super::georeference::from_transform(grid, keys(16_110), "a.tif").unwrap();
        let foot = 1200.0 / 3937.0;
        let Crs::Projected { metres_per_unit, name } = &world.crs else { panic!("{:?}", world.crs) };
        assert!((metres_per_unit - foot).abs() < 1e-12);
        assert_eq!(name, "UTM zone 10S on NAD27");
        let text = world.wkt().unwrap();
        assert!(text.starts_with("PROJCS[\"UTM zone 10S on NAD27\",GEOGCS[\"NAD27\""), "{text}");
        assert!(text.contains("UNIT[\"US survey foot\",0.3048006"), "{text}");
        let read = wkt::keys(&text).unwrap();
        let expected = [0.0, -123.0, 0.9996, 500_000.0 / foot, 10_000_000.0 / foot];
        for ((_, id), expected) in METHODS[0].2.iter().zip(expected) {
            let value = read.double(*id).unwrap();
            assert!((value - expected).abs() < 1e-6 * expected.abs().max(1e-6), "{id}: {value}, {expected}");
        }
        // Another projection without parameters has no text.
        assert_eq!(Georeference { geokeys: keys(10_101), ..world }.wkt(), None);
    }
}
