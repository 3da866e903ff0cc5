//! GeoJSON: lines on the earth with what they are, one feature to a line of the file (RFC 7946).
//!
//! Coordinates are longitudes and latitudes in degrees (WGS 84). In any other reference system the collection has the
//! member `crs` with the system's code, as the edition of 2008 had it and GDAL writes and reads it; east comes before
//! north, and longitude before latitude, whatever the system's own order is.

use std::io::Write;
use std::path::Path;

use super::FileError;
use super::atomic::AtomicFile;

/// The system of a file that names none.
const WGS84: u16 = 4326;

/// Lines of one file.
#[derive(Clone, Debug, PartialEq)]
pub struct Collection {
    /// For people.
    pub name: String,
    /// The EPSG code of the reference system of the coordinates.
    pub epsg: u16,
    /// Digits of coordinates behind the point.
    pub digits: usize,
    /// In drawing order.
    pub features: Vec<Feature>,
}

/// A line, or a dot.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// What it follows or is.
    pub kind: &'static str,
    /// The name of its layer.
    pub layer: String,
    /// On the land, in metres.
    pub width_m: f64,
    /// `#14120f`.
    pub ink: String,
    /// 0 to 1.
    pub opacity: f64,
    /// The number of its pen, from 1, where pens draw.
    pub pen: Option<usize>,
    /// East and north, or longitude and latitude. One place is a dot. Several parts are one line that is cut.
    pub parts: Vec<Vec<[f64; 2]>>,
}

/// Writes a collection, whole or not at all.
///
/// # Errors
/// A number that is not finite; a folder that is not there or not writable; a full disk.
pub fn write_geojson(path: &Path, collection: &Collection) -> Result<(), FileError> {
    let is_finite = |feature: &Feature| {
        let mut numbers = feature.parts.iter().flatten().flatten();
        numbers.all(|number| number.is_finite()) && feature.width_m.is_finite() && feature.opacity.is_finite()
    };
    if !collection.features.iter().all(is_finite) {
        return Err(FileError::write(path, "a line has a number that is not finite"));
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
    let pen = feature.pen.map_or_else(String::new, |pen| format!(", \"pen\": {pen}"));
    format!(
        "{{ \"type\": \"Feature\", \"properties\": {{ \"kind\": {}, \"layer\": {}, \"width_m\": {}, \"ink\": {}, \
         \"opacity\": {}{pen} }}, \"geometry\": {{ \"type\": \"{geometry}\", \"coordinates\": {coordinates} }} }}",
        text(feature.kind),
        text(&feature.layer),
        rounded(feature.width_m),
        text(&feature.ink),
        rounded(feature.opacity),
    )
}

/// Four digits that say something.
fn rounded(value: f64) -> f64 {
    format!("{value:.3e}").parse().unwrap_or(value)
}

fn text(words: &str) -> String {
    serde_json::Value::from(words).to_string()
}
