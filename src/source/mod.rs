//! Height files → heights in metres on a regular grid, with the place of that grid on the earth.
//!
//! [`open_reader`] looks at a file's content, not at its ending, and reads what it finds by windows; [`open`] reads all
//! of it. Whatever the file declares (no-data mark, scale and offset, vertical unit) is applied on the way, so that
//! what comes out is metres, or NaN.
//!
//! Each format has a file of its own. Those with an index or samples at fixed places (GeoTIFF, `.hgt`, DTED, BIL,
//! GridFloat, ENVI, raw, tiles) are read by windows, whatever their size; text and PNG are decoded into memory, at 2 to
//! 4 bytes for each sample. [`statistics`] reads a grid of any size without holding it.
//!
//! Why: `docs/decisions/height-readers.md`.

mod ascii_grid;
pub(crate) mod cog;
pub mod continent;
mod crs_catalogue;
mod dted;
mod earth_place;
mod ehdr;
mod envi;
mod erosion;
mod error;
mod esri_citation;
mod flat;
mod folder;
mod format;
mod geokeys;
pub mod georeference;
mod geotiff;
mod geotiff_layout;
mod hgt;
mod hillslope;
mod inputs;
mod masked;
mod memory;
pub mod mosaic;
mod picture;
mod place;
mod png16;
mod prj;
pub mod procedural;
mod raster;
mod raw;
pub mod reader;
mod relief;
mod samples;
mod side_file;
mod statistics;
mod terrain_rgb;
mod text;
mod tiff_blocks;
mod tiff_samples;
pub(crate) mod tiff_side_files;
mod tile_folder;
mod undeclared;
mod usgs_dem;
mod valley;
mod values;
pub mod voids;
mod wkt;
mod wkt_text;
mod world_mapping;
mod xyz;

use std::path::Path;

pub use earth_place::EarthPlace;
pub use error::SourceError;
pub use folder::{Kind, kind_of, members};
use format::Format;
pub use geokeys::{GeoKey, GeoKeyValue, GeoKeys};
use georeference::Georeference;
pub use georeference::GeoreferenceError;
pub use inputs::{add_inputs, files_of};
pub use reader::{HeightReader, Window};
pub use side_file::{Encoding, OpenOptions};
pub use statistics::{Statistics, statistics};
pub use values::{Holds, Values, open_values};
use voids::Filled;
pub use voids::VoidMode;
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

/// Another number where files give other heights, or another place, than they did before: what was baked of them then
/// is baked anew.
pub const VERSION: u32 = 2;

/// More samples than this are not read into memory at once: 8 GiB of heights.
const MAX_SAMPLES: u64 = 1 << 31;

/// So many samples are read between two reports of progress.
const SAMPLES_PER_REPORT: u64 = 1 << 22;

/// Reads a height file, or a folder of tiles, whole: `width × height` samples, every one a finite number of metres or
/// NaN.
///
/// # Errors
/// A [`SourceError`] whose message is one line with the file's name and the cause. Damaged and hostile files give
/// errors too: neither a panic nor an allocation that the file's size does not justify.
pub fn open(path: &Path, progress: &dyn Progress) -> Result<HeightGrid, SourceError> {
    read_all(&*open_reader(path)?, path, progress)
}

/// Opens a height file, or a folder of tiles, to be read by windows, whatever its size. That its samples are all
/// no-data is found only by whoever reads them all.
///
/// # Errors
/// As [`open`].
pub fn open_reader(path: &Path) -> Result<Box<dyn HeightReader>, SourceError> {
    open_reader_with(path, &OpenOptions::default())
}

/// As [`open_reader`], for files that do not say all of themselves.
///
/// # Errors
/// As [`open`].
pub fn open_reader_with(path: &Path, options: &OpenOptions) -> Result<Box<dyn HeightReader>, SourceError> {
    let reader = undeclared::watch(open_as_it_is(path, options)?, path, options);
    Ok(match options.voids {
        VoidMode::Fill => voids::filled(reader),
        VoidMode::Holes => reader,
    })
}

/// With marks for no data that nobody declares.
fn open_as_it_is(path: &Path, options: &OpenOptions) -> Result<Box<dyn HeightReader>, SourceError> {
    if kind_of(path) == Kind::TileFolder {
        return Ok(Box::new(tile_folder::TileFolderReader::open(path, options)?));
    }
    let format = format::of(path, options)?;
    // What every format may need to be told.
    let special = OpenOptions { no_data: None, voids: VoidMode::default(), ..*options };
    if special != OpenOptions::default() && !matches!(format, Format::Png | Format::Raw) {
        tracing::warn!(
            "{}: says its size, spacing and heights itself; the options for them are passed over",
            path.display()
        );
    }
    let said = || side_file::Said::of(path, options);
    Ok(match format {
        Format::GeoTiff => geotiff::GeoTiffReader::open(path)?,
        Format::Png => geotiff::guarded(path, || png16::open(path, &said()?))?,
        Format::Hgt => Box::new(hgt::open(path)?),
        Format::ZippedHgt => Box::new(geotiff::guarded(path, || hgt::open_zip(path))?),
        Format::Dted { offset } => Box::new(dted::DtedReader::open(path, offset)?),
        Format::AsciiGrid => Box::new(ascii_grid::open(path)?),
        Format::UsgsDem => Box::new(usgs_dem::open(path)?),
        Format::Xyz => Box::new(xyz::open(path)?),
        Format::Ehdr { data, header } => Box::new(ehdr::open(&data, &header)?),
        Format::Envi { data, header } => Box::new(envi::open(&data, &header)?),
        Format::Raw => Box::new(raw::open(path, &said()?)?),
    })
}

/// Reads all that a reader has; `path` names it in errors.
///
/// # Errors
/// What the reader says; more samples than are held in memory; a grid without a single height.
pub fn read_all(reader: &dyn HeightReader, path: &Path, progress: &dyn Progress) -> Result<HeightGrid, SourceError> {
    let [width, height] = reader.size();
    let samples = u64::from(width) * u64::from(height);
    if samples > MAX_SAMPLES {
        return Err(SourceError::TooLarge { path: path.into(), width, height });
    }
    let mut heights_m = memory::room(path, [width, height], samples)?;
    // Whole rows of blocks, so that none is decoded twice.
    let block_rows = u64::from(reader.block()[1].max(1));
    let rows_at_once = (SAMPLES_PER_REPORT / u64::from(width) / block_rows).max(1) * block_rows;
    // Holes are filled when all is there, so that nothing is read twice.
    let bare = reader.filled().map_or(reader, Filled::bare);
    let mut row = 0;
    while row < height {
        progress.report("reading heights", row as f32 / height as f32);
        let rows = rows_at_once.min(u64::from(height - row)) as u32;
        heights_m.extend(bare.read(Window { x: 0, y: row, width, height: rows })?);
        row += rows;
    }
    progress.report("reading heights", 1.0);
    if heights_m.iter().all(|height: &f32| height.is_nan()) {
        return Err(SourceError::AllNoData { path: path.into() });
    }
    if let Some(filled) = reader.filled() {
        filled.fill_whole(&mut heights_m);
    }
    Ok(HeightGrid { width, height, heights_m, georeference: reader.georeference().clone() })
}
