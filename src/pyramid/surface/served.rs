//! Tiles as they are served, from levels of any kind.

use super::fill::{HeightLevels, read_filled};
use crate::pyramid::error::PyramidError;
use crate::pyramid::tile::{TILE_BORDER, TILE_SAMPLES, TILE_STRIDE, Tile, TileAddress};

/// Reads an existing tile with its borders and with no-data filled; `fallback_m` is as for [`read_filled`].
pub(crate) fn serve<L: HeightLevels + ?Sized>(
    levels: &L,
    address: TileAddress,
    fallback_m: f32,
) -> Result<Tile, PyramidError> {
    let size = levels.sizes()[address.level as usize];
    let region = size.tile_region(address.x, address.y, TILE_BORDER);
    let served = read_filled(levels, address.level as usize, region, fallback_m)?;
    // The sample of the level at a column (or row) of the tile: the nearest inside the level.
    let inside = |tile: u32, at: u32, count: u32| (tile * TILE_SAMPLES + at).saturating_sub(TILE_BORDER).min(count - 1);
    let mut samples = Vec::with_capacity((TILE_STRIDE * TILE_STRIDE) as usize);
    for row in 0..TILE_STRIDE {
        let row = (inside(address.y, row, size.height) - region.y) * region.width;
        let row = &served[row as usize..(row + region.width) as usize];
        samples.extend((0..TILE_STRIDE).map(|column| row[(inside(address.x, column, size.width) - region.x) as usize]));
    }
    Ok(Tile { samples })
}
