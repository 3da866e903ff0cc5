//! Recognises the format of a file by its content: its first bytes, its length, its sidecar files. The extension
//! decides only if the content is inconclusive (`.hgt`, `.r16`) or ambiguous (`.hdr`).

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::SourceError;
use super::archive::{self, Container};
use super::place::{cannot_open, ending, unclear};
use super::sidecar::{OpenOptions, sidecar_path};
use super::{dted, ehdr, hgt, tile_json, usgs_dem, webp, xyz};
use crate::file::input;
use crate::file::message::shown;

/// Number of bytes that are examined: enough for every signature and for the header words of the text formats.
const HEAD_BYTES: u64 = 2048;

/// A supported format, with the findings that opening it needs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Format {
    GeoTiff,
    /// A PNG or WebP picture.
    Png,
    PmTiles,
    TileJson,
    Hgt,
    /// A compressed file or an archive.
    Container(Container),
    NetCdf,
    Exr,
    Dted {
        offset: u64,
    },
    AsciiGrid,
    UsgsDem,
    Xyz,
    Ehdr {
        data: PathBuf,
        header: PathBuf,
    },
    Envi {
        data: PathBuf,
        header: PathBuf,
    },
    Raw,
}

impl Format {
    /// Returns the name of the format with its article, for people.
    pub(super) fn name(&self, path: &Path) -> &'static str {
        match self {
            Self::GeoTiff => "a GeoTIFF",
            Self::Png if ending(path) == "webp" => "a WebP picture",
            Self::Png => "a PNG picture",
            Self::PmTiles => "a PMTiles archive",
            Self::TileJson => "a TileJSON",
            Self::Hgt => "an SRTM .hgt",
            Self::Container(Container::Zip) => "a zip archive",
            Self::Container(Container::Tar) => "a tar archive",
            Self::Container(Container::Gzip) => "a gzip archive",
            Self::NetCdf => "a netCDF file",
            Self::Exr => "an EXR picture",
            Self::Dted { .. } => "a DTED",
            Self::AsciiGrid => "an ASCII grid",
            Self::UsgsDem => "a USGS DEM",
            Self::Xyz => "XYZ points",
            Self::Ehdr { data, .. } if ending(data) == "flt" => "a GridFloat",
            Self::Ehdr { .. } => "a BIL, BIP or BSQ raster",
            Self::Envi { .. } => "an ENVI raster",
            Self::Raw => "a raw heightmap",
        }
    }
}

/// Length of a signature that proves the format of a file. The samples of a raw raster may begin with a shorter one by
/// chance.
const PROOF_BYTES: usize = 8;

/// First bytes of unsupported formats, and their descriptions.
const SIGNATURES: &[(&[u8], &str)] = &[
    (b"\xff\xd8\xff", "is a JPEG picture"),
    (b"GIF8", "is a GIF picture"),
    (b"BM", "is a BMP picture"),
    (b"RIFF", "is a RIFF file (audio or video?)"),
    (b"SQLite format 3\0", "is an SQLite file (`pmtiles convert` converts MBTiles)"),
    (b"\0\0\0\x0cjP  ", "is a JPEG 2000 picture (gdal_translate converts it)"),
    (b"\x28\xb5\x2f\xfd", "is a Zstandard archive"),
    (b"GRIB", "is a GRIB file (gdal_translate converts it)"),
    (b"LASF", "is a LAS point cloud"),
    (b"DSAA", "is a Surfer grid (gdal_translate converts it)"),
    (b"DSBB", "is a Surfer grid (gdal_translate converts it)"),
    (b"DSRB", "is a Surfer grid (gdal_translate converts it)"),
    (b"EHFA_HEADER_TAG", "is an ERDAS Imagine file (gdal_translate converts it)"),
    (b"%PDF", "is a PDF"),
    (b"<VRT", "is a GDAL virtual raster (gdal_translate converts it)"),
    (b"<?xml", "is an XML file"),
    (b"<", "is a markup file"),
    (b"{", "is a JSON file"),
];

/// Extensions of data that are nothing without a header, `NAME.hdr`.
const HEADED_ENDINGS: [&str; 4] = ["bil", "bip", "bsq", "flt"];

/// First words of unsupported text formats, in lower case.
const FIRST_WORDS: &[(&str, &str)] = &[
    ("v", "is an OBJ model"),
    ("o", "is an OBJ model"),
    ("g", "is an OBJ model"),
    ("mtllib", "is an OBJ model"),
    ("newmtl", "is an OBJ material library"),
];

/// First words of ASCII grids, in lower case.
const GRID_WORDS: [&str; 17] = [
    "ncols",
    "nrows",
    "xllcorner",
    "yllcorner",
    "xllcenter",
    "yllcenter",
    "cellsize",
    "dx",
    "dy",
    "nodata_value",
    "north:",
    "south:",
    "east:",
    "west:",
    "rows:",
    "cols:",
    "null:",
];

/// Returns the format of a file.
///
/// # Errors
/// Returns [`SourceError::Open`], `NotAFile`, `Empty` or `UnknownFormat`; also fails for a header without its data.
pub(super) fn of(path: &Path, options: &OpenOptions) -> Result<Format, SourceError> {
    let metadata = std::fs::metadata(path).map_err(cannot_open(path))?;
    // This check comes before opening: opening a pipe without a writer would wait forever.
    if !metadata.is_file() {
        return Err(SourceError::NotAFile { path: path.into(), kind: input::kind(metadata.file_type()) });
    }
    if metadata.len() == 0 {
        return Err(SourceError::Empty { path: path.into() });
    }
    let head = beginning_of(path)?;
    if let Some(format) = by_signature(&head) {
        return Ok(format);
    }
    let unknown = |looks_like| Err(SourceError::UnknownFormat { path: path.into(), looks_like });
    // An .img with an ENVI or ESRI header next to it may still be another program's file.
    if let Some(what) = proved(&head) {
        return unknown(what);
    }
    let (ending, length) = (ending(path), metadata.len());
    if let Some(format) = with_header(path, &ending, &head)? {
        return Ok(format);
    }
    let is_tile = hgt::size_by_length(length).is_some()
        && path.file_name().and_then(|name| hgt::corner_by_name(&name.to_string_lossy())).is_some();
    if ending == "hgt" || is_tile {
        return Ok(Format::Hgt);
    }
    // The sidecar file of these describes the content, or the tiles.
    if archive::is_gzip(&head) && ["gz", "tgz"].contains(&&*ending) {
        return Ok(Format::Container(Container::Gzip));
    }
    if begins_as_json(&head) && tile_json::is_tile_json(path) {
        return Ok(Format::TileJson);
    }
    if ending == "r16" || sidecar_path(path).is_some() || (options.size.is_some() && !is_text(&head)) {
        return Ok(Format::Raw);
    }
    if ending == "raw" && !is_text(&head) {
        return Ok(Format::Raw);
    }
    if archive::is_gzip(&head) {
        return Ok(Format::Container(Container::Gzip));
    }
    if let Some((_, what)) = SIGNATURES.iter().find(|(signature, _)| head.starts_with(signature)) {
        return unknown(what);
    }
    if !is_text(&head) {
        if HEADED_ENDINGS.contains(&&*ending) {
            let header = path.with_extension("hdr");
            let header = header.file_name().unwrap_or_default().to_string_lossy();
            return Err(unclear(path, format!("its header {} is missing", shown(&header))));
        }
        return unknown("is not a known format");
    }
    if usgs_dem::is_header(&head) {
        return Ok(Format::UsgsDem);
    }
    let text = String::from_utf8_lossy(&head).trim_start_matches('\u{feff}').to_ascii_lowercase();
    let words = text.lines().filter(|line| !line.trim_start().starts_with('#')).flat_map(str::split_whitespace);
    let first_word = words.into_iter().next().unwrap_or("");
    if GRID_WORDS.contains(&first_word) {
        return Ok(Format::AsciiGrid);
    }
    if let Some((_, what)) = FIRST_WORDS.iter().find(|(word, _)| *word == first_word) {
        return unknown(what);
    }
    match xyz::is_beginning(&text, length <= HEAD_BYTES) {
        true => Ok(Format::Xyz),
        false => unknown("is a text file"),
    }
}

fn beginning_of(path: &Path) -> Result<Vec<u8>, SourceError> {
    let mut head = Vec::new();
    File::open(path).and_then(|file| file.take(HEAD_BYTES).read_to_end(&mut head)).map_err(cannot_open(path))?;
    Ok(head)
}

/// Returns the description of a file whose first bytes cannot be raw samples by chance.
fn proved(head: &[u8]) -> Option<&'static str> {
    let found = SIGNATURES.iter().find(|(it, _)| it.len() >= PROOF_BYTES && head.starts_with(it));
    found.map(|(_, what)| *what)
}

fn by_signature(head: &[u8]) -> Option<Format> {
    match head {
        [b'I', b'I', b'*' | b'+', 0, ..] | [b'M', b'M', 0, b'*' | b'+', ..] => Some(Format::GeoTiff),
        _ if head.starts_with(b"\x89PNG\r\n\x1a\n") || webp::begins(head) => Some(Format::Png),
        [b'C', b'D', b'F', 1 | 2 | 5, ..] => Some(Format::NetCdf),
        // The version, 2, and its flags follow the signature.
        [0x76, 0x2f, 0x31, 1, 2, _, 0, 0, ..] => Some(Format::Exr),
        _ if head.starts_with(b"PMTiles") => Some(Format::PmTiles),
        _ if head.starts_with(b"\x89HDF\r\n\x1a\n") => Some(Format::NetCdf),
        _ => archive::proved(head)
            .map(Format::Container)
            .or_else(|| dted::header_offset(head).map(|offset| Format::Dted { offset })),
    }
}

/// Returns the format of a data file with a header, or of a header with its data.
fn with_header(path: &Path, ending: &str, head: &[u8]) -> Result<Option<Format>, SourceError> {
    let is_header = ending == "hdr" || head.starts_with(b"ENVI");
    let Some(partner) = ehdr::partner(path) else {
        return match is_header && is_text(head) {
            true => {
                Err(SourceError::Unclear { path: path.into(), why: "is a header, but its data file is missing".into() })
            }
            false => Ok(None),
        };
    };
    let (data, header) = if is_header { (partner, path.to_owned()) } else { (path.to_owned(), partner) };
    if is_header && let Some(looks_like) = proved(&beginning_of(&data)?) {
        return Err(SourceError::UnknownFormat { path: data, looks_like });
    }
    let beginning = beginning_of(&header)?;
    if beginning.starts_with(b"ENVI") {
        return Ok(Some(Format::Envi { data, header }));
    }
    Ok(ehdr::is_header(&String::from_utf8_lossy(&beginning)).then_some(Format::Ehdr { data, header }))
}

fn begins_as_json(head: &[u8]) -> bool {
    String::from_utf8_lossy(head).trim_start_matches('\u{feff}').trim_start().starts_with('{')
}

fn is_text(head: &[u8]) -> bool {
    head.iter().all(|&byte| matches!(byte, b'\t' | b'\n' | b'\r' | b' '..=b'~') || byte >= 0x80)
}
