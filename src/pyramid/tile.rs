//! Tiles of heights: their addresses, their sizes, and the bit that marks a sample as no-data.

/// Number of samples along the side of a tile.
pub(crate) const TILE_SAMPLES: u32 = crate::gpu::wgsl::shared::terrain::TILE_SAMPLES as u32;

/// Number of border samples on each side of a tile, copied from its neighbours: as many as the surface needs up to half
/// a sample beyond the tile's own.
pub(crate) const TILE_BORDER: u32 = crate::gpu::wgsl::shared::terrain::TILE_BORDER as u32;

/// Number of samples in a row of a tile, borders included.
pub(crate) const TILE_STRIDE: u32 = TILE_SAMPLES + 2 * TILE_BORDER;

/// Number of quads along the side of a mesh patch. Small patches follow the terrain more closely: with 32, the same
/// error bound took half as many triangles again, and 1.4 times as long on a software driver.
pub(crate) const PATCH_QUADS: u32 = 16;

/// The address of a tile. The tile's own samples are the columns 256 x … 256 x + 255 and the rows 256 y … 256 y + 255
/// of its level.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TileAddress {
    /// The level; 0 is the finest.
    pub level: u32,
    /// Column, from the west for a north-up grid.
    pub x: u32,
    /// Row, from the north for a north-up grid.
    pub y: u32,
}

/// The heights of a tile.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    /// 260 × 260 heights in metres, row-major: the tile's 256 × 256 samples and two more on every side, replicated
    /// beyond the level's extent. The lowest mantissa bit of a sample is 1 for no-data and 0 for a valid height;
    /// no-data samples hold a smooth filling (`surface::fill`).
    pub samples: Vec<f32>,
}

/// Returns whether a served height is no-data, which its lowest mantissa bit says.
pub(crate) fn is_void(served: f32) -> bool {
    served.to_bits() & 1 == 1
}

/// Returns a served height: `height_m` with the no-data flag in its lowest mantissa bit.
pub(super) fn flagged(height_m: f32, void: bool) -> f32 {
    f32::from_bits(height_m.to_bits() & !1 | u32::from(void))
}
