//! Grey PNG of 16 bits: the heightmap of game engines. How high a step is, how far samples are apart and where they lie
//! comes from a side file or from options.

use std::path::Path;

use png::{BitDepth, ColorType};

use super::SourceError;
use super::memory::{self, MemoryReader};
use super::place;
use super::samples::{Meaning, SampleType, Tally, Told};
use super::side_file::Said;
use super::{picture, terrain_rgb};

/// Reads a PNG: a heightmap, or terrain-RGB.
pub(super) fn open(path: &Path, said: &Said) -> Result<MemoryReader, SourceError> {
    let header = picture::header(path)?;
    place::check_size(path, header.size)?;
    let refused = |what| Err(SourceError::NotHeights { path: path.into(), what });
    match (header.color, header.depth) {
        (ColorType::Grayscale | ColorType::GrayscaleAlpha, BitDepth::Sixteen) => grey(path, said),
        (ColorType::Grayscale | ColorType::GrayscaleAlpha, _) => refused("a grey picture of 8 bits or less"),
        (_, BitDepth::Sixteen) => refused("a colour picture of 16 bits"),
        _ => terrain_rgb::open(path, said),
    }
}

fn grey(path: &Path, said: &Said) -> Result<MemoryReader, SourceError> {
    let picture = picture::decode(path)?;
    let georeference = said.georeference(path, picture.size)?;
    let [scale, offset] = said.steps(path);
    let meaning =
        Meaning { sample_type: SampleType::U16, no_data: said.side.no_data, scale, offset, metres_per_unit: 1.0 };
    let mut heights_m = memory::room(path, picture.size)?;
    let mut tally = Tally::default();
    let (samples, _) = picture.bytes.as_chunks::<2>();
    for pixel in samples.chunks_exact(picture.channels) {
        let is_transparent = pixel.get(1) == Some(&[0, 0]);
        let value = f64::from(u16::from_be_bytes(pixel[0]));
        heights_m.push(if is_transparent { f32::NAN } else { meaning.height_m(value, &mut tally) });
    }
    Told::default().tell(path, &tally);
    Ok(MemoryReader { path: path.into(), size: picture.size, heights_m, georeference, identity: said.identity(path) })
}
