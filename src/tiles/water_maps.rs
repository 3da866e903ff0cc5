//! Water maps: for each slot of the atlas, the distance of each sample from the shore of still water. They are
//! recomputed when the sea level changes, and managed like all [`slot_maps`](super::slot_maps).
//!
//! Why: `docs/decisions/water.md`.

use super::atlas::Atlas;
use super::slot_maps::SlotMaps;
use crate::gpu::Gpu;
use crate::gpu::wgsl::shared::water_maps::{MAP_ROWS, MAP_WORDS};

/// Size of a map in texels: four samples per texel of a row, and a row that says whether there is any water.
pub(crate) const WATER_MAP_SIZE: [u32; 2] = [MAP_WORDS as u32, MAP_ROWS as u32];
/// The sea level where the scene has no sea: lower than any land.
pub(crate) const NO_SEA_M: f32 = -1e30;

/// The water maps; their key is the sea level in metres.
pub(crate) type WaterMaps = SlotMaps<f32>;

/// Creates as many maps as the atlas has slots; none is computed yet.
pub(crate) fn water_maps(gpu: &Gpu, atlas: &Atlas, sea_m: f32) -> WaterMaps {
    SlotMaps::new(gpu, atlas, "water maps", WATER_MAP_SIZE, sea_m)
}
