//! Reads GeoJSON (RFC 7946, and `crs` of its draft of 2008, which GDAL and QGIS write): a collection, a single feature or
//! geometry, or any number of them one after the other (newline-delimited GeoJSON, and text sequences of RFC 8142).
//!
//! The text is read as a stream: each entry of `features` is passed on as soon as it ends. Members may come in any
//! order, so `type` and `crs` of a collection may follow its features.

mod coordinates;
mod geometry;
mod object;
mod value;

use std::path::Path;

use serde::de::DeserializeSeed;

use self::object::{Document, State};
use super::bounded::{Bounded, Replaced};
use super::error::Cause;
use super::sink::Sink;
use super::summary::{Crs, CrsOrigin};
use super::{check_only_layer, stem};
use crate::file::message::quoted;

/// The byte that begins a text in a sequence of RFC 8142. It occurs nowhere else in JSON.
const RECORD_SEPARATOR: u8 = 0x1e;

/// Reads a file.
pub(super) fn read(path: &Path, layer: Option<&str>, sink: &mut Sink<'_>) -> Result<(), Cause> {
    let (file, gauge) = Bounded::open(path)?;
    sink.begin("GeoJSON", "feature");
    let stem = stem(path);
    sink.add_layer(stem.clone());
    let mut state = State::new(sink, gauge);
    let mut json = serde_json::Deserializer::from_reader(Replaced { reader: file, from: RECORD_SEPARATOR, to: b' ' });
    loop {
        let read = Document(&mut state).deserialize(&mut json);
        if state.sink.has_ended() {
            break;
        }
        if let Some(failure) = state.failure.take() {
            return Err(failure);
        }
        read.map_err(cause_of)?;
        if json.end().is_ok() {
            break;
        }
    }
    let State { crs, name, sink, .. } = state;
    let names = [name.as_deref().unwrap_or(&stem), &stem];
    check_only_layer(layer, &names)?;
    if let Some(name) = &name {
        sink.rename_layer(0, name.clone());
    }
    let crs = match crs {
        Some(named) => named,
        None => Some(Crs::epsg(4326, CrsOrigin::Format)),
    };
    sink.set_crs(crs);
    Ok(())
}

/// Returns what is wrong with a text.
fn cause_of(error: serde_json::Error) -> Cause {
    if error.is_io() {
        return Cause::Read(error.into());
    }
    let (line, column, text) = (error.line(), error.column(), error.to_string());
    let at = format!("line {line}, column {column}");
    if error.is_eof() {
        let what = text.strip_prefix("EOF while parsing ").and_then(|rest| rest.split(" at line").next());
        return Cause::content(format!("ends within {} ({at}); it is truncated", what.unwrap_or("a value")));
    }
    if text.contains("unicode") {
        return Cause::content(format!("is not UTF-8 text ({at}); convert it with iconv -t UTF-8"));
    }
    let text = text.split(" at line ").next().unwrap_or_default();
    Cause::content(format!("is not valid GeoJSON: {text} ({at})"))
}

/// Returns the reference system that the member `crs` names; `None` for a system that is said to be unknown.
fn crs_of(name: &str) -> Result<Option<Crs>, Cause> {
    let code = |code| Ok(Some(Crs::epsg(code, CrsOrigin::File)));
    let upper = name.to_ascii_uppercase();
    let number = upper.contains("EPSG").then(|| upper.rsplit([':', '/']).next()?.parse::<u32>().ok()).flatten();
    match (upper.as_str(), number) {
        (_, Some(number)) => code(number),
        (other, None) if other.ends_with("CRS84") || other.ends_with("CRS84H") => code(4326),
        (other, None) if other.ends_with("CRS83") => code(4269),
        (other, None) if other.ends_with("CRS27") => code(4267),
        ("", None) => Err(Cause::content("has a crs without a name; convert it with ogr2ogr -t_srs EPSG:4326")),
        _ => Err(Cause::content(format!(
            "has the unknown crs {}; convert it with ogr2ogr -t_srs EPSG:4326",
            quoted(name)
        ))),
    }
}
