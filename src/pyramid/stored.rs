//! The levels of a pyramid's GeoTIFF, decoded on demand.

use std::path::{Path, PathBuf};

use tiff_reader::{OpenOptions, TiffFile};

use super::fill::HeightLevels;
use super::levels::{LevelSize, Region};
use super::{PyramidError, TILE_SAMPLES};

/// Decoded TIFF tiles kept, shared by all threads: 192 of 256 KiB.
const CACHE_BYTES: usize = 48 * 1024 * 1024;

/// An open GeoTIFF whose images are the levels.
pub struct StoredLevels {
    path: PathBuf,
    file: TiffFile,
    sizes: Vec<LevelSize>,
}

impl StoredLevels {
    /// Opens the GeoTIFF at `path` and checks that its images are `sizes`, in tiles of 256 × 256 f32. `name` stands in
    /// messages.
    pub fn open(path: &Path, name: &Path, sizes: Vec<LevelSize>) -> Result<Self, PyramidError> {
        let options = OpenOptions { block_cache_bytes: CACHE_BYTES, ..OpenOptions::default() };
        let file = TiffFile::open_with_options(path, options).map_err(PyramidError::decode(name))?;
        let mismatch = |cause: String| PyramidError::Mismatch { path: name.to_owned(), cause };
        if file.ifd_count() != sizes.len() {
            return Err(mismatch(format!("{} levels expected, {} found", sizes.len(), file.ifd_count())));
        }
        for (level, (image, size)) in file.ifds().iter().zip(&sizes).enumerate() {
            let layout = image.raster_layout().map_err(PyramidError::decode(name))?;
            let tile = Some(TILE_SAMPLES);
            if (image.width(), image.height()) != (size.width, size.height)
                || (image.tile_width(), image.tile_height()) != (tile, tile)
                || (layout.samples_per_pixel, layout.bits_per_sample, layout.sample_format) != (1, 32, 3)
            {
                return Err(mismatch(format!("level {level} is not {} × {} f32 in tiles", size.width, size.height)));
            }
        }
        Ok(Self { path: name.to_owned(), file, sizes })
    }
}

impl HeightLevels for StoredLevels {
    fn sizes(&self) -> &[LevelSize] {
        &self.sizes
    }

    fn read(&self, level: usize, region: Region) -> Result<Vec<f32>, PyramidError> {
        let Region { x, y, width, height } = region;
        let image = self.file.ifd(level).map_err(PyramidError::decode(&self.path))?;
        let heights_m = self
            .file
            .read_window_from_ifd::<f32>(image, y as usize, x as usize, height as usize, width as usize)
            .map_err(PyramidError::decode(&self.path))?;
        let (heights_m, offset) = heights_m.into_raw_vec_and_offset();
        if heights_m.len() != region.samples() || offset.unwrap_or(0) != 0 {
            let cause = format!("level {level}: {} samples expected, {} found", region.samples(), heights_m.len());
            return Err(PyramidError::Mismatch { path: self.path.clone(), cause });
        }
        Ok(heights_m)
    }
}
