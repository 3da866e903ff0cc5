//! Horizon maps with sky visibility: for each slot of the atlas, how high the horizon toward the sun stands and how
//! much of the sky is visible. They are made again when the sun has another azimuth, and kept as all maps are
//! ([`slot_maps`](super::slot_maps)).
//!
//! Why: `docs/decisions/horizon-maps.md`.

use glam::{DVec2, Vec2};

use super::atlas::Atlas;
use super::slot_maps::SlotMaps;
use crate::gpu::Gpu;

/// Texels along the side of a map, each with both numbers in 16 bits; `shaders/shared/horizon_maps.wgsl` has it too.
pub const HORIZON_MAP_SIDE: u32 = 130;
/// Bytes of a map.
pub const HORIZON_MAP_BYTES: u64 = HORIZON_MAP_SIDE as u64 * HORIZON_MAP_SIDE as u64 * 4;

/// The maps; their key is the way to the sun: unit, east and north.
pub struct HorizonMaps {
    /// As they lie on the GPU.
    pub maps: SlotMaps<Vec2>,
    sampler: wgpu::Sampler,
}

impl HorizonMaps {
    /// As many as the atlas has slots; none is made yet.
    pub fn new(gpu: &Gpu, atlas: &Atlas) -> Self {
        let maps = SlotMaps::new(gpu, atlas, "horizon maps", [HORIZON_MAP_SIDE; 2], Vec2::Y);
        Self { maps, sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor::default()) }
    }

    /// Gathers texels; it filters nothing.
    pub fn sampler(&self) -> &wgpu::Sampler {
        &self.sampler
    }

    /// From the next plan on the sun stands there. In the zenith any azimuth will do.
    pub fn set_sun(&mut self, to_sun: DVec2) {
        self.maps.set_key(to_sun.try_normalize().unwrap_or(DVec2::Y).as_vec2());
    }
}
