//! The tile pyramid: a cloud-optimised GeoTIFF of heights with the measured errors of its tiles beside it, and whatever
//! else gives tiles as if it were one.
//!
//! [`bake()`] writes a pyramid from a height grid, [`Pyramid::open`] reads it, [`store::open_or_bake`] does what is
//! needed, and [`TileStore`] is what all who give tiles have in common.
//!
//! The rooms are listed in order: a module uses only rooms that stand above its own, and in its own room only modules
//! that stand above it. What is needed is imported from where it is defined; the names here are for those outside.
//!
//! ```text
//! tile      tiles and their samples: addresses, sizes, the void bit
//! error     what can go wrong
//! surface   levels in memory: registration, filled voids, the bicubic surface, statistics, errors of triangles
//! format    what lies in files: COG, sidecar, records, encodings, tags
//! bake      heights → files, with measured errors
//! store     who gives tiles: baked pyramids, COGs, mosaics, the continent, the cache
//! ```
//!
//! Why: `docs/decisions/cog-pyramid.md`.

pub mod tile;
mod error;
pub mod surface;
pub mod format;
pub mod bake;
pub mod store;

pub use bake::{BakeOptions, bake};
pub use error::PyramidError;
pub use store::{Pyramid, TileStore};
pub use surface::levels::LevelSize;
pub use surface::loaded_tile::LoadedTile;
pub use tile::TileAddress;
