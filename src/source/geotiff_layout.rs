//! What a TIFF's header claims, checked before anything of that size is allocated or decoded.

use std::path::Path;

use tiff_reader::{Ifd, TiffFile};

use super::SourceError;
use super::samples::SampleType;

/// More samples than this are not read into memory at once: 8 GiB of heights.
const MAX_SAMPLES: u64 = 1 << 31;
/// One strip or tile, decoded, all bands.
const MAX_BLOCK_BYTES: u64 = 1 << 31;
/// What a file may always decode to, however small it is.
const FREE_BYTES: u64 = 64 << 20;
/// Decoded bytes per byte of the file beyond that. Deflate reaches 1032; Zstandard and LERC go further on constant
/// data, of which a file of heights holds some but not only.
const MAX_RATIO: u64 = 32_768;

const TAG_SUBFILE_TYPE: u16 = 254;
const TAG_TILE_OFFSETS: u16 = 324;

/// A picture in the file that can be read as heights.
pub(super) struct Layout<'a> {
    pub ifd: &'a Ifd,
    pub width: u32,
    pub height: u32,
    pub sample_type: SampleType,
    /// Size of a strip or tile in samples.
    pub block: [usize; 2],
    /// Columns and rows of the first band's strips or tiles that the file leaves out, as [first, end).
    pub absent_blocks: Vec<[[usize; 2]; 2]>,
}

/// Chooses the picture and checks everything about it that can be known without decoding.
///
/// # Errors
/// Anything that is damaged, not a height field, not supported, too small or too large.
pub(super) fn check<'a>(file: &'a TiffFile, file_bytes: u64, path: &Path) -> Result<Layout<'a>, SourceError> {
    let inconsistent = |what: &str| SourceError::Inconsistent { path: path.into(), what: what.to_owned() };
    let subfile_type = |ifd: &Ifd| ifd.tag(TAG_SUBFILE_TYPE).and_then(|tag| tag.value.as_u32()).unwrap_or(0);
    // Bit 0 marks an overview, bit 2 a mask; a cloud-optimised file has both behind the full resolution.
    let full = file.ifds().iter().find(|ifd| subfile_type(ifd) & 0b101 == 0);
    let ifd = full.or(file.ifds().first()).ok_or_else(|| inconsistent("it holds no picture"))?;
    let layout = check_image(ifd, file_bytes, path)?;
    let (width, height) = (layout.width, layout.height);
    if u64::from(width) * u64::from(height) > MAX_SAMPLES {
        return Err(SourceError::TooLarge { path: path.into(), width, height });
    }
    Ok(layout)
}

/// Whether the picture is an overview: a smaller copy of another one, and no mask.
pub(super) fn is_overview(ifd: &Ifd) -> bool {
    ifd.tag(TAG_SUBFILE_TYPE).and_then(|tag| tag.value.as_u32()).unwrap_or(0) & 0b101 == 1
}

/// Checks everything about one picture that can be known without decoding.
///
/// # Errors
/// As [`check`].
pub(super) fn check_image<'a>(ifd: &'a Ifd, file_bytes: u64, path: &Path) -> Result<Layout<'a>, SourceError> {
    let inconsistent = |what: &str| SourceError::Inconsistent { path: path.into(), what: what.to_owned() };
    let (width, height) = (ifd.width(), ifd.height());
    if width == 0 || height == 0 {
        return Err(inconsistent("its width or height is missing or zero"));
    }
    require_heights(ifd, path)?;
    require_known_compression(ifd, path)?;
    if width < 2 || height < 2 {
        return Err(SourceError::TooSmall { path: path.into(), width, height });
    }
    let layout = ifd.raster_layout().map_err(|source| match source {
        tiff_reader::TiffError::UnsupportedBitsPerSample(bits) => {
            let kind = match ifd.sample_format().ok().and_then(|formats| formats.first().copied()) {
                Some(3) => "floating-point",
                Some(2) => "signed",
                _ => "unsigned",
            };
            SourceError::Unsupported { path: path.into(), what: format!("a {bits}-bit {kind} sample") }
        }
        tiff_reader::TiffError::InvalidImageLayout(_) if ifd.predictor() != 1 && is_bit_packed(ifd) => {
            SourceError::Unsupported { path: path.into(), what: "a predictor on bit-packed samples".to_owned() }
        }
        source => SourceError::Damaged { path: path.into(), source },
    })?;
    let sample_type = SampleType::from_format(layout.sample_format, layout.bytes_per_sample).ok_or_else(|| {
        let (bits, format) = (layout.bits_per_sample, layout.sample_format);
        SourceError::Unsupported { path: path.into(), what: format!("a sample of {bits} bits in format {format}") }
    })?;
    if layout.samples_per_pixel > 1 {
        tracing::warn!("{}: has {} bands; the first is taken as heights", path.display(), layout.samples_per_pixel);
    }

    let block = match (ifd.tile_width(), ifd.tile_height()) {
        (Some(width), Some(height)) => [width, height],
        _ => [width, ifd.rows_per_strip().min(height)],
    };
    if block.contains(&0) {
        return Err(inconsistent("its strips or tiles have no size"));
    }
    let interleaved = if layout.planar_configuration == 1 { layout.samples_per_pixel as u64 } else { 1 };
    let sample_bytes = layout.bytes_per_sample as u64;
    let samples = u64::from(width) * u64::from(height);
    let blocks_across = u64::from(width.div_ceil(block[0]));
    let block_count = blocks_across * u64::from(height.div_ceil(block[1]));
    // Saturating: a number that does not fit is larger than any bound, too.
    let block_bytes =
        u64::from(block[0]).saturating_mul(block[1].into()).saturating_mul(interleaved).saturating_mul(sample_bytes);
    let tables = if ifd.tag(TAG_TILE_OFFSETS).is_some() {
        (ifd.tile_offsets(), ifd.tile_byte_counts())
    } else {
        (ifd.strip_offsets(), ifd.strip_byte_counts())
    };
    let (Some(offsets), Some(counts)) = tables else {
        return Err(inconsistent("it does not say where its samples are"));
    };
    if (offsets.len() as u64) < block_count || (counts.len() as u64) < block_count {
        return Err(inconsistent("it lists fewer strips or tiles than its size needs"));
    }
    let is_absent = |index: usize| offsets[index] == 0 || counts[index] == 0;
    // Within both tables by the check above, so the conversion cannot cut anything off.
    let absent: Vec<usize> = (0..block_count as usize).filter(|&index| is_absent(index)).collect();

    let allowed = if ifd.compression() == 1 && absent.is_empty() {
        // Uncompressed samples lie in the file as they are; bit-packed ones grow at most eightfold.
        file_bytes.saturating_mul(8)
    } else {
        FREE_BYTES.saturating_add(file_bytes.saturating_mul(MAX_RATIO))
    };
    let too_large = || SourceError::TooLarge { path: path.into(), width, height };
    let band_bytes = samples.saturating_mul(sample_bytes);
    if block_bytes > MAX_BLOCK_BYTES {
        return Err(too_large());
    }
    // A tile of an uncompressed file may be larger than the picture, so only the picture is held against the file.
    if band_bytes > allowed || block_bytes > allowed.max(FREE_BYTES) {
        return Err(inconsistent(&format!("{width}×{height} samples cannot lie in {file_bytes} bytes")));
    }

    let block = block.map(|size| size as usize);
    let absent_blocks = absent
        .into_iter()
        .map(|index| {
            let (column, row) = (index % blocks_across as usize, index / blocks_across as usize);
            let span = |at: usize, size: usize, end: u32| [at * size, ((at + 1) * size).min(end as usize)];
            [span(column, block[0], width), span(row, block[1], height)]
        })
        .collect();
    Ok(Layout { ifd, width, height, sample_type, block, absent_blocks })
}

fn is_bit_packed(ifd: &Ifd) -> bool {
    ifd.bits_per_sample().is_ok_and(|bits| bits.iter().any(|bits| !matches!(bits, 8 | 16 | 32 | 64)))
}

fn require_heights(ifd: &Ifd, path: &Path) -> Result<(), SourceError> {
    let format = ifd.sample_format().ok().and_then(|formats| formats.first().copied());
    let what = match (format, ifd.photometric_interpretation()) {
        (Some(5 | 6), _) => "complex numbers",
        (_, Some(2)) => "an RGB picture",
        (_, Some(3)) => "a palette picture",
        (_, Some(4)) => "a mask",
        (_, Some(5)) => "a CMYK picture",
        (_, Some(6)) => "a YCbCr picture",
        (_, Some(8..=10)) => "a CIE L*a*b* picture",
        (_, Some(32_803)) => "a camera's raw picture",
        (_, Some(32_844 | 32_845)) => "a LogLuv picture",
        _ => return Ok(()),
    };
    Err(SourceError::NotHeights { path: path.into(), what })
}

fn require_known_compression(ifd: &Ifd, path: &Path) -> Result<(), SourceError> {
    let code = ifd.compression();
    let name = match code {
        // None, LZW, JPEG, Deflate (two codes), PackBits, LERC, Zstandard, WebP.
        1 | 5 | 7 | 8 | 32_946 | 32_773 | 34_887 | 50_000 | 50_001 => return Ok(()),
        2..=4 => "CCITT fax",
        6 => "old-style JPEG",
        34_676 | 34_677 => "SGI Log",
        34_712 => "JPEG 2000",
        34_925 => "LZMA",
        50_002 | 52_546 => "JPEG XL",
        _ => "of an unknown kind",
    };
    Err(SourceError::Unsupported { path: path.into(), what: format!("compression {name} ({code})") })
}
