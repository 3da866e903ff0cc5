//! What kind of file this is, by its first bytes: a height file that is not TIFF is called by its name in the error.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::SourceError;

/// Enough for every signature below and for the header words of the text formats.
const HEAD_BYTES: u64 = 512;

/// First bytes and what they mean.
const SIGNATURES: &[(&[u8], &str)] = &[
    (b"\x89PNG\r\n\x1a\n", "is a PNG picture"),
    (b"\xff\xd8\xff", "is a JPEG picture"),
    (b"GIF8", "is a GIF picture"),
    (b"BM", "is a BMP picture"),
    (b"RIFF", "is a RIFF file (WebP?)"),
    (b"\0\0\0\x0cjP  ", "is a JPEG 2000 picture"),
    (b"\x76\x2f\x31\x01", "is an EXR picture"),
    (b"PK\x03\x04", "is a ZIP archive"),
    (b"\x1f\x8b", "is a gzip archive"),
    (b"\x28\xb5\x2f\xfd", "is a Zstandard archive"),
    (b"\x89HDF\r\n\x1a\n", "is an HDF5 file"),
    (b"CDF\x01", "is a netCDF file"),
    (b"CDF\x02", "is a netCDF file"),
    (b"GRIB", "is a GRIB file"),
    (b"LASF", "is a LAS point cloud"),
    (b"UHL1", "is a DTED file"),
    (b"DSAA", "is a Surfer grid"),
    (b"DSBB", "is a Surfer grid"),
    (b"DSRB", "is a Surfer grid"),
    (b"ENVI", "is an ENVI header"),
    (b"EHFA_HEADER_TAG", "is an ERDAS Imagine file"),
    (b"%PDF", "is a PDF"),
    (b"<VRT", "is a GDAL virtual raster"),
    (b"<?xml", "is an XML file"),
    (b"<", "is a markup file"),
    (b"{", "is a JSON file"),
];

/// First words of text formats, in lower case.
const FIRST_WORDS: &[(&str, &str)] = &[
    ("ncols", "is an ESRI ASCII grid"),
    ("nrows", "is an ESRI ASCII grid"),
    ("north:", "is a GRASS ASCII grid"),
    ("byteorder", "is an ESRI raster header"),
    ("v", "is an OBJ model"),
    ("o", "is an OBJ model"),
    ("g", "is an OBJ model"),
    ("mtllib", "is an OBJ model"),
    ("newmtl", "is an OBJ material library"),
];

/// Checks that the file can be opened and begins as a TIFF or BigTIFF does.
///
/// # Errors
/// [`SourceError::Open`], `NotAFile`, `Empty`, `NotTiff`.
pub(super) fn require_tiff(path: &Path) -> Result<(), SourceError> {
    let cannot_open = |source| SourceError::Open { path: path.into(), source };
    let metadata = std::fs::metadata(path).map_err(cannot_open)?;
    // Asked before opening: to open a pipe that nobody writes to waits forever.
    if !metadata.is_file() {
        return Err(SourceError::NotAFile { path: path.into() });
    }
    if metadata.len() == 0 {
        return Err(SourceError::Empty { path: path.into() });
    }
    let mut head = Vec::new();
    File::open(path).and_then(|file| file.take(HEAD_BYTES).read_to_end(&mut head)).map_err(cannot_open)?;
    match head.get(..4) {
        Some(b"II*\0" | b"MM\0*" | b"II+\0" | b"MM\0+") => Ok(()),
        _ => Err(SourceError::NotTiff { path: path.into(), looks_like: describe(&head, metadata.len()) }),
    }
}

/// What a file of `len` bytes that begins with `head` looks like, as a verb phrase.
fn describe(head: &[u8], len: u64) -> &'static str {
    if let Some((_, what)) = SIGNATURES.iter().find(|(signature, _)| head.starts_with(signature)) {
        return what;
    }
    // SRTM tiles have no header at all: their size is the only mark.
    if matches!(len, 2_884_802 | 25_934_402 | 12_967_202) {
        return "is an SRTM tile (.hgt)";
    }
    let is_text = head.iter().all(|&byte| matches!(byte, b'\t' | b'\n' | b'\r' | b' '..=b'~') || byte >= 0x80);
    if !is_text {
        return "is not a TIFF";
    }
    let text = String::from_utf8_lossy(head).to_ascii_lowercase();
    let words = text.lines().filter(|line| !line.trim_start().starts_with('#')).flat_map(str::split_whitespace);
    let first_word = words.into_iter().next().unwrap_or("");
    FIRST_WORDS.iter().find(|(word, _)| *word == first_word).map_or("is a text file", |(_, what)| what)
}
