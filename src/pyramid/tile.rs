//! Tiles of heights: where they stand in the pyramid, how large they are, and how a sample says that it is void.

/// Samples along the side of a tile.
pub const TILE_SAMPLES: u32 = crate::gpu::wgsl::shared::terrain::TILE_SAMPLES as u32;

/// Samples of its neighbours that a tile has on each side: as many as the surface needs up to half a sample beyond
/// the tile's own.
pub const TILE_BORDER: u32 = crate::gpu::wgsl::shared::terrain::TILE_BORDER as u32;

/// Samples in a row of a tile with its borders.
pub const TILE_STRIDE: u32 = TILE_SAMPLES + 2 * TILE_BORDER;

/// Quads along the side of a mesh patch. Small patches follow the relief: with 32 the same error bound took half as
/// many triangles again, and 1.4 times as long on a software driver.
pub const PATCH_QUADS: u32 = 16;

/// A tile of a level: its own samples are the columns 256 x … 256 x + 255 and the rows 256 y … 256 y + 255.
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
    /// 260 × 260 heights in metres, row-major: the tile's 256 × 256 samples and two more on every side, those beyond
    /// the level's extent replicated. The lowest mantissa bit says whether the sample is void (1) or valid (0); voids
    /// have a smooth filling (`surface::fill`).
    pub samples: Vec<f32>,
}

/// The void flag of a served height: its lowest mantissa bit.
pub fn is_void(served: f32) -> bool {
    served.to_bits() & 1 == 1
}

/// A served height: the flag in the lowest mantissa bit.
pub(super) fn flagged(height_m: f32, void: bool) -> f32 {
    f32::from_bits(height_m.to_bits() & !1 | u32::from(void))
}
