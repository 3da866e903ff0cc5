//! Images that are decoded as a whole: PNG, WebP and JPEG.

use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use jpeg_decoder::{Decoder, PixelFormat};

use super::super::georeference::{self, Georeference};
use super::super::place::{cannot_open, foreign_message, inconsistent, unclear};
use super::super::sidecar::RasterInfo;
use super::super::{OpenOptions, SourceError, memory, picture};
use super::{MOST_PX_IN_MEMORY, Rgba};
use crate::file::input::open_regular;

/// The format of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ImageFormat {
    Tiff,
    /// PNG or WebP.
    Png,
    Jpeg,
}

/// Recognises a file by its first bytes.
///
/// # Errors
/// The file cannot be opened, or is none of the formats.
pub(super) fn format_of(path: &Path) -> Result<ImageFormat, SourceError> {
    let file = open_regular(path).map_err(cannot_open(path))?;
    let mut head = Vec::new();
    file.take(12).read_to_end(&mut head).map_err(cannot_open(path))?;
    match &*head {
        [] => Err(SourceError::Empty { path: path.into() }),
        [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => Ok(ImageFormat::Tiff),
        [0x89, b'P', b'N', b'G', ..] | [b'R', b'I', b'F', b'F', ..] => Ok(ImageFormat::Png),
        [0xff, 0xd8, 0xff, ..] => Ok(ImageFormat::Jpeg),
        _ => Err(unclear(path, "is not an image; images on the land are GeoTIFF, PNG, WebP or JPEG")),
    }
}

/// Returns the position of an image that has none of its own, and whether a sidecar file gives it.
pub(super) fn place(path: &Path, size: [u32; 2]) -> Result<(Georeference, bool), SourceError> {
    let info = RasterInfo::of(path, &OpenOptions::default())?;
    match info.is_located() {
        true => Ok((info.georeference(path, size)?, true)),
        false => Ok((georeference::assumed(), false)),
    }
}

/// Decodes an image.
pub(super) fn whole(path: &Path, format: ImageFormat) -> Result<([u32; 2], Vec<Rgba>), SourceError> {
    if format == ImageFormat::Jpeg {
        return jpeg(path);
    }
    check_size(path, picture::header(path)?.size)?;
    let picture = picture::decode(path)?;
    let mut pixels = room(path, picture.size)?;
    let high = picture.channel_bytes;
    pixels.extend(picture.bytes.chunks_exact(picture.channels * high).map(|pixel| {
        // The high byte of a channel comes first.
        let channel = |index: usize| pixel[index * high];
        match picture.channels {
            1 => [channel(0), channel(0), channel(0), 255],
            2 => [channel(0), channel(0), channel(0), channel(1)],
            3 => [channel(0), channel(1), channel(2), 255],
            _ => [channel(0), channel(1), channel(2), channel(3)],
        }
    }));
    Ok((picture.size, pixels))
}

fn jpeg(path: &Path) -> Result<([u32; 2], Vec<Rgba>), SourceError> {
    let damaged = |error: jpeg_decoder::Error| inconsistent(path, foreign_message(&error));
    let mut decoder = Decoder::new(BufReader::new(File::open(path).map_err(cannot_open(path))?));
    decoder.read_info().map_err(damaged)?;
    let info = decoder.info().ok_or_else(|| inconsistent(path, "it has no size"))?;
    let size = [u32::from(info.width), u32::from(info.height)];
    check_size(path, size)?;
    let bytes = decoder.decode().map_err(damaged)?;
    let mut pixels = room(path, size)?;
    let shade = |shade: u8| [shade, shade, shade, 255];
    match info.pixel_format {
        PixelFormat::L8 => pixels.extend(bytes.iter().map(|value| shade(*value))),
        PixelFormat::L16 => pixels
            .extend(bytes.as_chunks::<2>().0.iter().map(|value| shade(u16::from_ne_bytes(*value).to_be_bytes()[0]))),
        PixelFormat::RGB24 => {
            pixels.extend(bytes.as_chunks::<3>().0.iter().map(|&[red, green, blue]| [red, green, blue, 255]));
        }
        PixelFormat::CMYK32 => {
            return Err(SourceError::Unsupported { path: path.into(), what: "a CMYK image".to_owned() });
        }
    }
    match pixels.len() as u64 == u64::from(size[0]) * u64::from(size[1]) {
        true => Ok((size, pixels)),
        false => Err(inconsistent(path, "its decoded size differs from that in its header")),
    }
}

fn room(path: &Path, size: [u32; 2]) -> Result<Vec<Rgba>, SourceError> {
    memory::room(path, size, u64::from(size[0]) * u64::from(size[1]))
}

fn check_size(path: &Path, [width, height]: [u32; 2]) -> Result<(), SourceError> {
    match u64::from(width) * u64::from(height) {
        0 => Err(inconsistent(path, "its width or height is missing or zero")),
        count if count > MOST_PX_IN_MEMORY => Err(SourceError::TooLarge { path: path.into(), width, height }),
        _ => Ok(()),
    }
}
