//! Decodes the samples of a TIFF: converts their stored form to numbers in the machine's byte order.
//!
//! Samples of whole bytes have the file's byte order. Samples of odd numbers of bits follow each other without gaps,
//! the highest bit first, and each row begins at a new byte (TIFF 6.0, section 2). Floating-point numbers of 16 and 24
//! bits are those of Adobe's TIFF Technical Note 3.

use std::path::Path;

use half::f16;
use tiff_reader::{ByteOrder, ExtraSample, Ifd, TiffError, filters};

use super::SourceError;
use super::geotiff::damaged;
use super::samples::SampleType;

/// Codecs with which the predictor tag is valid: LZW, DEFLATE (two codes), Zstandard, LZMA. libtiff ignores the tag
/// with all others.
const CODECS_WITH_PREDICTOR: [u16; 5] = [5, 8, 32_946, 50_000, 34_925];

const UNSIGNED: u16 = 1;
const SIGNED: u16 = 2;
const FLOATING: u16 = 3;
/// Sample format "undefined", which libtiff reads as unsigned.
const UNDEFINED: u16 = 4;

/// The stored form of a picture's samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Samples {
    /// Bits of a sample in the file.
    pub bits: u16,
    format: u16,
    predictor: u16,
    /// Number of bands.
    pub per_pixel: usize,
    /// Whether each band has its own strips or tiles.
    pub is_planar: bool,
    /// Type of the decoded samples.
    pub decoded: SampleType,
    /// Index of the alpha band, if there is one.
    pub alpha: Option<usize>,
}

impl Samples {
    /// Reads the form of the samples from the tags of a picture.
    ///
    /// # Errors
    /// Fails if tags contradict each other, or if the kind of samples is not supported.
    pub(super) fn of(ifd: &Ifd, path: &Path) -> Result<Self, SourceError> {
        let damaged = damaged(path);
        let unsupported = |what: String| SourceError::Unsupported { path: path.into(), what };
        let all_bits = ifd.bits_per_sample().map_err(damaged)?;
        let formats = ifd.sample_format().map_err(damaged)?;
        let (bits, format) = match (&*all_bits, &*formats) {
            ([bits, ..], [format, ..]) => (*bits, if *format == UNDEFINED { UNSIGNED } else { *format }),
            _ => return Err(damaged(TiffError::InvalidImageLayout("it has no sample type".into()))),
        };
        if all_bits.iter().any(|other| *other != bits) || formats.iter().any(|other| *other != formats[0]) {
            return Err(unsupported("a picture with bands of different types".to_owned()));
        }
        let per_pixel = usize::from(ifd.samples_per_pixel());
        if per_pixel == 0 {
            return Err(damaged(TiffError::InvalidImageLayout("it has no bands".into())));
        }
        let decoded = match (format, bits) {
            (UNSIGNED, 1..=8) => SampleType::U8,
            (UNSIGNED, 9..=16) => SampleType::U16,
            (UNSIGNED, 17..=32) => SampleType::U32,
            (UNSIGNED, 64) => SampleType::U64,
            (SIGNED, 8) => SampleType::I8,
            (SIGNED, 16) => SampleType::I16,
            (SIGNED, 32) => SampleType::I32,
            (SIGNED, 64) => SampleType::I64,
            (FLOATING, 16 | 24 | 32) => SampleType::F32,
            (FLOATING, 64) => SampleType::F64,
            _ => {
                let kind = match format {
                    UNSIGNED => "unsigned",
                    SIGNED => "signed",
                    FLOATING => "floating-point",
                    _ => return Err(unsupported(format!("a sample of {bits} bits in format {format}"))),
                };
                return Err(unsupported(format!("a {bits}-bit {kind} sample")));
            }
        };
        let is_planar = match ifd.planar_configuration() {
            1 => false,
            2 => true,
            other => return Err(damaged(TiffError::UnsupportedPlanarConfiguration(other))),
        };
        let predictor = if CODECS_WITH_PREDICTOR.contains(&ifd.compression()) { ifd.predictor() } else { 1 };
        match (predictor, bits) {
            (1, _) | (2, 8 | 16 | 32 | 64) | (3, 16 | 32 | 64) => {}
            (2 | 3, _) => return Err(unsupported("a predictor on bit-packed samples".to_owned())),
            _ => return Err(unsupported(format!("predictor {predictor}"))),
        }
        // Bands beyond those of the colour model come last.
        let extra = ifd.extra_samples().unwrap_or_default();
        let is_alpha =
            |kind: &ExtraSample| matches!(kind, ExtraSample::AssociatedAlpha | ExtraSample::UnassociatedAlpha);
        let alpha = extra.iter().position(is_alpha).and_then(|at| (at + per_pixel).checked_sub(extra.len()));
        let alpha = alpha.filter(|&band| band > 0);
        Ok(Self { bits, format, predictor, per_pixel, is_planar, decoded, alpha })
    }

    /// Returns the number of bands that are stored together in a block.
    pub(super) fn interleaved(&self) -> usize {
        if self.is_planar { 1 } else { self.per_pixel }
    }

    /// Returns whether samples have the same form in the file as in memory, except for their byte order.
    pub(super) fn are_plain(&self) -> bool {
        self.predictor == 1 && usize::from(self.bits) == 8 * self.decoded.bytes()
    }

    /// Converts the rows of a block to samples of the type `decoded`, in the machine's byte order.
    pub(super) fn unpack(
        &self,
        mut bytes: Vec<u8>,
        row_bytes: usize,
        columns: usize,
        order: ByteOrder,
    ) -> Result<Vec<u8>, TiffError> {
        let per_row = columns * self.interleaved();
        let is_big_endian = order == ByteOrder::BigEndian;
        match self.bits {
            8 | 16 | 32 | 64 => {
                for row in bytes.chunks_exact_mut(row_bytes.max(1)) {
                    let bands = self.interleaved() as u16;
                    filters::fix_endianness_and_predict(row, self.bits, bands, order, self.predictor)?;
                }
                if (self.format, self.bits) == (FLOATING, 16) {
                    let halves = bytes.as_chunks::<2>().0.iter();
                    return Ok(halves.flat_map(|&half| f16::from_ne_bytes(half).to_f32().to_ne_bytes()).collect());
                }
                Ok(bytes)
            }
            24 => {
                let threes = bytes.as_chunks::<3>().0.iter();
                // GDAL writes integers of 24 bits as a stream of bits, which libtiff then swaps in files of the other
                // byte order, so that the highest byte comes first in little-endian files and last in others.
                let is_highest_first = is_big_endian == (self.format == FLOATING);
                let whole = threes.map(|&[a, b, c]| match is_highest_first {
                    true => u32::from_be_bytes([0, a, b, c]),
                    false => u32::from_le_bytes([a, b, c, 0]),
                });
                Ok(match self.format {
                    FLOATING => whole.flat_map(|bits| float_of_24_bits(bits).to_ne_bytes()).collect(),
                    _ => whole.flat_map(u32::to_ne_bytes).collect(),
                })
            }
            bits => {
                let mut samples = Vec::with_capacity(bytes.len() / row_bytes.max(1) * per_row * self.decoded.bytes());
                for row in bytes.chunks_exact(row_bytes.max(1)) {
                    for index in 0..per_row {
                        let value = bits_at(row, index * usize::from(bits), usize::from(bits));
                        match self.decoded {
                            SampleType::U8 => samples.push(value as u8),
                            SampleType::U16 => samples.extend((value as u16).to_ne_bytes()),
                            _ => samples.extend(value.to_ne_bytes()),
                        }
                    }
                }
                Ok(samples)
            }
        }
    }
}

/// Returns `count` bits, at most 32, that begin at bit `first` of a row, the highest bit of each byte first.
fn bits_at(row: &[u8], first: usize, count: usize) -> u32 {
    let mut value = 0u64;
    for byte in &row[first / 8..(first + count).div_ceil(8)] {
        value = value << 8 | u64::from(*byte);
    }
    let unused = (8 - (first + count) % 8) % 8;
    (value >> unused & ((1 << count) - 1)) as u32
}

/// Decodes a float of 24 bits: a sign, 7 bits of exponent with a bias of 63, and 16 bits of mantissa.
fn float_of_24_bits(bits: u32) -> f32 {
    let sign = if bits >> 23 & 1 == 1 { -1.0 } else { 1.0 };
    let (exponent, mantissa) = ((bits >> 16 & 0x7f) as i32, (bits & 0xffff) as f32 / 65_536.0);
    match exponent {
        0 => sign * mantissa * 2f32.powi(-62),
        127 if mantissa == 0.0 => sign * f32::INFINITY,
        127 => f32::NAN,
        _ => sign * (1.0 + mantissa) * 2f32.powi(exponent - 63),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn odd_bits_are_taken_from_the_highest_on() {
        // The row contains two samples of 12 bits: 0xabc, 0xdef.
        let row = [0xab, 0xcd, 0xef];
        assert_eq!([bits_at(&row, 0, 12), bits_at(&row, 12, 12)], [0xabc, 0xdef]);
        assert_eq!((0..8).map(|bit| bits_at(&[0b1010_0110], bit, 1)).collect::<Vec<_>>(), [1, 0, 1, 0, 0, 1, 1, 0]);
        assert_eq!(bits_at(&[0x01, 0xff, 0xff, 0xff, 0xfe], 7, 32), u32::MAX);
        assert_eq!(bits_at(&[0x3f, 0xff, 0xff, 0xff], 2, 30), (1 << 30) - 1);
    }

    #[test]
    fn floats_of_24_bits() {
        let of = |exponent: u32, mantissa: u32| float_of_24_bits(exponent << 16 | mantissa);
        assert_eq!([of(63, 0), of(64, 0x8000), of(0, 0)], [1.0, 3.0, 0.0]);
        assert_eq!(float_of_24_bits(1 << 23 | 73 << 16), -1024.0);
        assert!(of(127, 1).is_nan() && of(127, 0).is_infinite());
        assert_eq!(of(0, 0x8000), of(1, 0) * 0.5, "numbers below the smallest exponent go on evenly");
    }
}
