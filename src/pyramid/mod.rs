//! The tile pyramid: a cloud-optimised GeoTIFF of heights with the measured errors of its tiles beside it.

/// Samples along the side of a tile.
pub const TILE_SAMPLES: u32 = 256;

/// Quads along the side of a mesh patch.
pub const PATCH_QUADS: u32 = 32;
