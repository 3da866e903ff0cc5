//! GeoJSON (RFC 7946): lines on the earth with their properties, one feature per line of the file.
//!
//! Coordinates are longitudes and latitudes in degrees (WGS 84). For any other reference system the collection has the
//! member `crs` with the system's code, as in the 2008 edition, which GDAL reads and writes; east comes before north,
//! and longitude before latitude, whatever the axis order of the system.

use std::io::Write;
use std::path::Path;

use super::FileError;
use super::atomic::AtomicFile;

/// EPSG code of WGS 84, the reference system of a file without `crs`.
pub(crate) const WGS84: u16 = 4326;

/// The lines of one file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Collection {
    /// Name of the collection, which GIS programs show as the layer's name.
    pub name: String,
    /// EPSG code of the reference system of the coordinates.
    pub epsg: u16,
    /// Number of decimals of the coordinates.
    pub digits: usize,
    /// Features in drawing order.
    pub features: Vec<Feature>,
}

/// A line or a dot.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Feature {
    /// The kind of line, for example a contour or a hatching mark.
    pub kind: &'static str,
    /// Name of the layer.
    pub layer: String,
    /// Width on the ground in metres.
    pub width_m: f64,
    /// Colour as `#14120f`.
    pub ink: String,
    /// Opacity, 0 to 1.
    pub opacity: f64,
    /// Number of the pen, from 1, if pens draw.
    pub pen: Option<usize>,
    /// Length on the map in metres.
    pub length_m: f64,
    /// Height of a contour line in metres.
    pub height_m: Option<f64>,
    /// Slope of the land in the middle of a hatching mark, in degrees.
    pub slope_deg: Option<f64>,
    /// Coordinates as east and north, or longitude and latitude. A single position is a dot. Several parts are one line
    /// with gaps.
    pub parts: Vec<Vec<[f64; 2]>>,
}

/// Writes a collection, completely or not at all.
///
/// # Errors
/// Fails if a number is not finite, the folder does not exist or is not writable, or the disk is full.
pub(crate) fn write_geojson(path: &Path, collection: &Collection) -> Result<(), FileError> {
    let is_finite = |feature: &Feature| {
        let mut numbers = feature.parts.iter().flatten().flatten();
        let own = [Some(feature.width_m), Some(feature.opacity), Some(feature.length_m), feature.height_m];
        let mut own = own.into_iter().chain([feature.slope_deg]).flatten();
        numbers.all(|number| number.is_finite()) && own.all(f64::is_finite)
    };
    if !collection.features.iter().all(is_finite) {
        let cause = format!("some lines of the map have no coordinates in EPSG:{}", collection.epsg);
        return Err(FileError::write(path, cause));
    }
    let failed = |error| FileError::write(path, error);
    let mut file = AtomicFile::create(path).map_err(failed)?;
    write(file.writer(), collection).map_err(failed)?;
    file.commit().map_err(failed)
}

fn write(out: &mut impl Write, collection: &Collection) -> std::io::Result<()> {
    writeln!(out, "{{")?;
    writeln!(out, "\"type\": \"FeatureCollection\",")?;
    writeln!(out, "\"name\": {},", text(&collection.name))?;
    if collection.epsg != WGS84 {
        let name = format!("urn:ogc:def:crs:EPSG::{}", collection.epsg);
        writeln!(out, "\"crs\": {{ \"type\": \"name\", \"properties\": {{ \"name\": \"{name}\" }} }},")?;
    }
    writeln!(out, "\"features\": [")?;
    for (number, feature) in collection.features.iter().enumerate() {
        let comma = if number + 1 < collection.features.len() { "," } else { "" };
        writeln!(out, "{}{comma}", line(feature, collection.digits))?;
    }
    writeln!(out, "]\n}}")
}

fn line(feature: &Feature, digits: usize) -> String {
    let place = |[x, y]: &[f64; 2]| format!("[{x:.digits$},{y:.digits$}]");
    let places = |part: &Vec<[f64; 2]>| format!("[{}]", part.iter().map(place).collect::<Vec<_>>().join(","));
    let (geometry, coordinates) = match feature.parts.as_slice() {
        [part] => match part.as_slice() {
            [dot] => ("Point", place(dot)),
            _ => ("LineString", places(part)),
        },
        parts => ("MultiLineString", format!("[{}]", parts.iter().map(places).collect::<Vec<_>>().join(","))),
    };
    let optional =
        |key: &str, value: Option<f64>| value.map_or_else(String::new, |value| format!(", \"{key}\": {}", value + 0.0));
    let pen = optional("pen", feature.pen.map(|pen| pen as f64));
    let height = optional("height_m", feature.height_m);
    let slope = optional("slope_deg", feature.slope_deg.map(|slope| (slope * 10.0).round() / 10.0));
    format!(
        "{{ \"type\": \"Feature\", \"properties\": {{ \"kind\": {}, \"layer\": {}, \"width_m\": {}, \"ink\": {}, \
         \"opacity\": {}, \"length_m\": {}{height}{slope}{pen} }}, \"geometry\": {{ \"type\": \"{geometry}\", \"coordinates\": {coordinates} }} }}",
        text(feature.kind),
        text(&feature.layer),
        rounded(feature.width_m),
        text(&feature.ink),
        rounded(feature.opacity),
        rounded(feature.length_m),
    )
}

/// Rounds to four significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

fn text(words: &str) -> String {
    serde_json::Value::from(words).to_string()
}
