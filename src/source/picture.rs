//! Decodes PNG pictures (ISO/IEC 15948), and lossless WebP pictures (`webp`), for heightmaps and terrain-RGB. A picture is
//! either decoded completely and held with the samples of its file (2 to 4 bytes per pixel), or a PNG is read row by row
//! from the top, one row at a time.

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read, Seek};
use std::path::{Path, PathBuf};

use png::{BitDepth, ColorType, Decoder, DecodingError, Reader, Transformations};

use super::SourceError;
use super::place::{cannot_open, foreign_message, inconsistent};
use super::{memory, webp};
use crate::file::input::most_deflated_bytes;

/// Largest size of a tile's file.
const MAX_TILE_BYTES: u64 = 64 << 20;

/// The size, colour type and bit depth from a picture's header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub size: [u32; 2],
    pub color: ColorType,
    pub depth: BitDepth,
}

/// A decoded picture.
pub(super) struct Picture {
    pub size: [u32; 2],
    /// Channels per pixel: grey; grey and alpha; red, green, blue; or these and alpha.
    pub channels: usize,
    /// Bytes per channel: 1, or 2 in big-endian order.
    pub channel_bytes: usize,
    /// The pixels row by row, without padding.
    pub bytes: Vec<u8>,
}

/// Reads only the header.
pub(super) fn header(path: &Path) -> Result<Header, SourceError> {
    let mut source = BufReader::new(File::open(path).map_err(cannot_open(path))?);
    if webp::begins(source.fill_buf().map_err(cannot_open(path))?) {
        return webp::header(path, source);
    }
    let mut decoder = Decoder::new(source);
    let info = decoder.read_header_info().map_err(|error| damaged(path, &error))?;
    Ok(Header { size: [info.width, info.height], color: info.color_type, depth: info.bit_depth })
}

/// Reads the rows of a picture from the top.
pub(super) struct Rows {
    path: PathBuf,
    reader: Reader<BufReader<File>>,
    row: Vec<u8>,
    /// Index of the next row.
    pub next: u32,
}

impl Rows {
    /// Opens a picture before its first row; returns `None` for an interlaced picture, whose rows are not stored in
    /// order.
    ///
    /// # Errors
    /// The same as [`decode`], as far as the header reveals them.
    pub(super) fn open(path: &Path) -> Result<Option<Self>, SourceError> {
        let (reader, _) = begin_file(path)?;
        if reader.info().interlaced {
            return Ok(None);
        }
        let size = [reader.info().width, reader.info().height];
        let row_bytes = reader.output_line_size(size[0]).ok_or(SourceError::TooLarge {
            path: path.into(),
            width: size[0],
            height: size[1],
        })?;
        let mut row = memory::room(path, [size[0], 1], row_bytes as u64)?;
        row.resize(row_bytes, 0);
        Ok(Some(Self { path: path.into(), reader, row, next: 0 }))
    }

    /// Returns the samples of the next row.
    ///
    /// # Errors
    /// Fails if the file is damaged or ends before this row.
    pub(super) fn read(&mut self) -> Result<&[u8], SourceError> {
        let read = self.reader.read_row(&mut self.row).map_err(|error| damaged(&self.path, &error))?;
        read.ok_or_else(|| inconsistent(&self.path, format!("it ends before row {}", self.next)))?;
        self.next += 1;
        Ok(&self.row)
    }
}

/// Decodes a picture file; palettes become colours.
pub(super) fn decode(path: &Path) -> Result<Picture, SourceError> {
    let mut source = BufReader::new(File::open(path).map_err(cannot_open(path))?);
    if webp::begins(source.fill_buf().map_err(cannot_open(path))?) {
        return webp::decode(path, source);
    }
    decode_png(path, begin_file(path)?)
}

/// Decodes a picture in memory; `path` is its name in errors.
pub(super) fn decode_bytes(path: &Path, bytes: &[u8]) -> Result<Picture, SourceError> {
    match webp::begins(bytes) {
        true => webp::decode(path, Cursor::new(bytes)),
        false => decode_png(path, begin(path, Cursor::new(bytes), bytes.len() as u64)?),
    }
}

/// Reads the file of a small picture, such as a tile, into memory.
pub(super) fn small_file(path: &Path) -> Result<Vec<u8>, SourceError> {
    let file = File::open(path).map_err(cannot_open(path))?;
    let mut bytes = Vec::new();
    file.take(MAX_TILE_BYTES + 1).read_to_end(&mut bytes).map_err(cannot_open(path))?;
    match bytes.len() as u64 > MAX_TILE_BYTES {
        true => Err(inconsistent(path, format!("a tile of more than {} MiB is not read", MAX_TILE_BYTES >> 20))),
        false => Ok(bytes),
    }
}

fn decode_png<R: BufRead + Seek>(
    path: &Path,
    (mut reader, needed): (Reader<R>, usize),
) -> Result<Picture, SourceError> {
    let [width, height] = [reader.info().width, reader.info().height];
    let mut bytes = memory::room(path, [width, height], needed as u64)?;
    bytes.resize(needed, 0);
    let info = reader.next_frame(&mut bytes).map_err(|error| damaged(path, &error))?;
    bytes.truncate(info.buffer_size());
    let channel_bytes = if info.bit_depth == BitDepth::Sixteen { 2 } else { 1 };
    let picture = Picture { size: [width, height], channels: info.color_type.samples(), channel_bytes, bytes };
    if picture.bytes.len() != width as usize * height as usize * picture.channels * channel_bytes {
        return Err(inconsistent(path, "its decoded size differs from that in its header"));
    }
    Ok(picture)
}

/// Opens a file as [`begin`] does.
fn begin_file(path: &Path) -> Result<(Reader<BufReader<File>>, usize), SourceError> {
    let file = File::open(path).map_err(cannot_open(path))?;
    let file_bytes = file.metadata().map_err(cannot_open(path))?.len();
    begin(path, BufReader::new(file), file_bytes)
}

/// Returns a decoder that has read up to the samples, and the decoded size in bytes.
fn begin<R: BufRead + Seek>(path: &Path, source: R, file_bytes: u64) -> Result<(Reader<R>, usize), SourceError> {
    let mut decoder = Decoder::new(source);
    decoder.set_transformations(Transformations::EXPAND);
    let reader = decoder.read_info().map_err(|error| damaged(path, &error))?;
    let [width, height] = [reader.info().width, reader.info().height];
    memory::check_count(path, [width, height])?;
    let too_large = || SourceError::TooLarge { path: path.into(), width, height };
    let needed = reader.output_buffer_size().ok_or_else(too_large)?;
    // The decoder expands a palette index of a few bits to three bytes, so the packed size is compared with the file.
    let packed = (reader.info().raw_bytes() as u64).min(needed as u64);
    if packed > most_deflated_bytes(file_bytes) {
        return Err(inconsistent(path, format!("{width}×{height} samples do not fit in {file_bytes} bytes")));
    }
    Ok((reader, needed))
}

fn damaged(path: &Path, error: &DecodingError) -> SourceError {
    inconsistent(path, foreign_message(error))
}
