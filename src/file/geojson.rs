//! GeoJSON (RFC 7946): lines on the earth with their properties, one feature per line of the file.
//!
//! Coordinates are longitudes and latitudes in degrees (WGS 84). For any other reference system the collection has the
//! member `crs` with the system's code, as in the 2008 edition, which GDAL reads and writes; east comes before north,
//! and longitude before latitude, whatever the axis order of the system.

use std::collections::BTreeMap;
use std::fmt;
use std::io::Write;
use std::path::Path;

use serde::de::{Deserializer, Error, IgnoredAny, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};

use super::FileError;
use super::atomic::AtomicFile;
use super::geojson_polygons::{LARGEST_BYTES, epsg_of, not_geojson};
use super::input::read_text;
use super::unnamed::head;

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

/// The beginning of a file that hachure wrote: its second member names the program, and then its version. GIS programs skip
/// the member, and write the others in another order.
const HEAD: &str = "{\n\"type\": \"FeatureCollection\",\n\"generator\": \"hachure ";

/// Returns whether hachure wrote the GeoJSON at `path`.
pub(crate) fn is_own(path: &Path) -> bool {
    head(path, HEAD.len()) == HEAD.as_bytes()
}

fn write(out: &mut impl Write, collection: &Collection) -> std::io::Result<()> {
    writeln!(out, "{HEAD}{}\",", env!("CARGO_PKG_VERSION"))?;
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

/// Largest number of kinds that are counted separately.
const MOST_KINDS: usize = 64;

/// The number of features of a file, by geometry and by their property `kind`.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Summary {
    pub lines: u64,
    pub points: u64,
    /// Features with other geometries, or with none.
    pub others: u64,
    /// Number of features by kind; those without one are not counted here.
    pub kinds: BTreeMap<String, u64>,
    /// Code of the reference system; longitude and latitude if the file names none.
    pub epsg: Option<u16>,
}

impl Summary {
    /// Counts the features of a file.
    ///
    /// # Errors
    /// Fails if the file cannot be read or is not GeoJSON.
    pub(crate) fn read(path: &Path) -> Result<Self, FileError> {
        let failed = |cause: String| FileError::read(path, cause);
        let text = read_text(path, LARGEST_BYTES).map_err(|error| failed(error.to_string()))?;
        let head: Head =
            serde_json::from_str(text.trim_start_matches('\u{feff}')).map_err(|error| failed(not_geojson(&error)))?;
        let mut found = head.features.0;
        match (head.form.as_str(), head.geometry) {
            ("FeatureCollection", _) => {}
            ("Feature", geometry) => found.add(geometry.as_ref(), head.properties.as_ref()),
            (_, _) => found.add(Some(&Geometry { form: head.form }), None),
        }
        found.epsg = match head.crs {
            Some(crs) => epsg_of(&crs.properties.name).map_err(failed)?,
            None => None,
        };
        Ok(found)
    }

    fn add(&mut self, geometry: Option<&Geometry>, properties: Option<&Properties>) {
        *match geometry.map(|geometry| geometry.form.as_str()) {
            Some("LineString" | "MultiLineString") => &mut self.lines,
            Some("Point" | "MultiPoint") => &mut self.points,
            _ => &mut self.others,
        } += 1;
        let Some(Kind::Name(kind)) = properties.and_then(|properties| properties.kind.as_ref()) else { return };
        if let Some(count) = self.kinds.get_mut(kind) {
            *count += 1;
        } else if self.kinds.len() < MOST_KINDS {
            self.kinds.insert(kind.clone(), 1);
        }
    }
}

/// A GeoJSON object of any type, without its coordinates.
#[derive(Deserialize)]
struct Head {
    #[serde(rename = "type")]
    form: String,
    crs: Option<NamedCrs>,
    #[serde(default)]
    features: Features,
    geometry: Option<Geometry>,
    properties: Option<Properties>,
}

#[derive(Deserialize)]
struct NamedCrs {
    properties: CrsName,
}

#[derive(Deserialize)]
struct CrsName {
    name: String,
}

#[derive(Deserialize)]
struct Geometry {
    #[serde(rename = "type")]
    form: String,
}

#[derive(Deserialize)]
struct Properties {
    kind: Option<Kind>,
}

/// The property `kind`, which programs other than hachure may use for anything.
#[derive(Deserialize)]
#[serde(untagged)]
enum Kind {
    Name(String),
    Other(IgnoredAny),
}

#[derive(Deserialize)]
struct FeatureHead {
    geometry: Option<Geometry>,
    properties: Option<Properties>,
}

/// Counts features while they are read, so that none of them is held in memory.
#[derive(Default)]
struct Features(Summary);

impl<'de> Deserialize<'de> for Features {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Counter;
        impl<'de> Visitor<'de> for Counter {
            type Value = Features;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list of features")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut features: A) -> Result<Features, A::Error> {
                let mut found = Summary::default();
                while let Some(FeatureHead { geometry, properties }) = features.next_element()? {
                    found.add(geometry.as_ref(), properties.as_ref());
                }
                Ok(Features(found))
            }

            fn visit_unit<E: Error>(self) -> Result<Features, E> {
                Ok(Features::default())
            }
        }
        deserializer.deserialize_any(Counter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::atomic;

    #[test]
    fn files_of_hachure_begin_with_its_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.geojson");
        let collection = Collection { name: "a".to_owned(), epsg: WGS84, digits: 6, features: Vec::new() };
        assert!(!is_own(&path), "nothing is there");
        write_geojson(&path, &collection).unwrap();
        assert!(is_own(&path));
        let text = read_text(&path, LARGEST_BYTES).unwrap();
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(value["generator"].as_str(), Some(concat!("hachure ", env!("CARGO_PKG_VERSION"))));
        // GDAL writes the members of others after its own.
        let of_gdal = "{\n\"type\": \"FeatureCollection\",\n\"name\": \"a\",\n\"generator\": \"hachure 0.1.0\",\n\"features\": []\n}\n";
        atomic::write(&path, of_gdal.as_bytes()).unwrap();
        assert!(!is_own(&path));
    }
}
