//! Rasters of values other than heights that cover a world: shades of grey and classes.
//!
//! The readers of heights read them as plain numbers; the scale, offset and unit of a GeoTIFF are ignored, because a
//! class has none. Shades may also come from a grey PNG of any bit depth, which has no georeference.

use std::fmt;
use std::path::Path;

use png::ColorType;

use super::format::{self, Format};
use super::geotiff::{GeoTiffReader, guarded};
use super::memory::{self, MemoryReader};
use super::picture;
use super::place;
use super::{HeightReader, OpenOptions, SourceError, georeference};

/// The meaning of a file's samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// Heights in metres.
    Heights,
    /// Codes of land-cover classes.
    Classes,
    /// Shades, from nothing to everything.
    Shades,
}

impl fmt::Display for Holds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Heights => "heights",
            Self::Classes => "classes",
            Self::Shades => "shades of grey",
        })
    }
}

/// An open raster of shades or classes.
pub(crate) struct Values {
    /// Reader of the numbers; NaN where there is no data.
    pub reader: Box<dyn HeightReader>,
    /// The sample that means "everything"; smaller ones are fractions of it.
    pub full: f64,
    /// Whether the file has a georeference.
    pub is_located: bool,
}

/// Opens a raster of values.
///
/// # Errors
/// The same as [`super::open_reader`].
pub(crate) fn open_values(path: &Path, holds: Holds) -> Result<Values, SourceError> {
    match format::of(path, &OpenOptions::default())? {
        Format::GeoTiff => GeoTiffReader::open_as(path, holds),
        Format::Png if holds == Holds::Shades => guarded(path, || grey(path)),
        _ => Ok(Values { reader: super::open_reader(path)?, full: 1.0, is_located: true }),
    }
}

/// Decodes a whole grey picture.
fn grey(path: &Path) -> Result<Values, SourceError> {
    let refused = |what| Err(SourceError::NotHeights { path: path.into(), what, holds: Holds::Shades });
    let header = picture::header(path)?;
    place::check_size(path, header.size)?;
    if !matches!(header.color, ColorType::Grayscale | ColorType::GrayscaleAlpha) {
        return refused("a picture in colours");
    }
    let picture = picture::decode(path)?;
    let [width, height] = picture.size;
    let mut shades = memory::room(path, picture.size, u64::from(width) * u64::from(height))?;
    // A single transparent shade (a tRNS chunk) is also decoded as an alpha channel.
    let pixels = picture.bytes.chunks_exact(picture.channels * picture.channel_bytes);
    shades.extend(pixels.map(|pixel| match (picture.channel_bytes, pixel) {
        (1, [_, 0]) | (2, [_, _, 0, 0]) => f32::NAN,
        (1, [shade, ..]) => f32::from(*shade),
        (_, [high, low, ..]) => f32::from(u16::from_be_bytes([*high, *low])),
        _ => f32::NAN,
    }));
    let full = if picture.channel_bytes == 1 { 255.0 } else { 65_535.0 };
    let identity = place::identity(&[path], "shades\n");
    let georeference = georeference::assumed();
    let (path, size) = (path.into(), picture.size);
    let reader = MemoryReader { path, size, heights_m: shades, unit_m: 1.0, georeference, identity };
    Ok(Values { reader: Box::new(reader), full, is_located: false })
}
