//! Height files → heights in metres on a regular grid, with the place of that grid on the earth.

mod erosion;
pub mod georeference;
mod hillslope;
pub mod procedural;
mod raster;
mod relief;
mod valley;

use georeference::Georeference;

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
