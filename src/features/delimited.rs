//! Reads CSV files with columns of coordinates, or with a column of Well-Known Text. Commas, semicolons or tabs separate
//! the fields; with semicolons and tabs, numbers may have decimal commas.

use std::io::Read;
use std::path::Path;

use csv::{ByteRecord, ReaderBuilder, Terminator};

use super::bounded::{Bounded, Replaced};
use super::delimited_columns::{Header, Place};
use super::error::Cause;
use super::model::{Attributes, Value, coordinate};
use super::shapes::Shapes;
use super::sink::{Name, Sink};
use super::summary::{Crs, CrsOrigin, Reason};
use super::{check_only_layer, stem, well_known_text};

/// Reads a file that begins with `head`.
pub(super) fn read(path: &Path, head: &[u8], layer: Option<&str>, sink: &mut Sink<'_>) -> Result<(), Cause> {
    let header = Header::find(head)?;
    let stem = stem(path);
    check_only_layer(layer, &[&stem])?;
    sink.begin("CSV", "line");
    let layer = sink.add_layer(stem);
    let names: Vec<Option<Name>> = header
        .names
        .iter()
        .enumerate()
        .map(|(column, name)| (!name.is_empty() && !header.is_geometry(column)).then(|| sink.name(name)))
        .collect();
    let (file, gauge) = Bounded::open(path)?;
    // Lines that end in a carriage return alone are rare, but some spreadsheets write them.
    let from = if head.contains(&b'\n') { b'\n' } else { b'\r' };
    let mut reader = reader(header.separator, Replaced { reader: file, from, to: b'\n' });
    let mut rows = Rows { header, names, layer, srid: Srid::Unread };
    let mut record = ByteRecord::new();
    let mut is_header = true;
    loop {
        gauge.reset();
        if !reader.read_byte_record(&mut record).map_err(cause_of)? {
            break;
        }
        let line = line(&record, reader.position().line());
        if !std::mem::take(&mut is_header) && rows.take(&record, line, sink)?.is_break() {
            break;
        }
    }
    sink.set_crs(rows.crs());
    Ok(())
}

/// Returns a reader of rows that end in a line feed; a carriage return before it belongs to the last field.
pub(super) fn reader<R: Read>(separator: u8, file: R) -> csv::Reader<R> {
    let mut builder = ReaderBuilder::new();
    builder.delimiter(separator).terminator(Terminator::Any(b'\n')).flexible(true).has_headers(false);
    builder.from_reader(file)
}

/// Returns the line in which a row begins, if the reader is in the line `after` it. The position of a row is that of
/// the empty lines before it.
fn line(record: &ByteRecord, after: u64) -> u64 {
    let before = record.position().map_or(1, csv::Position::line);
    let inside = record.as_slice().iter().filter(|byte| **byte == b'\n').count() as u64;
    before + after.saturating_sub(before).saturating_sub(inside + 1)
}

fn cause_of(error: csv::Error) -> Cause {
    match error.into_kind() {
        csv::ErrorKind::Io(error) => Cause::Read(error),
        kind => Cause::content(format!("is not valid CSV: {kind:?}")),
    }
}

/// The code before the text of geometries (`SRID=25832;POINT …`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Srid {
    Unread,
    Read(Option<u32>),
}

struct Rows {
    header: Header,
    /// The names of the attributes; `None` for columns of coordinates and for columns without a name.
    names: Vec<Option<Name>>,
    layer: usize,
    srid: Srid,
}

impl Rows {
    fn take(
        &mut self,
        record: &ByteRecord,
        line: u64,
        sink: &mut Sink<'_>,
    ) -> Result<std::ops::ControlFlow<()>, Cause> {
        let go_on = Ok(std::ops::ControlFlow::Continue(()));
        let fields = fields(record, line)?;
        // Spreadsheets write separators at the end of rows and of files.
        if fields.iter().all(|field| field.trim().is_empty()) {
            return go_on;
        }
        let (own, extra) = fields.split_at_checked(self.names.len()).unwrap_or((&fields, &[]));
        if own.len() < self.names.len() || extra.iter().any(|field| !field.trim().is_empty()) {
            sink.skip(line, Reason::Fields);
            return go_on;
        }
        let shapes = self.shapes(own)?;
        let has_decimal_commas = self.header.separator != b',';
        let mut attributes = Attributes::default();
        for (name, field) in self.names.iter().zip(own) {
            if let Some(name) = name {
                sink.add(&mut attributes, name, Value::guessed(field, has_decimal_commas));
            }
        }
        Ok(sink.take(self.layer, line, shapes, attributes))
    }

    fn shapes(&mut self, fields: &[&str]) -> Result<Shapes, Cause> {
        let field = |column: usize| fields.get(column).copied().unwrap_or_default();
        match self.header.place {
            Place::Columns { x, y, z, .. } => {
                let has_decimal_commas = self.header.separator != b',';
                let number = |column| coordinate(field(column), has_decimal_commas).unwrap_or(f64::NAN);
                let mut shapes = Shapes::default();
                shapes.point([number(x), number(y), z.map_or(f64::NAN, number)]);
                Ok(shapes)
            }
            Place::Text(column) if field(column).trim().is_empty() => Ok(Shapes::faulty(Reason::NoGeometry)),
            Place::Text(column) => match well_known_text::parse(field(column)) {
                Ok((shapes, srid)) => {
                    if self.srid != Srid::Unread && self.srid != Srid::Read(srid) {
                        return Err(Cause::content("contains several reference systems (SRID=); it needs one"));
                    }
                    self.srid = Srid::Read(srid);
                    Ok(shapes)
                }
                Err(reason) => Ok(Shapes::faulty(reason)),
            },
        }
    }

    fn crs(&self) -> Option<Crs> {
        match (self.header.place, self.srid) {
            (Place::Columns { are_degrees: true, .. }, _) => Some(Crs::epsg(4326, CrsOrigin::Assumed)),
            (_, Srid::Read(Some(code))) if code > 0 => Some(Crs::epsg(code, CrsOrigin::File)),
            _ => None,
        }
    }
}

/// Returns the fields of a row as text.
fn fields(record: &ByteRecord, line: u64) -> Result<Vec<&str>, Cause> {
    let text = |field| {
        std::str::from_utf8(field).map_err(|_| {
            Cause::content(format!("is not UTF-8 text (line {line}); convert it with iconv -f LATIN1 -t UTF-8"))
        })
    };
    record.iter().map(text).collect()
}
