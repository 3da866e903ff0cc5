//! From the pyramid to the GPU: which tiles of heights are resident, which patches are drawn, and the surface that both
//! describe.
//!
//! The modules are listed in order of dependency: each uses only those above it.

pub(crate) mod grid_projection;
pub(crate) mod earth_curvature;
pub(crate) mod atlas;
pub(crate) mod cache;
pub(crate) mod loader;
pub(crate) mod skyline;
pub(crate) mod needed;
pub(crate) mod memory_factor;
pub(crate) mod map_neighbours;
pub(crate) mod residency_floor;
mod queues;
pub(crate) mod patches;
pub(crate) mod selection;
mod patch_tree;
mod walk;
pub(crate) mod select;
mod prefetch;
mod camera_motion;
pub(crate) mod residency;
pub(crate) mod budget;
pub(crate) mod slot_maps;
pub(crate) mod horizon_maps;
pub(crate) mod water_maps;
pub(crate) mod page_table;
pub(crate) mod terrain_buffers;
pub(crate) mod terrain;

pub(crate) use terrain::Terrain;
