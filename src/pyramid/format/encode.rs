//! Encoding of a tile of heights as the bytes of a TIFF block.
//!
//! Why: `docs/decisions/compression.md`.

use geotiff_writer::{Compression, LercAdditionalCompression, LercOptions, Predictor};
use lerc_writer::{EncodeOptions, EncoderProfile, MaskView, RasterView};
use tiff_reader::ByteOrder;
use tiff_writer::ImageBuilder;
use tiff_writer::compress::{BlockEncodingOptions, compress_block, compress_with_level};

use crate::pyramid::surface::levels::Region;
use crate::pyramid::tile::TILE_SAMPLES;

type BoxError = Box<dyn std::error::Error + Send + Sync>;

/// The compression of heights.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Codec {
    /// DEFLATE after the floating-point predictor; bit-identical when decoded. (Level 3 is the best compromise: level 6
    /// takes twice as long for three per cent, and the Zstandard encoder in Rust packs a quarter less.)
    Lossless,
    /// LERC, then DEFLATE; no height changes by more than this many metres.
    WithinMetres(f64),
}

const DEFLATE_LEVEL: u32 = 3;

/// The output of LERC is short and hardly repeats, so the best level costs little.
const LERC_DEFLATE_LEVEL: u32 = 9;

impl Codec {
    /// Adds the codec to the description of an image.
    pub(crate) fn describe(self, image: ImageBuilder) -> ImageBuilder {
        match self {
            Self::Lossless => image.compression(Compression::Deflate).predictor(Predictor::FloatingPoint),
            Self::WithinMetres(max_z_error) => image
                .lerc_options(LercOptions { max_z_error, additional_compression: LercAdditionalCompression::Deflate }),
        }
    }

    /// Encodes a tile of 256 × 256 heights, NaN for no-data. `index` is the tile's number in the image, for messages.
    pub(crate) fn encode(self, tile: &[f32], index: usize) -> Result<Vec<u8>, BoxError> {
        match self {
            Self::Lossless => {
                let options = BlockEncodingOptions {
                    byte_order: ByteOrder::LittleEndian,
                    compression: Compression::Deflate,
                    predictor: Predictor::FloatingPoint,
                    samples_per_pixel: 1,
                    row_width_pixels: TILE_SAMPLES as usize,
                    jpeg_options: None,
                    jpeg_sampling: None,
                    deflate_level: Some(DEFLATE_LEVEL),
                };
                Ok(compress_block(tile, options, index)?)
            }
            Self::WithinMetres(max_z_error) => {
                // The TIFF writer's LERC path has no masks, and LERC rejects NaN; so LERC is called here, with a mask.
                let raster = RasterView::new(TILE_SAMPLES, TILE_SAMPLES, 1, tile)?;
                let valid: Vec<u8> = tile.iter().map(|height| u8::from(!height.is_nan())).collect();
                let mask = match valid.contains(&0) {
                    true => Some(MaskView::new(TILE_SAMPLES, TILE_SAMPLES, &valid)?),
                    false => None,
                };
                let options = EncodeOptions::new().with_max_z_error(max_z_error).with_profile(EncoderProfile::Gdal);
                let blob = lerc_writer::encode(raster, mask, options)?;
                Ok(compress_with_level(&blob, Compression::Deflate, Some(LERC_DEFLATE_LEVEL), index)?)
            }
        }
    }
}

/// Cuts the tile that holds the samples of `region` out of the heights `heights_m` of the region `all` (row-major).
/// Returns 256 × 256 samples, the last ones repeated beyond the level's extent (which compresses better than a
/// constant).
pub(crate) fn padded_tile(heights_m: &[f32], all: Region, region: Region) -> Vec<f32> {
    let side = TILE_SAMPLES as usize;
    let mut tile = Vec::with_capacity(side * side);
    for row in region.y - all.y..region.y - all.y + region.height {
        let start = row as usize * all.width as usize + (region.x - all.x) as usize;
        tile.extend_from_slice(&heights_m[start..start + region.width as usize]);
        let last = tile[tile.len() - 1];
        tile.resize(tile.len() + side - region.width as usize, last);
    }
    let last_row = tile.len() - side;
    while tile.len() < side * side {
        tile.extend_from_within(last_row..last_row + side);
    }
    tile
}
