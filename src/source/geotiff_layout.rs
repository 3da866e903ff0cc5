//! Checks the claims of a TIFF's header before anything of the claimed size is allocated or decoded.

use std::path::Path;

use tiff_reader::{Ifd, TiffFile};

use super::SourceError;
use super::error::RGB_PICTURE;
use super::flat::Strides;
use super::place::inconsistent;
use super::tiff_blocks::{Blocks, CODEC_NONE};
use super::tiff_samples::Samples;
use super::values::Holds;

/// Largest decoded size in bytes of one strip or tile with all its bands.
pub(super) const MAX_BLOCK_BYTES: u64 = 1 << 31;
/// Decoded size in bytes that is allowed for any file, however small it is.
const FREE_BYTES: u64 = 64 << 20;
/// Decoded bytes per byte of the file that are allowed beyond that. Deflate reaches 1032; Zstandard and LERC reach more
/// on constant data, which makes up only a part of a file of heights.
const MAX_RATIO: u64 = 32_768;

const TAG_SUBFILE_TYPE: u16 = 254;

/// Bits of that tag: a smaller copy of another picture; a mask of another picture's valid samples.
const OVERVIEW: u32 = 1;
const MASK: u32 = 4;

/// A picture in the file that can be read.
pub(super) struct Layout {
    pub width: u32,
    pub height: u32,
    pub blocks: Blocks,
    /// Size of a decoded block with all bands that are stored in it.
    pub block_bytes: u64,
    /// Positions of the samples, if they are uncompressed and contiguous from the first strip to the last.
    pub strides: Option<Strides>,
}

/// Returns the layout of the main picture of a file: the first that is neither an overview nor a mask.
///
/// # Errors
/// Fails if the file is damaged, does not hold `holds`, is not supported, or is too small or too large.
pub(super) fn check(file: &TiffFile, file_bytes: u64, path: &Path, holds: Holds) -> Result<Layout, SourceError> {
    let none = || SourceError::Inconsistent { path: path.into(), what: "it contains no picture".to_owned() };
    // A cloud-optimised file stores overviews and masks after the full resolution.
    let full = file.ifds().iter().position(|ifd| subfile_type(ifd) & (OVERVIEW | MASK) == 0).unwrap_or(0);
    let ifd = file.ifds().get(full).ok_or_else(none)?;
    require_size(ifd, path)?;
    require_samples_of(ifd, path, holds)?;
    check_grid(ifd, full, file_bytes, path, holds)
}

fn subfile_type(ifd: &Ifd) -> u32 {
    ifd.tag(TAG_SUBFILE_TYPE).and_then(|tag| tag.value.as_u32()).unwrap_or(0)
}

/// Returns whether the picture is an overview: a smaller copy of another one, but not a mask.
pub(super) fn is_overview(ifd: &Ifd) -> bool {
    subfile_type(ifd) & (OVERVIEW | MASK) == OVERVIEW
}

/// Returns whether the picture is a mask, which marks the valid samples of another picture of the same size.
pub(super) fn is_mask(ifd: &Ifd) -> bool {
    subfile_type(ifd) & MASK != 0
}

/// Checks everything about one picture of heights, number `index` of its file, that can be known without decoding.
///
/// # Errors
/// The same as [`check`].
pub(super) fn check_image(ifd: &Ifd, index: usize, file_bytes: u64, path: &Path) -> Result<Layout, SourceError> {
    require_size(ifd, path)?;
    require_samples_of(ifd, path, Holds::Heights)?;
    check_grid(ifd, index, file_bytes, path, Holds::Heights)
}

/// Checks the size, the compression and the samples of a picture whose kind of samples has been checked.
fn check_grid(ifd: &Ifd, index: usize, file_bytes: u64, path: &Path, holds: Holds) -> Result<Layout, SourceError> {
    let (width, height) = (ifd.width(), ifd.height());
    require_known_compression(ifd, path)?;
    if width < 2 || height < 2 {
        return Err(SourceError::TooSmall { path: path.into(), width, height });
    }
    let layout = check_samples(ifd, index, file_bytes, path)?;
    let Samples { per_pixel, alpha, .. } = layout.blocks.samples;
    if per_pixel > 1 + usize::from(alpha.is_some()) {
        tracing::warn!("{}: has {per_pixel} bands; the first is read as {holds}", path.display());
    }
    Ok(layout)
}

/// Returns the layouts of the main picture of a file that holds colours and of its overviews, from the largest to the
/// smallest. Overviews that cannot be read, or have other bands, are left out.
///
/// # Errors
/// Fails if the file is damaged or not supported, or has no colours.
pub(super) fn check_colors(file: &TiffFile, file_bytes: u64, path: &Path) -> Result<Vec<Layout>, SourceError> {
    let none = || inconsistent(path, "it contains no picture");
    let full = file.ifds().iter().position(|ifd| subfile_type(ifd) & (OVERVIEW | MASK) == 0).unwrap_or(0);
    let check = |ifd: &Ifd, index: usize| {
        require_size(ifd, path)?;
        require_known_compression(ifd, path)?;
        check_samples(ifd, index, file_bytes, path)
    };
    let main = check(file.ifds().get(full).ok_or_else(none)?, full)?;
    let mut levels = vec![main];
    for (index, ifd) in file.ifds().iter().enumerate().filter(|(index, ifd)| *index != full && is_overview(ifd)) {
        let Ok(level) = check(ifd, index) else { continue };
        let (of_main, own) = (&levels[0].blocks.samples, &level.blocks.samples);
        let is_smaller = level.width < levels[0].width && level.height < levels[0].height;
        if is_smaller && (own.per_pixel, own.decoded) == (of_main.per_pixel, of_main.decoded) {
            levels.push(level);
        }
    }
    levels.sort_by_key(|level| std::cmp::Reverse(level.width));
    Ok(levels)
}

/// Checks a mask, picture `index` of its file, as [`check_image`] checks heights.
///
/// # Errors
/// The same as [`check`].
pub(super) fn check_mask(ifd: &Ifd, index: usize, file_bytes: u64, path: &Path) -> Result<Layout, SourceError> {
    require_size(ifd, path)?;
    require_known_compression(ifd, path)?;
    check_samples(ifd, index, file_bytes, path)
}

fn require_size(ifd: &Ifd, path: &Path) -> Result<(), SourceError> {
    match ifd.width() == 0 || ifd.height() == 0 {
        true => Err(inconsistent(path, "its width or height is missing or zero")),
        false => Ok(()),
    }
}

fn check_samples(ifd: &Ifd, index: usize, file_bytes: u64, path: &Path) -> Result<Layout, SourceError> {
    let (width, height) = (ifd.width(), ifd.height());
    let samples = Samples::of(ifd, path)?;
    let blocks = Blocks::of(ifd, index, samples, file_bytes, path)?;
    let is_sparse = blocks.is_sparse();
    // A block is decoded with all of its bands, in the type to which its samples are decoded.
    let sample_bytes = samples.decoded.bytes() as u64;
    let decoded_row = u64::from(blocks.block[0]).saturating_mul(samples.interleaved() as u64 * sample_bytes);
    // Saturating arithmetic: a number that does not fit is larger than any bound, too.
    let block_bytes = decoded_row.saturating_mul(blocks.block[1].into()).max(blocks.block_bytes());

    let allowed = if ifd.compression() == CODEC_NONE && !is_sparse {
        // Uncompressed samples have their full size in the file; bit-packed ones grow at most eightfold.
        file_bytes.saturating_mul(8)
    } else {
        FREE_BYTES.saturating_add(file_bytes.saturating_mul(MAX_RATIO))
    };
    let too_large = || SourceError::TooLarge { path: path.into(), width, height };
    // Blocks that the file leaves out take no bytes in it and are never decoded.
    let stored = blocks.stored();
    let stored_samples = u64::from(blocks.block[0]).saturating_mul(blocks.block[1].into()).saturating_mul(stored);
    let band_bytes = (u64::from(width) * u64::from(height)).min(stored_samples).saturating_mul(sample_bytes);
    let row_bytes = blocks.row_bytes() as u64;
    let is_plain = ifd.compression() == CODEC_NONE
        && samples.are_plain()
        && ifd.fill_order() == 1
        && !blocks.is_tiled()
        && !is_sparse;
    let first = blocks.offsets().next().unwrap_or(0);
    let strip = |index: usize| first.checked_add((index as u64 * u64::from(blocks.block[1])).checked_mul(row_bytes)?);
    // If each band has its own strips, only those of the first band count.
    let follow = || blocks.offsets().enumerate().all(|(index, at)| strip(index) == Some(at));
    let strides = (is_plain && follow()).then(|| Strides {
        offset: first,
        row: row_bytes,
        sample: samples.interleaved() as u64 * sample_bytes,
    });
    if block_bytes > MAX_BLOCK_BYTES && strides.is_none() {
        return Err(too_large());
    }
    // A tile of an uncompressed file may be larger than the picture, so only the picture is compared with the file.
    if band_bytes > allowed || (stored > 0 && block_bytes > allowed.max(FREE_BYTES)) {
        return Err(inconsistent(path, format!("{width}×{height} samples do not fit in {file_bytes} bytes")));
    }
    Ok(Layout { width, height, blocks, block_bytes, strides })
}

fn require_samples_of(ifd: &Ifd, path: &Path, holds: Holds) -> Result<(), SourceError> {
    let format = ifd.sample_format().ok().and_then(|formats| formats.first().copied());
    let what = match (format, ifd.photometric_interpretation()) {
        (Some(5 | 6), _) => "complex numbers",
        (_, Some(2)) => RGB_PICTURE,
        // The palette only gives the display colours of classes.
        (_, Some(3)) if holds == Holds::Classes => return Ok(()),
        (_, Some(3)) => "a palette picture",
        (_, Some(4)) if holds == Holds::Shades => return Ok(()),
        (_, Some(4)) => "a mask",
        (_, Some(5)) => "a CMYK picture",
        (_, Some(6)) => "a YCbCr picture",
        (_, Some(8..=10)) => "a CIE L*a*b* picture",
        (_, Some(32_803)) => "a camera's raw picture",
        (_, Some(32_844 | 32_845)) => "a LogLuv picture",
        _ => return Ok(()),
    };
    Err(SourceError::NotHeights { path: path.into(), what, holds })
}

fn require_known_compression(ifd: &Ifd, path: &Path) -> Result<(), SourceError> {
    let code = ifd.compression();
    let name = match code {
        // No compression, LZW, JPEG, Deflate (two codes), PackBits, LZMA, LERC, Zstandard, WebP.
        1 | 5 | 7 | 8 | 32_946 | 32_773 | 34_925 | 34_887 | 50_000 | 50_001 => return Ok(()),
        2..=4 => "CCITT fax",
        6 => "old-style JPEG",
        34_676 | 34_677 => "SGI Log",
        34_712 => "JPEG 2000",
        50_002 | 52_546 => "JPEG XL",
        _ => "of unknown type",
    };
    Err(SourceError::Unsupported { path: path.into(), what: format!("compression {name} ({code})") })
}
