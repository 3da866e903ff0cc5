//! Horizon maps with sky visibility: for each slot of the atlas, the elevation of the horizon toward the sun, and the
//! visible fraction of the sky. They are recomputed when the sun's azimuth changes, and managed like all
//! [`slot_maps`](super::slot_maps).
//!
//! Why: `docs/decisions/horizon-maps.md`.

use glam::{DVec2, Vec2};

use super::atlas::Atlas;
use super::slot_maps::SlotMaps;
use crate::gpu::Gpu;

/// Texels along the side of a map, each with both numbers in 16 bits; must match `shaders/shared/horizon_maps.wgsl`.
pub(crate) const HORIZON_MAP_SIDE: u32 = 130;
/// Size of a map in bytes.
#[cfg(test)]
pub(crate) const HORIZON_MAP_BYTES: u64 = HORIZON_MAP_SIDE as u64 * HORIZON_MAP_SIDE as u64 * 4;

/// The horizon maps; their key is the direction to the sun: a unit vector, east and north.
pub(crate) struct HorizonMaps {
    /// The maps on the GPU.
    pub maps: SlotMaps<Vec2>,
    sampler: wgpu::Sampler,
}

impl HorizonMaps {
    /// Creates as many maps as the atlas has slots; none is computed yet.
    pub(crate) fn new(gpu: &Gpu, atlas: &Atlas) -> Self {
        let maps = SlotMaps::new(gpu, atlas, "horizon maps", [HORIZON_MAP_SIDE; 2], Vec2::Y);
        Self { maps, sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor::default()) }
    }

    /// Returns the sampler for gathering texels, which does not filter.
    pub(crate) fn sampler(&self) -> &wgpu::Sampler {
        &self.sampler
    }

    /// Sets the direction to the sun from the next plan on. At the zenith, the azimuth is arbitrary.
    pub(crate) fn set_sun(&mut self, to_sun: DVec2) {
        self.maps.set_key(to_sun.try_normalize().unwrap_or(DVec2::Y).as_vec2());
    }
}
