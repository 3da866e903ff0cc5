//! Pyramid → GPU: which tiles of heights are there, which patches are drawn, and the one surface that both describe.

pub mod atlas;
pub mod frustum;
pub mod residency;
pub mod selection;
pub mod terrain;
pub mod warp;

pub use terrain::Terrain;
