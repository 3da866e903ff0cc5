//! The sources of tiles: a baked pyramid, heights in memory, a local or remote COG, several DEMs as one, computed land,
//! and the cache of pyramids that hachure bakes automatically.
//!
//! Rendering knows only [`TileStore`]. The modules are listed in order of dependency: each uses only those above it.
//!
//! Why: `docs/decisions/tile-streaming.md`.

mod tile_store;
mod tile_heights;
mod ground;
mod highest;

mod data_area;
mod pyramid;
mod memory_store;
mod derive;
mod measured;
mod cog_levels;
mod cog_store;
mod small_members;
mod mosaic_store;
mod manifest;
mod trim;
mod entry;
mod healing;
mod altered;
mod cache;
pub(crate) mod continent_store;
mod open_store;

pub(crate) use altered::Altered;
pub(crate) use cache::cache_folder;
#[cfg(test)]
pub(crate) use cache::{open_or_bake, open_or_bake_key};
pub use cache::{open_or_bake_file, open_or_bake_store, open_or_grow_store};
pub use cog_store::CogStore;
pub use continent_store::ContinentStore;
pub(crate) use data_area::{DataArea, data_bounds};
#[cfg(test)]
pub(crate) use derive::coarse_patches;
pub use derive::derive;
pub(crate) use ground::Ground;
pub(crate) use highest::{HighestSample, highest_sample};
#[cfg(test)]
pub(crate) use manifest::write_manifest;
pub use memory_store::MemoryStore;
pub(crate) use mosaic_store::MosaicStore;
pub(crate) use open_store::open_local_cog_with;
pub use open_store::{open_local_cog, open_remote, open_remote_with};
pub use pyramid::Pyramid;
pub(crate) use tile_heights::tile_heights_m;
pub use tile_store::{Cancel, Decode, TileStore};
#[cfg(test)]
pub(crate) use trim::trim;
