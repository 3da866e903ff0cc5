//! Height files → heights in metres on a regular grid, with the place of that grid on the earth.
//!
//! [`open`] looks at a file's content, not at its ending, and reads what it finds: today GeoTIFF and cloud-optimised
//! GeoTIFF. Whatever the file declares (no-data mark, scale and offset, vertical unit) is applied on the way, so that
//! what comes out is metres, or NaN.

pub mod continent;
mod crs_catalogue;
mod erosion;
mod error;
mod geokeys;
pub mod georeference;
mod geotiff;
mod geotiff_layout;
mod hillslope;
mod looks_like;
pub mod mosaic;
pub mod procedural;
mod raster;
pub mod reader;
mod relief;
mod samples;
mod valley;
mod world_mapping;

use std::path::Path;

pub use error::SourceError;
pub use geokeys::{GeoKey, GeoKeyValue, GeoKeys};
use georeference::Georeference;
pub use georeference::GeoreferenceError;
pub use reader::{HeightReader, Window};
pub use world_mapping::WorldMapping;

/// A height field in memory, as its file gives it: regular in the grid of the file, not resampled.
#[derive(Clone, Debug)]
pub struct HeightGrid {
    /// Samples per row, at least 2.
    pub width: u32,
    /// Rows, at least 2.
    pub height: u32,
    /// Heights in metres, row-major, in the file's row order; NaN where there is no data.
    pub heights_m: Vec<f32>,
    /// Where the samples lie.
    pub georeference: Georeference,
}

/// What long work tells about itself. `done` runs from 0 to 1.
pub trait Progress: Sync {
    /// Called now and then, from any thread.
    fn report(&self, what: &str, done: f32);
}

/// Says nothing.
pub struct Silent;

impl Progress for Silent {
    fn report(&self, _what: &str, _done: f32) {}
}

/// Reads a height file whole: `width × height` samples, every one a finite number of metres or NaN.
///
/// # Errors
/// A [`SourceError`] whose message is one line with the file's name and the cause. Damaged and hostile files give
/// errors too: neither a panic nor an allocation that the file's size does not justify.
pub fn open(path: &Path, progress: &dyn Progress) -> Result<HeightGrid, SourceError> {
    looks_like::require_tiff(path)?;
    geotiff::read(path, progress)
}
