//! Reads FlatGeobuf version 3: a header with the columns and the reference system, an index that is skipped, and the
//! features one after the other. <https://flatgeobuf.org>
//!
//! The crate `flatgeobuf` is not used, because it panics on damaged files and allocates what they ask for; the tests use
//! it to write files.

mod geometry;
mod properties;

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use self::properties::Column;
use super::bounded::FEATURE_BYTES;
use super::error::Cause;
use super::flat_tables::{Buffer, Table};
use super::shapes::Shapes;
use super::sink::Sink;
use super::summary::{Crs, CrsOrigin, Reason};
use super::{check_only_layer, stem};
use crate::file::input::open_regular;

/// Largest header in bytes.
const HEADER_BYTES: u64 = 16 << 20;
/// Bytes of a node of the index: four coordinates and an offset.
const NODE_BYTES: u64 = 40;

/// Numbers of the fields of the tables.
mod field {
    pub(super) mod header {
        pub(in super::super) const NAME: usize = 0;
        pub(in super::super) const GEOMETRY_TYPE: usize = 2;
        pub(in super::super) const COLUMNS: usize = 7;
        pub(in super::super) const FEATURES: usize = 8;
        pub(in super::super) const NODE_SIZE: usize = 9;
        pub(in super::super) const CRS: usize = 10;
    }
    pub(super) mod crs {
        pub(in super::super) const ORGANISATION: usize = 0;
        pub(in super::super) const CODE: usize = 1;
        pub(in super::super) const WKT: usize = 4;
        pub(in super::super) const CODE_TEXT: usize = 5;
    }
    pub(super) mod feature {
        pub(in super::super) const GEOMETRY: usize = 0;
        pub(in super::super) const PROPERTIES: usize = 1;
        pub(in super::super) const COLUMNS: usize = 2;
    }
}

/// The contents of the header of a FlatGeobuf file.
struct Header {
    name: Option<String>,
    geometry_type: u8,
    columns: Vec<Column>,
    crs: Option<Crs>,
    /// Number of features; 0 if it is unknown.
    features: u64,
    index_bytes: u64,
}

/// Reads a file.
pub(super) fn read(path: &Path, layer: Option<&str>, sink: &mut Sink<'_>) -> Result<(), Cause> {
    let file = open_regular(path)?;
    let file_bytes = file.metadata()?.len();
    let mut file = Features { reader: BufReader::with_capacity(1 << 17, file), left: file_bytes, buffer: Vec::new() };
    let header = header(&mut file, sink)?;
    let stem = stem(path);
    let name = header.name.clone().unwrap_or_else(|| stem.clone());
    check_only_layer(layer, &[&name, &stem])?;
    sink.begin("FlatGeobuf", "feature");
    let layer = sink.add_layer(name);
    sink.set_crs(header.crs.clone());
    file.skip(header.index_bytes)?;
    let mut record = 0;
    while let Some(bytes) = file.next(record)? {
        record += 1;
        let damaged = || Cause::content(format!("is damaged: feature {record} cannot be read"));
        let feature = Buffer::new(bytes).root().ok_or_else(damaged)?;
        let own_columns = match feature.has(field::feature::COLUMNS) {
            true => Some(properties::columns(&feature, field::feature::COLUMNS, sink).ok_or_else(damaged)?),
            false => None,
        };
        let columns = own_columns.as_deref().unwrap_or(&header.columns);
        let properties = match feature.has(field::feature::PROPERTIES) {
            true => feature.bytes(field::feature::PROPERTIES).ok_or_else(damaged)?,
            false => &[],
        };
        let attributes = properties::attributes(properties, columns, sink).ok_or_else(damaged)?;
        let shapes = shapes(&feature, header.geometry_type, bytes.len());
        if sink.take(layer, record, shapes, attributes).is_break() {
            return Ok(());
        }
    }
    if header.features > 0 && record != header.features {
        return Err(Cause::content(format!("is truncated: it has {record} of {} features", header.features)));
    }
    Ok(())
}

fn shapes(feature: &Table<'_>, geometry_type: u8, bytes: usize) -> Shapes {
    if !feature.has(field::feature::GEOMETRY) {
        return Shapes::faulty(Reason::NoGeometry);
    }
    let shapes = feature.table(field::feature::GEOMETRY).ok_or(geometry::DAMAGED);
    let shapes = shapes.and_then(|table| geometry::shapes(&table, geometry_type, bytes));
    shapes.unwrap_or_else(Shapes::faulty)
}

/// The part of a file that has not been read.
struct Features {
    reader: BufReader<File>,
    /// Number of bytes that are left.
    left: u64,
    /// The bytes of the present feature.
    buffer: Vec<u8>,
}

impl Features {
    /// Reads bytes into the buffer.
    fn fill(&mut self, bytes: u64) -> Result<(), Cause> {
        self.buffer.clear();
        self.reader.by_ref().take(bytes).read_to_end(&mut self.buffer)?;
        self.left = self.left.saturating_sub(bytes);
        if (self.buffer.len() as u64) < bytes { Err(Cause::content("is truncated")) } else { Ok(()) }
    }

    fn skip(&mut self, bytes: u64) -> Result<(), Cause> {
        if bytes > self.left {
            return Err(Cause::content("is truncated, or its header is damaged: its index is larger than the file"));
        }
        self.left -= bytes;
        let distance = i64::try_from(bytes).map_err(|_| Cause::content("is damaged"))?;
        self.reader.seek_relative(distance)?;
        Ok(())
    }

    /// Returns the bytes of the next feature; `None` at the end of the file. `before` is the number of features so far.
    fn next(&mut self, before: u64) -> Result<Option<&[u8]>, Cause> {
        if self.left == 0 {
            return Ok(None);
        }
        let truncated = || Cause::content(format!("is truncated within feature {}", before + 1));
        if self.left < 4 {
            return Err(truncated());
        }
        self.fill(4)?;
        let size = self.buffer.first_chunk().map_or(0, |size| u64::from(u32::from_le_bytes(*size)));
        if size > self.left {
            return Err(truncated());
        }
        if size > FEATURE_BYTES {
            return Err(Cause::content(format!("has a feature of more than {} MiB", FEATURE_BYTES >> 20)));
        }
        self.fill(size)?;
        Ok(Some(&self.buffer))
    }
}

fn header(file: &mut Features, sink: &mut Sink<'_>) -> Result<Header, Cause> {
    let damaged = || Cause::content("is damaged: its header cannot be read");
    file.fill(8)?;
    match file.buffer.get(3) {
        Some(3) => {}
        Some(version) => {
            let cause = format!("is FlatGeobuf of version {version}; only version 3 can be read");
            return Err(Cause::Content(cause));
        }
        None => return Err(damaged()),
    }
    file.fill(4)?;
    let size = file.buffer.first_chunk().map_or(0, |size| u64::from(u32::from_le_bytes(*size)));
    if size > HEADER_BYTES || size > file.left {
        return Err(Cause::content(format!("is truncated, or its header is damaged: it is said to have {size} bytes")));
    }
    file.fill(size)?;
    let table = Buffer::new(&file.buffer).root().ok_or_else(damaged)?;
    let columns = match table.has(field::header::COLUMNS) {
        true => properties::columns(&table, field::header::COLUMNS, sink).ok_or_else(damaged)?,
        false => Vec::new(),
    };
    let features = table.u64(field::header::FEATURES).unwrap_or(0);
    let node_size = table.u16(field::header::NODE_SIZE).unwrap_or(16);
    Ok(Header {
        name: table.text(field::header::NAME).filter(|name| !name.is_empty()).map(str::to_owned),
        geometry_type: table.u8(field::header::GEOMETRY_TYPE).unwrap_or(0),
        columns,
        crs: table.table(field::header::CRS).and_then(|crs| self::crs(&crs)),
        features,
        index_bytes: index_bytes(features, node_size),
    })
}

fn crs(table: &Table<'_>) -> Option<Crs> {
    let organisation = table.text(field::crs::ORGANISATION).unwrap_or("EPSG");
    let code = table.i32(field::crs::CODE).filter(|code| *code > 0).and_then(|code| u32::try_from(code).ok());
    let code = code.or_else(|| table.text(field::crs::CODE_TEXT)?.parse().ok());
    let is_epsg = organisation.is_empty() || organisation.eq_ignore_ascii_case("EPSG");
    if let Some(code) = code.filter(|_| is_epsg) {
        return Some(Crs::epsg(code, CrsOrigin::File));
    }
    let text = table.text(field::crs::WKT).filter(|text| !text.trim().is_empty())?.to_owned();
    Some(Crs { text, origin: CrsOrigin::File })
}

/// Returns the size of the index: a tree whose lowest level has one node per feature. Saturates for hostile numbers.
fn index_bytes(features: u64, node_size: u16) -> u64 {
    if features == 0 || node_size == 0 {
        return 0;
    }
    let node_size = u64::from(node_size.max(2));
    let (mut level, mut nodes) = (features, features);
    loop {
        level = level.div_ceil(node_size);
        nodes = nodes.saturating_add(level);
        if level == 1 {
            return nodes.saturating_mul(NODE_BYTES);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_of_indices() {
        assert_eq!(index_bytes(0, 16), 0);
        assert_eq!(index_bytes(1, 16), 80);
        assert_eq!(index_bytes(16, 16), 17 * 40);
        assert_eq!(index_bytes(17, 16), (17 + 2 + 1) * 40);
        assert_eq!(index_bytes(5, 0), 0);
        assert_eq!(index_bytes(u64::MAX, 1), u64::MAX);
    }
}
