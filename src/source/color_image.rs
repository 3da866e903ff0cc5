//! Georeferenced images: orthophotos, scanned maps and thematic rasters, read by windows at several resolutions.
//!
//! A GeoTIFF may be grey, RGB, RGBA or a palette, with samples of any type; other bands are ignored. Samples of 8 bits,
//! and of 16 bits that use at least a quarter of their range, are shades as they are; all others are stretched from the
//! smallest to the largest value in the middle of the smallest level. A PNG, WebP or JPEG is decoded as a whole and needs a world file, an
//! `.aux.xml` or a `.toml` to have a position.
//!
//! Level 0 is the image itself. The next levels are the overviews of a GeoTIFF. If the smallest of these is still larger
//! than [`SMALL_PX`], reduced levels are computed once, in memory.

mod decode;
mod pixels;
#[cfg(test)]
mod tests;
mod tiff;

use std::path::{Path, PathBuf};

use rayon::prelude::*;

pub(crate) use self::pixels::Premultiplied;
use self::tiff::TiffColors;
use super::georeference::Georeference;
use super::geotiff::guarded;
use super::place::check_window;
use super::reader::Window;
use super::{SourceError, memory};

/// Largest number of pixels of an image that is decoded as a whole, or reduced in memory: 256 MB.
pub(crate) const MOST_PX_IN_MEMORY: u64 = 1 << 26;
/// Longest side of the smallest level.
const SMALL_PX: u32 = 256;

/// A pixel: red, green and blue in sRGB, and opacity.
pub(crate) type Rgba = [u8; 4];

/// An open image.
pub(crate) struct ColorImage {
    path: PathBuf,
    georeference: Georeference,
    /// Whether the file, or a sidecar file, gives the position of the image.
    pub is_located: bool,
    levels: Vec<Level>,
}

/// An image at one resolution.
enum Level {
    Tiff(TiffColors),
    Memory { size: [u32; 2], pixels: Vec<Rgba> },
}

impl Level {
    fn size(&self) -> [u32; 2] {
        match self {
            Self::Tiff(level) => level.size(),
            Self::Memory { size, .. } => *size,
        }
    }
}

impl ColorImage {
    /// Opens an image.
    ///
    /// # Errors
    /// A message of one line, if the file is damaged, has another format, or is too large to be reduced in memory.
    pub(crate) fn open(path: &Path) -> Result<Self, SourceError> {
        guarded(path, || Self::open_unguarded(path))
    }

    fn open_unguarded(path: &Path) -> Result<Self, SourceError> {
        let mut image = match decode::format_of(path)? {
            decode::ImageFormat::Tiff => {
                let (levels, georeference, is_located) = tiff::open(path)?;
                let levels = levels.into_iter().map(Level::Tiff).collect();
                Self { path: path.into(), georeference, is_located, levels }
            }
            format => {
                let (size, pixels) = decode::whole(path, format)?;
                let (georeference, is_located) = decode::place(path, size)?;
                Self { path: path.into(), georeference, is_located, levels: vec![Level::Memory { size, pixels }] }
            }
        };
        image.reduce()?;
        Ok(image)
    }

    /// Returns columns and rows of level 0.
    pub(crate) fn size(&self) -> [u32; 2] {
        self.level_size(0)
    }

    pub(crate) fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    /// Returns the number of levels, at least 1.
    pub(crate) fn levels(&self) -> usize {
        self.levels.len()
    }

    /// Returns columns and rows of a level; those of the smallest one if there are fewer levels.
    pub(crate) fn level_size(&self, level: usize) -> [u32; 2] {
        self.levels.get(level).or(self.levels.last()).map_or([1; 2], Level::size)
    }

    /// Returns the pixels of a window of a level, row by row.
    ///
    /// # Errors
    /// The window is not inside the level, or cannot be read.
    pub(crate) fn read(&self, level: usize, window: Window) -> Result<Vec<Rgba>, SourceError> {
        check_window(&self.path, window, self.level_size(level))?;
        match self.levels.get(level).or(self.levels.last()) {
            Some(Level::Tiff(level)) => guarded(&self.path, || level.read(window)),
            Some(Level::Memory { size, pixels }) => Ok(window.cut(Window::whole(*size), pixels)),
            None => Ok(Vec::new()),
        }
    }

    /// Adds reduced levels until the smallest one is small.
    fn reduce(&mut self) -> Result<(), SourceError> {
        loop {
            let last = self.levels.len() - 1;
            let [width, height] = self.level_size(last);
            if width.max(height) <= SMALL_PX {
                return Ok(());
            }
            if u64::from(width) * u64::from(height) > MOST_PX_IN_MEMORY {
                return Err(SourceError::Unclear {
                    path: self.path.clone(),
                    why: format!(
                        "{width}×{height} pixels without overviews are too many to be reduced in memory; add overviews with \
                         gdaladdo -r average FILE 2 4 8 16 32"
                    ),
                });
            }
            let size = [width.div_ceil(2), height.div_ceil(2)];
            let pixels = self.halved(last, size)?;
            self.levels.push(Level::Memory { size, pixels });
        }
    }

    /// Returns the means of 2 × 2 pixels of a level, in linear light. The last column or row of an odd number counts twice.
    fn halved(&self, level: usize, [width, height]: [u32; 2]) -> Result<Vec<Rgba>, SourceError> {
        let [columns, rows] = self.level_size(level);
        let mut half = memory::room(&self.path, [width, height], u64::from(width) * u64::from(height))?;
        half.resize(width as usize * height as usize, [0; 4]);
        // Bands of rows, each read at once.
        let band = 256_u32;
        let bands: Vec<_> = half.chunks_mut(width as usize * band as usize).enumerate().collect();
        bands.into_par_iter().try_for_each(|(number, out)| {
            let top = number as u32 * 2 * band;
            let window = Window { x: 0, y: top, width: columns, height: (2 * band).min(rows - top) };
            let pixels = self.read(level, window)?;
            let at = |x: u32, y: u32| pixels[(y.min(window.height - 1) * columns + x.min(columns - 1)) as usize];
            for (index, out) in out.iter_mut().enumerate() {
                let (x, y) = (2 * (index as u32 % width), 2 * (index as u32 / width));
                let four = [at(x, y), at(x + 1, y), at(x, y + 1), at(x + 1, y + 1)];
                let mut sum = Premultiplied::default();
                four.into_iter().for_each(|pixel| sum.add(Premultiplied::of(pixel), 0.25));
                *out = sum.pixel();
            }
            Ok::<(), SourceError>(())
        })?;
        Ok(half)
    }
}
