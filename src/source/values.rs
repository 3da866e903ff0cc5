//! Rasters of other things than heights, which lie over a world: shades, classes.
//!
//! They are read by the readers of heights, as numbers: of a GeoTIFF scale, offset and unit are passed over, for a class
//! has none. Shades may also come from a grey PNG, of any depth, which says nothing of where it lies.

use std::fmt;
use std::path::Path;

use png::ColorType;

use super::format::{self, Format};
use super::geotiff::{GeoTiffReader, guarded};
use super::memory::{self, MemoryReader};
use super::picture;
use super::place;
use super::{HeightReader, OpenOptions, SourceError, georeference};

/// What the samples of a file are taken for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holds {
    /// Metres.
    Heights,
    /// Numbers that stand for something.
    Classes,
    /// From nothing to all.
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

/// An open raster.
pub struct Values {
    /// Its numbers; NaN where there is no data.
    pub reader: Box<dyn HeightReader>,
    /// The shade that means all.
    pub full: f64,
    /// Whether it says where it lies.
    pub is_located: bool,
}

/// Opens a raster.
///
/// # Errors
/// As [`super::open_reader`].
pub fn open_values(path: &Path, holds: Holds) -> Result<Values, SourceError> {
    match format::of(path, &OpenOptions::default())? {
        Format::GeoTiff => GeoTiffReader::open_as(path, holds),
        Format::Png if holds == Holds::Shades => guarded(path, || grey(path)),
        _ => Ok(Values { reader: super::open_reader(path)?, full: 1.0, is_located: true }),
    }
}

/// A grey picture, decoded whole.
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
    // Transparency of one shade is a channel, too.
    let pixels = picture.bytes.chunks_exact(picture.channels * picture.channel_bytes);
    shades.extend(pixels.map(|pixel| match (picture.channel_bytes, pixel) {
        (1, [_, 0]) | (2, [_, _, 0, 0]) => f32::NAN,
        (1, [shade, ..]) => f32::from(*shade),
        (_, [high, low, ..]) => f32::from(u16::from_be_bytes([*high, *low])),
        _ => f32::NAN,
    }));
    let full = if picture.channel_bytes == 1 { 255.0 } else { 65_535.0 };
    let identity = place::identity(&[path], "shades\n");
    let georeference = georeference::unsaid();
    let reader = MemoryReader { path: path.into(), size: picture.size, heights_m: shades, georeference, identity };
    Ok(Values { reader: Box::new(reader), full, is_located: false })
}
