//! The tile pyramid: a cloud-optimised GeoTIFF of heights with the measured errors of its tiles beside it.
//!
//! [`bake()`] writes one from a height grid, [`Pyramid::open`] reads it, [`open_or_bake`] does what is needed. Level 0 is
//! the grid itself, never resampled; `levels` says how the coarser ones lie over it, `bicubic` is the surface between
//! samples, `fill` gives voids a height so that the surface can be evaluated beside them.

pub mod bicubic;
pub mod continent_store;
pub mod derive;
pub mod fill;
pub mod ground;
pub mod levels;
pub mod lows;
pub mod mosaic_store;
pub mod statistics;
pub mod store;

mod bake;
mod bytes;
mod cache;
mod cog;
mod cog_levels;
mod cog_store;
mod encode;
mod entry;
mod error;
mod exaggerated;
mod geotags;
mod healing;
mod link;
mod measured;
mod open;
mod open_store;
mod record;
mod served;
mod sidecar;
mod stored;

pub use bake::{BakeOptions, BakeReport, BakeWork, Baked, bake, bake_reader, parts_path};
pub(crate) use cache::cache_folder;
pub use cache::{
    CACHE_LIMIT_BYTES, open_or_bake, open_or_bake_file, open_or_bake_key, open_or_bake_store, open_or_grow_store, trim,
};
pub use cog_store::CogStore;
pub use continent_store::ContinentStore;
pub use error::PyramidError;
pub use exaggerated::Exaggerated;
pub use levels::LevelSize;
pub use mosaic_store::MosaicStore;
pub use open::Pyramid;
pub use open_store::{open_local_cog, open_remote, open_remote_with};
pub use sidecar::{LevelSummary, sidecar_path};
pub use statistics::{PatchStatistics, TileStatistics, Voids};
pub use store::{Cancel, LoadedTile, PatchPage, TileStore};

/// Samples along the side of a tile.
pub const TILE_SAMPLES: u32 = 256;

/// Samples of its neighbours that a tile has on each side: as many as the surface needs up to half a sample beyond
/// the tile's own.
pub const TILE_BORDER: u32 = 2;

/// Samples in a row of a tile with its borders.
pub const TILE_STRIDE: u32 = TILE_SAMPLES + 2 * TILE_BORDER;

/// Quads along the side of a mesh patch. Small patches follow the relief: with 32 the same error bound took half as many
/// triangles again, and 1.4 times as long on a software driver.
pub const PATCH_QUADS: u32 = 16;

/// A tile of a level: its own samples are the columns 256 x … 256 x + 255 and the rows 256 y … 256 y + 255.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TileAddress {
    /// 0 is the finest.
    pub level: u32,
    /// From the west, for a north-up grid.
    pub x: u32,
    /// From the north, for a north-up grid.
    pub y: u32,
}

/// The heights of a tile.
#[derive(Clone, Debug, PartialEq)]
pub struct Tile {
    /// 260 × 260 heights in metres, row-major: the tile's 256 × 256 samples and two more on every side, those beyond
    /// the level's extent replicated. The lowest mantissa bit says whether the sample is void (1) or valid (0); voids
    /// have a smooth filling ([`fill`]).
    pub samples: Vec<f32>,
}
