//! Pyramid → GPU: which tiles of heights are there, which patches are drawn, and the one surface that both describe.

pub mod atlas;
pub mod bending;
pub mod beside;
pub mod blocked;
pub mod budget;
pub mod cache;
mod flight;
pub mod frustum;
pub mod horizon;
pub mod loader;
pub mod needed;
pub mod patches;
pub mod residency;
pub mod seen;
pub mod selection;
pub mod tables;
pub mod terrain;
pub(crate) mod terrain_buffers;
mod walk;
pub mod warp;

pub use terrain::Terrain;
