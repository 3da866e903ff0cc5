//! `hachure info` for files of features: GPX, GeoPackage, FlatGeobuf, CSV with coordinates, one GeoJSON object per line.

use std::fmt::Write as _;
use std::path::Path;

use serde::Serialize;

use crate::features::{self, Choice, CrsOrigin, Summary};
use crate::file::message::{counted, printable};

/// Largest number of layers and of attributes that the text lists.
const MAX_LISTED: usize = 20;
/// Largest number of characters of a name that the text shows.
const MAX_NAME: usize = 60;

/// The contents of a file of features.
#[derive(Serialize)]
pub(super) struct LayersInfo {
    format: &'static str,
    /// `EPSG:n` or Well-Known Text; absent if nothing gives the reference system.
    crs: Option<String>,
    /// Whether the reference system is assumed, because columns are called longitude and latitude.
    is_assumed: bool,
    layers: Vec<LayerInfo>,
    /// Lowest x and y, highest x and y, in units of the reference system; absent without features.
    bounds: Option<[f64; 4]>,
    attributes: Vec<AttributeInfo>,
    left_out: Vec<LeftOutInfo>,
}

#[derive(Serialize)]
struct LayerInfo {
    name: String,
    features: u64,
}

/// An attribute, and how many features have a value of each kind.
#[derive(Serialize)]
struct AttributeInfo {
    name: String,
    texts: u64,
    numbers: u64,
    bools: u64,
}

#[derive(Serialize)]
struct LeftOutInfo {
    why: String,
    features: u64,
    /// Points, lines or rings of features of which something is left.
    parts: u64,
    /// The line, feature, row or element of the first of them, from 1.
    first: String,
}

/// Returns whether the beginning of a file is that of a GPX file, a GeoPackage or a FlatGeobuf file.
pub(super) fn is_likely(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(&head[..head.len().min(4096)]);
    head.starts_with(b"SQLite format 3\0") || head.starts_with(b"fgb") || text.contains("<gpx")
}

/// Reads a file of features.
///
/// # Errors
/// The file is damaged or has none of the formats.
pub(super) fn read(file: &Path) -> anyhow::Result<LayersInfo> {
    let summary = match features::survey(file, &Choice::default()) {
        // A GeoPackage with several layers.
        Err(error) if !error.layers().is_empty() => {
            let mut all = Summary::default();
            for layer in error.layers() {
                let found = features::survey(file, &Choice { layer: Some(layer.clone()) })?;
                all.merge(found);
            }
            all
        }
        found => found?,
    };
    let layers = summary.layers.iter().map(layer_info).collect();
    let attributes = summary.attributes.iter().map(|attribute| AttributeInfo {
        name: attribute.name.to_string(),
        texts: attribute.texts,
        numbers: attribute.numbers,
        bools: attribute.bools,
    });
    let left_out = summary.skipped.iter().map(|skipped| LeftOutInfo {
        why: skipped.reason.to_string(),
        features: skipped.features,
        parts: skipped.parts,
        first: format!("{} {}", summary.record_noun, skipped.first),
    });
    Ok(LayersInfo {
        format: summary.format,
        is_assumed: summary.crs.as_ref().is_some_and(|crs| crs.origin == CrsOrigin::Assumed),
        bounds: summary.bounds.map(|bounds| [bounds.min[0], bounds.min[1], bounds.max[0], bounds.max[1]]),
        attributes: attributes.collect(),
        left_out: left_out.collect(),
        crs: summary.crs.map(|crs| crs.text),
        layers,
    })
}

fn layer_info(layer: &features::Layer) -> LayerInfo {
    LayerInfo { name: layer.name.clone(), features: layer.features }
}

impl LayersInfo {
    pub(super) fn text(&self, file: &str) -> String {
        let count = self.layers.iter().map(|layer| layer.features).sum::<u64>();
        let mut text = format!("{file}: {} of {}\n", self.format, counted(count, "feature"));
        for LayerInfo { name, features } in self.layers.iter().take(MAX_LISTED) {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "layer     {}, {}", printable(name, MAX_NAME), counted(*features, "feature"));
        }
        let more = self.layers.len().saturating_sub(MAX_LISTED);
        if more > 0 {
            let _ = writeln!(text, "layer     {more} more, not listed");
        }
        let assumed = if self.is_assumed { ", assumed" } else { "" };
        let place = self.crs.as_ref().map_or("not stated; --names takes that of the heights".to_owned(), |crs| {
            format!("{}{assumed}", printable(crs, 80))
        });
        let extent = self.bounds.map(|[x0, y0, x1, y1]| format!(", x {x0} to {x1}, y {y0} to {y1}"));
        let _ = writeln!(text, "place     {place}{}", extent.unwrap_or_default());
        for attribute in self.attributes.iter().take(MAX_LISTED) {
            let AttributeInfo { name, texts, numbers, bools } = attribute;
            let kinds = [(texts, "text"), (numbers, "number"), (bools, "boolean")];
            let kinds = kinds.iter().filter(|(count, _)| **count > 0).map(|(count, kind)| counted(**count, kind));
            let kinds: Vec<String> = kinds.collect();
            let _ = writeln!(text, "attribute {}: {}", printable(name, MAX_NAME), kinds.join(", "));
        }
        let more = self.attributes.len().saturating_sub(MAX_LISTED);
        if more > 0 {
            let _ = writeln!(text, "attribute {more} more, not listed");
        }
        for LeftOutInfo { why, features, parts, first } in &self.left_out {
            let what = match (features, parts) {
                (features, 0) => counted(*features, "feature"),
                (0, parts) => counted(*parts, "part"),
                (features, parts) => format!("{} and {}", counted(*features, "feature"), counted(*parts, "part")),
            };
            let _ = writeln!(text, "left out  {what}: {why} (first: {first})");
        }
        text
    }
}

/// Returns whether the name of a file ends like that of a file of features.
pub(super) fn of_ending(file: &Path) -> bool {
    let endings = ["gpx", "gpkg", "fgb", "geojsonl", "geojsons", "geojsonseq", "ndjson"];
    file.extension().is_some_and(|own| endings.iter().any(|ending| own.eq_ignore_ascii_case(ending)))
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;

    #[test]
    fn a_file_is_described_by_its_layers_and_attributes() {
        let mut file = tempfile::Builder::new().suffix(".gpx").tempfile().unwrap();
        let text = "<gpx version=\"1.1\" xmlns=\"http://www.topografix.com/GPX/1/1\"><wpt lat=\"46.5\" lon=\"8\">\
                    <ele>1200</ele><name>Hut</name></wpt><trk><name>Way</name><trkseg><trkpt lat=\"46\" lon=\"8\"/>\
                    <trkpt lat=\"46.5\" lon=\"8.25\"/></trkseg></trk></gpx>";
        file.write_all(text.as_bytes()).unwrap();
        assert!(is_likely(text.as_bytes()) && of_ending(file.path()) && !is_likely(b"lon,lat\n1,2\n"));
        let text = read(file.path()).unwrap().text("a.gpx");
        for line in ["layer     waypoints, 1 feature", "layer     tracks, 1 feature", "attribute name: 2 texts"] {
            assert!(text.lines().any(|own| own == line), "{line} in {text}");
        }
        assert!(text.contains("place     EPSG:4326, x 8 to 8.25, y 46 to 46.5"), "{text}");
    }
}
