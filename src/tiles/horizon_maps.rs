//! Horizon maps with sky visibility: for each slot of the atlas, how high the horizon toward the sun stands and how much
//! of the sky is visible, and which of these maps have to be made.
//!
//! A map is made when its tile has come, and again when the sun has another azimuth or when more of the tiles that its
//! horizons look at have come ([`beside`](super::beside)). That some of them have gone is no reason: what was made with
//! them is the better. So many maps are made in a frame at most; those that were never made first, coarse ones before
//! fine ones, since a coarse one stands in, and then the oldest.
//!
//! Why: `docs/decisions/horizon-maps.md`.

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, Vec2};
use rustc_hash::{FxHashMap, FxHashSet};

use super::atlas::Atlas;
use super::beside::{Around, around};
use super::residency::Residency;
use crate::gpu::Gpu;
use crate::pyramid::{LevelSize, TileAddress};

/// The horizon toward the sun and the visible sky, in 16 bits each. Storage of two channels that every backend has.
pub const HORIZON_MAP_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// Texels along the side of a map; `shaders/shared/seen.wgsl` has it too.
pub const HORIZON_MAP_SIDE: u32 = 130;
/// Bytes of a map.
pub const HORIZON_MAP_BYTES: u64 = HORIZON_MAP_SIDE as u64 * HORIZON_MAP_SIDE as u64 * 4;
/// Maps that are made in a frame that must not wait.
pub const TILES_PER_FRAME: usize = 4;

/// A map to make, as the shader reads it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable, PartialEq, Eq)]
pub struct HorizonJob {
    slot: i32,
    level: i32,
    tile: [i32; 2],
}

crate::gpu::shared::describe!(HorizonJob as "SeenJob" in "surface/horizons": slot, level, tile);

/// How a map was made.
struct Made {
    slot: u32,
    /// When the tile came into the slot: another tile there came at another time.
    arrived_s: f64,
    around: Around,
    to_sun: Vec2,
    frame: u64,
}

/// The maps, and what has to be made of them in this frame.
pub struct HorizonMaps {
    view: wgpu::TextureView,
    sampler: wgpu::Sampler,
    slots: u32,
    to_sun: Vec2,
    made: FxHashMap<TileAddress, Made>,
    jobs: Vec<HorizonJob>,
}

impl HorizonMaps {
    /// As many as the atlas has slots; none is made yet.
    pub fn new(gpu: &Gpu, atlas: &Atlas) -> Self {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("horizon maps"),
            size: wgpu::Extent3d {
                width: HORIZON_MAP_SIDE,
                height: HORIZON_MAP_SIDE,
                depth_or_array_layers: atlas.slots(),
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: HORIZON_MAP_FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::STORAGE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor::default());
        Self { view, sampler, slots: atlas.slots(), to_sun: Vec2::Y, made: FxHashMap::default(), jobs: Vec::new() }
    }

    /// All maps, a layer for each slot of the atlas.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// Gathers texels; it filters nothing.
    pub fn sampler(&self) -> &wgpu::Sampler {
        &self.sampler
    }

    /// Bytes of all maps on the GPU, made or not.
    pub fn bytes(&self) -> u64 {
        u64::from(self.slots) * HORIZON_MAP_BYTES
    }

    /// Toward the sun: unit, east and north.
    pub fn to_sun(&self) -> Vec2 {
        self.to_sun
    }

    /// From the next plan on the sun stands there. In the zenith any azimuth will do.
    pub fn set_sun(&mut self, to_sun: DVec2) {
        self.to_sun = to_sun.try_normalize().unwrap_or(DVec2::Y).as_vec2();
    }

    /// The maps that this frame makes.
    pub fn jobs(&self) -> &[HorizonJob] {
        &self.jobs
    }

    /// The frame of the last plan was not drawn: what it planned counts as not made.
    pub fn forget_planned(&mut self) {
        for job in self.jobs.drain(..) {
            self.made.retain(|_, made| made.slot as i32 != job.slot);
        }
    }

    /// Whether a tile that is in the atlas has its map.
    pub fn is_made(&self, atlas: &Atlas, tile: TileAddress) -> bool {
        self.made_of(atlas, tile).is_some()
    }

    fn made_of(&self, atlas: &Atlas, tile: TileAddress) -> Option<&Made> {
        let resident = atlas.get(tile)?;
        self.made.get(&tile).filter(|made| made.slot == resident.slot && made.arrived_s == resident.arrived_s)
    }

    /// Chooses what is made in this frame, `most` maps at most, of those that the view needs; they count as made.
    /// Returns how many are left for later frames.
    pub fn plan(&mut self, residency: &Residency, levels: &[LevelSize], most: usize, frame: u64) -> usize {
        let Residency { atlas, needed, beside, .. } = residency;
        // The march reads what is in the page table, and not what else is in the atlas by chance.
        let needed_tiles = needed.iter().map(|tile| tile.address);
        let in_table: FxHashSet<TileAddress> = needed_tiles.chain(beside.iter().copied()).collect();
        let is_there = |(bit, tile)| Around::from(in_table.contains(&tile) && atlas.get(tile).is_some()) << bit;
        let mut stale: Vec<_> = needed
            .iter()
            .filter_map(|tile| {
                let resident = atlas.get(tile.address)?;
                let there = around(levels, tile.address).map(is_there).fold(0, |set, bit: Around| set | bit);
                let made = self.made_of(atlas, tile.address);
                let is_good = made.is_some_and(|made| made.to_sun == self.to_sun && there & !made.around == 0);
                let age = made.map_or(0, |made| made.frame);
                (!is_good).then_some((age, std::cmp::Reverse(tile.address.level), tile.address, resident, there))
            })
            .collect();
        stale.sort_unstable_by_key(|(age, level, address, ..)| (*age, *level, *address));
        stale.dedup_by_key(|(_, _, address, ..)| *address);
        let left = stale.len().saturating_sub(most);
        stale.truncate(most);
        self.jobs.clear();
        for (_, _, address, resident, around) in stale {
            let TileAddress { level, x, y } = address;
            let (slot, arrived_s) = (resident.slot, resident.arrived_s);
            self.jobs.push(HorizonJob { slot: slot as i32, level: level as i32, tile: [x as i32, y as i32] });
            self.made.insert(address, Made { slot, arrived_s, around, to_sun: self.to_sun, frame });
        }
        // What has left the atlas is not kept for ever.
        if self.made.len() > 2 * self.slots as usize {
            self.made.retain(|tile, _| atlas.get(*tile).is_some());
        }
        left
    }
}
