//! The columns of a table of features.

use rusqlite::types::ValueRef;
use rusqlite::{Connection, Row};

use super::{Cause, Value, cause_of, list, quoted};

/// The columns of a table.
pub(super) struct Columns {
    /// The primary key, if it is one column.
    key: Option<String>,
    geometry: String,
    attributes: Vec<Column>,
}

struct Column {
    name: String,
    is_bool: bool,
}

impl Columns {
    /// Finds the columns of a table whose geometry is in the column `geometry`.
    pub(super) fn find(connection: &Connection, table: &str, geometry: &str) -> Result<Self, Cause> {
        let sql = "SELECT name, type, pk FROM pragma_table_info(?1)";
        let mut statement = connection.prepare(sql).map_err(cause_of)?;
        let column =
            |row: &Row<'_>| -> rusqlite::Result<(String, String, i64)> { Ok((row.get(0)?, row.get(1)?, row.get(2)?)) };
        let found: Result<Vec<_>, _> = statement.query_map([table], column).map_err(cause_of)?.collect();
        let found = found.map_err(cause_of)?;
        if found.is_empty() {
            return Err(Cause::content(format!("is damaged: it has no table {}, which it lists", quoted(table))));
        }
        let Some((geometry, ..)) = found.iter().find(|(name, ..)| name.eq_ignore_ascii_case(geometry)) else {
            let names: Vec<String> = found.into_iter().map(|(name, ..)| name).collect();
            return Err(Cause::content(format!(
                "is damaged: its table {} has no column {}; its columns are {}",
                quoted(table),
                quoted(geometry),
                list(&names)
            )));
        };
        let mut keys = found.iter().filter(|(.., key)| *key > 0).map(|(name, ..)| name.clone());
        let key = keys.next().filter(|_| keys.next().is_none());
        let is_attribute = |name: &str| name != geometry && key.as_deref() != Some(name);
        let attributes = found.iter().filter(|(name, ..)| is_attribute(name));
        let attributes = attributes
            .map(|(name, kind, _)| Column { name: name.clone(), is_bool: kind.eq_ignore_ascii_case("BOOLEAN") })
            .collect();
        Ok(Self { geometry: geometry.clone(), key, attributes })
    }

    /// Returns whether the table has a primary key.
    pub(super) fn has_key(&self) -> bool {
        self.key.is_some()
    }

    /// Returns the names of the attributes.
    pub(super) fn attributes(&self) -> impl Iterator<Item = &str> {
        self.attributes.iter().map(|column| column.name.as_str())
    }

    /// Returns the query of all rows: the key, the geometry, and the attributes.
    pub(super) fn query(&self, table: &str) -> String {
        let key = self.key.as_deref().map_or_else(|| "NULL".to_owned(), quoted_name);
        let attributes: String = self.attributes().map(|name| format!(", {}", quoted_name(name))).collect();
        format!("SELECT {key}, {}{attributes} FROM {}", quoted_name(&self.geometry), quoted_name(table))
    }

    /// Returns the value of an attribute; `None` for binary data.
    pub(super) fn value(&self, row: &Row<'_>, index: usize, record: u64) -> Result<Option<Value>, Cause> {
        let column = self.attributes.get(index);
        let is_bool = column.is_some_and(|column| column.is_bool);
        Ok(Some(match row.get_ref(index + 2).map_err(cause_of)? {
            ValueRef::Null => Value::None,
            ValueRef::Integer(integer @ (0 | 1)) if is_bool => Value::Bool(integer == 1),
            ValueRef::Integer(integer) => Value::integer(integer),
            ValueRef::Real(number) => Value::number(number),
            ValueRef::Text(text) => match std::str::from_utf8(text) {
                Ok(text) => Value::text(text),
                Err(_) => {
                    let name = quoted(column.map_or("", |column| &column.name));
                    return Err(Cause::content(format!("has text that is not UTF-8 (row {record}, column {name})")));
                }
            },
            ValueRef::Blob(_) => return Ok(None),
        }))
    }
}

/// Returns a name in quotation marks, as SQL has it.
pub(super) fn quoted_name(name: &str) -> String {
    format!("\"{}\"", name.replace('"', "\"\""))
}
