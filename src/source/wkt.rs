//! Parses coordinate reference systems in Well-Known Text and converts them to GeoTIFF keys.
//!
//! The text is interpreted as far as the world's frame and a baked file need it: the kind of CRS, its EPSG code, unit,
//! ellipsoid, and the common projections. Both versions of the text have the same grammar,
//! `KEYWORD["name",value,CHILD[…]]`; version 1 is OGC 01-009 section 7, with ESRI's names in `.prj` files, and version
//! 2 is OGC 18-010r7.

use super::GeoKeys;
use super::geokeys::{self as key, GeoKey, USER_DEFINED};

/// Deepest nesting; no meaningful text is nested deeper.
const MAX_DEPTH: usize = 24;

/// A node `KEYWORD["name", 1.0, CHILD[…]]`.
#[derive(Debug, Default)]
struct Node {
    /// The keyword in upper case.
    keyword: String,
    /// Quoted texts and bare words.
    texts: Vec<String>,
    numbers: Vec<f64>,
    children: Vec<Node>,
}

impl Node {
    fn name(&self) -> &str {
        self.texts.first().map_or("", String::as_str)
    }

    fn child(&self, keywords: &[&str]) -> Option<&Node> {
        self.children.iter().find(|child| keywords.contains(&child.keyword.as_str()))
    }

    /// Returns this node, or the first one below it, that has one of the keywords.
    fn find(&self, keywords: &[&str]) -> Option<&Node> {
        if keywords.contains(&self.keyword.as_str()) {
            return Some(self);
        }
        self.children.iter().find_map(|child| child.find(keywords))
    }

    fn epsg(&self) -> Option<u16> {
        let authority = self.child(&["AUTHORITY", "ID"]).filter(|it| it.name().eq_ignore_ascii_case("EPSG"))?;
        match (authority.texts.get(1), authority.numbers.first()) {
            (Some(code), _) => code.parse().ok(),
            (None, Some(code)) => (*code >= 1.0 && *code <= 65_535.0).then_some(*code as u16),
            (None, None) => None,
        }
    }

    /// Returns the unit of the coordinates, in metres or radians. In version 2 each axis may have the unit.
    fn unit(&self) -> Option<f64> {
        let words = ["UNIT", "LENGTHUNIT", "ANGLEUNIT"];
        let of_axis = || self.child(&["AXIS"])?.child(&words);
        self.child(&words).or_else(of_axis)?.numbers.first().copied()
    }
}

const PROJECTED: [&str; 3] = ["PROJCS", "PROJCRS", "PROJECTEDCRS"];
const GEOGRAPHIC: [&str; 6] = ["GEOGCS", "GEOGCRS", "GEOGRAPHICCRS", "GEODCRS", "BASEGEOGCRS", "BASEGEODCRS"];

/// Returns the keys of a CRS; `None` for text that is not Well-Known Text of a known kind.
pub(crate) fn keys(text: &str) -> Option<GeoKeys> {
    let root = parse(&mut text.trim_start_matches('\u{feff}').trim_start(), 0)?;
    let keys = if let Some(projected) = root.find(&PROJECTED) {
        projected_keys(projected)?
    } else if let Some(geographic) = root.find(&GEOGRAPHIC) {
        let mut keys = vec![GeoKey::short(key::MODEL_TYPE, 2)];
        keys.extend(geographic_keys(geographic));
        keys
    } else if root.find(&["GEOCCS"]).is_some() {
        vec![GeoKey::short(key::MODEL_TYPE, 3)]
    } else {
        let local = root.find(&["LOCAL_CS", "ENGCRS", "ENGINEERINGCRS"])?;
        unit_keys(local.unit().unwrap_or(1.0))
    };
    Some(GeoKeys::from_keys(keys))
}

/// Returns the keys of the geographic CRS on which a projected one is based.
pub(super) fn base_geographic_keys(text: &str) -> Option<Vec<GeoKey>> {
    let root = parse(&mut &*text, 0)?;
    root.find(&PROJECTED)?.find(&GEOGRAPHIC).map(geographic_keys)
}

/// Parses one node at the front of `text`, and removes it from there.
fn parse(text: &mut &str, depth: usize) -> Option<Node> {
    let end = text.find(['[', '('])?;
    let keyword = text[..end].trim().to_ascii_uppercase();
    if depth > MAX_DEPTH
        || keyword.is_empty()
        || !keyword.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
    {
        return None;
    }
    let mut node = Node { keyword, ..Node::default() };
    *text = &text[end + 1..];
    loop {
        *text = text.trim_start_matches(|c: char| c.is_whitespace() || c == ',');
        let first = text.chars().next()?;
        if first == '"' {
            let (quoted, rest) = text[1..].split_once('"')?;
            node.texts.push(quoted.to_owned());
            *text = rest;
        } else if matches!(first, ']' | ')') {
            *text = &text[1..];
            return Some(node);
        } else {
            let end = text.find([',', '[', '(', ']', ')'])?;
            if text[end..].starts_with(['[', '(']) {
                node.children.push(parse(text, depth + 1)?);
                continue;
            }
            let word = text[..end].trim();
            match word.parse() {
                Ok(number) => node.numbers.push(number),
                Err(_) => node.texts.push(word.to_owned()),
            }
            *text = &text[end..];
        }
    }
}

fn projected_keys(node: &Node) -> Option<Vec<GeoKey>> {
    let geographic = node.find(&GEOGRAPHIC);
    let base = geographic.and_then(geographic_code);
    // Web Mercator is a method of its own: formulas of the sphere with latitudes on the ellipsoid.
    let web_mercator = || {
        let method = node.find(&["PROJECTION", "METHOD"]).map_or("", Node::name).to_ascii_lowercase();
        let is_method = ["mercator_auxiliary_sphere", "popular visualisation pseudo mercator"].contains(&&*method);
        (is_method || node.name() == "WGS_1984_Web_Mercator_Auxiliary_Sphere").then_some(3857)
    };
    let code = node.epsg().or_else(|| utm_code(node.name(), base?)).or_else(web_mercator);
    let mut keys = vec![
        GeoKey::short(key::MODEL_TYPE, 1),
        GeoKey::short(key::PROJECTED_CRS, code.unwrap_or(USER_DEFINED)),
        GeoKey::ascii(key::CITATION, node.name()),
    ];
    if let Some(unit) = node.unit() {
        keys.extend(unit_keys(unit));
    }
    if code.is_none() {
        keys.extend(geographic.map(geographic_keys).unwrap_or_default());
        keys.extend(projection_keys(node));
    }
    Some(keys)
}

fn unit_keys(metres: f64) -> Vec<GeoKey> {
    let known = [(1.0, key::METRE), (0.3048, 9002), (1200.0 / 3937.0, 9003)];
    match known.into_iter().find(|(unit, _)| (metres / unit - 1.0).abs() < 1e-9) {
        Some((_, code)) => vec![GeoKey::short(key::LINEAR_UNITS, code)],
        None => {
            vec![GeoKey::short(key::LINEAR_UNITS, USER_DEFINED), GeoKey::double(key::LINEAR_UNIT_SIZE, metres)]
        }
    }
}

/// Returns the keys of a geographic CRS without the model type, which depends on the outermost CRS.
fn geographic_keys(node: &Node) -> Vec<GeoKey> {
    if let Some(code) = geographic_code(node) {
        return vec![GeoKey::short(key::GEOGRAPHIC_CRS, code)];
    }
    let mut keys = vec![
        GeoKey::short(key::GEOGRAPHIC_CRS, USER_DEFINED),
        GeoKey::ascii(key::GEOGRAPHIC_CITATION, node.name()),
        GeoKey::short(key::GEOGRAPHIC_DATUM, USER_DEFINED),
    ];
    match node.unit() {
        Some(unit) if (unit / 1f64.to_radians() - 1.0).abs() > 1e-9 => {
            keys.extend([
                GeoKey::short(key::ANGULAR_UNITS, USER_DEFINED),
                GeoKey::double(key::ANGULAR_UNIT_SIZE, unit),
            ]);
        }
        _ => keys.push(GeoKey::short(key::ANGULAR_UNITS, key::DEGREE)),
    }
    if let Some(longitude_deg) = prime_meridian_deg(node).filter(|longitude_deg| *longitude_deg != 0.0) {
        // The key is in the angular unit of the CRS.
        let unit_deg = node.unit().map_or(1.0, f64::to_degrees);
        keys.extend([
            GeoKey::short(key::PRIME_MERIDIAN, USER_DEFINED),
            GeoKey::double(key::PRIME_MERIDIAN_LONGITUDE, longitude_deg / unit_deg),
        ]);
    }
    if let Some([axis, inverse, ..]) = node.find(&["SPHEROID", "ELLIPSOID"]).map(|it| &*it.numbers) {
        keys.extend([
            GeoKey::short(key::ELLIPSOID, USER_DEFINED),
            GeoKey::double(key::SEMI_MAJOR_AXIS, *axis),
            GeoKey::double(key::INVERSE_FLATTENING, *inverse),
        ]);
    }
    keys
}

/// Returns the longitude of the prime meridian in degrees. The first version of WKT has degrees whatever the unit of the
/// CRS is; in the second one a meridian may have a unit of its own.
fn prime_meridian_deg(geographic: &Node) -> Option<f64> {
    let meridian = geographic.find(&["PRIMEM", "PRIMEMERIDIAN"])?;
    let longitude = *meridian.numbers.first()?;
    Some(meridian.unit().map_or(longitude, |unit_rad| longitude * unit_rad.to_degrees()))
}

/// Returns the code of a geographic CRS, as given or by the names of the commonest ones, for which ESRI's text has no
/// codes.
fn geographic_code(node: &Node) -> Option<u16> {
    let is_degrees = node.unit().is_none_or(|unit| (unit / 1f64.to_radians() - 1.0).abs() < 1e-9);
    let is_greenwich = prime_meridian_deg(node).is_none_or(|longitude_deg| longitude_deg == 0.0);
    let by_name = || {
        let plain = |text: &str| text.to_ascii_uppercase().replace([' ', '_'], "");
        let (name, datum) = (plain(node.name()), plain(node.find(&["DATUM"]).map_or("", Node::name)));
        let is = |names: &[&str], datums: &[&str]| names.contains(&&*name) && datums.contains(&&*datum);
        match () {
            () if !is_degrees || !is_greenwich => None,
            () if is(&["GCSWGS1984", "WGS84", "WGS1984"], &["DWGS1984", "WGS1984", "WGS84"]) => Some(4326),
            () if is(&["GCSNORTHAMERICAN1983", "NAD83"], &["DNORTHAMERICAN1983", "NORTHAMERICANDATUM1983"]) => {
                Some(4269)
            }
            () if is(&["GCSNORTHAMERICAN1927", "NAD27"], &["DNORTHAMERICAN1927", "NORTHAMERICANDATUM1927"]) => {
                Some(4267)
            }
            () if is(&["GCSETRS1989", "ETRS89"], &["DETRS1989", "EUROPEANTERRESTRIALREFERENCESYSTEM1989"]) => {
                Some(4258)
            }
            () => None,
        }
    };
    node.epsg().or_else(by_name)
}

/// Returns the EPSG code of a UTM zone, from a name such as `WGS_1984_UTM_Zone_10N` and the code of its geographic CRS.
pub(super) fn utm_code(name: &str, geographic: u16) -> Option<u16> {
    let name = name.to_ascii_uppercase().replace('_', " ");
    let (_, zone) = name.split_once("UTM ZONE ")?;
    let digits = zone.len() - zone.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let is_north = match zone[digits..].trim() {
        "N" => true,
        "S" => false,
        _ => return None,
    };
    utm(zone[..digits].parse().ok()?, is_north, geographic)
}

/// Returns the EPSG code of a UTM zone on a geographic CRS.
pub(super) fn utm(zone: u16, is_north: bool, geographic: u16) -> Option<u16> {
    match (geographic, is_north) {
        (4326, true) if (1..=60).contains(&zone) => Some(32_600 + zone),
        (4326, false) if (1..=60).contains(&zone) => Some(32_700 + zone),
        (4269, true) if (1..=23).contains(&zone) => Some(26_900 + zone),
        (4267, true) if (1..=22).contains(&zone) => Some(26_700 + zone),
        (4258, true) if (28..=38).contains(&zone) => Some(25_800 + zone),
        _ => None,
    }
}

/// The known projections: names in lower case, code as a GeoTIFF key (ProjCoordTrans), and the keys of the parameters
/// latitude and longitude of origin, false easting and northing.
const PROJECTIONS: &[(&[&str], u16, [u16; 4])] = &[
    (&["transverse_mercator", "gauss_kruger", "transverse mercator"], 1, [3081, 3080, 3082, 3083]),
    (
        &["mercator", "mercator_1sp", "mercator_2sp", "mercator (variant a)", "mercator (variant b)"],
        7,
        [3081, 3080, 3082, 3083],
    ),
    (
        &["lambert_conformal_conic", "lambert_conformal_conic_2sp", "lambert conic conformal (2sp)"],
        8,
        [3085, 3084, 3086, 3087],
    ),
    (&["lambert_conformal_conic_1sp", "lambert conic conformal (1sp)"], 9, [3081, 3080, 3082, 3083]),
    (&["lambert_azimuthal_equal_area", "lambert azimuthal equal area"], 10, [3089, 3088, 3082, 3083]),
    (&["albers", "albers_conic_equal_area", "albers equal area"], 11, [3081, 3080, 3082, 3083]),
    (&["azimuthal_equidistant", "azimuthal equidistant"], 12, [3089, 3088, 3082, 3083]),
    (&["equidistant_conic", "equidistant conic"], 13, [3081, 3080, 3082, 3083]),
    (&["stereographic"], 14, [3089, 3088, 3082, 3083]),
    (
        &[
            "polar_stereographic",
            "stereographic_north_pole",
            "stereographic_south_pole",
            "polar stereographic (variant a)",
            "polar stereographic (variant b)",
        ],
        15,
        [3081, 3095, 3082, 3083],
    ),
    (&["oblique_stereographic", "double_stereographic", "oblique stereographic"], 16, [3081, 3080, 3082, 3083]),
    (
        &["equirectangular", "equidistant_cylindrical", "plate_carree", "equidistant cylindrical"],
        17,
        [3089, 3088, 3082, 3083],
    ),
    (&["cassini", "cassini_soldner", "cassini-soldner"], 18, [3081, 3080, 3082, 3083]),
    (&["sinusoidal"], 24, [3089, 3088, 3082, 3083]),
    (&["cylindrical_equal_area", "lambert cylindrical equal area"], 28, [3081, 3080, 3082, 3083]),
];

/// Returns the projection keys of a CRS without a code: method and parameters.
fn projection_keys(node: &Node) -> Vec<GeoKey> {
    let Some(projection) = node.find(&["PROJECTION", "METHOD"]) else { return Vec::new() };
    let name = projection.name().to_ascii_lowercase();
    let Some((_, code, [latitude, longitude, easting, northing])) =
        PROJECTIONS.iter().find(|(names, ..)| names.contains(&&*name))
    else {
        return Vec::new();
    };
    let mut keys = vec![GeoKey::short(key::PROJECTION, USER_DEFINED), GeoKey::short(key::PROJECTION_METHOD, *code)];
    let conversion = node.child(&["CONVERSION"]).unwrap_or(node);
    for parameter in conversion.children.iter().filter(|child| child.keyword == "PARAMETER") {
        let id = match &*parameter.name().to_ascii_lowercase().replace(' ', "_") {
            "latitude_of_origin"
            | "latitude_of_center"
            | "latitude_of_natural_origin"
            | "latitude_of_false_origin"
            | "latitude_of_standard_parallel" => *latitude,
            "central_meridian"
            | "longitude_of_center"
            | "longitude_of_origin"
            | "longitude_of_natural_origin"
            | "longitude_of_false_origin" => *longitude,
            "false_easting" | "easting_at_false_origin" => *easting,
            "false_northing" | "northing_at_false_origin" => *northing,
            "scale_factor" | "scale_factor_at_natural_origin" => 3092,
            "standard_parallel_1" | "latitude_of_1st_standard_parallel" => 3078,
            "standard_parallel_2" | "latitude_of_2nd_standard_parallel" => 3079,
            _ => continue,
        };
        keys.extend(parameter.numbers.first().map(|&value| GeoKey::double(id, value)));
    }
    keys
}

#[cfg(test)]
mod tests {
    use super::*;

    const GEOGCS: &str = r#"GEOGCS["GCS_WGS_1984",DATUM["D_WGS_1984",SPHEROID["WGS_1984",6378137.0,298.257223563]],
        PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]]"#;

    fn projcs(name: &str, geogcs: &str, unit: &str) -> String {
        format!(
            r#"PROJCS["{name}",{geogcs},PROJECTION["Transverse_Mercator"],PARAMETER["Scale_Factor",0.9996],{unit}]"#
        )
    }

    #[test]
    fn codes_are_given_or_found_by_name() {
        assert_eq!(keys(GEOGCS).unwrap().epsg, Some(4326));
        let metre = r#"UNIT["Meter",1.0]"#;
        assert_eq!(keys(&projcs("WGS_1984_UTM_Zone_10N", GEOGCS, metre)).unwrap().epsg, Some(32610));
        assert_eq!(keys(&projcs("WGS 84 / UTM zone 33S", GEOGCS, metre)).unwrap().epsg, Some(32733));
        let with_code = projcs("x", GEOGCS, r#"UNIT["metre",1],AUTHORITY["EPSG","2056"]"#);
        assert_eq!(keys(&with_code).unwrap().epsg, Some(2056));
        let second = r#"PROJCRS["x",BASEGEOGCRS["y",ID["EPSG",4326]],LENGTHUNIT["metre",1],ID["EPSG",32610]]"#;
        assert_eq!(keys(second).unwrap().epsg, Some(32610));
        let compound = format!(r#"COMPD_CS["both",{with_code},VERT_CS["h",UNIT["foot",0.3048]]]"#);
        assert_eq!(keys(&compound).unwrap().epsg, Some(2056));
    }

    #[test]
    fn units_and_ellipsoids_are_kept() {
        let feet = keys(&projcs("mine", GEOGCS, r#"UNIT["Foot_US",0.3048006096012192]"#)).unwrap();
        assert_eq!((feet.epsg, feet.short(key::LINEAR_UNITS)), (None, Some(9003)));
        assert_eq!((feet.short(key::PROJECTION_METHOD), feet.double(3092)), (Some(1), Some(0.9996)));
        let paris = keys(&GEOGCS.replace("\"Greenwich\",0.0", "\"Paris\",2.337229166666667")).unwrap();
        let longitude = paris.double(key::PRIME_MERIDIAN_LONGITUDE).unwrap();
        assert!(paris.epsg.is_none() && (longitude - 2.337_229_166_666_667).abs() < 1e-12, "{longitude}");
        let mars = GEOGCS.replace("GCS_WGS_1984", "Mars").replace("6378137.0", "3396190.0");
        let mars = keys(&mars).unwrap();
        assert_eq!((mars.epsg, mars.double(key::SEMI_MAJOR_AXIS)), (None, Some(3_396_190.0)));
    }

    #[test]
    fn other_texts_than_wkt_have_no_epsg_code() {
        let deep = "A[".repeat(10_000);
        for text in ["", "[", "GEOGCS", "GEOGCS[\"a", "Projection UTM\nZone 10", &deep, "é[\"ü\",]", "PROJCS[]x"] {
            assert!(keys(text).is_none_or(|keys| keys.epsg.is_none()), "{text:.20}");
        }
    }
}
