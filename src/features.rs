//! Reads layers of features from files: points, lines and areas with attributes.
//!
//! The formats are GeoJSON (also one object per line), GPX, CSV, GeoPackage and FlatGeobuf. A file is recognised by its
//! content first, and by the ending of its name only where the content leaves a choice. Features are passed to the
//! caller one at a time, so that memory does not grow with the file; a single feature has at most [`MAX_POSITIONS`]
//! positions and [`bounded::FEATURE_BYTES`] bytes.
//!
//! Coordinates are always in the order x, y, z: easting or longitude first, whatever the authority of the reference
//! system says. Whatever cannot be read is either an error of one line, or is left out and counted in
//! [`Summary::skipped`] with the reason.

mod bounded;
mod delimited;
mod delimited_columns;
mod error;
mod flat_tables;
mod flatgeobuf;
mod format;
mod geojson;
mod geopackage;
mod gpx;
mod model;
mod on_land;
mod shapes;
mod sink;
mod summary;
#[cfg(test)]
mod tests;
mod well_known_text;
pub(crate) mod when;
mod wkb;

use std::ops::ControlFlow;
use std::path::Path;

pub(crate) use self::error::FeatureError;
pub(crate) use self::model::{Area, Attributes, Feature, Geometry, Position, Value};
pub(crate) use self::on_land::{OnLand, OnLandError};
pub(crate) use self::summary::{CrsOrigin, Layer, Summary};

use self::error::Cause;
use self::format::Format;
use self::sink::Sink;
#[cfg(test)]
use self::summary::{Reason, Skipped};

/// Largest number of positions in one feature; 800 MB of memory. The largest polygon of OpenStreetMap's coastlines has
/// a third of it.
pub(crate) const MAX_POSITIONS: usize = 1 << 25;

/// The layer that is read from a file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Choice {
    /// The name of the layer; needed if a GeoPackage has several. A GPX file has the layers `waypoints`, `routes` and
    /// `tracks`, and all of them are read if none is named.
    pub layer: Option<String>,
}

/// Reads a file, and passes each of its features to `each` until that returns `Break`.
///
/// The reference system is known for certain only at the end, because GeoJSON may name it after the features. A caller
/// that needs it earlier calls [`survey`] first, or stores the features.
///
/// # Errors
/// Returns [`FeatureError`] if the file cannot be opened, has none of the known formats, is damaged, or if the choice of
/// the layer is not clear. Features that were passed before the error must not be used.
pub(crate) fn read(
    path: &Path,
    choice: &Choice,
    each: &mut dyn FnMut(Feature) -> ControlFlow<()>,
) -> Result<Summary, FeatureError> {
    read_into(path, choice, each).map_err(|cause| cause.of(path))
}

/// Reads a file completely, and returns its summary only: reference system, extent, attributes, and what is left out.
///
/// # Errors
/// The same as [`read`].
pub(crate) fn survey(path: &Path, choice: &Choice) -> Result<Summary, FeatureError> {
    read(path, choice, &mut |_| ControlFlow::Continue(()))
}

fn read_into(path: &Path, choice: &Choice, each: &mut dyn FnMut(Feature) -> ControlFlow<()>) -> Result<Summary, Cause> {
    let (format, head) = format::recognise(path)?;
    let mut sink = Sink::new(each);
    let layer = choice.layer.as_deref();
    match format {
        Format::GeoJson => geojson::read(path, layer, &mut sink)?,
        Format::Gpx => gpx::read(path, layer, &mut sink)?,
        Format::Delimited => delimited::read(path, &head, layer, &mut sink)?,
        Format::GeoPackage => geopackage::read(path, layer, &mut sink)?,
        Format::FlatGeobuf => flatgeobuf::read(path, layer, &mut sink)?,
    }
    Ok(sink.finish())
}

/// Returns the name of the only layer of a file that does not name it: the file's name without its ending.
fn stem(path: &Path) -> String {
    path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Checks the choice of a layer in a file that has only one, which may have several names.
fn check_only_layer(chosen: Option<&str>, names: &[&str]) -> Result<(), Cause> {
    match chosen {
        Some(chosen) if !names.contains(&chosen) => Err(Cause::Layers {
            wanted: Some(chosen.to_owned()),
            layers: names.iter().take(1).map(|name| (*name).to_owned()).collect(),
        }),
        _ => Ok(()),
    }
}
