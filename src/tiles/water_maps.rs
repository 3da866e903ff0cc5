//! Water maps: for each slot of the atlas, how far each sample is from the shore of still water. They are made again when
//! the sea stands at another height, and kept as all maps are ([`slot_maps`](super::slot_maps)).
//!
//! Why: `docs/decisions/water.md`.

use super::atlas::Atlas;
use super::slot_maps::SlotMaps;
use crate::gpu::Gpu;
use crate::gpu::wgsl::shared::water_maps::{MAP_ROWS, MAP_WORDS};

/// Texels of a map: four samples in each of a row, and a row that tells whether there is any water.
pub const WATER_MAP_SIZE: [u32; 2] = [MAP_WORDS as u32, MAP_ROWS as u32];
/// Bytes of a map.
pub const WATER_MAP_BYTES: u64 = WATER_MAP_SIZE[0] as u64 * WATER_MAP_SIZE[1] as u64 * 4;
/// The height of a sea where the scene has none: lower than any land.
pub const NO_SEA_M: f32 = -1e30;

/// The maps; their key is the height of the sea.
pub type WaterMaps = SlotMaps<f32>;

/// As many as the atlas has slots; none is made yet.
pub fn water_maps(gpu: &Gpu, atlas: &Atlas, sea_m: f32) -> WaterMaps {
    SlotMaps::new(gpu, atlas, "water maps", WATER_MAP_SIZE, sea_m)
}
