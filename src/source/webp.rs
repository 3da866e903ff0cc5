//! Decodes lossless WebP pictures (RFC 9649) for terrain-RGB. Lossy ones are refused: their colours are not those that
//! were stored, and a step of the highest byte is a thousand metres or more.

use std::io::{BufRead, Seek};
use std::path::Path;

use image_webp::{DecodingError, WebPDecoder};
use png::{BitDepth, ColorType};

use super::SourceError;
use super::memory;
use super::picture::{Header, Picture};
use super::place::{foreign_message, inconsistent, unclear};

/// Largest number of pixels: WebP has no largest compression ratio, so the size of the file does not bound it.
const MAX_PIXELS: u64 = 1 << 26;

/// Returns whether a file with these first bytes is a WebP picture.
pub(super) fn begins(bytes: &[u8]) -> bool {
    bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP")
}

/// Reads only the header.
pub(super) fn header<R: BufRead + Seek>(path: &Path, source: R) -> Result<Header, SourceError> {
    let decoder = begin(path, source)?;
    let color = if decoder.has_alpha() { ColorType::Rgba } else { ColorType::Rgb };
    Ok(Header { size: decoder.dimensions().into(), color, depth: BitDepth::Eight })
}

/// Decodes a picture.
pub(super) fn decode<R: BufRead + Seek>(path: &Path, source: R) -> Result<Picture, SourceError> {
    let mut decoder = begin(path, source)?;
    let size: [u32; 2] = decoder.dimensions().into();
    let channels = if decoder.has_alpha() { 4 } else { 3 };
    let needed = u64::from(size[0]) * u64::from(size[1]) * channels as u64;
    let mut bytes = memory::room(path, size, needed)?;
    bytes.resize(needed as usize, 0);
    decoder.read_image(&mut bytes).map_err(|error| damaged(path, &error))?;
    Ok(Picture { size, channels, channel_bytes: 1, bytes })
}

fn begin<R: BufRead + Seek>(path: &Path, source: R) -> Result<WebPDecoder<R>, SourceError> {
    let mut decoder = WebPDecoder::new(source).map_err(|error| damaged(path, &error))?;
    if decoder.is_animated() {
        return Err(unclear(path, "is an animated WebP picture, not heights"));
    }
    if decoder.is_lossy() {
        let why = "is a lossy WebP picture, whose colours no longer hold heights; they need lossless WebP or PNG";
        return Err(unclear(path, why));
    }
    let (width, height) = decoder.dimensions();
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(SourceError::TooLarge { path: path.into(), width, height });
    }
    Ok(decoder)
}

fn damaged(path: &Path, error: &DecodingError) -> SourceError {
    inconsistent(path, foreign_message(error))
}
