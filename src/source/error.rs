//! What can be wrong with a height file.

use std::path::PathBuf;

use tiff_reader::TiffError;

use super::georeference::GeoreferenceError;
use super::values::Holds;
use crate::file::message::{chain, named};
use crate::file::toml_text::TomlError;

/// Why a height file could not be read. The message is one line that names the file and the cause; `source()` gives the
/// cause as a value where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// The file system says no.
    #[error("{}: cannot be opened: {source}", named(path))]
    Open {
        /// Of the file.
        path: PathBuf,
        /// What the file system says.
        #[source]
        source: std::io::Error,
    },
    /// A folder, a pipe, a device.
    #[error("{}: is not a regular file", named(path))]
    NotAFile {
        /// Of the file.
        path: PathBuf,
    },
    /// Zero bytes.
    #[error("{}: is empty", named(path))]
    Empty {
        /// Of the file.
        path: PathBuf,
    },
    /// None of the formats that are read.
    #[error(
        "{}: {looks_like}; hachure reads GeoTIFF, HGT, DTED, USGS DEM, ASCII grids, BIL, GridFloat, ENVI, 16-bit PNG, \
         terrain-RGB, raw .r16 and XYZ",
        named(path)
    )]
    UnknownFormat {
        /// Of the file.
        path: PathBuf,
        /// What it is instead: "is a PNG picture".
        looks_like: &'static str,
    },
    /// The TIFF contradicts itself, or ends too early.
    #[error("{}: is damaged or truncated: {}", named(path), chain(source))]
    Damaged {
        /// Of the file.
        path: PathBuf,
        /// What the TIFF reader says.
        #[source]
        source: TiffError,
    },
    /// The file contradicts itself or ends too early, in words of ours.
    #[error("{}: is damaged: {what}", named(path))]
    Inconsistent {
        /// Of the file.
        path: PathBuf,
        /// The contradiction.
        what: String,
    },
    /// Sane, but written in a way that is not read here.
    #[error("{}: {what} is not supported; gdal_translate may convert it", named(path))]
    Unsupported {
        /// Of the file.
        path: PathBuf,
        /// The compression or sample type: "compression JPEG 2000 (34712)".
        what: String,
    },
    /// A picture, but not of heights, or of what else was to be read.
    #[error("{}: holds {what}, not {holds}", named(path))]
    NotHeights {
        /// Of the file.
        path: PathBuf,
        /// What it holds: "an RGB picture".
        what: &'static str,
        /// What it should hold.
        holds: Holds,
    },
    /// What the file leaves open has to be said elsewhere: in its name, a file beside it, an option.
    #[error("{}: {why}", named(path))]
    Unclear {
        /// Of the file.
        path: PathBuf,
        /// What is missing, and where it could be said.
        why: String,
    },
    /// A folder without a single height file.
    #[error("{}: the folder holds no height files", named(path))]
    NoMembers {
        /// Of the folder.
        path: PathBuf,
    },
    /// A single row or column.
    #[error("{}: has {width}×{height} samples, but a surface needs at least 2×2", named(path))]
    TooSmall {
        /// Of the file.
        path: PathBuf,
        /// Samples per row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// More samples than a format is read with that has to be decoded whole.
    #[error(
        "{}: {width}×{height} samples are more than can be decoded at once; convert it to a tiled GeoTIFF",
        named(path)
    )]
    TooLarge {
        /// Of the file.
        path: PathBuf,
        /// Samples per row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// The system does not give the memory.
    #[error(
        "{}: {width}×{height} samples at once need {} MB of memory, which cannot be had",
        named(path),
        needed_bytes.div_ceil(1_000_000)
    )]
    Memory {
        /// Of the file.
        path: PathBuf,
        /// Samples per row, of what was to be read at once.
        width: u32,
        /// Rows.
        height: u32,
        /// That were asked for.
        needed_bytes: u64,
    },
    /// Nothing to draw.
    #[error("{}: no sample holds a height: all are no-data, not finite, or beyond ±1000 km", named(path))]
    AllNoData {
        /// Of the file.
        path: PathBuf,
    },
    /// Several files that are no single grid.
    #[error("{}: {cause}", named(path))]
    Mosaic {
        /// Of the first file.
        path: PathBuf,
        /// What does not fit.
        cause: String,
    },
    /// The file beside it that says what it means (`NAME.ext.toml`) does not hold.
    #[error(transparent)]
    SideFile(#[from] TomlError),
    /// The place on the earth is unknown or impossible.
    #[error("{}: {source}", named(path))]
    Georeference {
        /// Of the file.
        path: PathBuf,
        /// What is wrong with it.
        source: GeoreferenceError,
    },
}
