//! Reads the `.prj` sidecar file of a raster: the CRS of formats that cannot store one.
//!
//! It contains Well-Known Text, or the older form of ARC/INFO with a keyword and a value per line: `Projection UTM`,
//! `Zone 10`, `Datum NAD83`, `Units METERS`.

use std::path::{Path, PathBuf};

use super::geokeys::{self as key, GeoKey, USER_DEFINED};
use super::place::{self, sibling, small_text};
use super::{GeoKeys, SourceError, wkt};

/// Returns the keys of the CRS in the `.prj` file of `path`, and that file, if it exists. A file without a known CRS is
/// ignored with a warning.
pub(super) fn given(path: &Path) -> Result<Option<(GeoKeys, PathBuf)>, SourceError> {
    let Some(prj) = sibling(path, "prj") else { return Ok(None) };
    let text = small_text(&prj)?;
    let keys = wkt::keys(&text).or_else(|| arc_info(&text));
    if keys.is_none() {
        tracing::warn!("{}: contains no known CRS and is ignored", prj.display());
    }
    Ok(keys.map(|keys| (keys, prj)))
}

/// Returns the keys of the CRS in the `.prj` file of `path`, and that file. If there is none, `crs_from_grid` decides
/// whether the coordinates can only be degrees.
pub(super) fn keys(
    path: &Path,
    crs_from_grid: [f64; 6],
    size: [u32; 2],
) -> Result<(GeoKeys, Option<PathBuf>), SourceError> {
    if let Some((keys, prj)) = given(path)? {
        return Ok((keys, Some(prj)));
    }
    let name = path.display();
    if are_degrees(crs_from_grid, size) {
        tracing::warn!("{name}: has no coordinate reference system; its coordinates are taken as degrees (WGS 84)");
        return Ok((place::wgs84(), None));
    }
    Ok((GeoKeys::default(), None))
}

/// Returns whether coordinates in an unnamed CRS are longitudes and latitudes: they are on the globe, away from its
/// origin, and have a spacing that divides a degree and would be less than 2 cm in metres.
fn are_degrees([x0, dx, _, y0, _, dy]: [f64; 6], [width, height]: [u32; 2]) -> bool {
    let (x1, y1) = (x0 + dx * f64::from(width), y0 + dy * f64::from(height));
    let on_globe = [x0, x1].iter().all(|x| x.abs() <= 360.0) && [y0, y1].iter().all(|y| y.abs() <= 90.0);
    let parts = 1.0 / dx.abs();
    on_globe
        && (x0.abs() > 1.0 || y0.abs() > 1.0)
        && dx.abs() < 0.02
        && dy.abs() < 0.02
        && (parts - parts.round()).abs() < 1e-4 * parts
}

fn arc_info(text: &str) -> Option<GeoKeys> {
    let field = |name: &str| {
        let line =
            text.lines().find(|line| line.split_whitespace().next().is_some_and(|it| it.eq_ignore_ascii_case(name)));
        line.map(|line| line.split_whitespace().skip(1).collect::<Vec<_>>().join(" ").to_ascii_uppercase())
    };
    let projection = field("Projection")?;
    let geographic = match field("Datum").unwrap_or_default().as_str() {
        "NAD83" | "NAR_C" | "NAR" => 4269,
        "NAD27" | "NAS_C" | "NAS" => 4267,
        "WGS72" => 4322,
        _ => 4326,
    };
    let units = field("Units").unwrap_or_default();
    if projection.starts_with("GEOGRAPHIC") {
        // A grid in arc seconds would need another unit than that of its datum's code.
        return (units != "DS").then(|| place::epsg(geographic, true));
    }
    let unit = match units.as_str() {
        "FEET" => 9003,
        _ => key::METRE,
    };
    let zone = field("Zone").and_then(|zone| zone.parse::<i32>().ok());
    let code = zone
        .filter(|_| projection == "UTM")
        .and_then(|zone| wkt::utm(u16::try_from(zone.unsigned_abs()).ok()?, zone > 0, geographic));
    Some(GeoKeys::from_keys(vec![
        GeoKey::short(key::MODEL_TYPE, 1),
        GeoKey::short(key::PROJECTED_CRS, code.unwrap_or(USER_DEFINED)),
        GeoKey::ascii(key::CITATION, &projection),
        GeoKey::short(key::LINEAR_UNITS, unit),
    ]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_older_form_is_understood() {
        let ned = "Projection    GEOGRAPHIC\nDatum         NAD83\nZunits        METERS\nUnits         DD\n";
        assert_eq!(arc_info(ned).unwrap().epsg, Some(4269));
        let utm = "Projection UTM\r\nDatum NAD27\r\nUnits METERS\r\nZone 10\r\nParameters\r\n";
        assert_eq!(arc_info(utm).unwrap().epsg, Some(26710));
        assert_eq!(arc_info("nonsense"), None);
    }

    #[test]
    fn degrees_are_distinguished_from_metres() {
        let srtm = [-105.55, 1.0 / 1200.0, 0.0, 40.2, 0.0, -1.0 / 1200.0];
        assert!(are_degrees(srtm, [240, 144]));
        assert!(!are_degrees([5.0, 5.0, 0.0, 3.0, 0.0, -5.0], [10, 10]));
        assert!(!are_degrees([0.0, 0.001, 0.0, 0.5, 0.0, -0.001], [100, 100]), "a flume in a laboratory");
        assert!(!are_degrees([556_440.0, 0.01, 0.0, 5e6, 0.0, -0.01], [50, 37]));
    }
}
