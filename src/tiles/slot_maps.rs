//! Maps that are made of heights and kept: a layer for each slot of the atlas, and which of them have to be made.
//!
//! A map is made when its tile has come, and again when what it was made for has changed (its key: where the sun stands,
//! how high the sea is) or when more of the tiles that it looks at have come ([`beside`](super::beside)). That some of
//! them have gone is no reason: what was made with them is the better. A frame that must not wait makes [`MAPS_AT_ONCE`]:
//! those that were never made first, by the error that is seen while a coarser one stands in, and then the oldest. They
//! fade in as the surface's detail does ([`ResidencyFloor`]). A frame for a file makes all of them, as many in each
//! submit.
//!
//! Why: `docs/decisions/horizon-maps.md`, `docs/decisions/water.md`.

use rustc_hash::{FxHashMap, FxHashSet};

use super::atlas::Atlas;
use super::beside::{Around, around};
use super::queues::by_level;
use super::residency::Residency;
use super::residency_floor::ResidencyFloor;
use crate::gpu::Gpu;
pub use crate::gpu::wgsl::shared::map_job::MapJob;
use crate::pyramid::{LevelSize, TileAddress};

/// Storage of one channel that every backend has; a texel holds several small numbers.
pub const MAP_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// Maps of a kind that a frame makes if it must not wait, and that one submit makes if it must.
pub const MAPS_AT_ONCE: usize = 4;

/// How a map was made.
struct Made<K> {
    slot: u32,
    /// When the tile came into the slot: another tile there came at another time.
    arrived_s: f64,
    around: Around,
    key: K,
    frame: u64,
}

/// The maps of a kind, and what has to be made of them in this frame.
pub struct SlotMaps<K> {
    view: wgpu::TextureView,
    bytes: u64,
    slots: u32,
    key: K,
    made: FxHashMap<TileAddress, Made<K>>,
    /// By how much a picture has to stay above the levels of maps that are missing.
    floor: ResidencyFloor,
    jobs: Vec<MapJob>,
}

/// What a frame asks of its maps.
#[derive(Clone, Copy, Debug)]
pub struct MapStep {
    /// Its number.
    pub frame: u64,
    /// Makes as many maps at most.
    pub most: usize,
    /// The time since the last frame, in seconds; none fades nothing.
    pub fade_step_s: Option<f64>,
}

impl<K: Copy + PartialEq> SlotMaps<K> {
    /// As many as the atlas has slots, of `size` texels each; none is made yet.
    pub fn new(gpu: &Gpu, atlas: &Atlas, name: &'static str, size: [u32; 2], key: K) -> Self {
        let [width, height] = size;
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(name),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: atlas.slots() },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: MAP_FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::STORAGE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        });
        Self {
            view,
            bytes: u64::from(atlas.slots()) * u64::from(width * height) * 4,
            slots: atlas.slots(),
            key,
            made: FxHashMap::default(),
            floor: ResidencyFloor::default(),
            jobs: Vec::new(),
        }
    }

    /// All maps, a layer for each slot of the atlas.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// Bytes of all maps on the GPU, made or not.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// What maps are made for now.
    pub fn key(&self) -> K {
        self.key
    }

    /// From the next plan on maps are made for this.
    pub fn set_key(&mut self, key: K) {
        self.key = key;
    }

    /// The maps that this frame makes.
    pub fn jobs(&self) -> &[MapJob] {
        &self.jobs
    }

    /// How far above a tile's level a picture has to stay, at its corners; none for a tile that has no map.
    pub fn floor_at(&self, atlas: &Atlas, tile: TileAddress) -> Option<[f32; 4]> {
        self.made_of(atlas, tile).map(|_| self.floor.at(tile))
    }

    /// The frame of the last plan was not drawn: what it planned counts as not made.
    pub fn forget_planned(&mut self) {
        for job in self.jobs.drain(..) {
            self.made.retain(|_, made| made.slot as i32 != job.slot);
        }
    }

    fn made_of(&self, atlas: &Atlas, tile: TileAddress) -> Option<&Made<K>> {
        let resident = atlas.get(tile)?;
        self.made.get(&tile).filter(|made| made.slot == resident.slot && made.arrived_s == resident.arrived_s)
    }

    /// Chooses what is made in this frame of those maps that the view needs; they count as made. Whether the next frame
    /// of the same view would have other maps: some are left for it, or fade in.
    pub fn plan(&mut self, residency: &Residency, levels: &[LevelSize], step: MapStep) -> bool {
        let MapStep { frame, most, fade_step_s } = step;
        let Residency { atlas, needed, beside, .. } = residency;
        // A map is made of what is in the page table, and not what else is in the atlas by chance.
        let needed_tiles = needed.iter().map(|tile| tile.address);
        let in_table: FxHashSet<TileAddress> = needed_tiles.chain(beside.iter().copied()).collect();
        let is_there = |(bit, tile)| Around::from(in_table.contains(&tile) && atlas.get(tile).is_some()) << bit;
        let mut stale: Vec<_> = needed
            .iter()
            .filter_map(|tile| {
                let resident = atlas.get(tile.address)?;
                let there = around(levels, tile.address).map(is_there).fold(0, |set, bit: Around| set | bit);
                let made = self.made_of(atlas, tile.address);
                let is_good = made.is_some_and(|made| made.key == self.key && there & !made.around == 0);
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
            self.jobs.push(MapJob { slot: slot as i32, level: level as i32, tile: [x as i32, y as i32] });
            self.made.insert(tile.address, Made { slot, arrived_s, around, key: self.key, frame });
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
