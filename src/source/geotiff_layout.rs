//! What a TIFF's header claims, checked before anything of that size is allocated or decoded.

use std::ops::Range;
use std::path::Path;

use tiff_reader::{Ifd, TiffFile};

use super::SourceError;
use super::flat::Strides;
use super::reader::Window;
use super::samples::SampleType;

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
pub(super) struct Layout {
    pub ifd: Ifd,
    pub width: u32,
    pub height: u32,
    pub sample_type: SampleType,
    /// Size of a strip or tile in samples.
    pub block: [usize; 2],
    /// Of one that is decoded, with all bands that lie in it.
    pub block_bytes: u64,
    /// Where samples that are not compressed lie one after the other from the first strip to the last.
    pub strides: Option<Strides>,
    /// For each of the first band's strips or tiles, by rows, whether the file leaves it out. Empty where it leaves out
    /// none.
    is_absent: Vec<bool>,
}

impl Layout {
    /// Whether the file leaves out all of the blocks that a window touches.
    pub fn is_absent(&self, window: Window) -> bool {
        let is_inside =
            |at: u32, count: u32, size: u32| count > 0 && at.checked_add(count).is_some_and(|it| it <= size);
        if self.is_absent.is_empty()
            || !is_inside(window.x, window.width, self.width)
            || !is_inside(window.y, window.height, self.height)
        {
            return false;
        }
        let [columns, rows] = self.block;
        let blocks_across = (self.width as usize).div_ceil(columns);
        let blocks =
            |at: u32, count: u32, size: usize| at as usize / size..(at as usize + count as usize).div_ceil(size);
        let across = blocks(window.x, window.width, columns);
        blocks(window.y, window.height, rows)
            .all(|row| self.is_absent[row * blocks_across..][across.clone()].iter().all(|&it| it))
    }

    /// Columns and rows, from the window's first sample on, of the blocks in it that the file leaves out.
    pub fn absent_in(&self, window: Window) -> impl Iterator<Item = [Range<usize>; 2]> + '_ {
        let window = [window.x, window.y, window.width, window.height].map(|it| it as usize);
        let [x, y, width, height] = window;
        let blocks_across = (self.width as usize).div_ceil(self.block[0]);
        let blocks = |axis: usize| {
            let (first, count) = (window[axis], window[axis + 2]);
            first / self.block[axis]..(first + count).div_ceil(self.block[axis])
        };
        let across = blocks(0);
        let all = blocks(1).filter(|_| !self.is_absent.is_empty());
        let all = all.flat_map(move |row| across.clone().map(move |column| (column, row)));
        all.filter(move |(column, row)| self.is_absent[row * blocks_across + column]).map(move |(column, row)| {
            let span = |at: usize, size: usize, first: usize, count: usize| {
                (at * size).saturating_sub(first)..((at + 1) * size - first).min(count)
            };
            [span(column, self.block[0], x, width), span(row, self.block[1], y, height)]
        })
    }
}

/// Chooses the picture and checks everything about it that can be known without decoding.
///
/// # Errors
/// Anything that is damaged, not a height field, not supported, too small or too large.
pub(super) fn check(file: &TiffFile, file_bytes: u64, path: &Path) -> Result<Layout, SourceError> {
    let inconsistent = |what: &str| SourceError::Inconsistent { path: path.into(), what: what.to_owned() };
    let subfile_type = |ifd: &Ifd| ifd.tag(TAG_SUBFILE_TYPE).and_then(|tag| tag.value.as_u32()).unwrap_or(0);
    // Bit 0 marks an overview, bit 2 a mask; a cloud-optimised file has both behind the full resolution.
    let full = file.ifds().iter().find(|ifd| subfile_type(ifd) & 0b101 == 0);
    let ifd = full.or(file.ifds().first()).ok_or_else(|| inconsistent("it holds no picture"))?;
    check_image(ifd, file_bytes, path)
}

/// Whether the picture is an overview: a smaller copy of another one, and no mask.
pub(super) fn is_overview(ifd: &Ifd) -> bool {
    ifd.tag(TAG_SUBFILE_TYPE).and_then(|tag| tag.value.as_u32()).unwrap_or(0) & 0b101 == 1
}

/// Checks everything about one picture that can be known without decoding.
///
/// # Errors
/// As [`check`].
pub(super) fn check_image(ifd: &Ifd, file_bytes: u64, path: &Path) -> Result<Layout, SourceError> {
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
    let mut absent: Vec<bool> = (0..block_count as usize).map(is_absent).collect();
    if !absent.contains(&true) {
        absent.clear();
    }

    let allowed = if ifd.compression() == 1 && absent.is_empty() {
        // Uncompressed samples lie in the file as they are; bit-packed ones grow at most eightfold.
        file_bytes.saturating_mul(8)
    } else {
        FREE_BYTES.saturating_add(file_bytes.saturating_mul(MAX_RATIO))
    };
    let too_large = || SourceError::TooLarge { path: path.into(), width, height };
    // What the file leaves out needs no bytes in it, and is never decoded.
    let stored = block_count - absent.iter().filter(|&&it| it).count() as u64;
    let stored_samples = u64::from(block[0]).saturating_mul(block[1].into()).saturating_mul(stored);
    let band_bytes = samples.min(stored_samples).saturating_mul(sample_bytes);
    let row_bytes = u64::from(width) * interleaved * sample_bytes;
    let is_plain = ifd.compression() == 1
        && ifd.predictor() == 1
        && ifd.fill_order() == 1
        && ifd.tag(TAG_TILE_OFFSETS).is_none()
        && absent.is_empty()
        && ifd.bits_per_sample().is_ok_and(|bits| bits.iter().all(|&bits| u64::from(bits) == 8 * sample_bytes));
    let strip = |index: usize| offsets[0].checked_add(index as u64 * u64::from(block[1]) * row_bytes);
    // Only the first band's strips, should each band have its own.
    let follow = || offsets.iter().take(block_count as usize).enumerate().all(|(index, &at)| strip(index) == Some(at));
    let strides = (is_plain && follow()).then(|| Strides {
        offset: offsets[0],
        row: row_bytes,
        sample: interleaved * sample_bytes,
    });
    if block_bytes > MAX_BLOCK_BYTES && strides.is_none() {
        return Err(too_large());
    }
    // A tile of an uncompressed file may be larger than the picture, so only the picture is held against the file.
    if band_bytes > allowed || (stored > 0 && block_bytes > allowed.max(FREE_BYTES)) {
        return Err(inconsistent(&format!("{width}×{height} samples cannot lie in {file_bytes} bytes")));
    }

    let block = block.map(|size| size as usize);
    Ok(Layout { ifd: ifd.clone(), width, height, sample_type, block, block_bytes, strides, is_absent: absent })
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
