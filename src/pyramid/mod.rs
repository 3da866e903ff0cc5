//! The tile pyramid: a cloud-optimised GeoTIFF of heights with a sidecar file that holds the measured errors of its
//! tiles, and the other sources of tiles that have the same interface.
//!
//! [`bake()`] writes a pyramid from a height grid, [`Pyramid::open`] reads it, [`store::open_or_bake_file`] bakes only if
//! necessary, and [`TileStore`] is the interface of all sources of tiles.
//!
//! The submodules are listed in order of dependency: a module uses only submodules listed before its own, and within
//! its submodule only modules listed before itself. Inside the crate, items are imported from where they are defined;
//! the names re-exported here are for users of the library.
//!
//! ```text
//! tile      tiles and their samples: addresses, sizes, the no-data bit
//! error     the error type
//! surface   levels in memory: registration, filled no-data, the bicubic surface, statistics, triangle errors
//! format    file formats: COG, sidecar, records, encodings, tags
//! bake      heights → files, with measured errors
//! store     sources of tiles: baked pyramids, COGs, mosaics, the continent, the cache
//! ```
//!
//! Why: `docs/decisions/cog-pyramid.md`.

pub(crate) mod tile;
mod error;
pub(crate) mod surface;
pub(crate) mod format;
pub mod bake;
pub mod store;

pub use bake::{BakeOptions, bake};
pub use error::PyramidError;
pub use store::{Pyramid, TileStore};
pub use surface::levels::LevelSize;
pub use surface::loaded_tile::LoadedTile;
pub use surface::statistics::{PatchPage, PatchStatistics, TileStatistics, Voids};
pub use tile::{Tile, TileAddress};
