//! Reads the polygons of GeoJSON files (RFC 7946, and `crs` of its draft of 2008, which GDAL and QGIS write).

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::input::read_text;
use super::message::{named, printable};

/// Largest file that is read, in bytes; outlines of water are smaller.
pub(crate) const LARGEST_BYTES: u64 = 256 << 20;
/// Largest nesting depth of collections.
const DEEPEST: usize = 8;

/// The reason why a file has no usable polygons. One line that names the file.
#[derive(Debug, thiserror::Error)]
pub enum PolygonsError {
    /// The file cannot be read.
    #[error("cannot read {}: {cause}", named(path))]
    Read {
        path: PathBuf,
        #[source]
        cause: std::io::Error,
    },
    /// The file is not GeoJSON, or has no polygons.
    #[error("{}: {cause}", named(path))]
    Content { path: PathBuf, cause: String },
}

/// The vertices of an outline or of a hole.
pub(crate) type Ring = Vec<[f64; 2]>;

/// Polygons and the reference system of their coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Polygons {
    /// EPSG code of the reference system; `None` is longitude and latitude on WGS 84.
    pub epsg: Option<u16>,
    /// The rings of each polygon, in that system, without the last vertex, which repeats the first. A point within an
    /// odd number of a polygon's rings is inside the polygon: holes are ordinary rings, and rings may cross themselves.
    pub polygons: Vec<Vec<Ring>>,
}

impl Polygons {
    /// Reads a file.
    ///
    /// # Errors
    /// Returns [`PolygonsError`] if the file is not JSON, has no polygon, has a coordinate that is not a finite number,
    /// or has an unknown reference system.
    pub(crate) fn read(path: &Path) -> Result<Self, PolygonsError> {
        let text =
            read_text(path, LARGEST_BYTES).map_err(|cause| PolygonsError::Read { path: path.to_owned(), cause })?;
        Self::parse(&text).map_err(|cause| PolygonsError::Content { path: path.to_owned(), cause })
    }

    /// Parses GeoJSON text.
    ///
    /// # Errors
    /// Returns the cause in one line.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let value: Value = serde_json::from_str(text)
            .map_err(|error| format!("it is not GeoJSON: {}", printable(&error.to_string(), 120)))?;
        let mut polygons = Self { epsg: epsg_of(&value)?, polygons: Vec::new() };
        polygons.add(&value, 0)?;
        if polygons.polygons.is_empty() {
            return Err("it has no polygons".to_owned());
        }
        Ok(polygons)
    }

    /// Adds the polygons of a GeoJSON object.
    fn add(&mut self, value: &Value, depth: usize) -> Result<(), String> {
        if depth > DEEPEST {
            return Err(format!("its collections are nested more than {DEEPEST} deep"));
        }
        let list = |key: &str| value.get(key).and_then(Value::as_array).map(Vec::as_slice);
        match value.get("type").and_then(Value::as_str) {
            Some("FeatureCollection") => {
                let features = list("features").ok_or("its collection has no features")?;
                features.iter().try_for_each(|feature| self.add(feature, depth + 1))
            }
            Some("GeometryCollection") => {
                let geometries = list("geometries").ok_or("its collection has no geometries")?;
                geometries.iter().try_for_each(|geometry| self.add(geometry, depth + 1))
            }
            Some("Feature") => match value.get("geometry") {
                None | Some(Value::Null) => Ok(()),
                Some(geometry) => self.add(geometry, depth + 1),
            },
            Some("Polygon") => self.polygon(value.get("coordinates")),
            Some("MultiPolygon") => {
                let polygons = list("coordinates").ok_or("a MultiPolygon has no coordinates")?;
                polygons.iter().try_for_each(|polygon| self.polygon(Some(polygon)))
            }
            // Lines and points have no interior.
            Some("Point" | "MultiPoint" | "LineString" | "MultiLineString") => Ok(()),
            _ => Err("it is not GeoJSON: an object has no known type".to_owned()),
        }
    }

    fn polygon(&mut self, rings: Option<&Value>) -> Result<(), String> {
        let number = self.polygons.len() + 1;
        let mut polygon = Vec::new();
        let wrong = |cause: &str| format!("polygon {number}: {cause}");
        let rings = rings.and_then(Value::as_array).ok_or_else(|| wrong("it has no list of rings"))?;
        for ring in rings {
            let places = ring.as_array().ok_or_else(|| wrong("a ring is not a list of positions"))?;
            let place = |place: &Value| {
                let [x, y] = [0, 1].map(|axis| place.get(axis).and_then(Value::as_f64).filter(|c| c.is_finite()));
                x.zip(y).map(|(x, y)| [x, y]).ok_or_else(|| wrong("a position is not a pair of finite numbers"))
            };
            let mut places = places.iter().map(place).collect::<Result<Vec<_>, _>>()?;
            if places.len() > 1 && places.first() == places.last() {
                places.pop();
            }
            if places.len() < 3 {
                return Err(wrong("a ring has fewer than three positions"));
            }
            polygon.push(places);
        }
        self.polygons.push(polygon);
        Ok(())
    }
}

/// Returns the EPSG code of the member `crs`; `None` is WGS 84.
fn epsg_of(value: &Value) -> Result<Option<u16>, String> {
    let Some(crs) = value.get("crs").filter(|crs| !crs.is_null()) else { return Ok(None) };
    let name = crs.pointer("/properties/name").and_then(Value::as_str).ok_or("its crs has no name")?;
    if name.ends_with("CRS84") {
        return Ok(None);
    }
    let code = name.to_ascii_uppercase().contains("EPSG").then(|| name.rsplit(':').next()?.parse().ok()).flatten();
    match code {
        // GeoJSON has longitudes first, also under this code.
        Some(4326) => Ok(None),
        Some(code) => Ok(Some(code)),
        None => Err(format!("its crs {} is not known", printable(name, 60))),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    const SQUARE: &str = "[[[0,0],[1,0],[1,1],[0,1],[0,0]],[[0.2,0.2],[0.4,0.2],[0.4,0.4],[0.2,0.2]]]";

    #[test]
    fn polygons_are_found_wherever_they_lie() {
        let polygon = format!("{{\"type\":\"Polygon\",\"coordinates\":{SQUARE}}}");
        let parsed = Polygons::parse(&polygon).unwrap();
        let rings: Vec<usize> = parsed.polygons[0].iter().map(Vec::len).collect();
        assert_eq!((parsed.epsg, parsed.polygons.len(), rings), (None, 1, vec![4, 3]));
        let feature = format!("{{\"type\":\"Feature\",\"properties\":null,\"geometry\":{polygon}}}");
        let several = format!("{{\"type\":\"MultiPolygon\",\"coordinates\":[{SQUARE},{SQUARE}]}}");
        let all = format!(
            "{{\"type\":\"FeatureCollection\",\"crs\":{{\"type\":\"name\",\"properties\":{{\"name\":\
             \"urn:ogc:def:crs:EPSG::32632\"}}}},\"features\":[{feature},{{\"type\":\"Feature\",\"geometry\":{several}}},\
             {{\"type\":\"Feature\",\"geometry\":null}}]}}"
        );
        let parsed = Polygons::parse(&all).unwrap();
        assert_eq!((parsed.epsg, parsed.polygons.len()), (Some(32632), 3));
    }

    #[test]
    fn errors_are_one_line() {
        let ring = |places: &str| format!("{{\"type\":\"Polygon\",\"coordinates\":[[{places}]]}}");
        let crs = |name: &str| {
            format!(
                "{{\"crs\":{{\"properties\":{{\"name\":\"{name}\"}}}},\"type\":\"Polygon\",\"coordinates\":{SQUARE}}}"
            )
        };
        for (text, expected) in [
            ("".to_owned(), "it is not GeoJSON"),
            ("[1]".to_owned(), "no known type"),
            ("{\"type\":\"FeatureCollection\",\"features\":[]}".to_owned(), "it has no polygons"),
            ("{\"type\":\"FeatureCollection\"}".to_owned(), "no features"),
            (ring("[0,0],[1,0]"), "polygon 1: a ring has fewer than three positions"),
            (ring("[0,0],[1,null],[1,1]"), "polygon 1: a position is not a pair of finite numbers"),
            (ring("[0,0],[1,NaN],[1,1]"), "it is not GeoJSON"),
            (ring("[0,0],[1e999,1],[1,1]"), "it is not GeoJSON"),
            (crs("local"), "its crs local is not known"),
        ] {
            let error = Polygons::parse(&text).unwrap_err();
            assert!(error.contains(expected) && !error.contains('\n') && error.len() < 200, "{error}");
        }
    }
}
