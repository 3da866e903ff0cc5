//! Reads columns and attributes of FlatGeobuf.

use super::super::flat_tables::Table;
use super::super::model::{Attributes, Value};
use super::super::sink::{Name, Sink};

/// Largest number of columns; values refer to them by numbers of two bytes.
const MOST_COLUMNS: usize = 1 << 16;

/// Numbers of the fields of a column.
const NAME: usize = 0;
const TYPE: usize = 1;

/// A column of the attribute table, from the header.
pub(super) struct Column {
    name: Name,
    kind: Kind,
}

#[derive(Clone, Copy)]
enum Kind {
    I8,
    U8,
    Bool,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
    Text,
    Binary,
}

impl Kind {
    fn new(code: u8) -> Option<Self> {
        Some(match code {
            0 => Self::I8,
            1 => Self::U8,
            2 => Self::Bool,
            3 => Self::I16,
            4 => Self::U16,
            5 => Self::I32,
            6 => Self::U32,
            7 => Self::I64,
            8 => Self::U64,
            9 => Self::F32,
            10 => Self::F64,
            // Text, JSON and times.
            11..=13 => Self::Text,
            14 => Self::Binary,
            _ => return None,
        })
    }
}

/// Reads the columns of a header or a feature; `None` if they are damaged.
pub(super) fn columns(table: &Table<'_>, field: usize, sink: &mut Sink<'_>) -> Option<Vec<Column>> {
    let list = table.list(field, 4).filter(|list| list.len() <= MOST_COLUMNS)?;
    let column = |index| {
        let column = list.table(index)?;
        Some(Column { name: sink.name(column.text(NAME)?), kind: Kind::new(column.u8(TYPE).unwrap_or(0))? })
    };
    (0..list.len()).map(column).collect()
}

/// Reads attributes: the number of a column and its value, again and again. `None` if they are damaged.
pub(super) fn attributes(bytes: &[u8], columns: &[Column], sink: &mut Sink<'_>) -> Option<Attributes> {
    let mut attributes = Attributes::default();
    let mut rest = bytes;
    let mut values = 0;
    while !rest.is_empty() {
        values += 1;
        // A feature has at most one value per column.
        if values > columns.len() {
            return None;
        }
        let column = columns.get(usize::from(u16::from_le_bytes(take(&mut rest)?)))?;
        match value(&mut rest, column.kind)? {
            Some(value) => sink.add(&mut attributes, &column.name, value),
            None => sink.leave_out_binary(&column.name),
        }
    }
    Some(attributes)
}

fn take<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (bytes, after) = rest.split_first_chunk::<N>()?;
    *rest = after;
    Some(*bytes)
}

/// Reads a value; the inner `None` is binary data.
fn value(rest: &mut &[u8], kind: Kind) -> Option<Option<Value>> {
    Some(Some(match kind {
        Kind::I8 => Value::integer(i8::from_le_bytes(take(rest)?)),
        Kind::U8 => Value::integer(u8::from_le_bytes(take(rest)?)),
        Kind::Bool => Value::Bool(take::<1>(rest)? != [0]),
        Kind::I16 => Value::integer(i16::from_le_bytes(take(rest)?)),
        Kind::U16 => Value::integer(u16::from_le_bytes(take(rest)?)),
        Kind::I32 => Value::integer(i32::from_le_bytes(take(rest)?)),
        Kind::U32 => Value::integer(u32::from_le_bytes(take(rest)?)),
        Kind::I64 => Value::integer(i64::from_le_bytes(take(rest)?)),
        Kind::U64 => Value::integer(u64::from_le_bytes(take(rest)?)),
        Kind::F32 => Value::number(f64::from(f32::from_le_bytes(take(rest)?))),
        Kind::F64 => Value::number(f64::from_le_bytes(take(rest)?)),
        Kind::Text | Kind::Binary => {
            let length = usize::try_from(u32::from_le_bytes(take(rest)?)).ok()?;
            let (bytes, after) = rest.split_at_checked(length)?;
            *rest = after;
            match kind {
                Kind::Binary => return Some(None),
                _ => Value::text(std::str::from_utf8(bytes).ok()?),
            }
        }
    }))
}
