//! Reads the feature tables of a GeoPackage (OGC 12-128r18), which is a SQLite database.
//!
//! The database is opened as immutable, so that SQLite neither locks it nor creates files next to it. Changes in a
//! write-ahead log would then be ignored, so a file with one is refused. A GeoPackage may define views, which are
//! programs: what they may do and how long they may run is limited.

mod columns;

use std::fmt::Write;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use rusqlite::config::DbConfig;
use rusqlite::limits::Limit;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, OpenFlags, OptionalExtension, Row};

use self::columns::Columns;
use super::bounded::FEATURE_BYTES;
use super::error::{Cause, list};
use super::model::{Attributes, Value};
use super::shapes::Shapes;
use super::sink::Sink;
use super::summary::{Crs, CrsOrigin, Reason};
use super::wkb;
use crate::file::message::quoted;

/// Number of instructions of SQLite between two checks.
const CHECK_INSTRUCTIONS: i32 = 1 << 20;
/// Number of checks after which a query must have returned a row; about a minute.
const MOST_CHECKS: u32 = 1 << 12;

/// A table of features.
struct FeatureTable {
    name: String,
    geometry: String,
    srs_id: i64,
}

/// Reads a file.
pub(super) fn read(path: &Path, layer: Option<&str>, sink: &mut Sink<'_>) -> Result<(), Cause> {
    let file_bytes = std::fs::metadata(path)?.len();
    check_journals(path)?;
    check_size(path, file_bytes)?;
    let mut connection = open(path)?;
    let checks = limit(&mut connection).map_err(cause_of)?;
    let table = choose(tables(&connection)?, layer)?;
    let columns = Columns::find(&connection, &table.name, &table.geometry)?;
    sink.begin("GeoPackage", if columns.has_key() { "fid" } else { "row" });
    let layer = sink.add_layer(table.name.clone());
    sink.set_crs(crs(&connection, table.srs_id)?);
    let names: Vec<_> = columns.attributes().map(|name| sink.name(name)).collect();
    let mut statement = connection.prepare(&columns.query(&table.name)).map_err(cause_of)?;
    let mut rows = statement.query([]).map_err(cause_of)?;
    let mut count = 0;
    while let Some(row) = rows.next().map_err(cause_of)? {
        checks.store(0, Ordering::Relaxed);
        count += 1;
        // A row takes more than a byte, unless a view or a damaged table repeats rows without end.
        if count > file_bytes {
            return Err(Cause::content("is damaged: a table has more rows than the file has bytes"));
        }
        let record = record(row).unwrap_or(count);
        let mut attributes = Attributes::default();
        for (index, name) in names.iter().enumerate() {
            match columns.value(row, index, record)? {
                Some(value) => sink.add(&mut attributes, name, value),
                None => sink.leave_out_binary(name),
            }
        }
        if sink.take(layer, record, shapes(row), attributes).is_break() {
            break;
        }
    }
    Ok(())
}

/// Returns the primary key of a row, which is in its first column.
fn record(row: &Row<'_>) -> Option<u64> {
    match row.get_ref(0) {
        Ok(ValueRef::Integer(key)) => u64::try_from(key).ok(),
        _ => None,
    }
}

/// Returns the geometry of a row, which is in its second column.
fn shapes(row: &Row<'_>) -> Shapes {
    match row.get_ref(1) {
        Ok(ValueRef::Blob(blob)) => wkb::parse_geopackage(blob).unwrap_or_else(Shapes::faulty),
        Ok(ValueRef::Null) => Shapes::faulty(Reason::NoGeometry),
        _ => Shapes::faulty(Reason::Damaged("it is not a blob")),
    }
}

/// Returns what is wrong with a database.
fn cause_of(error: rusqlite::Error) -> Cause {
    match error {
        rusqlite::Error::SqliteFailure(failure, _) if failure.code == rusqlite::ErrorCode::OperationInterrupted => {
            Cause::content("has a view that takes too long; save it as a table")
        }
        rusqlite::Error::SqliteFailure(failure, message) => {
            Cause::content(format!("is damaged or truncated: {}", message.unwrap_or_else(|| failure.to_string())))
        }
        error => Cause::content(format!("is damaged or truncated: {error}")),
    }
}

/// Checks that the file does not depend on a log or a journal next to it.
fn check_journals(path: &Path) -> Result<(), Cause> {
    let beside = |ending: &str| {
        let mut name = path.as_os_str().to_owned();
        name.push(ending);
        PathBuf::from(name)
    };
    // A journal that is no longer needed is empty or begins with zero.
    let is_used = |path: &Path| {
        let mut first = [0];
        let is_file = std::fs::metadata(path).is_ok_and(|it| it.is_file() && it.len() > 0);
        is_file && File::open(path).and_then(|mut file| file.read_exact(&mut first)).is_ok() && first != [0]
    };
    for ending in ["-wal", "-journal"] {
        if is_used(&beside(ending)) {
            return Err(Cause::content(format!(
                "has changes that are only in the file with the ending {ending}; close the program that edits it, or \
                 open and close it with QGIS"
            )));
        }
    }
    Ok(())
}

/// Checks that the file has as many pages as its header says. SQLite takes a part of a page that is missing as zeros.
fn check_size(path: &Path, file_bytes: u64) -> Result<(), Cause> {
    let mut header = [0; 100];
    let truncated = |_| Cause::content("is truncated");
    File::open(path)?.read_exact(&mut header).map_err(truncated)?;
    let word = |at: usize| header.get(at..).and_then(|rest| rest.first_chunk()).map_or(0, |it| u32::from_be_bytes(*it));
    let page_bytes = match word(16) >> 16 {
        1 => 1 << 16,
        bytes => u64::from(bytes),
    };
    // The count is valid only if the program that last wrote the file maintains it.
    let is_valid = word(24) == word(92);
    if is_valid && page_bytes * u64::from(word(28)) > file_bytes {
        return Err(Cause::content("is truncated: the file is shorter than its header says"));
    }
    Ok(())
}

/// Opens a database without writing anything.
fn open(path: &Path) -> Result<Connection, Cause> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let path = std::path::absolute(path)?;
    Connection::open_with_flags(address(&path), flags).map_err(cause_of)
}

/// Returns the address of a file with an absolute path.
fn address(path: &Path) -> String {
    let bytes = path.as_os_str().as_encoded_bytes();
    let mut address = String::from("file:");
    if !bytes.starts_with(b"/") {
        address.push_str("///");
    }
    for &byte in bytes {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'/' | b'.' | b'-' | b'_' | b':' => {
                address.push(char::from(byte));
            }
            b'\\' if cfg!(windows) => address.push('/'),
            // Writing to a string does not fail.
            _ => drop(write!(address, "%{byte:02X}")),
        }
    }
    address + "?mode=ro&immutable=1"
}

/// Limits what a hostile database can do, and returns the number of checks since the last row.
fn limit(connection: &mut Connection) -> rusqlite::Result<Arc<AtomicU32>> {
    for (config, value) in [
        (DbConfig::SQLITE_DBCONFIG_DEFENSIVE, true),
        (DbConfig::SQLITE_DBCONFIG_TRUSTED_SCHEMA, false),
        (DbConfig::SQLITE_DBCONFIG_ENABLE_TRIGGER, false),
    ] {
        connection.set_db_config(config, value)?;
    }
    connection.set_limit(Limit::SQLITE_LIMIT_LENGTH, i32::try_from(FEATURE_BYTES).unwrap_or(i32::MAX))?;
    connection.set_limit(Limit::SQLITE_LIMIT_ATTACHED, 0)?;
    connection.execute_batch("PRAGMA temp_store = MEMORY")?;
    let checks = Arc::new(AtomicU32::new(0));
    let counted = Arc::clone(&checks);
    let is_too_long = move || counted.fetch_add(1, Ordering::Relaxed) > MOST_CHECKS;
    connection.progress_handler(CHECK_INSTRUCTIONS, Some(is_too_long))?;
    Ok(checks)
}

/// Returns the tables of features.
fn tables(connection: &Connection) -> Result<Vec<FeatureTable>, Cause> {
    let sql = "SELECT count(*) FROM sqlite_master WHERE lower(name) IN ('gpkg_contents', 'gpkg_geometry_columns')";
    let known: i64 = connection.query_row(sql, [], |row| row.get(0)).map_err(cause_of)?;
    if known < 2 {
        return Err(Cause::content(
            "is a SQLite database, but not a GeoPackage with features: it has no table gpkg_contents or \
             gpkg_geometry_columns",
        ));
    }
    let sql = "SELECT g.table_name, g.column_name, g.srs_id FROM gpkg_contents AS c JOIN gpkg_geometry_columns AS g \
               ON lower(c.table_name) = lower(g.table_name) WHERE c.data_type = 'features' ORDER BY g.table_name";
    let mut statement = connection.prepare(sql).map_err(cause_of)?;
    let table = |row: &Row<'_>| Ok(FeatureTable { name: row.get(0)?, geometry: row.get(1)?, srs_id: row.get(2)? });
    let tables = statement.query_map([], table).map_err(cause_of)?;
    tables.collect::<Result<_, _>>().map_err(cause_of)
}

fn choose(mut tables: Vec<FeatureTable>, layer: Option<&str>) -> Result<FeatureTable, Cause> {
    let chosen = match (layer, tables.len()) {
        (_, 0) => return Err(Cause::content("is a GeoPackage without features")),
        (Some(layer), _) => tables.iter().position(|table| table.name == layer),
        (None, 1) => Some(0),
        (None, _) => None,
    };
    match chosen {
        Some(chosen) => Ok(tables.swap_remove(chosen)),
        None => {
            let layers = tables.into_iter().map(|table| table.name).collect();
            Err(Cause::Layers { wanted: layer.map(str::to_owned), layers })
        }
    }
}

/// Returns the reference system of an identifier; `None` for an undefined system.
fn crs(connection: &Connection, srs_id: i64) -> Result<Option<Crs>, Cause> {
    if srs_id <= 0 {
        return Ok(None);
    }
    let sql = "SELECT organization, organization_coordsys_id, definition FROM gpkg_spatial_ref_sys WHERE srs_id = ?1";
    let entry =
        |row: &Row<'_>| -> rusqlite::Result<(String, i64, String)> { Ok((row.get(0)?, row.get(1)?, row.get(2)?)) };
    let entry = connection.query_row(sql, [srs_id], entry).optional().map_err(cause_of)?;
    let Some((organisation, code, definition)) = entry else { return Ok(None) };
    let code = u32::try_from(code).ok().filter(|code| *code > 0 && organisation.eq_ignore_ascii_case("EPSG"));
    if let Some(code) = code {
        return Ok(Some(Crs::epsg(code, CrsOrigin::File)));
    }
    let is_defined = !definition.trim().is_empty() && !definition.trim().eq_ignore_ascii_case("undefined");
    Ok(is_defined.then_some(Crs { text: definition, origin: CrsOrigin::File }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_escaped() {
        assert_eq!(address(Path::new("/a b/c?x=1#ä.gpkg")), "file:/a%20b/c%3Fx%3D1%23%C3%A4.gpkg?mode=ro&immutable=1");
    }
}
