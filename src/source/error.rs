//! The errors of reading height files.

use std::path::PathBuf;

use tiff_reader::TiffError;

use super::georeference::GeoreferenceError;
use super::values::Holds;
use crate::file::message::{chain, named};
use crate::file::toml_text::TomlError;

/// The content of a TIFF with colours.
pub(super) const RGB_PICTURE: &str = "an RGB picture";

/// The reason why a height file could not be read. The message is one line that names the file and the cause;
/// `source()` returns the cause as a value where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SourceError {
    /// The file system refused to open the file.
    #[error("{}: cannot be opened: {source}", named(path))]
    Open {
        path: PathBuf,
        #[source]
        source: std::io::Error,
    },
    /// The path is a folder, a pipe or a device.
    #[error("{}: is {kind}, not a file", named(path))]
    NotAFile {
        path: PathBuf,
        /// The kind of the path, with its article, for example "a folder".
        kind: &'static str,
    },
    /// The file has zero bytes.
    #[error("{}: is empty", named(path))]
    Empty { path: PathBuf },
    /// The file has none of the formats that hachure reads.
    #[error(
        "{}: {looks_like}; hachure reads GeoTIFF, HGT, DTED, USGS DEM, ASCII grids, BIL, ENVI, 16-bit PNG, terrain-RGB, \
         PMTiles, netCDF, EXR, .r16 and XYZ",
        named(path)
    )]
    UnknownFormat {
        path: PathBuf,
        /// The type that the file appears to have, for example "is a PNG picture".
        looks_like: &'static str,
    },
    /// The TIFF contradicts itself or ends too early.
    #[error("{}: is damaged or truncated: {}", named(path), chain(source))]
    Damaged {
        path: PathBuf,
        /// The error of the TIFF reader.
        #[source]
        source: TiffError,
    },
    /// The file contradicts itself or ends too early; hachure's own message says where.
    #[error("{}: is damaged: {what}", named(path))]
    Inconsistent {
        path: PathBuf,
        /// The contradiction, as a clause that follows "is damaged:".
        what: String,
    },
    /// The file is valid, but uses a feature that hachure does not read.
    #[error("{}: {what} is not supported; gdal_translate may convert it", named(path))]
    Unsupported {
        path: PathBuf,
        /// The unsupported feature, for example "compression JPEG 2000 (34712)".
        what: String,
    },
    /// The file is a picture of something other than the expected values.
    #[error("{}: holds {what}, not {holds}{}", named(path), way_out(what, *holds))]
    NotHeights {
        path: PathBuf,
        /// The content of the file, for example "an RGB picture".
        what: &'static str,
        /// The content that was expected.
        holds: Holds,
    },
    /// The file leaves something open that its name, a sidecar file or an option has to give.
    #[error("{}: {why}", named(path))]
    Unclear {
        path: PathBuf,
        /// The missing information, and where it can be given.
        why: String,
    },
    /// The colours hold numbers that several encodings read as heights, or that none reads as heights of land.
    #[error(
        "{}: its colours may be {candidates}; give --encoding, and --height-scale and --height-offset if it has others",
        named(path)
    )]
    Encodings {
        path: PathBuf,
        /// The encodings with the heights that each gives, such as "mapbox (410 to 990 m) or gsi (1041 to 1099 m)".
        candidates: String,
    },
    /// The file in a container cannot be read.
    #[error("{}: {cause}", named(path))]
    InArchive {
        path: PathBuf,
        /// The error of the file, which begins with its name.
        cause: String,
    },
    /// The file in a container cannot be written to a folder.
    #[error("{}: cannot be unpacked into {}: {source}; HACHURE_CACHE sets another folder", named(path), named(folder))]
    Unpack {
        path: PathBuf,
        folder: PathBuf,
        #[source]
        source: std::io::Error,
    },
    /// The folder contains no height file.
    #[error("{}: the folder holds no height files", named(path))]
    NoMembers { path: PathBuf },
    /// The grid has a single row or column.
    #[error("{}: has {width}×{height} samples, but a surface needs at least 2×2", named(path))]
    TooSmall { path: PathBuf, width: u32, height: u32 },
    /// The grid has more samples than a format that must be decoded whole may have.
    #[error(
        "{}: {width}×{height} samples are more than can be decoded at once; convert it to a tiled GeoTIFF",
        named(path)
    )]
    TooLarge { path: PathBuf, width: u32, height: u32 },
    /// The system has not enough memory.
    #[error(
    "{}: not enough memory: reading {width}×{height} samples at once needs {} MB; convert it to a tiled GeoTIFF",
    named(path),
    needed_bytes.div_ceil(1_000_000)
  )]
    Memory {
        path: PathBuf,
        /// Samples per row of the part that was to be read at once.
        width: u32,
        /// Rows of that part.
        height: u32,
        /// Size of the allocation that failed, in bytes.
        needed_bytes: u64,
    },
    /// The file contains no height at all.
    #[error("{}: no sample holds a height: all are no-data, not finite, or beyond ±1000 km", named(path))]
    AllNoData { path: PathBuf },
    /// The files do not form a single grid.
    #[error("{}: {cause}", named(path))]
    Mosaic {
        /// Path of the first file.
        path: PathBuf,
        /// The mismatch, as a sentence.
        cause: String,
    },
    /// The sidecar file `NAME.ext.toml` is invalid.
    #[error(transparent)]
    Sidecar(#[from] TomlError),
    /// The position on the earth is unknown or impossible.
    #[error("{}: {source}", named(path))]
    Georeference { path: PathBuf, source: GeoreferenceError },
}

/// Returns what to do with a file that holds something else than was to be read; empty if nothing helps.
fn way_out(what: &str, holds: Holds) -> &'static str {
    match (what, holds) {
        (RGB_PICTURE, Holds::Heights) => {
            "; terrain-RGB is read only from PNG or lossless WebP: gdal_translate -of PNG IN OUT.png, then --encoding"
        }
        _ => "",
    }
}
