//! The levels of a pyramid's GeoTIFF, decoded on demand.

use std::path::{Path, PathBuf};

use tiff_reader::{OpenOptions, TagValue, TiffFile};

use crate::file::random_access::RandomAccess;
use crate::pyramid::error::PyramidError;
use crate::pyramid::surface::fill::HeightLevels;
use crate::pyramid::surface::levels::{LevelSize, Region};
use crate::pyramid::surface::statistics::tile_index;
use crate::pyramid::tile::{TILE_SAMPLES, TileAddress};

/// Bytes of decoded TIFF tiles in the cache, which all threads share: 192 tiles of 256 KiB.
const CACHE_BYTES: usize = 48 * 1024 * 1024;

/// Upper bound of the length of a tile, however it is compressed.
const LARGEST_TILE_BYTES: u64 = 1 << 20;

/// An open GeoTIFF whose images are the levels of a pyramid.
pub(crate) struct StoredLevels {
    path: PathBuf,
    file: TiffFile,
    bytes: RandomAccess,
    sizes: Vec<LevelSize>,
}

const TILE_OFFSETS: u16 = 324;
const TILE_BYTE_COUNTS: u16 = 325;

impl StoredLevels {
    /// Opens the GeoTIFF at `path` and checks that its images have the sizes `sizes` and consist of tiles of 256 × 256
    /// f32. `name` is the file name in messages.
    pub(crate) fn open(path: &Path, name: &Path, sizes: Vec<LevelSize>) -> Result<Self, PyramidError> {
        let options = OpenOptions { block_cache_bytes: CACHE_BYTES, ..OpenOptions::default() };
        let file = TiffFile::open_with_options(path, options).map_err(PyramidError::decode(name))?;
        let mismatch = |cause: String| PyramidError::Mismatch { path: name.to_owned(), cause };
        if file.ifd_count() != sizes.len() {
            return Err(mismatch(format!("expected {} levels, found {}", sizes.len(), file.ifd_count())));
        }
        for (level, (image, size)) in file.ifds().iter().zip(&sizes).enumerate() {
            let layout = image.raster_layout().map_err(PyramidError::decode(name))?;
            let tile = Some(TILE_SAMPLES);
            if (image.width(), image.height()) != (size.width, size.height)
                || (image.tile_width(), image.tile_height()) != (tile, tile)
                || (layout.samples_per_pixel, layout.bits_per_sample, layout.sample_format) != (1, 32, 3)
            {
                return Err(mismatch(format!(
                    "level {level} is not {} × {} float32 in tiles of 256",
                    size.width, size.height
                )));
            }
        }
        let bytes = RandomAccess::open(path).map_err(PyramidError::io(name, "opening"))?;
        Ok(Self { path: name.to_owned(), file, bytes, sizes })
    }

    /// Reads the bytes of a tile as they are stored.
    pub(crate) fn tile_bytes(&self, address: TileAddress) -> Result<Vec<u8>, PyramidError> {
        let missing = || PyramidError::NoSuchTile { path: self.path.clone(), address };
        let index = tile_index(&self.sizes, address).ok_or_else(missing)?;
        let image = self.file.ifd(address.level as usize).map_err(PyramidError::decode(&self.path))?;
        let number = |code: u16| match &image.tag(code)?.value {
            TagValue::Long(values) => values.get(index).map(|&value| u64::from(value)),
            TagValue::Long8(values) => values.get(index).copied(),
            _ => None,
        };
        let (offset, count) = number(TILE_OFFSETS).zip(number(TILE_BYTE_COUNTS)).ok_or_else(missing)?;
        if count > LARGEST_TILE_BYTES {
            let cause = format!("a tile has {count} bytes: the file is damaged");
            return Err(PyramidError::Mismatch { path: self.path.clone(), cause });
        }
        self.bytes.read(offset, count as usize).map_err(PyramidError::io(&self.path, "reading a tile"))
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
            let cause = format!("level {level}: expected {} samples, found {}", region.samples(), heights_m.len());
            return Err(PyramidError::Mismatch { path: self.path.clone(), cause });
        }
        Ok(heights_m)
    }
}
