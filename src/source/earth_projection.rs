//! The projection of a coordinate reference system: between its coordinates and longitudes and latitudes.

use glam::DVec2;
use proj4rs::Proj;
use proj4rs::transform::transform;

use super::crs_catalogue as catalogue;
use super::datum::{self, GeographicBase, parameter};
use super::geokeys::{self as key, GeoKeys, USER_DEFINED};
use super::georeference::{Crs, Georeference};

const WGS84: [f64; 2] = [6_378_137.0, 298.257_223_563];

/// The parameters of a PROJ string that set the ellipsoid or a datum.
const SHAPE_PARAMETERS: [&str; 9] = ["datum", "ellps", "a", "b", "R", "rf", "f", "towgs84", "nadgrids"];

/// The projection of a CRS, without its datum shift: its coordinates and geodetic longitudes and latitudes on its own
/// ellipsoid.
#[derive(Clone, Debug)]
pub(crate) struct EarthProjection {
    projected: Proj,
    geographic: Proj,
    /// Factor from a unit of the CRS to metres, or to radians for a geographic CRS.
    per_unit: f64,
    /// Semi-major axis in metres and inverse flattening (0 for a sphere).
    pub ellipsoid: [f64; 2],
}

impl EarthProjection {
    /// Builds the projection of a georeference's CRS. Returns `None` for a grid without CRS, and for projections that are neither in
    /// the catalogue nor described by known keys.
    pub(crate) fn of(georeference: &Georeference) -> Option<Self> {
        let (text, per_unit) = text(georeference).ok()?;
        let ellipsoid = ellipsoid(georeference);
        let value = |name: &str| parameter(&text, name);
        // Web Mercator applies the formulas of the sphere to latitudes on the ellipsoid.
        let is_sphere = value("R").is_some() || value("a").is_some_and(|a| value("b") == Some(a));
        let shape = match (is_sphere, ellipsoid) {
            (true, [radius_m, _]) => {
                format!("+R={}", value("R").or(value("a")).map_or(radius_m.to_string(), Into::into))
            }
            (false, [radius_m, 0.0]) => format!("+R={radius_m}"),
            (false, [axis_m, inverse]) => format!("+a={axis_m} +rf={inverse}"),
        };
        let is_shape =
            |word: &&str| SHAPE_PARAMETERS.contains(&word.trim_start_matches('+').split('=').next().unwrap_or(""));
        let bare = text.split_whitespace().filter(|word| !is_shape(word)).collect::<Vec<_>>().join(" ");
        let projected = Proj::from_proj_string(&format!("{bare} {shape}")).ok()?;
        let geographic = Proj::from_proj_string(&format!("+proj=longlat {shape} +no_defs")).ok()?;
        Some(Self { projected, geographic, per_unit, ellipsoid })
    }

    /// Returns longitude and latitude in radians at a position in the CRS; NaN where there is none. Longitudes are from
    /// Greenwich, from −π to π.
    pub(crate) fn longitude_latitude_rad(&self, crs: DVec2) -> DVec2 {
        project(&self.projected, &self.geographic, crs * self.per_unit)
    }

    /// Returns the position in the CRS at a longitude and latitude in radians; NaN where there is none.
    pub(crate) fn crs(&self, longitude_latitude_rad: DVec2) -> DVec2 {
        project(&self.geographic, &self.projected, longitude_latitude_rad) / self.per_unit
    }
}

/// Transforms a point; the result is NaN where a projection cannot represent it.
pub(super) fn project(from: &Proj, to: &Proj, point: DVec2) -> DVec2 {
    let mut point = (point.x, point.y, 0.0);
    match transform(from, to, &mut point) {
        Ok(()) => DVec2::new(point.0, point.1),
        Err(_) => DVec2::NAN,
    }
}

/// Returns the CRS as a PROJ string in metres or radians, with its datum and its prime meridian, and the metres or
/// radians of one unit of its coordinates. The datum of a CRS without a code is its base's, or unknown.
///
/// # Errors
/// Fails, with one line, for a grid without CRS and for an unknown projection.
pub(super) fn text(georeference: &Georeference) -> Result<(String, f64), String> {
    match &georeference.crs {
        Crs::Local => Err("it has no coordinate reference system".into()),
        Crs::Geographic { radians_per_unit, semi_major_axis_m, inverse_flattening, name } => {
            if let Some(text) = code(name).and_then(datum::definition) {
                return Ok((text, *radians_per_unit));
            }
            let base = GeographicBase::of(&georeference.geokeys, [*semi_major_axis_m, *inverse_flattening])
                .ok_or_else(|| format!("the prime meridian of {name} is unknown"))?;
            let GeographicBase { datum, prime_meridian_deg, .. } = base;
            Ok((format!("+proj=longlat {datum} +pm={prime_meridian_deg} +no_defs"), *radians_per_unit))
        }
        Crs::Projected { metres_per_unit, name } => {
            let text = match code(name).and_then(datum::definition) {
                // All lengths are in metres: the file's own unit takes precedence over that of the code.
                Some(known) => {
                    let is_unit = |word: &&str| word.starts_with("+units=") || word.starts_with("+to_meter=");
                    let words = known.split_whitespace().filter(|word| !is_unit(word));
                    Some(words.chain(["+units=m"]).collect::<Vec<_>>().join(" "))
                }
                None => text_of_keys(&georeference.geokeys, *metres_per_unit),
            };
            let unknown = || format!("no transformation is known from {name} to other reference systems");
            Ok((text.ok_or_else(unknown)?, *metres_per_unit))
        }
    }
}

/// Returns the EPSG code that is the name of a CRS.
pub(super) fn code(name: &str) -> Option<u16> {
    name.strip_prefix("EPSG:")?.parse().ok()
}

/// Returns semi-major axis in metres and inverse flattening of a CRS. WGS 84 is assumed where nothing gives them.
fn ellipsoid(georeference: &Georeference) -> [f64; 2] {
    match &georeference.crs {
        Crs::Geographic { semi_major_axis_m, inverse_flattening, .. } => [*semi_major_axis_m, *inverse_flattening],
        Crs::Local => WGS84,
        Crs::Projected { name, .. } => {
            let known = code(name).and_then(catalogue::look_up).and_then(|known| known.ellipsoid);
            known.unwrap_or_else(|| ellipsoid_of_keys(&georeference.geokeys))
        }
    }
}

fn ellipsoid_of_keys(keys: &GeoKeys) -> [f64; 2] {
    let base = keys.short(key::GEOGRAPHIC_CRS).filter(|&code| code != USER_DEFINED);
    if let Some(known) = base.and_then(catalogue::look_up).and_then(|known| known.ellipsoid) {
        return known;
    }
    match (keys.double(key::SEMI_MAJOR_AXIS), keys.double(key::INVERSE_FLATTENING), keys.double(key::SEMI_MINOR_AXIS)) {
        (Some(major), Some(inverse), _) => [major, inverse],
        (Some(major), None, Some(minor)) if minor != major => [major, major / (major - minor)],
        (Some(major), None, Some(_)) => [major, 0.0],
        _ => WGS84,
    }
}

/// Which parameters a projection takes, besides the origin's longitude and false easting and northing.
#[derive(Clone, Copy)]
enum Parameters {
    /// Latitude of origin and a scale factor there.
    Scaled,
    /// Latitude of origin.
    Origin,
    /// Two standard parallels and a latitude of origin.
    Conic,
    /// One standard parallel, where the scale is true.
    TrueScale,
    /// The pole next to the latitude of origin; the scale is true at that latitude.
    Polar,
}

/// The known projections: GeoTIFF code (ProjCoordTrans), name in PROJ, and parameters.
const METHODS: [(u16, &str, Parameters); 15] = [
    (1, "tmerc", Parameters::Scaled),
    (7, "merc", Parameters::TrueScale),
    (8, "lcc", Parameters::Conic),
    (9, "lcc", Parameters::Scaled),
    (10, "laea", Parameters::Origin),
    (11, "aea", Parameters::Conic),
    (12, "aeqd", Parameters::Origin),
    (13, "eqdc", Parameters::Conic),
    (14, "stere", Parameters::Scaled),
    (15, "stere", Parameters::Polar),
    (16, "sterea", Parameters::Scaled),
    (17, "eqc", Parameters::TrueScale),
    (18, "cass", Parameters::Origin),
    (24, "sinu", Parameters::Origin),
    (28, "cea", Parameters::TrueScale),
];

/// Returns the projection that GeoKeys describe by its parameters, as a PROJ string in metres.
fn text_of_keys(keys: &GeoKeys, metres_per_unit: f64) -> Option<String> {
    let ellipsoid = ellipsoid_of_keys(keys);
    let GeographicBase { datum, degrees_per_unit, prime_meridian_deg } = GeographicBase::of(keys, ellipsoid)?;
    let shape = format!("{datum} +pm={prime_meridian_deg}");
    // The codes of UTM zones as projections: 16001 to 16060 in the north, 16101 to 16160 in the south.
    if let Some(zone) = keys.short(key::PROJECTION).filter(|code| (16_001..=16_160).contains(code)) {
        let (zone, south) = (zone % 100, if zone > 16_100 { " +south" } else { "" });
        return (1..=60).contains(&zone).then(|| format!("+proj=utm +zone={zone}{south} {shape} +units=m"));
    }
    let method = keys.short(key::PROJECTION_METHOD)?;
    let (_, name, parameters) = METHODS.into_iter().find(|(code, ..)| *code == method)?;
    let first = |ids: &[u16]| ids.iter().find_map(|&id| keys.double(id));
    let angle = |ids: &[u16]| first(ids).map(|angle| angle * degrees_per_unit);
    let latitude = angle(&[3081, 3085, 3089]);
    let parallels = [3078, 3079].map(|id| angle(&[id]));
    let scale = first(&[3092, 3093]).unwrap_or(1.0);
    let latitude_of_origin = latitude.unwrap_or(0.0);
    let own = match parameters {
        // One standard parallel of a conic is its latitude of origin.
        Parameters::Scaled if name == "lcc" => {
            format!("+lat_1={latitude_of_origin} +lat_0={latitude_of_origin} +k_0={scale}")
        }
        Parameters::Scaled => format!("+lat_0={latitude_of_origin} +k={scale}"),
        Parameters::Origin => format!("+lat_0={latitude_of_origin}"),
        Parameters::Conic => {
            let first = parallels[0]?;
            format!("+lat_1={first} +lat_2={} +lat_0={latitude_of_origin}", parallels[1].unwrap_or(first))
        }
        Parameters::TrueScale => match parallels[0] {
            Some(parallel) => format!("+lat_ts={parallel} +lat_0={latitude_of_origin}"),
            None if name == "merc" => format!("+k={scale}"),
            // Without a parallel GDAL takes the latitude of origin for it.
            None => format!("+lat_ts={latitude_of_origin}"),
        },
        Parameters::Polar => {
            let true_scale = latitude.or(parallels[0])?;
            format!("+lat_0={} +lat_ts={true_scale} +k={scale}", 90f64.copysign(true_scale))
        }
    };
    // `etmerc` is Poder and Engsager's exact algorithm; it does not support a sphere, for which `tmerc` is exact.
    let name = if name == "tmerc" && ellipsoid[1] != 0.0 { "etmerc" } else { name };
    let longitude = angle(&[3095, 3080, 3084, 3088]).unwrap_or(0.0);
    let [easting_m, northing_m] =
        [[3082, 3086, 3090], [3083, 3087, 3091]].map(|ids| first(&ids).unwrap_or(0.0) * metres_per_unit);
    Some(format!("+proj={name} {own} +lon_0={longitude} +x_0={easting_m} +y_0={northing_m} {shape} +units=m +no_defs"))
}

/// Returns the distance after which the coordinate x repeats itself, in units of the CRS: a full turn of longitude.
/// Returns `None` for projections whose meridians are not parallel lines.
pub(crate) fn turn_in_crs(georeference: &Georeference) -> Option<f64> {
    match &georeference.crs {
        Crs::Local => None,
        Crs::Geographic { radians_per_unit, .. } => Some(std::f64::consts::TAU / radians_per_unit),
        Crs::Projected { .. } => {
            let (text, _) = text(georeference).ok()?;
            let is_cylindrical =
                ["+proj=merc", "+proj=eqc", "+proj=cea", "+proj=mill"].iter().any(|it| text.contains(it));
            let projection = EarthProjection::of(georeference).filter(|_| is_cylindrical)?;
            let x = |longitude: f64| projection.crs(DVec2::new(longitude, 0.0)).x;
            // The meridian of origin may be anywhere; a small step is always on one side of its antimeridian.
            let here = projection.longitude_latitude_rad(DVec2::ZERO).x;
            let step = 1e-3;
            let turn = (x(here + step) - x(here)) / step * std::f64::consts::TAU;
            turn.is_finite().then(|| turn.abs()).filter(|turn| *turn > 0.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::wkt;
    use super::*;

    /// Returns the georeference of a Well-Known Text in metres.
    fn place(text: &str) -> Georeference {
        let geokeys = wkt::keys(text).unwrap();
        let crs = Crs::Projected { metres_per_unit: 1.0, name: "mine".into() };
        Georeference { crs_from_grid: [0.0, 1.0, 0.0, 0.0, 0.0, -1.0], crs, geokeys }
    }

    fn degrees(georeference: &Georeference, [x, y]: [f64; 2]) -> DVec2 {
        EarthProjection::of(georeference).unwrap().longitude_latitude_rad(DVec2::new(x, y)).map(f64::to_degrees)
    }

    /// Reference systems of the catalogue, each with a place on it.
    const KNOWN: [(u16, [f64; 2]); 9] = [
        (2154, [950_000.0, 6_500_000.0]),
        (3035, [4_500_000.0, 2_700_000.0]),
        (5070, [-1_500_000.0, 1_900_000.0]),
        (3413, [-1_200_000.0, -2_000_000.0]),
        (3031, [900_000.0, 1_300_000.0]),
        (3395, [1_000_000.0, 6_000_000.0]),
        (28992, [150_000.0, 450_000.0]),
        (32632, [600_000.0, 5_200_000.0]),
        (6933, [3_000_000.0, 5_000_000.0]),
    ];

    #[test]
    fn parameters_give_the_projection_of_the_code() {
        for (code, at) in KNOWN {
            // Without its codes the text has only parameters, as files of other programs have.
            let text = catalogue::text(code).unwrap();
            let bare = text.replace("AUTHORITY[\"EPSG\"", "AUTHORITY[\"mine\"");
            let own = place(&bare.replace("UTM zone", "zone"));
            assert_eq!(own.geokeys.epsg, None, "{code}");
            let known = Georeference {
                crs: Crs::Projected { metres_per_unit: 1.0, name: format!("EPSG:{code}") },
                geokeys: GeoKeys::default(),
                ..own.clone()
            };
            let (found, expected) = (degrees(&own, at), degrees(&known, at));
            assert!(found.distance(expected) < 1e-8, "EPSG:{code}: {found}, by its code {expected}");
        }
    }

    #[test]
    fn other_parameters_give_other_places() {
        let (code, at) = KNOWN[0];
        let text = catalogue::text(code).unwrap().replace("AUTHORITY[\"EPSG\"", "AUTHORITY[\"mine\"");
        let planted = place(&text.replace("\"standard_parallel_1\",49", "\"standard_parallel_1\",48"));
        assert!(degrees(&place(&text), at).distance(degrees(&planted, at)) > 1e-4, "planted");
        let unknown = place(&text.replace("Lambert_Conformal_Conic_2SP", "Somebodys_Own"));
        assert!(EarthProjection::of(&unknown).is_none());
    }

    #[test]
    fn a_turn_is_the_width_of_the_whole_earth() {
        let turn = |code: u16| {
            let crs = Crs::Projected { metres_per_unit: 1.0, name: format!("EPSG:{code}") };
            turn_in_crs(&Georeference { crs, ..place(catalogue::text(2154).unwrap()) })
        };
        assert!((turn(3857).unwrap() - 40_075_016.685_6).abs() < 1.0, "{:?}", turn(3857));
        assert!(turn(2154).is_none() && turn(3413).is_none());
    }
}
