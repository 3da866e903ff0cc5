//! Reads the polygons of GeoJSON files (RFC 7946, and `crs` of its draft of 2008, which GDAL and QGIS write).
//!
//! The text is read in one pass, and only positions are stored, 16 bytes each: a tree of JSON values would take a
//! hundred bytes for each number of a hostile file, and thirty for each member that no polygon has.

mod reader;

use std::path::{Path, PathBuf};

use serde::de::DeserializeSeed;

use self::reader::{Found, Object};
use super::input::read_text;
use super::message::{named, printable};

/// Largest file that is read, in bytes; outlines of water are smaller.
pub(crate) const LARGEST_BYTES: u64 = 256 << 20;
/// The cause for a file without polygons.
pub(crate) const NO_POLYGONS: &str = "GeoJSON without polygons; --water needs polygons";
/// Largest number of positions; a file of [`LARGEST_BYTES`] with the usual digits has half as many.
const MAX_PLACES: usize = 1 << 24;

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
    Content {
        path: PathBuf,
        /// The defect of the text.
        cause: String,
    },
}

/// Polygons and the reference system of their coordinates.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Polygons {
    /// EPSG code of the reference system; `None` is longitude and latitude on WGS 84.
    pub epsg: Option<u16>,
    /// The vertices of all rings, in that system, without the last vertex of a ring, which repeats the first.
    places: Vec<[f64; 2]>,
    /// The end of each ring among the vertices.
    ring_ends: Vec<u32>,
    /// The end of each polygon among the rings.
    polygon_ends: Vec<u32>,
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
        Self::parse_some(text, MAX_PLACES)
    }

    /// Returns the vertices of all rings.
    pub(crate) fn vertices(&self) -> &[[f64; 2]] {
        &self.places
    }

    /// Parses text with at most `most_places` positions.
    fn parse_some(text: &str, most_places: usize) -> Result<Self, String> {
        let mut found = Found { polygons: Self::default(), most_places, crs: None, failure: None };
        let mut json = serde_json::Deserializer::from_str(text.trim_start_matches('\u{feff}'));
        let read = Object { found: &mut found, depth: 0 }.deserialize(&mut json).and_then(|()| json.end());
        if let Some(cause) = found.failure {
            return Err(cause);
        }
        read.map_err(|error| not_geojson(&error))?;
        found.polygons.epsg = found.crs.map_or(Ok(None), |crs| epsg_of(&crs))?;
        match found.polygons.polygon_ends.is_empty() {
            true => Err(NO_POLYGONS.to_owned()),
            false => Ok(found.polygons),
        }
    }

    /// Returns the number of polygons.
    pub(crate) fn count(&self) -> usize {
        self.polygon_ends.len()
    }

    /// Returns all vertices, to be replaced by those in another system.
    pub(crate) fn places_mut(&mut self) -> &mut [[f64; 2]] {
        &mut self.places
    }

    /// Returns the rings of each polygon. A point within an odd number of a polygon's rings is inside the polygon:
    /// holes are ordinary rings, and rings may cross themselves.
    pub(crate) fn polygons(&self) -> impl Iterator<Item = Rings<'_>> {
        (0..self.count()).map(|number| Rings { polygons: self, number })
    }
}

/// The rings of one polygon.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rings<'a> {
    polygons: &'a Polygons,
    number: usize,
}

/// Returns where an entry begins and ends, of a list of ends.
fn span(ends: &[u32], number: usize) -> std::ops::Range<usize> {
    let begin = number.checked_sub(1).map_or(0, |before| ends[before]);
    begin as usize..ends[number] as usize
}

impl<'a> Rings<'a> {
    /// Returns the vertices of each ring.
    pub(crate) fn rings(self) -> impl Iterator<Item = &'a [[f64; 2]]> {
        let Polygons { places, ring_ends, polygon_ends, .. } = self.polygons;
        span(polygon_ends, self.number).map(|ring| &places[span(ring_ends, ring)])
    }

    /// Returns the vertices of all rings.
    pub(crate) fn places(self) -> impl Iterator<Item = &'a [f64; 2]> {
        self.rings().flatten()
    }
}

/// Returns what is wrong with a text that is not GeoJSON, in one line.
pub(super) fn not_geojson(error: &serde_json::Error) -> String {
    let text = error.to_string();
    if error.is_eof() && !text.starts_with("EOF while parsing a value at line 1 column 0") {
        let what = text.strip_prefix("EOF while parsing ").and_then(|rest| rest.split(" at line").next());
        let what = what.unwrap_or("a value");
        return format!(
            "it is not GeoJSON: the file ends within {what} (line {}, column {})",
            error.line(),
            error.column()
        );
    }
    format!("it is not GeoJSON: {}", printable(&text, 120))
}

/// Returns the EPSG code of the name of a reference system; `None` is WGS 84.
pub(super) fn epsg_of(name: &str) -> Result<Option<u16>, String> {
    if name.is_empty() {
        return Err("its crs has no name".to_owned());
    }
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
        let rings: Vec<usize> = parsed.polygons().flat_map(Rings::rings).map(<[_]>::len).collect();
        assert_eq!((parsed.epsg, parsed.count(), rings), (None, 1, vec![4, 3]));
        let feature = format!("{{\"type\":\"Feature\",\"properties\":null,\"geometry\":{polygon}}}");
        let several = format!("{{\"type\":\"MultiPolygon\",\"coordinates\":[{SQUARE},{SQUARE}]}}");
        let all = format!(
            "{{\"type\":\"FeatureCollection\",\"crs\":{{\"type\":\"name\",\"properties\":{{\"name\":\
             \"urn:ogc:def:crs:EPSG::32632\"}}}},\"features\":[{feature},{{\"type\":\"Feature\",\"geometry\":{several}}},\
             {{\"type\":\"Feature\",\"geometry\":null}}]}}"
        );
        let parsed = Polygons::parse(&all).unwrap();
        assert_eq!((parsed.epsg, parsed.count()), (Some(32632), 3));
        // Members may come in any order, a type last; lines between polygons leave nothing behind.
        let line = "{\"coordinates\":[[5,5],[6,6]],\"type\":\"LineString\"}";
        let turned = format!("{{\"coordinates\":{SQUARE},\"bbox\":[0,0,1,1],\"type\":\"Polygon\"}}");
        let several = format!("{{\"geometries\":[{line},{turned},{line}],\"type\":\"GeometryCollection\"}}");
        assert_eq!(Polygons::parse(&several).unwrap(), Polygons::parse(&polygon).unwrap());
        // Other members may be anything.
        let other = format!("\u{feff}{{\"x\":[{{\"coordinates\":0}}],{}", &turned[1..]);
        assert_eq!(Polygons::parse(&other).unwrap(), Polygons::parse(&polygon).unwrap());
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
            ("[1]".to_owned(), "expected an object of a known type"),
            ("{\"type\":[1]}".to_owned(), "no known type"),
            ("{\"type\":\"Polygon\"}".to_owned(), "polygon 1: it has no list of rings"),
            ("{\"type\":\"Polygon\",\"coordinates\":[[0,0],[1,0],[1,1]]}".to_owned(), "it has no list of rings"),
            ("{\"type\":\"Polygon\",\"coordinates\":[[]]}".to_owned(), "fewer than three positions"),
            ("{\"type\":\"Polygon\",\"coordinates\":[],\"features\":[]}".to_owned(), "members of two types"),
            (format!("{{\"type\":\"MultiPolygon\",\"coordinates\":{SQUARE}}}"), "it has no list of rings"),
            (ring("[0,0],[1,0],1"), "a ring is not a list of positions"),
            ("{\"type\":\"FeatureCollection\",\"features\":[]}".to_owned(), "GeoJSON without polygons"),
            ("{\"type\":\"Feat".to_owned(), "the file ends within a string (line 1, column 13)"),
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

    #[test]
    fn memory_is_that_of_the_positions() {
        let ring = |places: usize| {
            let places: Vec<String> = (0..places).map(|i| format!("[{i},{}]", i % 2)).collect();
            format!("{{\"type\":\"Polygon\",\"coordinates\":[[{}]]}}", places.join(","))
        };
        assert_eq!(Polygons::parse_some(&ring(50), 50).unwrap().places.len(), 50);
        let error = Polygons::parse_some(&ring(51), 50).unwrap_err();
        assert!(error.contains("more than 50 positions"), "{error}");
        // Content other than polygons takes no room, however much of it there is.
        let lines = format!("{{\"type\":\"LineString\",\"coordinates\":[{}[0,0]]}}", "[0,0],".repeat(40));
        let all = format!("{{\"type\":\"GeometryCollection\",\"geometries\":[{lines},{lines},{}]}}", ring(40));
        assert_eq!(Polygons::parse_some(&all, 50).unwrap().places.len(), 40);
        let nested = format!("{}1{}", "[".repeat(1 << 20), "]".repeat(1 << 20));
        let error = Polygons::parse(&format!("{{\"x\":{nested}}}")).unwrap_err();
        assert!(error.contains("not GeoJSON"), "{error}");
    }
}
