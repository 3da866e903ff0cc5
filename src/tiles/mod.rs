//! From the pyramid to the GPU: which tiles of heights are resident, which patches are drawn, and the surface that both
//! describe.
//!
//! The modules are listed in order of dependency: each uses only those above it.

pub mod grid_projection;
pub mod earth_curvature;
pub mod atlas;
pub mod cache;
pub mod loader;
pub mod needed;
pub mod map_neighbours;
pub mod residency_floor;
mod queues;
pub mod residency;
pub mod patches;
pub mod skyline;
pub mod selection;
mod leaves;
mod walk;
pub mod select;
pub mod budget;
mod camera_motion;
pub mod slot_maps;
pub mod horizon_maps;
pub mod water_maps;
pub mod page_table;
pub(crate) mod terrain_buffers;
pub mod terrain;

pub use terrain::Terrain;
