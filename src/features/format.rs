//! Recognises the format of a file of features.

use std::io::Read;
use std::path::Path;

use super::error::Cause;
use crate::file::input::open_regular;

/// Number of bytes at the beginning of a file that are looked at.
const HEAD_BYTES: u64 = 1 << 16;
/// Number of bytes within which the first element of an XML file begins.
const XML_BYTES: usize = 1 << 14;

/// A file format of features.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Format {
    GeoJson,
    Gpx,
    /// CSV with commas, semicolons or tabs.
    Delimited,
    GeoPackage,
    FlatGeobuf,
}

/// Beginnings of formats that are not read, with what they are.
const FOREIGN: [(&[u8], &str); 9] = [
    (b"\x00\x00\x27\x0a", "is a shapefile; convert it with ogr2ogr OUT.gpkg IN.shp"),
    (b"PK\x03\x04", "is a ZIP archive; unpack it"),
    (b"\x1f\x8b", "is compressed with gzip; unpack it with gunzip"),
    (b"\xff\xfe", "is UTF-16 text; save it as UTF-8"),
    (b"\xfe\xff", "is UTF-16 text; save it as UTF-8"),
    (b"\x89PNG", "is a PNG picture"),
    (b"II*\x00", "is a TIFF picture"),
    (b"PAR1", "is a Parquet file; convert it with ogr2ogr OUT.gpkg IN.parquet"),
    (b"%PDF", "is a PDF document"),
];

/// Returns the format of a file, and its beginning without a byte order mark.
pub(super) fn recognise(path: &Path) -> Result<(Format, Vec<u8>), Cause> {
    let mut head = Vec::new();
    let mut file = open_regular(path)?;
    let bytes = file.metadata()?.len();
    file.by_ref().take(HEAD_BYTES).read_to_end(&mut head)?;
    if head.starts_with(b"\xef\xbb\xbf") {
        head.drain(..3);
    }
    if head.iter().all(|byte| byte.is_ascii_whitespace()) {
        return Err(if bytes <= HEAD_BYTES { Cause::Empty } else { unknown("begins with blanks only") });
    }
    by_content(&head, &ending(path)).map(|format| (format, head))
}

fn unknown(looks_like: &str) -> Cause {
    Cause::UnknownFormat(looks_like.to_owned())
}

fn ending(path: &Path) -> String {
    path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

fn by_content(head: &[u8], ending: &str) -> Result<Format, Cause> {
    if head.starts_with(b"SQLite format 3\0") {
        return Ok(Format::GeoPackage);
    }
    if head.starts_with(b"fgb") && head.get(4..7) == Some(b"fgb") {
        return Ok(Format::FlatGeobuf);
    }
    if let Some((_, what)) = FOREIGN.iter().find(|(beginning, _)| head.starts_with(beginning)) {
        return Err(unknown(what));
    }
    let text = head.trim_ascii_start();
    match text.first() {
        // A record separator begins each object of a GeoJSON text sequence (RFC 8142).
        Some(b'{' | 0x1e) => return Ok(Format::GeoJson),
        Some(b'[') => return Err(unknown("is a JSON list, not a GeoJSON object")),
        Some(b'<') => return xml(text),
        _ => {}
    }
    match ending {
        "geojson" | "json" | "geojsonl" | "ndjson" | "geojsons" => Err(unknown("is not GeoJSON, which begins with {")),
        "gpx" => Err(unknown("is not GPX, which begins with <")),
        "gpkg" => Err(unknown("is not a GeoPackage, which begins with \"SQLite format 3\"")),
        "fgb" => Err(unknown("is not FlatGeobuf, which begins with \"fgb\"")),
        _ if head.contains(&0) => Err(unknown("has an unknown format")),
        _ => Ok(Format::Delimited),
    }
}

/// Returns the format of an XML file by its first element.
fn xml(text: &[u8]) -> Result<Format, Cause> {
    let text = text.get(..XML_BYTES).unwrap_or(text);
    let mut rest = text;
    while let Some(begin) = rest.iter().position(|byte| *byte == b'<') {
        rest = rest.get(begin + 1..).unwrap_or_default();
        // Comments may contain anything.
        if rest.starts_with(b"!--") {
            let end = rest.windows(3).position(|window| window == b"-->").unwrap_or(rest.len());
            rest = rest.get(end..).unwrap_or_default();
        } else if rest.first().is_some_and(|byte| byte.is_ascii_alphabetic()) {
            let end = rest.iter().position(|byte| !(byte.is_ascii_alphanumeric() || b":_-.".contains(byte)));
            let name = rest.get(..end.unwrap_or(rest.len())).unwrap_or_default();
            let name = name.rsplit(|byte| *byte == b':').next().unwrap_or_default();
            return match name {
                b"gpx" => Ok(Format::Gpx),
                b"kml" => Err(unknown("is a KML file; convert it with ogr2ogr OUT.gpkg IN.kml")),
                b"osm" => Err(unknown("is a file of OpenStreetMap; convert it with ogr2ogr OUT.gpkg IN.osm")),
                b"html" => Err(unknown("is a web page; perhaps a download failed")),
                _ => Err(unknown("is XML, but not GPX")),
            };
        }
    }
    Err(unknown("is XML, but not GPX"))
}
