//! Comparison of two pictures: a threshold for each pixel **and** a bound on the share of pixels beyond it. A mean
//! would not notice a lost line; the share does.

use std::path::Path;

use crate::file::FileError;
use crate::file::png::{Picture, read_rgba8};

/// How different two pictures may be and still count as equal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Threshold for each channel, of 255; a pixel is an outlier if one of its four channels differs by more.
    pub channel_difference: u8,
    /// Share of pixels that may be outliers, 0 to 1.
    pub outlier_share: f64,
}

impl Tolerance {
    /// Every byte must be equal.
    pub const EXACT: Self = Self { channel_difference: 0, outlier_share: 0.0 };
}

/// The difference between two pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Number of pixels of each picture.
    pub pixels: u64,
    pub outliers: u64,
    /// Largest difference of a channel, of 255, outlier or not.
    pub worst_difference: u8,
    /// Column and row of the first pixel with that difference.
    pub worst_px: [u32; 2],
    /// The tolerance of the comparison.
    pub tolerance: Tolerance,
}

/// Why two pictures cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// The reference is missing or broken: an error, never a pass.
    #[error("cannot read the reference picture: {0}")]
    Reference(FileError),
    /// The pictures have different sizes.
    #[error("the pictures have different sizes: {}x{} and {}x{}", .0[0], .0[1], .1[0], .1[1])]
    Size([u32; 2], [u32; 2]),
    /// The number of bytes does not match the size.
    #[error("a picture of {}x{} pixels needs 4 bytes per pixel, but has {bytes} bytes", .size_px[0], .size_px[1])]
    Bytes { size_px: [u32; 2], bytes: usize },
}

impl Comparison {
    /// Whether the share of outliers is within the tolerance. Empty pictures do not pass, because they show nothing.
    pub fn passes(&self) -> bool {
        // A NaN tolerance passes nothing.
        self.pixels > 0 && self.outliers as f64 <= self.tolerance.outlier_share * self.pixels as f64
    }
}

impl std::fmt::Display for Comparison {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y] = self.worst_px;
        write!(
            f,
            "{} of {} pixels differ by more than {} (allowed: {}); the largest difference is {} at ({x}, {y})",
            self.outliers,
            self.pixels,
            self.tolerance.channel_difference,
            (self.tolerance.outlier_share * self.pixels as f64).floor(),
            self.worst_difference,
        )
    }
}

/// Compares two pictures.
///
/// # Errors
/// The pictures have different sizes, or their bytes do not fill them.
pub fn compare(picture: &Picture, reference: &Picture, tolerance: Tolerance) -> Result<Comparison, CompareError> {
    for Picture { width, height, rgba } in [picture, reference] {
        if u64::from(*width) * u64::from(*height) * 4 != rgba.len() as u64 {
            return Err(CompareError::Bytes { size_px: [*width, *height], bytes: rgba.len() });
        }
    }
    let size = |picture: &Picture| [picture.width, picture.height];
    if size(picture) != size(reference) {
        return Err(CompareError::Size(size(picture), size(reference)));
    }
    let (mut outliers, mut worst_difference, mut worst_index) = (0, 0, 0);
    let (pixels, references) = (picture.rgba.as_chunks::<4>().0, reference.rgba.as_chunks::<4>().0);
    for (index, (pixel, reference)) in pixels.iter().zip(references).enumerate() {
        let difference = pixel.iter().zip(reference).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
        outliers += u64::from(difference > tolerance.channel_difference);
        if difference > worst_difference {
            (worst_difference, worst_index) = (difference, index);
        }
    }
    let width = picture.width.max(1) as usize;
    let worst_px = [(worst_index % width) as u32, (worst_index / width) as u32];
    Ok(Comparison { pixels: pixels.len() as u64, outliers, worst_difference, worst_px, tolerance })
}

/// Compares a picture with a reference in a PNG file.
///
/// # Errors
/// The reference is missing or not readable, or has another size.
pub fn compare_with_file(
    picture: &Picture,
    reference: &Path,
    tolerance: Tolerance,
) -> Result<Comparison, CompareError> {
    compare(picture, &read_rgba8(reference).map_err(CompareError::Reference)?, tolerance)
}
