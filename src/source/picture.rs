//! PNG pictures (ISO/IEC 15948) as samples: what heightmaps and terrain-RGB have in common.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use png::{BitDepth, ColorType, Decoder, DecodingError, Transformations};

use super::SourceError;
use super::place::{cannot_open, inconsistent};

/// Deflate packs 1032 bytes into one at best; so many more are free for the header.
const MAX_RATIO: u64 = 1032;
const FREE_BYTES: u64 = 1 << 16;
/// A picture is decoded whole.
const MAX_SAMPLES: u64 = 1 << 28;

/// What the header says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub size: [u32; 2],
    pub color: ColorType,
    pub depth: BitDepth,
}

/// A decoded picture.
pub(super) struct Picture {
    pub size: [u32; 2],
    /// Grey, grey and alpha, red green blue, or all four.
    pub channels: usize,
    /// Bytes of a channel: 1, or 2 with the larger first.
    pub channel_bytes: usize,
    /// By rows, without gaps.
    pub bytes: Vec<u8>,
}

/// Reads the header alone.
pub(super) fn header(path: &Path) -> Result<Header, SourceError> {
    let mut decoder = Decoder::new(BufReader::new(File::open(path).map_err(cannot_open(path))?));
    let info = decoder.read_header_info().map_err(|error| damaged(path, &error))?;
    Ok(Header { size: [info.width, info.height], color: info.color_type, depth: info.bit_depth })
}

/// Decodes a picture; palettes become colours.
pub(super) fn decode(path: &Path) -> Result<Picture, SourceError> {
    let file = File::open(path).map_err(cannot_open(path))?;
    let file_bytes = file.metadata().map_err(cannot_open(path))?.len();
    let mut decoder = Decoder::new(BufReader::new(file));
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(|error| damaged(path, &error))?;
    let [width, height] = [reader.info().width, reader.info().height];
    let too_large = || SourceError::TooLarge { path: path.into(), width, height };
    if u64::from(width) * u64::from(height) > MAX_SAMPLES {
        return Err(too_large());
    }
    let needed = reader.output_buffer_size().ok_or_else(too_large)?;
    // Bits of a palette grow to three bytes, in the decoder and not in the file.
    let packed = (reader.info().raw_bytes() as u64).min(needed as u64);
    if packed > FREE_BYTES + file_bytes.saturating_mul(MAX_RATIO) {
        return Err(inconsistent(path, format!("{width}×{height} samples cannot lie in {file_bytes} bytes")));
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(needed).map_err(|_| too_large())?;
    bytes.resize(needed, 0);
    let info = reader.next_frame(&mut bytes).map_err(|error| damaged(path, &error))?;
    bytes.truncate(info.buffer_size());
    let channel_bytes = if info.bit_depth == BitDepth::Sixteen { 2 } else { 1 };
    let picture = Picture { size: [width, height], channels: info.color_type.samples(), channel_bytes, bytes };
    if picture.bytes.len() != width as usize * height as usize * picture.channels * channel_bytes {
        return Err(inconsistent(path, "it decodes to another size than its header says"));
    }
    Ok(picture)
}

fn damaged(path: &Path, error: &DecodingError) -> SourceError {
    inconsistent(path, error.to_string().split_whitespace().collect::<Vec<_>>().join(" "))
}
