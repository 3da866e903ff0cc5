//! Reads height files: turns them into heights in metres on a regular grid, with the position of that grid on the
//! earth.
//!
//! [`open_reader`] recognises a file by its content, not by its extension, and reads it window by window; [`open`]
//! reads the whole file. Whatever the file declares (no-data value, scale and offset, vertical unit) is applied on the
//! way, so that the result is metres, or NaN.
//!
//! Each format has its own module. Formats with an index or with samples at fixed offsets (GeoTIFF, `.hgt`, DTED, BIL,
//! GridFloat, ENVI, raw, tiles) are read by windows, whatever their size; text and PNG are decoded into memory, at 2 to
//! 4 bytes per sample. `statistics` reads a grid of any size without holding all of it in memory.
//!
//! The reasons are in `docs/decisions/height-readers.md`.

pub(crate) mod alignment;
mod archive;
mod ascii_grid;
pub(crate) mod cog;
pub(crate) mod color_image;
mod colour_proof;
pub(crate) mod continent;
mod crs_catalogue;
mod datum;
mod dted;
mod earth_place;
pub(crate) mod earth_projection;
mod ehdr;
mod encoding;
mod envi;
mod erosion;
mod error;
mod esri_citation;
mod exr_heights;
mod flat;
pub(crate) mod folder;
mod format;
mod geokeys;
pub mod georeference;
mod geotiff;
mod geotiff_layout;
mod hgt;
mod hillslope;
mod inputs;
pub(crate) mod lon_lat;
mod masked;
pub(crate) mod memory;
pub(crate) mod mosaic;
mod netcdf;
mod netcdf_axes;
mod picture;
mod place;
mod pmtiles;
mod png16;
mod prj;
pub mod procedural;
mod raster;
mod raw;
pub(crate) mod reader;
mod relief;
pub(crate) mod samples;
mod sidecar;
pub(crate) mod statistics;
mod terrain_rgb;
mod text;
mod tiff_blocks;
mod tiff_samples;
pub(crate) mod tiff_sidecars;
mod tile_folder;
mod tile_json;
mod tile_seams;
mod tile_set;
mod undeclared;
mod usgs_dem;
mod valley;
mod values;
pub(crate) mod voids;
mod webp;
pub(crate) mod wkt;
mod wkt_text;
mod world_mapping;
mod xyz;

use std::path::Path;
use std::sync::atomic::AtomicBool;

pub use earth_place::EarthPlace;
pub use encoding::{Encoding, HeightUnit, TileRows};
pub use error::SourceError;
pub(crate) use folder::{Kind, kind_of};
use format::Format;
pub use geokeys::{GeoKey, GeoKeyValue, GeoKeys};
use georeference::Georeference;
pub use georeference::GeoreferenceError;
pub(crate) use inputs::{add_inputs, files_of};
pub use reader::{GridReader, HeightReader, Window};
pub use sidecar::OpenOptions;
pub(crate) use statistics::Statistics;
pub(crate) use statistics::statistics;
pub(crate) use values::{Holds, open_values};
use voids::Filled;
pub use voids::VoidMode;
pub use world_mapping::WorldMapping;
pub(crate) use world_mapping::{GroundScale, ScaleRange};

/// A height field in memory, on the grid of its file, not resampled.
#[derive(Clone, Debug)]
pub struct HeightGrid {
    /// Samples per row, at least 2.
    pub width: u32,
    /// Rows, at least 2.
    pub height: u32,
    /// Heights in metres, row-major, in the file's row order; NaN where there is no data.
    pub heights_m: Vec<f32>,
    /// Position of the samples on the earth.
    pub georeference: Georeference,
}

/// Receives progress reports from long-running work.
pub trait Progress: Sync {
    /// Reports that `what` is in progress; `done` runs from 0 to 1. Called now and then, from any thread.
    fn report(&self, what: &str, done: f32);

    /// Returns whether the work is to stop. A bake then ends with an error; the files that it needs to continue stay.
    fn stop(&self) -> &AtomicBool {
        &NEVER
    }
}

static NEVER: AtomicBool = AtomicBool::new(false);

/// Ignores progress reports.
pub struct Silent;

impl Progress for Silent {
    fn report(&self, _what: &str, _done: f32) {}
}

/// Version of the readers' results. It changes when files yield other heights, or another position, than before;
/// pyramids baked with an older version are then baked again.
pub(crate) const VERSION: u32 = 4;

/// Largest number of samples that are read into memory at once: 8 GiB of heights.
pub(crate) const MAX_SAMPLES: u64 = 1 << 31;

/// Number of samples that are read between two progress reports.
const SAMPLES_PER_REPORT: u64 = 1 << 22;

/// Reads a whole height file, or a folder of tiles: `width × height` samples, each a finite number of metres or NaN.
///
/// # Errors
/// Returns a [`SourceError`] whose message is one line with the file's name and the cause. Damaged and hostile files
/// also give errors: they cause neither a panic nor an allocation that the file's size does not justify.
pub fn open(path: &Path, progress: &dyn Progress) -> Result<HeightGrid, SourceError> {
    read_all(&*open_reader(path)?, path, progress)
}

/// Opens a height file, or a folder of tiles, for reading by windows, whatever its size. If all samples are no-data,
/// only a caller that reads all of them finds out.
///
/// # Errors
/// The same as [`open`].
pub fn open_reader(path: &Path) -> Result<Box<dyn HeightReader>, SourceError> {
    open_reader_with(path, &OpenOptions::default())
}

/// Opens a height file as [`open_reader`] does, with options for what the file does not declare.
///
/// # Errors
/// The same as [`open`].
pub fn open_reader_with(path: &Path, options: &OpenOptions) -> Result<Box<dyn HeightReader>, SourceError> {
    let reader = open_as_it_is(path, options)?;
    if reader.is_coarse() {
        tracing::warn!(
            "{}: its samples have 8 bits, which is 256 heights at most; a hillshade or a picture holds no heights",
            path.display()
        );
    }
    let reader = undeclared::watch(reader, path, options)?;
    Ok(match options.voids {
        VoidMode::Fill => voids::filled(reader),
        VoidMode::Holes => reader,
    })
}

/// The options that tiles of terrain-RGB use.
const TILE_OPTIONS: [&str; 4] = ["--height-scale", "--height-offset", "--encoding", "--tile-rows"];

/// The name of a folder of tiles, with its article.
const TILE_FOLDER: &str = "a folder of tiles";

/// Returns the name of the format of a file, or of a folder of tiles, with its article.
///
/// # Errors
/// Fails if the file cannot be opened, or has none of the formats that hachure reads.
pub(crate) fn format_name(path: &Path, options: &OpenOptions) -> Result<&'static str, SourceError> {
    match kind_of(path) {
        Kind::TileFolder => Ok(TILE_FOLDER),
        Kind::Folder => Ok("a folder"),
        Kind::File => Ok(format::of(path, options)?.name(path)),
    }
}

/// Opens a file without filling holes and without looking for undeclared no-data values.
fn open_as_it_is(path: &Path, options: &OpenOptions) -> Result<Box<dyn HeightReader>, SourceError> {
    if kind_of(path) == Kind::TileFolder {
        options.warn_unused(path, TILE_FOLDER, &TILE_OPTIONS);
        return Ok(Box::new(geotiff::guarded(path, || tile_folder::open(path, options))?));
    }
    let format = format::of(path, options)?;
    let name = format.name(path);
    match format {
        // A picture's own options depend on its colours.
        Format::Png => {}
        // The content decides which options apply.
        Format::Container(_) => {}
        Format::Exr => options.warn_unused(path, name, &["--spacing", "--height-scale", "--height-offset"]),
        Format::Raw => options.warn_unused(
            path,
            name,
            &["--spacing", "--raw-size", "--height-scale", "--height-offset", "--raw-big-endian"],
        ),
        Format::PmTiles | Format::TileJson => options.warn_unused(path, name, &TILE_OPTIONS),
        _ => options.warn_unused(path, name, &[]),
    }
    let info = || sidecar::RasterInfo::of(path, options);
    Ok(match format {
        Format::GeoTiff => geotiff::GeoTiffReader::open(path)?,
        Format::Png => geotiff::guarded(path, || png16::open(path, &info()?, options))?,
        Format::PmTiles => Box::new(geotiff::guarded(path, || pmtiles::open(path, options))?),
        Format::TileJson => Box::new(geotiff::guarded(path, || tile_json::open(path, options))?),
        Format::Hgt => Box::new(hgt::open(path)?),
        Format::Container(container) => geotiff::guarded(path, || archive::open(path, container, options))?,
        Format::NetCdf => geotiff::guarded(path, || netcdf::open(path))?,
        Format::Exr => Box::new(geotiff::guarded(path, || exr_heights::open(path, &info()?))?),
        Format::Dted { offset } => Box::new(dted::DtedReader::open(path, offset)?),
        Format::AsciiGrid => Box::new(ascii_grid::open(path)?),
        Format::UsgsDem => Box::new(usgs_dem::open(path)?),
        Format::Xyz => Box::new(xyz::open(path)?),
        Format::Ehdr { data, header } => Box::new(ehdr::open(&data, &header)?),
        Format::Envi { data, header } => Box::new(envi::open(&data, &header)?),
        Format::Raw => Box::new(raw::open(path, &info()?)?),
    })
}

/// Reads all samples of a reader; `path` is the name in errors.
///
/// # Errors
/// Passes on the errors of the reader; also fails if there are more samples than fit in memory, or if no sample is a
/// height.
pub fn read_all(reader: &dyn HeightReader, path: &Path, progress: &dyn Progress) -> Result<HeightGrid, SourceError> {
    let [width, height] = reader.size();
    let samples = u64::from(width) * u64::from(height);
    if samples > MAX_SAMPLES {
        return Err(SourceError::TooLarge { path: path.into(), width, height });
    }
    let mut heights_m = memory::room(path, [width, height], samples)?;
    // Reads whole rows of blocks, so that no block is decoded twice.
    let block_rows = u64::from(reader.block()[1].max(1));
    let rows_at_once = (SAMPLES_PER_REPORT / u64::from(width) / block_rows).max(1) * block_rows;
    // Holes are filled at the end, when all samples are in memory, so that nothing is read twice.
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
