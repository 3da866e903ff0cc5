//! Decoding of freshly encoded tiles before the GeoTIFF exists, as its readers will see them.

use std::io::Cursor;
use std::path::Path;

use rayon::prelude::*;
use tiff_reader::TiffFile;

use crate::pyramid::error::PyramidError;
use crate::pyramid::format::cog::CogWriter;
use crate::pyramid::format::encode::Codec;
use crate::pyramid::surface::levels::{LevelSize, Region};
use crate::pyramid::tile::TILE_SAMPLES;
use crate::source::georeference::{Crs, Georeference};

/// Decodes `tiles`, the encoded tiles of the region `own` (both row-major), with the reader that opens pyramids. That
/// reader needs a file, so the tiles are first written to a GeoTIFF in memory.
pub(super) fn decode(codec: Codec, own: Region, tiles: &[Vec<u8>], out: &Path) -> Result<Vec<f32>, PyramidError> {
    let nowhere =
        Georeference { crs_from_grid: [0.0, 1.0, 0.0, 0.0, 0.0, -1.0], crs: Crs::Local, geokeys: Default::default() };
    let size = LevelSize { width: own.width, height: own.height };
    let mut file = Cursor::new(Vec::new());
    let mut writer = CogWriter::begin(&mut file, out, &[size], &nowhere, codec)?;
    for (tile, bytes) in tiles.iter().enumerate() {
        writer.put(0, tile, bytes)?;
    }
    writer.finish()?;
    let options = tiff_reader::OpenOptions { block_cache_bytes: 1 << 20, ..Default::default() };
    let file = TiffFile::from_bytes_with_options(file.into_inner(), options).map_err(PyramidError::decode(out))?;
    let image = file.ifd(0).map_err(PyramidError::decode(out))?;
    let mut heights_m = vec![0.0; own.samples()];
    let rows = heights_m.par_chunks_mut((TILE_SAMPLES * own.width) as usize).enumerate();
    rows.try_for_each(|(row, heights_m)| {
        let (y, height) = (row * TILE_SAMPLES as usize, heights_m.len() / own.width as usize);
        let read = file
            .read_window_from_ifd::<f32>(image, y, 0, height, own.width as usize)
            .map_err(PyramidError::decode(out))?;
        for (out, height) in heights_m.iter_mut().zip(read) {
            *out = height;
        }
        Ok::<(), PyramidError>(())
    })?;
    Ok(heights_m)
}
