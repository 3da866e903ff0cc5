//! Horizon maps with sky visibility: for each slot of the atlas, how high the horizon toward the sun stands and how
//! much of the sky is visible, and which of these maps have to be made.
//!
//! A map is made when its tile has come, and again when the sun has another azimuth or when more of the tiles that its
//! horizons look at have come ([`beside`](super::beside)). That some of them have gone is no reason: what was made with
//! them is the better. A frame that must not wait makes [`MAPS_AT_ONCE`]: those that were never made first, by the
//! error that is seen while a coarser one stands in, and then the oldest. They fade in as the surface's detail does
//! ([`ResidencyFloor`]). A frame for a file makes all of them, as many in each submit.
//!
//! Why: `docs/decisions/horizon-maps.md`.

use glam::{DVec2, Vec2};
use rustc_hash::{FxHashMap, FxHashSet};

use super::atlas::Atlas;
use super::beside::{Around, around};
use super::queues::by_level;
use super::residency::Residency;
use super::residency_floor::ResidencyFloor;
use crate::gpu::Gpu;
pub use crate::gpu::wgsl::surface::land::horizons::HorizonJob;
use crate::pyramid::{LevelSize, TileAddress};

/// The horizon toward the sun and the visible sky, in 16 bits each. Storage of two channels that every backend has.
pub const HORIZON_MAP_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// Texels along the side of a map; `shaders/shared/horizon_maps.wgsl` has it too.
pub const HORIZON_MAP_SIDE: u32 = 130;
/// Bytes of a map.
pub const HORIZON_MAP_BYTES: u64 = HORIZON_MAP_SIDE as u64 * HORIZON_MAP_SIDE as u64 * 4;
/// Maps that a frame makes if it must not wait, and that one submit makes if it must: 67 600 texels.
pub const MAPS_AT_ONCE: usize = 4;

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
    /// By how much horizons have to stay above the levels of maps that are missing.
    floor: ResidencyFloor,
    jobs: Vec<HorizonJob>,
}

/// What a frame asks of its horizon maps.
#[derive(Clone, Copy, Debug)]
pub struct HorizonStep {
    /// Its number.
    pub frame: u64,
    /// Makes as many maps at most.
    pub most: usize,
    /// The time since the last frame, in seconds; none fades nothing.
    pub fade_step_s: Option<f64>,
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
        Self {
            view,
            sampler,
            slots: atlas.slots(),
            to_sun: Vec2::Y,
            made: FxHashMap::default(),
            floor: ResidencyFloor::default(),
            jobs: Vec::new(),
        }
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

    /// How far above a tile's level horizons have to stay, at its corners; none for a tile that has no map.
    pub fn floor_at(&self, atlas: &Atlas, tile: TileAddress) -> Option<[f32; 4]> {
        self.made_of(atlas, tile).map(|_| self.floor.at(tile))
    }

    /// The frame of the last plan was not drawn: what it planned counts as not made.
    pub fn forget_planned(&mut self) {
        for job in self.jobs.drain(..) {
            self.made.retain(|_, made| made.slot as i32 != job.slot);
        }
    }

    fn made_of(&self, atlas: &Atlas, tile: TileAddress) -> Option<&Made> {
        let resident = atlas.get(tile)?;
        self.made.get(&tile).filter(|made| made.slot == resident.slot && made.arrived_s == resident.arrived_s)
    }

    /// Chooses what is made in this frame of those maps that the view needs; they count as made. Whether the next frame
    /// of the same view would have other maps: some are left for it, or fade in.
    pub fn plan(&mut self, residency: &Residency, levels: &[LevelSize], step: HorizonStep) -> bool {
        let HorizonStep { frame, most, fade_step_s } = step;
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
                (!is_good).then_some((age, tile, resident, there))
            })
            .collect();
        stale.sort_unstable_by(|(age, tile, ..), (other_age, other, ..)| {
            // A parent is at least as urgent as its children, and comes before them.
            let by_urgency = other.urgency.total_cmp(&tile.urgency);
            let (address, other) = (tile.address, other.address);
            age.cmp(other_age).then(by_urgency).then(other.level.cmp(&address.level)).then(address.cmp(&other))
        });
        stale.dedup_by_key(|(_, tile, ..)| tile.address);
        let is_late = stale.len() > most;
        stale.truncate(most);
        self.jobs.clear();
        for (_, tile, resident, around) in stale {
            let TileAddress { level, x, y } = tile.address;
            let (slot, arrived_s) = (resident.slot, resident.arrived_s);
            self.jobs.push(HorizonJob { slot: slot as i32, level: level as i32, tile: [x as i32, y as i32] });
            self.made.insert(tile.address, Made { slot, arrived_s, around, to_sun: self.to_sun, frame });
        }
        // What has left the atlas is not kept for ever.
        if self.made.len() > 2 * self.slots as usize {
            self.made.retain(|tile, _| atlas.get(*tile).is_some());
        }
        let is_made = needed.iter().map(|tile| (tile.address, self.made_of(atlas, tile.address).is_some()));
        let by_level: Vec<_> = by_level(is_made, Vec::new()).collect();
        self.floor.update(by_level.into_iter(), fade_step_s);
        is_late || self.floor.is_fading()
    }
}
