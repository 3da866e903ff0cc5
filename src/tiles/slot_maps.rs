//! Cached maps computed from heights: a layer for each slot of the atlas, and the schedule of their computation.
//!
//! A map is computed when its tile has been loaded, and again when its key has changed (for example the direction to
//! the sun, or the sea level) or when more of the tiles that it depends on have been loaded
//! ([`map_neighbours`](super::map_neighbours)). It is not recomputed when some of them have gone, because the map with
//! them is better. A frame that must not wait computes [`MAPS_AT_ONCE`] maps, or up to [`MOST_MAPS`] if the last frame took
//! long: first those that never were, ordered by the error that is visible while a coarser one is used, then the oldest;
//! then those of tiles that the view will need in a moment. Maps fade in as the surface's detail does
//! ([`ResidencyFloor`]). A frame for a file computes all maps, [`MAPS_AT_ONCE`] per submit.
//!
//! Why: `docs/decisions/horizon-maps.md`, `docs/decisions/water.md`.

use std::hash::{Hash, Hasher};
use std::sync::atomic::{AtomicU64, Ordering};

use rustc_hash::{FxHashMap, FxHashSet, FxHasher};

use super::atlas::Atlas;
use super::map_neighbours::{Around, around};
use super::queues::by_level;
use super::residency::Residency;
use super::residency_floor::ResidencyFloor;
use crate::gpu::Gpu;
pub(crate) use crate::gpu::wgsl::shared::map_job::MapJob;
use crate::pyramid::{LevelSize, TileAddress};

/// A storage format of one channel that every backend has; a texel packs several small numbers.
pub(crate) const MAP_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R32Uint;
/// Number of maps of a kind that a short frame computes if it must not wait, and that each submit computes otherwise.
pub(crate) const MAPS_AT_ONCE: usize = 4;
/// Number of maps of a kind for each second since the last frame.
const MAPS_PER_S: f64 = 960.0;
/// The largest number of maps of a kind that a frame computes if it must not wait.
pub(crate) const MOST_MAPS: usize = 8 * MAPS_AT_ONCE;

/// Number of maps for which a frame that must not wait looks whether more tiles have come around theirs. Where memory is
/// short, that may be hundreds, each with dozens of tiles around it.
const LOOKS_AT_ONCE: usize = 64;

/// How a map was computed.
struct Made<K> {
    slot: u32,
    /// The tile's arrival in the slot, in seconds: another tile in that slot arrived at another time.
    arrived_s: f64,
    around: Around,
    /// Whether `around` has all tiles around it that exist, so that the map cannot become better.
    is_complete: bool,
    key: K,
    frame: u64,
}

/// A map that a frame can read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct MapInView {
    pub slot: u32,
    /// A number that identifies what the map was computed from, and when.
    pub content: u64,
}

/// The maps of a kind, and those that this frame has to compute.
pub(crate) struct SlotMaps<K> {
    /// A number that no other maps of the program have.
    number: u64,
    view: wgpu::TextureView,
    bytes: u64,
    slots: u32,
    key: K,
    made: FxHashMap<TileAddress, Made<K>>,
    /// The floor by which a picture stays above the levels of missing maps.
    floor: ResidencyFloor,
    jobs: Vec<MapJob>,
    /// Number of maps in view that were computed without some of the tiles around them.
    incomplete: usize,
    /// The version of the residency and the key for which nothing was left to compute and nothing was fading in.
    settled: Option<(u64, K)>,
    /// Changes whenever a map is computed or forgotten.
    version: u64,
}

/// Returns the largest number of maps of a kind for a frame that must not wait, by the time since the last frame.
pub(crate) fn maps_of_frame(elapsed_s: f64) -> usize {
    ((elapsed_s * MAPS_PER_S) as usize).clamp(MAPS_AT_ONCE, MOST_MAPS)
}

/// The parameters of a frame for its maps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MapStep {
    /// Number of the frame.
    pub frame: u64,
    /// The largest number of maps to compute.
    pub most: usize,
    /// Time since the last frame, in seconds; `None` disables fading.
    pub fade_step_s: Option<f64>,
    /// Whether the camera rests, or the frame is for a file.
    pub is_at_rest: bool,
}

impl<K: Copy + PartialEq> SlotMaps<K> {
    /// Creates as many maps as the atlas has slots, of `size` texels each; none is computed yet.
    pub(crate) fn new(gpu: &Gpu, atlas: &Atlas, name: &'static str, size: [u32; 2], key: K) -> Self {
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
        static MADE: AtomicU64 = AtomicU64::new(0);
        Self {
            number: MADE.fetch_add(1, Ordering::Relaxed),
            view,
            bytes: u64::from(atlas.slots()) * u64::from(width * height) * 4,
            slots: atlas.slots(),
            key,
            made: FxHashMap::default(),
            floor: ResidencyFloor::default(),
            jobs: Vec::new(),
            incomplete: 0,
            settled: None,
            version: 0,
        }
    }

    /// Returns all maps, a layer for each slot of the atlas.
    pub(crate) fn view(&self) -> &wgpu::TextureView {
        &self.view
    }

    /// Returns the GPU memory of all maps in bytes, computed or not.
    pub(crate) fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Returns the current key, the input of the maps besides heights.
    pub(crate) fn key(&self) -> K {
        self.key
    }

    /// Sets the key from the next plan on.
    pub(crate) fn set_key(&mut self, key: K) {
        self.key = key;
    }

    /// Returns the maps of the tiles in the page table, those that this frame computes included.
    pub(crate) fn in_view(&self, residency: &Residency) -> Vec<MapInView> {
        let in_table = residency.needed.iter().map(|tile| tile.address).chain(residency.map_neighbours.iter().copied());
        let map = |address| {
            let made = self.made_of(&residency.atlas, address)?;
            let mut hasher = FxHasher::default();
            (self.number, address, made.arrived_s.to_bits(), made.frame).hash(&mut hasher);
            Some(MapInView { slot: made.slot, content: hasher.finish() })
        };
        let mut maps: Vec<MapInView> = in_table.filter_map(map).collect();
        maps.sort_unstable();
        maps.dedup();
        maps
    }

    /// Returns a number that changes whenever a map or its floor changes.
    pub(crate) fn table_version(&self) -> u64 {
        self.version + self.floor.version()
    }

    /// Returns the maps that this frame computes.
    pub(crate) fn jobs(&self) -> &[MapJob] {
        &self.jobs
    }

    /// Returns the fraction of a level by which a picture stays above a tile's level, at the tile's corners, or `None`
    /// if the tile has no map.
    pub(crate) fn floor_at(&self, atlas: &Atlas, tile: TileAddress) -> Option<[f32; 4]> {
        self.made_of(atlas, tile).map(|_| self.floor.at(tile))
    }

    /// Marks the planned maps as not computed, because the frame of the last plan was not drawn.
    pub(crate) fn forget_planned(&mut self) {
        self.version += 1;
        self.settled = None;
        for job in self.jobs.drain(..) {
            self.made.retain(|_, made| made.slot as i32 != job.slot);
        }
    }

    fn made_of(&self, atlas: &Atlas, tile: TileAddress) -> Option<&Made<K>> {
        let resident = atlas.get(tile)?;
        self.made.get(&tile).filter(|made| made.slot == resident.slot && made.arrived_s == resident.arrived_s)
    }

    /// Chooses the maps to compute in this frame among those that the view needs, and marks them as computed. Returns
    /// whether the next frame of the same view would have other maps, because some are left for it or are fading in. While
    /// the camera moves, maps that could be better do not count.
    pub(crate) fn plan(&mut self, residency: &Residency, levels: &[LevelSize], step: MapStep) -> bool {
        let MapStep { frame, most, fade_step_s, is_at_rest } = step;
        self.jobs.clear();
        if self.settled == Some((residency.version(), self.key)) {
            return false;
        }
        let Residency { atlas, needed, map_neighbours, mapped_ahead, .. } = residency;
        // A map depends on tiles in the page table only, not on others that are in the atlas by chance.
        let needed_tiles = needed.iter().map(|tile| tile.address);
        let in_table: FxHashSet<TileAddress> =
            needed_tiles.chain(map_neighbours.iter().chain(mapped_ahead).copied()).collect();
        let is_there = |(bit, tile)| Around::from(in_table.contains(&tile) && atlas.get(tile).is_some()) << bit;
        // While the camera moves, incomplete maps are looked at in turns.
        let turns = if is_at_rest { 1 } else { self.incomplete.div_ceil(LOOKS_AT_ONCE).max(1) };
        let mut incomplete = 0;
        let mut stale: Vec<_> = needed
            .iter()
            .filter_map(|tile| {
                let resident = atlas.get(tile.address)?;
                let made = self.made_of(atlas, tile.address);
                if let Some(made) = made.filter(|made| made.key == self.key) {
                    incomplete += usize::from(!made.is_complete);
                    if made.is_complete || incomplete % turns != frame as usize % turns {
                        return None;
                    }
                }
                let there = around(levels, tile.address).map(is_there).fold(0, |set, bit: Around| set | bit);
                let is_good = made.is_some_and(|made| made.key == self.key && there & !made.around == 0);
                let age = made.map_or(0, |made| made.frame);
                (!is_good).then_some((age, tile, resident, there))
            })
            .collect();
        self.incomplete = incomplete;
        stale.sort_unstable_by(|(age, tile, ..), (other_age, other, ..)| {
            // A parent is at least as urgent as its children, and precedes them.
            let by_urgency = other.urgency.total_cmp(&tile.urgency);
            let (address, other) = (tile.address, other.address);
            age.cmp(other_age).then(by_urgency).then(other.level.cmp(&address.level)).then(address.cmp(&other))
        });
        stale.dedup_by_key(|(_, tile, ..)| tile.address);
        let unmade = stale.iter().filter(|(_, tile, ..)| self.made_of(atlas, tile.address).is_none()).count();
        let has_more = stale.len() > most;
        let is_late = if is_at_rest { has_more } else { unmade > most };
        stale.truncate(most);
        let of_view = stale.into_iter().map(|(_, tile, resident, there)| (tile.address, resident, there));
        let mut planned: Vec<_> = of_view.collect();
        // What the view leaves over is for the near future; those maps are made again when more is around their tiles.
        for tile in mapped_ahead {
            if planned.len() < most
                && self.made_of(atlas, *tile).is_none_or(|made| made.key != self.key)
                && let Some(resident) = atlas.get(*tile)
            {
                let there = around(levels, *tile).map(is_there).fold(0, |set, bit: Around| set | bit);
                planned.push((*tile, resident, there));
            }
        }
        self.version += u64::from(!planned.is_empty());
        for (tile, resident, there) in planned {
            let TileAddress { level, x, y } = tile;
            let (slot, arrived_s) = (resident.slot, resident.arrived_s);
            self.jobs.push(MapJob { slot: slot as i32, level: level as i32, tile: [x as i32, y as i32] });
            let exist = around(levels, tile).fold(0, |set, (bit, _)| set | Around::from(true) << bit);
            let made = Made { slot, arrived_s, around: there, is_complete: there == exist, key: self.key, frame };
            self.made.insert(tile, made);
        }
        // Forget maps of tiles that have left the atlas.
        if self.made.len() > 2 * self.slots as usize {
            self.made.retain(|tile, _| atlas.get(*tile).is_some());
        }
        let is_made = needed.iter().map(|tile| (tile.address, self.made_of(atlas, tile.address).is_some()));
        let by_level: Vec<_> = by_level(is_made, Vec::new()).collect();
        self.floor.update(by_level.into_iter(), fade_step_s);
        let goes_on = is_late || self.floor.is_fading();
        let is_settled = !goes_on && !has_more && self.jobs.is_empty() && turns == 1;
        self.settled = is_settled.then_some((residency.version(), self.key));
        goes_on
    }
}
