//! Environment pictures in the Radiance format: `.hdr`, equirectangular.

use std::io::{BufReader, Cursor};
use std::path::Path;

use glam::DVec3;
use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder};

use super::input::read_bytes;
use super::message::named;
use super::one_line;

/// Largest file in bytes: 8192 × 4096 uncompressed pixels.
const LARGEST_BYTES: u64 = 160 << 20;
/// Largest width and height of a picture in pixels.
const LARGEST_SIDE_PX: u32 = 16_384;
/// Columns and rows that are retained; lighting needs only a coarse picture.
const KEPT: [usize; 2] = [128, 64];

/// The error of an environment picture that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{}: cannot read the environment: {cause}", named(path))]
pub struct HdrError {
    path: String,
    cause: String,
}

/// Radiance by direction, averaged over the cells of an equirectangular picture. The middle of the picture is north,
/// and its first row the zenith.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyPicture {
    /// Linear red, green and blue, row by row.
    cells: Vec<[f32; 3]>,
}

impl SkyPicture {
    /// Reads a Radiance picture.
    ///
    /// # Errors
    /// Returns [`HdrError`] if the file does not exist, is too large, or is not such a picture.
    pub fn load(path: &Path) -> Result<Self, HdrError> {
        let wrong = |cause: String| HdrError { path: path.display().to_string(), cause: one_line(&cause) };
        let bytes = read_bytes(path, LARGEST_BYTES).map_err(|error| wrong(error.to_string()))?;
        Self::parse(&bytes).map_err(wrong)
    }

    /// Decodes the bytes of a file, or returns the cause of the failure.
    fn parse(bytes: &[u8]) -> Result<Self, String> {
        let decoder = HdrDecoder::new(BufReader::new(Cursor::new(bytes))).map_err(|error| error.to_string())?;
        let (width, height) = decoder.dimensions();
        // The size is checked first: a damaged header may claim a size that exceeds the memory.
        if width != 2 * height || width > LARGEST_SIDE_PX || height == 0 {
            return Err(format!(
                "it is {width} × {height} px, but a picture of the whole sphere must be twice as wide as high and no \
                 wider than {LARGEST_SIDE_PX} px"
            ));
        }
        let picture = DynamicImage::from_decoder(decoder).map_err(|error| error.to_string())?.into_rgb32f();
        let [columns, rows] = KEPT;
        let mut sums = vec![([0.0_f64; 3], 0.0_f64); columns * rows];
        for (x, y, pixel) in picture.enumerate_pixels() {
            let column = (x as usize * columns) / width as usize;
            let row = (y as usize * rows) / height as usize;
            let (sum, count) = &mut sums[row * columns + column];
            for (channel, value) in sum.iter_mut().zip(pixel.0) {
                *channel += f64::from(value).max(0.0);
            }
            *count += 1.0;
        }
        let mut cells: Vec<[f32; 3]> =
            sums.iter().map(|(sum, count)| sum.map(|channel| (channel / count.max(1.0)) as f32)).collect();
        // A picture that is smaller than the grid leaves some cells without a pixel; they take the nearest one.
        for index in 0..cells.len() {
            if sums[index].1 == 0.0 {
                let (column, row) = (index % columns, index / columns);
                let x = (column * width as usize / columns) as u32;
                let y = (row * height as usize / rows) as u32;
                cells[index] = picture.get_pixel(x, y).0.map(|value| value.max(0.0));
            }
        }
        Ok(Self { cells })
    }

    /// Returns the radiance from a direction in the world, which need not be a unit vector: linear red, green and blue.
    pub fn radiance(&self, direction: DVec3) -> [f64; 3] {
        let [columns, rows] = KEPT;
        let unit = direction.normalize_or(DVec3::Z);
        let across = unit.x.atan2(unit.y) / std::f64::consts::TAU + 0.5;
        let down = unit.z.clamp(-1.0, 1.0).acos() / std::f64::consts::PI;
        let column = ((across * columns as f64) as usize).min(columns - 1);
        let row = ((down * rows as f64) as usize).min(rows - 1);
        self.cells[row * columns + column].map(f64::from)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    /// Builds a flat RGBE picture whose left half is red and whose upper half is eight times as bright.
    fn picture(width: usize, height: usize) -> Vec<u8> {
        let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
        for y in 0..height {
            for x in 0..width {
                let exponent = if y < height / 2 { 132 } else { 129 };
                bytes.extend(if x < width / 2 { [128, 0, 0, exponent] } else { [0, 0, 128, exponent] });
            }
        }
        bytes
    }

    #[test]
    fn directions_find_their_pixels() {
        for [width, height] in [[256, 128], [4, 2]] {
            let sky = SkyPicture::parse(&picture(width, height)).unwrap();
            // The middle is north; west of it is on the left.
            let west_up = sky.radiance(DVec3::new(-1.0, 0.1, 0.5));
            let east_down = sky.radiance(DVec3::new(1.0, 0.1, -0.5));
            assert!(west_up[0] > 0.0 && west_up[2] == 0.0 && east_down[0] == 0.0 && east_down[2] > 0.0);
            assert!((west_up[0] / east_down[2] - 8.0).abs() < 1e-6, "{west_up:?} {east_down:?}");
        }
    }

    #[test]
    fn a_broken_picture_has_an_error_of_one_line() {
        let cut = &picture(64, 32)[..200];
        for (bytes, words) in [(&b"PNG"[..], ""), (cut, ""), (&picture(64, 64), "twice as wide"), (b"", "")] {
            let cause = SkyPicture::parse(bytes).unwrap_err();
            assert!(!cause.is_empty() && cause.contains(words), "{cause}");
        }
        let claims = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000000000 +X 2000000000\n";
        assert!(SkyPicture::parse(claims).unwrap_err().contains("no wider"));
    }
}
