//! The search for NaN and infinity in the pictures and buffers that passes write
//! ([`Submits::Checked`](super::recorder::Submits)).
//!
//! Pictures and buffers of a frame have finite numbers only: none of them uses infinity or NaN as a sign for something.
//! The output of a pass is searched before the next pass runs, so the first number that is found comes from the pass
//! that produced it, not from one that read it.
//!
//! Why: `docs/decisions/finite-numbers.md`.

use std::fmt;

use super::buffer::Buffer;
use super::reflection::FloatWords;
use super::target::Content;
use super::trace::{PassTrace, Traced};
use super::{Gpu, GpuError, readback};

/// A number in a picture or buffer that is NaN or infinite.
#[derive(Clone, Debug, PartialEq)]
pub struct NonFinite {
    /// Name of the pass that wrote it.
    pub pass: &'static str,
    /// Name of the picture or buffer.
    pub target: &'static str,
    pub place: Place,
    /// The number itself: NaN, or an infinity.
    pub value: f32,
    /// Number of values of the layer, or of the searched part of the buffer, that are not finite.
    pub count: usize,
}

/// The place of a number in a picture or buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// In a picture.
    Texel {
        /// Size of the picture, in pixels.
        size_px: [u32; 2],
        /// Layer of an array; 0 for other pictures.
        layer: u32,
        /// Column and row.
        pixel: [u32; 2],
        /// Channel, from 0.
        channel: u32,
    },
    /// In a buffer: the index of a 32-bit word.
    Word(usize),
}

/// A buffer with floats that a pass writes.
pub(super) struct WrittenFloats {
    /// Index of the pass's submit in the frame.
    pub(super) submit: u32,
    /// Name of the pass.
    pub(super) pass: &'static str,
    pub(super) buffer: Buffer,
    pub(super) floats: FloatWords,
}

/// Largest part of a buffer that is searched, in words. Lists are filled from the beginning, and have room for far more
/// than a small picture puts into them.
const SEARCHED_WORDS: u64 = 1 << 16;

impl WrittenFloats {
    /// Searches the beginning of the buffer. Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::Readback`] if the device is lost or out of memory.
    pub(super) fn search(&self, gpu: &Gpu) -> Result<Option<NonFinite>, GpuError> {
        let Buffer { name, raw, offset, size } = &self.buffer;
        let rest = raw.size().saturating_sub(*offset);
        let words = (size.map_or(rest, |size| rest.min(size.get())) / 4).min(SEARCHED_WORDS);
        let first = (offset / 4) as usize;
        let read: Vec<u32> = readback::read_buffer(gpu, raw, first + words as usize)?;
        let found = search_words(&read[first..], &self.floats);
        Ok(found.map(|(word, value, count)| {
            let (pass, target, place) = (self.pass, *name, Place::Word(word));
            NonFinite { pass, target, place, value, count }
        }))
    }
}

/// Returns the first float among words that is not finite, with its index, and the number of all such floats.
fn search_words(words: &[u32], floats: &FloatWords) -> Option<(usize, f32, usize)> {
    let value = |word: &u32| f32::from_bits(*word);
    let mut wrong = words.iter().enumerate().filter(|(i, word)| !value(word).is_finite() && floats.is_float(*i));
    let (first, word) = wrong.next()?;
    Some((first, value(word), 1 + wrong.count()))
}

impl fmt::Display for NonFinite {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { pass, target, place, value, count } = self;
        write!(f, "the pass {pass} wrote {value} into ")?;
        match place {
            Place::Texel { size_px: [width, height], layer, pixel: [x, y], channel } => {
                write!(f, "the picture {target:?} ({width}x{height} px), pixel ({x}, {y})")?;
                if *layer > 0 {
                    write!(f, " of layer {layer}")?;
                }
                write!(f, ", channel {channel}")?;
            }
            Place::Word(word) => write!(f, "the buffer {target:?}, word {word}")?,
        }
        match count {
            1 => write!(f, ", the only one that is not finite of those searched"),
            count => write!(f, "; {count} of the numbers searched are not finite"),
        }
    }
}

/// The floats in the texels of a format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Floats {
    /// Number of channels.
    channels: usize,
    /// Bytes of a channel.
    bytes: usize,
    /// Mask of the channels that are floats.
    mask: u32,
}

impl Floats {
    /// Returns the floats in a picture; `None` if it has none.
    fn of(format: wgpu::TextureFormat, content: Option<Content>) -> Option<Self> {
        use wgpu::TextureFormat as Format;
        let [channels, bytes] = match format {
            Format::R16Float => [1, 2],
            Format::Rg16Float => [2, 2],
            Format::Rgba16Float => [4, 2],
            Format::R32Float | Format::Depth32Float | Format::R32Uint => [1, 4],
            Format::Rg32Float | Format::Rg32Uint => [2, 4],
            Format::Rgba32Float | Format::Rgba32Uint => [4, 4],
            _ => return None,
        };
        let is_words = matches!(format, Format::R32Uint | Format::Rg32Uint | Format::Rgba32Uint);
        let mask = if is_words { content.map_or(0, |content| content.float_words) } else { (1 << channels) - 1 };
        (mask != 0).then_some(Self { channels, bytes, mask })
    }

    /// Returns the first number that is not finite, as texel, channel and value, and the number of all such numbers.
    fn search(self, texels: &[u8]) -> Option<(usize, usize, f32, usize)> {
        let (mut first, mut count) = (None, 0);
        for (i, number) in texels.chunks_exact(self.bytes).enumerate() {
            // All bits of the exponent are set in infinity and NaN, and in no other number.
            let is_finite = match *number {
                [_, high] => high & 0x7c != 0x7c,
                [_, _, middle, high] => high & 0x7f != 0x7f || middle & 0x80 == 0,
                _ => true,
            };
            let channel = i % self.channels;
            if !is_finite && self.mask >> channel & 1 == 1 {
                count += 1;
                first.get_or_insert_with(|| (i / self.channels, channel, value_of(number)));
            }
        }
        first.map(|(texel, channel, value)| (texel, channel, value, count))
    }
}

/// Returns the value of a number of 16 or 32 bits that is NaN or infinite.
fn value_of(number: &[u8]) -> f32 {
    match *number {
        [low, high] if low == 0 && high & 3 == 0 => {
            if high & 0x80 == 0 {
                f32::INFINITY
            } else {
                f32::NEG_INFINITY
            }
        }
        [a, b, c, d] => f32::from_le_bytes([a, b, c, d]),
        _ => f32::NAN,
    }
}

/// Searches the pictures that a pass wrote, and returns at most one number of each. Waits for the GPU.
///
/// # Errors
/// [`GpuError::Readback`] if the device is lost or out of memory.
pub(super) fn search(gpu: &Gpu, pass: &PassTrace, found: &mut Vec<NonFinite>) -> Result<(), GpuError> {
    for written in &pass.writes {
        found.extend(search_picture(gpu, pass.name, written)?);
    }
    Ok(())
}

fn search_picture(gpu: &Gpu, pass: &'static str, written: &Traced) -> Result<Option<NonFinite>, GpuError> {
    let Some(texture) = &written.texture else { return Ok(None) };
    let Some(floats) = Floats::of(texture.format(), written.content) else { return Ok(None) };
    let size_px = [texture.width(), texture.height()];
    for layer in 0..texture.depth_or_array_layers() {
        let texels = readback::read_layer(gpu, texture, layer, [0, 0], size_px)?;
        if let Some((texel, channel, value, count)) = floats.search(&texels) {
            let (texel, channel) = (texel as u32, channel as u32);
            let pixel = [texel % size_px[0], texel / size_px[0]];
            let place = Place::Texel { size_px, layer, pixel, channel };
            return Ok(Some(NonFinite { pass, target: written.name, place, value, count }));
        }
    }
    Ok(None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::target::Group;

    #[test]
    fn every_float_that_is_not_finite_is_found() {
        let floats = |format| Floats::of(format, None);
        let of = |numbers: &[f32]| numbers.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>();
        let two = floats(wgpu::TextureFormat::Rg32Float).expect("it has floats");
        assert_eq!(two.search(&of(&[0.0, -0.0, f32::MAX, f32::MIN, 1e-45, 3.0])), None);
        for value in [f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(two.search(&of(&[0.0, 1.0, 2.0, value, value, 5.0])), Some((1, 1, value, 2)));
        }
        let found = two.search(&of(&[0.0, 1.0, f32::NAN, 3.0])).map(|(texel, channel, value, count)| {
            assert!(value.is_nan());
            (texel, channel, count)
        });
        assert_eq!(found, Some((1, 0, 1)));
        // Every number of 16 bits is judged as the type of that size judges it.
        let half = floats(wgpu::TextureFormat::R16Float).expect("it has floats");
        for bits in 0..=u16::MAX {
            let found = half.search(&bits.to_le_bytes()).map(|(_, _, value, _)| value);
            let expected = half::f16::from_bits(bits);
            assert_eq!(found.is_none(), expected.is_finite(), "{bits:#x}");
            assert!(found.is_none_or(|value| value == expected.to_f32() || expected.is_nan()), "{bits:#x}: {found:?}");
        }
    }

    #[test]
    fn words_that_hold_floats_are_searched() {
        let content = Group::Surface.shows("words").with_float_words(0b10);
        let words = Floats::of(wgpu::TextureFormat::Rg32Uint, Some(content)).expect("it has floats");
        let nan = f32::NAN.to_bits();
        let of = |words: [u32; 2]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
        assert_eq!(words.search(&of([nan, 1.0_f32.to_bits()])), None);
        assert_eq!(words.search(&of([0, nan])).map(|(_, channel, ..)| channel), Some(1));
        assert_eq!(Floats::of(wgpu::TextureFormat::Rg32Uint, None), None);
        assert_eq!(Floats::of(wgpu::TextureFormat::Rgba8Unorm, None), None);
    }
}
