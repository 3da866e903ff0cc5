//! Writes features in all formats.

use std::fmt::Write;
use std::path::Path;

use flatgeobuf::{ColumnType, FgbCrs, FgbWriter, FgbWriterOptions, GeometryType};
use geozero::error::Result;
use geozero::{ColumnValue, GeomProcessor, GeozeroGeometry, PropertyProcessor};
use rusqlite::Connection;

use super::super::{Area, Feature, Geometry, Position, Value};

/// The columns of all samples, with the types of GeoPackage and FlatGeobuf.
const COLUMNS: [(&str, &str, ColumnType); 4] = [
    ("name", "TEXT", ColumnType::String),
    ("ele", "DOUBLE", ColumnType::Double),
    ("climbed", "BOOLEAN", ColumnType::Bool),
    ("class", "TEXT", ColumnType::String),
];

/// Writes positions with a function for each; rings are closed.
fn list(positions: &[Position], is_ring: bool, separator: &str, one: fn(&Position) -> String) -> String {
    let closing = positions.first().filter(|_| is_ring);
    positions.iter().chain(closing).map(one).collect::<Vec<_>>().join(separator)
}

fn rings(area: &Area) -> impl Iterator<Item = &Vec<Position>> {
    std::iter::once(&area.outer).chain(&area.holes)
}

fn json_position([x, y, z]: &Position) -> String {
    if z.is_nan() { format!("[{x},{y}]") } else { format!("[{x}, {y},{z} ]") }
}

/// Returns the type and the coordinates of a geometry.
pub(super) fn json_geometry(geometry: &Geometry) -> String {
    let line = |line: &Vec<Position>| format!("[{}]", list(line, false, ",", json_position));
    let ring = |line: &Vec<Position>| format!("[{}]", list(line, true, ",", json_position));
    let area = |area: &Area| format!("[{}]", rings(area).map(ring).collect::<Vec<_>>().join(","));
    let (kind, coordinates) = match geometry {
        Geometry::Points(points) if points.len() == 1 => ("Point", json_position(&points[0])),
        Geometry::Points(points) => ("MultiPoint", line(points)),
        Geometry::Lines(lines) if lines.len() == 1 => ("LineString", line(&lines[0])),
        Geometry::Lines(lines) => {
            ("MultiLineString", format!("[{}]", lines.iter().map(line).collect::<Vec<_>>().join(",")))
        }
        Geometry::Areas(areas) if areas.len() == 1 => ("Polygon", area(&areas[0])),
        Geometry::Areas(areas) => {
            ("MultiPolygon", format!("[{}]", areas.iter().map(area).collect::<Vec<_>>().join(",")))
        }
    };
    format!("\"type\":\"{kind}\",\"coordinates\":{coordinates}")
}

/// Returns a GeoJSON feature.
pub(super) fn json_feature(feature: &Feature) -> String {
    let mut properties = Vec::new();
    for (name, value) in feature.attributes.iter() {
        let value = match value {
            Value::Text(text) => serde_json::to_string(text).unwrap(),
            Value::Number(number) => number.to_string(),
            Value::Bool(value) => value.to_string(),
            Value::None => "null".to_owned(),
        };
        properties.push(format!("\"{name}\":{value}"));
    }
    let geometry = json_geometry(&feature.geometry);
    format!("{{\"type\":\"Feature\",\"properties\":{{{}}},\"geometry\":{{{geometry}}}}}", properties.join(","))
}

/// Returns a GeoJSON collection.
pub(super) fn geojson(features: &[Feature]) -> String {
    let features: Vec<String> = features.iter().map(json_feature).collect();
    format!("{{\"type\":\"FeatureCollection\",\"features\":[\n{}\n]}}\n", features.join(",\n"))
}

fn wkt_position([x, y, z]: &Position) -> String {
    if z.is_nan() { format!("{x} {y}") } else { format!("{x} {y} {z}") }
}

/// Returns Well-Known Text.
fn wkt(geometry: &Geometry) -> String {
    let line = |line: &Vec<Position>| format!("({})", list(line, false, ", ", wkt_position));
    let ring = |line: &Vec<Position>| format!("({})", list(line, true, ",", wkt_position));
    let area = |area: &Area| format!("({})", rings(area).map(ring).collect::<Vec<_>>().join(", "));
    let is_deep = geometry.positions().next().is_some_and(|[.., z]| !z.is_nan());
    let (kind, body) = match geometry {
        Geometry::Points(points) => ("MULTIPOINT", line(points)),
        Geometry::Lines(lines) => {
            ("MULTILINESTRING", format!("({})", lines.iter().map(line).collect::<Vec<_>>().join(",")))
        }
        Geometry::Areas(areas) => {
            ("MULTIPOLYGON", format!("({})", areas.iter().map(area).collect::<Vec<_>>().join(",")))
        }
    };
    format!("{kind}{} {body}", if is_deep { " Z" } else { "" })
}

/// Returns CSV with a column of Well-Known Text.
pub(super) fn csv(features: &[Feature], separator: char) -> String {
    let field = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let names: Vec<&str> = COLUMNS.iter().map(|(name, ..)| *name).collect();
    let mut text = format!("WKT{separator}{}\r\n", names.join(&separator.to_string()));
    for feature in features {
        text.push_str(&field(&wkt(&feature.geometry)));
        for name in &names {
            let value = feature.attributes.get(name).key().unwrap_or_default();
            write!(text, "{separator}{}", field(&value)).unwrap();
        }
        text.push_str("\r\n");
    }
    text
}

fn wkb_positions(bytes: &mut Vec<u8>, positions: &[Position], is_ring: bool) {
    bytes.extend((positions.len() as u32 + u32::from(is_ring)).to_le_bytes());
    positions.iter().chain(positions.first().filter(|_| is_ring)).for_each(|it| wkb_position(bytes, it));
}

fn wkb_position(bytes: &mut Vec<u8>, [x, y, z]: &Position) {
    for number in [x, y, z].into_iter().filter(|number| !number.is_nan()) {
        bytes.extend(number.to_le_bytes());
    }
}

/// Returns the blob of a GeoPackage.
pub(super) fn blob(geometry: &Geometry) -> Vec<u8> {
    let deep = if geometry.positions().any(|[.., z]| z.is_nan()) { 0 } else { 1000 };
    let mut bytes = b"GP\0\x01\xe6\x10\0\0".to_vec();
    let head = |bytes: &mut Vec<u8>, code: u32| {
        bytes.push(1);
        bytes.extend((code + deep).to_le_bytes());
    };
    let (code, count) = match geometry {
        Geometry::Points(points) => (4, points.len()),
        Geometry::Lines(lines) => (5, lines.len()),
        Geometry::Areas(areas) => (6, areas.len()),
    };
    head(&mut bytes, code);
    bytes.extend((count as u32).to_le_bytes());
    match geometry {
        Geometry::Points(points) => points.iter().for_each(|point| {
            head(&mut bytes, 1);
            wkb_position(&mut bytes, point);
        }),
        Geometry::Lines(lines) => lines.iter().for_each(|line| {
            head(&mut bytes, 2);
            wkb_positions(&mut bytes, line, false);
        }),
        Geometry::Areas(areas) => areas.iter().for_each(|area| {
            head(&mut bytes, 3);
            bytes.extend((1 + area.holes.len() as u32).to_le_bytes());
            rings(area).for_each(|ring| wkb_positions(&mut bytes, ring, true));
        }),
    }
    bytes
}

/// The tables that every GeoPackage has, with two reference systems.
const TABLES: &str = "
    PRAGMA application_id = 0x47504B47; PRAGMA page_size = 1024; PRAGMA synchronous = OFF;
    CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT NOT NULL, srs_id INTEGER PRIMARY KEY, organization TEXT NOT NULL,
        organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL, description TEXT);
    CREATE TABLE gpkg_contents (table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL, identifier TEXT UNIQUE,
        srs_id INTEGER);
    CREATE TABLE gpkg_geometry_columns (table_name TEXT NOT NULL, column_name TEXT NOT NULL,
        geometry_type_name TEXT NOT NULL, srs_id INTEGER NOT NULL, z TINYINT NOT NULL, m TINYINT NOT NULL);
    INSERT INTO gpkg_spatial_ref_sys VALUES ('WGS 84', 4326, 'EPSG', 4326, 'GEOGCS[\"WGS 84\"]', NULL),
        ('own', 100000, 'NONE', 1, 'PROJCS[\"own\"]', NULL), ('undefined', -1, 'NONE', -1, 'undefined', NULL);
";

/// Creates a GeoPackage without features.
pub(super) fn empty_geopackage(path: &Path) -> Connection {
    let connection = Connection::open(path).unwrap();
    connection.execute_batch(TABLES).unwrap();
    connection
}

/// Adds a table of features to a GeoPackage.
pub(super) fn add_table(connection: &Connection, name: &str, srs_id: i32, features: &[Feature]) {
    let columns: Vec<String> = COLUMNS.iter().map(|(name, kind, _)| format!("\"{name}\" {kind}")).collect();
    let columns = columns.join(", ");
    let quoted = name.replace('"', "\"\"");
    let sql = format!("CREATE TABLE \"{quoted}\" (fid INTEGER PRIMARY KEY, \"the geom\" BLOB, {columns})");
    connection.execute_batch(&sql).unwrap();
    connection.execute("INSERT INTO gpkg_contents VALUES (?1, 'features', ?1, ?2)", (name, srs_id)).unwrap();
    let sql = "INSERT INTO gpkg_geometry_columns VALUES (?1, 'the geom', 'GEOMETRY', ?2, 2, 0)";
    connection.execute(sql, (name, srs_id)).unwrap();
    for feature in features {
        let sql = format!("INSERT INTO \"{quoted}\" VALUES (NULL, ?1, ?2, ?3, ?4, ?5)");
        let text = |name| match feature.attributes.get(name) {
            Value::Text(text) => Some(text.clone()),
            _ => None,
        };
        let number = match feature.attributes.get("ele") {
            Value::Number(number) => Some(*number),
            _ => None,
        };
        let climbed = match feature.attributes.get("climbed") {
            Value::Bool(value) => Some(*value),
            _ => None,
        };
        connection.execute(&sql, (blob(&feature.geometry), text("name"), number, climbed, text("class"))).unwrap();
    }
}

/// Creates a GeoPackage with one table.
pub(super) fn geopackage(path: &Path, features: &[Feature]) {
    add_table(&empty_geopackage(path), "samples", 4326, features);
}

struct Geozero<'a>(&'a Geometry);

impl Geozero<'_> {
    fn position<P: GeomProcessor>(processor: &mut P, [x, y, z]: &Position, index: usize) -> Result<()> {
        match processor.multi_dim() {
            true => processor.coordinate(*x, *y, Some(*z).filter(|z| !z.is_nan()), None, None, None, index),
            false => processor.xy(*x, *y, index),
        }
    }

    fn area<P: GeomProcessor>(processor: &mut P, area: &Area, index: usize) -> Result<()> {
        processor.polygon_begin(false, 1 + area.holes.len(), index)?;
        for (number, ring) in rings(area).enumerate() {
            processor.linestring_begin(false, ring.len() + 1, number)?;
            for (index, position) in ring.iter().chain(ring.first()).enumerate() {
                Self::position(processor, position, index)?;
            }
            processor.linestring_end(false, number)?;
        }
        processor.polygon_end(false, index)
    }
}

impl GeozeroGeometry for Geozero<'_> {
    fn process_geom<P: GeomProcessor>(&self, processor: &mut P) -> Result<()> {
        match self.0 {
            Geometry::Points(points) => {
                processor.multipoint_begin(points.len(), 0)?;
                for (index, point) in points.iter().enumerate() {
                    Self::position(processor, point, index)?;
                }
                processor.multipoint_end(0)
            }
            Geometry::Lines(lines) => {
                processor.multilinestring_begin(lines.len(), 0)?;
                for (number, line) in lines.iter().enumerate() {
                    processor.linestring_begin(false, line.len(), number)?;
                    for (index, position) in line.iter().enumerate() {
                        Self::position(processor, position, index)?;
                    }
                    processor.linestring_end(false, number)?;
                }
                processor.multilinestring_end(0)
            }
            Geometry::Areas(areas) => {
                processor.multipolygon_begin(areas.len(), 0)?;
                areas.iter().enumerate().try_for_each(|(index, area)| Self::area(processor, area, index))?;
                processor.multipolygon_end(0)
            }
        }
    }
}

/// Returns a FlatGeobuf file. With an index, its writer sorts the features.
pub(super) fn flatgeobuf(features: &[Feature], has_z: bool, has_index: bool) -> Vec<u8> {
    let options = FgbWriterOptions {
        write_index: has_index,
        detect_type: false,
        promote_to_multi: false,
        has_z,
        crs: FgbCrs { code: 4326, org: Some("EPSG"), ..Default::default() },
        ..Default::default()
    };
    let mut writer = FgbWriter::create_with_options("samples", GeometryType::Unknown, options).unwrap();
    COLUMNS.iter().for_each(|(name, _, kind)| writer.add_column(name, *kind, |_, _| {}));
    for feature in features {
        let values = COLUMNS.iter().enumerate().filter_map(|(index, (name, ..))| {
            let value = match feature.attributes.get(name) {
                Value::Text(text) => ColumnValue::String(text),
                Value::Number(number) => ColumnValue::Double(*number),
                Value::Bool(value) => ColumnValue::Bool(*value),
                Value::None => return None,
            };
            Some((index, name, value))
        });
        let geometry = Geozero(&feature.geometry);
        let add = writer.add_feature_geom(geometry, |writer| {
            values.for_each(|(index, name, value)| assert!(!writer.property(index, name, &value).unwrap()));
        });
        add.unwrap();
    }
    let mut bytes = Vec::new();
    writer.write(&mut bytes).unwrap();
    bytes
}

/// Returns GPX with the features that are points or lines, and their names and heights.
pub(super) fn gpx(features: &[Feature]) -> String {
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<gpx version=\"1.1\" creator=\"x\">\n");
    let escaped = |text: &str| text.replace('&', "&amp;").replace('<', "&lt;");
    let point = |tag: &str, [x, y, z]: &Position, more: &str| {
        let height = if z.is_nan() { String::new() } else { format!("<ele>{z}</ele>") };
        format!("<{tag} lat=\"{y}\" lon='{x}'>{height}{more}</{tag}>\n")
    };
    for feature in features {
        let name = match feature.attributes.get("name") {
            Value::Text(name) => format!("<name>{}</name>", escaped(name)),
            _ => String::new(),
        };
        match &feature.geometry {
            Geometry::Points(points) => points.iter().for_each(|it| text.push_str(&point("wpt", it, &name))),
            Geometry::Lines(lines) => {
                let segment = |line: &Vec<Position>| line.iter().map(|it| point("trkpt", it, "")).collect::<String>();
                let segments = lines.iter().map(|line| format!("<trkseg>{}</trkseg>", segment(line)));
                writeln!(text, "<trk>{name}{}</trk>", segments.collect::<String>()).unwrap();
            }
            Geometry::Areas(_) => {}
        }
    }
    text + "</gpx>\n"
}
