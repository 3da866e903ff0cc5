//! The scheduler of tiles: which are on the GPU, which are being loaded, and in which order.
//!
//! There are three groups, after Cesium: *urgent* tiles are needed by the view and missing; *normal* ones will be
//! needed if the camera keeps moving as it does; *preload* ones are just outside the view. Within a group the tile
//! whose parent, drawn instead, shows the largest error comes first, with a preference for the middle of the view. A
//! tile that is no longer wanted is never read. A tile that cannot be read is retried at increasing intervals, while its
//! parent is drawn instead.
//!
//! Which tiles a view needs changes slowly, so the list is found with a margin and used for as long as the camera stays
//! within it (`residency/find.rs`). If a view needs more tiles than there are slots, its pixels count as wider by a
//! factor (`memory_error`). What will be needed soon is found by another thread (`prefetch`).
//!
//! Why: `docs/decisions/tile-streaming.md`.

mod find;

use std::sync::Arc;

use glam::{DVec2, DVec3};
use rustc_hash::{FxHashMap, FxHashSet};

use self::find::Found;
use super::atlas::{Atlas, Protected, Upload};
use super::cache::TileCache;
use super::camera_motion::Turning;
use super::grid_projection::GridProjection;
use super::loader::Loader;
use super::memory_error::MemoryError;
use super::needed::{HeightRanges, LevelRule, Needed, TilePlaces};
use super::prefetch::{Foreseen, Prefetcher};
use super::queues::{by_level, in_order, most_urgent};
use super::residency_floor::ResidencyFloor;
use super::skyline::Skyline;
use crate::gpu::Gpu;
use crate::pyramid::surface::tile_height::{height_in_tile, tile_at};
use crate::pyramid::{LoadedTile, PyramidError, TileAddress, TileStore};

/// The pause after a failure, in seconds; it doubles with each failure, up to the longest pause.
const FIRST_PAUSE_S: f64 = 0.2;
const LONGEST_PAUSE_S: f64 = 30.0;
/// Number of failures after which a tile counts as unreadable. It is retried nevertheless.
const MAX_TRIES: u32 = 3;
/// The largest number of tiles that a frame uploads because they will be needed soon: 4 MiB.
const MAX_SOON_UPLOADS: usize = 16;
/// Urgency of tiles that only maps depend on: lower than that of all tiles that the surface needs.
const MAP_URGENCY: f32 = 1e-3;

/// The state of the tiles of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Loaded {
    /// Number of tiles that the view needs.
    pub wanted: u64,
    /// Number of tiles that were uploaded to the GPU for this frame.
    pub loaded: u64,
    /// Number of tiles that are being loaded; coarser ones are drawn instead.
    pub pending: u64,
    /// Number of tiles for which there was no slot; coarser ones are drawn instead.
    pub without_room: u64,
    /// Number of tiles that cannot be read; coarser ones are drawn instead.
    pub failed: u64,
    /// Whether some of the surface is coarser than its allowed error requires, also while detail fades in.
    pub late: bool,
}

/// The requirements of a frame: a view, and the motion of its camera.
#[derive(Clone, Debug)]
pub(crate) struct Movement {
    /// The level rule of the view that is drawn.
    pub rule: LevelRule,
    /// Velocity of the camera.
    pub velocity_m_s: DVec3,
    /// Whether the camera jumped to this frame.
    pub has_jumped: bool,
    /// Time since the last frame, in seconds.
    pub frame_s: f64,
    /// Tiles that the mesh requests, with their urgency.
    pub requested: FxHashMap<TileAddress, f64>,
    /// Whether maps are computed, which depend on tiles next to the view.
    pub needs_map_neighbours: bool,
}

/// The ground under a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ground {
    /// Height in metres.
    pub height_m: f64,
    /// How far the height may be off, in metres, because finer tiles are missing.
    pub error_m: f64,
}

struct Failure {
    tries: u32,
    next_s: f64,
}

/// The tiles of a terrain, from loading to their slots on the GPU.
pub(crate) struct Residency {
    store: Arc<dyn TileStore>,
    loader: Loader,
    cache: TileCache,
    places: TilePlaces,
    failures: FxHashMap<TileAddress, Failure>,
    /// The error of the first tile that counts as unreadable.
    failure: Option<Arc<PyramidError>>,
    /// The tiles on the GPU.
    pub atlas: Atlas,
    /// The residency floor, by which the surface stays above the levels of missing tiles.
    pub floor: ResidencyFloor,
    /// The tiles that the view of this frame needs, coarse levels first.
    pub needed: Vec<Needed>,
    /// The tiles that only its maps depend on.
    pub map_neighbours: Vec<TileAddress>,
    /// The same tiles as in `needed`, for lookups.
    needed_set: FxHashSet<TileAddress>,
    /// The view for which they were found.
    found: Option<Found>,
    /// Those of both lists that are not on the GPU, the most urgent first.
    missing: Vec<Needed>,
    /// The tiles around needed ones that do not exist, because nothing finer is known there.
    absent: Vec<(TileAddress, bool)>,
    /// The tiles that will probably be needed soon.
    foreseen: Arc<Foreseen>,
    /// Those of the near future that are not on the GPU, the most urgent first.
    missing_near: Vec<TileAddress>,
    /// The tiles that are missing for a smaller factor of the error, if there is room for them.
    missing_finer: Vec<TileAddress>,
    /// Other foreseen tiles that are not on the GPU, in the order in which to load them.
    missing_soon: Vec<TileAddress>,
    /// The frame in which `foreseen` arrived.
    soon_since: u64,
    prefetcher: Option<Prefetcher>,
    turning: Turning,
    /// The time of the last look ahead, in seconds.
    looked_s: f64,
    /// Whether there is a slot for every tile of the pyramid.
    fits_all: bool,
    /// The factor by which the surface is coarser because its tiles would not fit.
    memory: MemoryError,
    /// Whether tiles that land hides count as not needed, because memory is short; and the skyline of the last frame.
    drops_hidden: bool,
    skyline: Option<Skyline>,
    ranges: HeightRanges,
    /// Changes whenever `needed`, `map_neighbours`, or which of them are on the GPU changes.
    version: u64,
    hits: Hits,
    #[cfg(test)]
    pub diag: std::collections::BTreeMap<(&'static str, u32), u32>,
    #[cfg(test)]
    diag_seen: FxHashSet<(TileAddress, u64)>,
}

/// How often a tile was at hand when it was wanted, since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Hits {
    /// Tiles that a view began to need: how many were on the GPU, and how many were not.
    pub gpu: [u64; 2],
    /// Number of tiles that were uploaded to the GPU.
    pub uploaded: u64,
    /// Number of tiles that were read and decoded; those uploaded without being read were in memory.
    pub read: u64,
}

impl Residency {
    /// Creates a scheduler that has loaded nothing. It may use `memory_bytes` on the GPU and as much on the CPU.
    pub(crate) fn new(gpu: &Gpu, store: Arc<dyn TileStore>, memory_bytes: u64) -> Self {
        let tiles = store.levels().iter().map(|size| u64::from(size.tiles_x()) * u64::from(size.tiles_y())).sum();
        let atlas = Atlas::new(gpu, tiles, memory_bytes);
        Self {
            fits_all: u64::from(atlas.slots()) >= tiles,
            loader: Loader::new(Arc::clone(&store)),
            cache: TileCache::new(memory_bytes),
            places: TilePlaces::default(),
            failures: FxHashMap::default(),
            failure: None,
            atlas,
            floor: ResidencyFloor::default(),
            needed: Vec::new(),
            map_neighbours: Vec::new(),
            needed_set: FxHashSet::default(),
            found: None,
            missing: Vec::new(),
            absent: Vec::new(),
            foreseen: Arc::default(),
            missing_near: Vec::new(),
            missing_finer: Vec::new(),
            missing_soon: Vec::new(),
            soon_since: 0,
            prefetcher: None,
            turning: Turning::default(),
            looked_s: f64::NEG_INFINITY,
            memory: MemoryError::default(),
            drops_hidden: false,
            skyline: None,
            ranges: HeightRanges::default(),
            version: 0,
            hits: Hits::default(),
            #[cfg(test)]
            diag: Default::default(),
            #[cfg(test)]
            diag_seen: Default::default(),
            store,
        }
    }

    /// Returns a tile that is in memory.
    pub(crate) fn in_memory(&self, address: TileAddress) -> Option<&Arc<LoadedTile>> {
        self.cache.peek(address)
    }

    /// Returns the ground at a grid position, from the finest tile that the view needs and that is in memory. Other
    /// tiles are in memory by chance, and no picture may depend on them. The result is fine enough once all are there,
    /// because the tiles of the land in front of the camera extend under it.
    pub(crate) fn ground(&self, grid: DVec2) -> Option<Ground> {
        let levels = self.store.levels();
        let mut is_finest = true;
        for tile in self.under(grid) {
            if let Some(loaded) = self.in_memory(tile)
                && let Some(height_m) = height_in_tile(levels, tile, &loaded.tile, grid.x, grid.y)
            {
                let error_m = if is_finest { 0.0 } else { f64::from(loaded.statistics.error_m) };
                return Some(Ground { height_m, error_m });
            }
            is_finest = false;
        }
        None
    }

    /// Returns the needed tiles under a grid position, the finest first.
    fn under(&self, grid: DVec2) -> impl Iterator<Item = TileAddress> {
        let levels = self.store.levels();
        let at = move |level| tile_at(levels, level, grid.x, grid.y);
        (0..levels.len() as u32).filter_map(at).filter(|tile| self.needed_set.contains(tile))
    }

    /// Returns whether a tile is not on the GPU but can still be loaded.
    pub(crate) fn can_come(&self, address: TileAddress) -> bool {
        let given_up = || self.failures.get(&address).is_some_and(|failure| failure.tries >= MAX_TRIES);
        self.atlas.get(address).is_none() && !given_up() && self.needed.len() < self.atlas.slots() as usize
    }

    /// Returns whether tiles are being loaded, or will be retried soon.
    pub(crate) fn is_busy(&self, now_s: f64) -> bool {
        let soon = |failure: &Failure| failure.tries < MAX_TRIES && failure.next_s > now_s - 1.0;
        self.loader.pending() > 0 || self.failures.values().any(soon)
    }

    /// Returns the error of the first tile that could not be read.
    pub(crate) fn failure(&self) -> Option<&Arc<PyramidError>> {
        self.failure.as_ref()
    }

    /// Waits for the loading threads, when rendering to files.
    pub(crate) fn wait(&self) {
        self.loader.wait(std::time::Duration::from_millis(100));
    }

    /// Returns the number of tiles that are waiting to be read, and of those that are being read or decoded.
    #[cfg(test)]
    pub(crate) fn queued_and_under_way(&self) -> [usize; 2] {
        self.loader.queued_and_under_way()
    }

    /// Returns the memory of decoded tiles in bytes.
    pub(crate) fn cache_bytes(&self) -> u64 {
        self.cache.bytes()
    }

    #[cfg(test)]
    pub(crate) fn near_len(&self) -> (usize, usize) {
        (self.foreseen.near.iter().filter(|n| !self.needed_set.contains(&n.address)).count(), self.foreseen.later.len())
    }

    /// Returns whether tiles that land hides count as not needed, because memory is short.
    pub(crate) fn drops_hidden(&self) -> bool {
        self.drops_hidden
    }

    /// Sets the skyline of a frame, by which the next one knows the tiles that land hides.
    pub(crate) fn set_skyline(&mut self, skyline: Skyline) {
        self.skyline = Some(skyline);
    }

    /// Returns how often tiles were at hand when they were wanted.
    pub(crate) fn hits(&self) -> Hits {
        self.hits
    }

    /// Returns the factor by which the surface is coarser than requested because its tiles would not fit into memory.
    pub(crate) fn memory_factor(&self) -> f64 {
        self.memory.factor()
    }

    /// Returns a number that changes whenever the needed tiles, those for maps, or which of them are on the GPU change.
    pub(crate) fn version(&self) -> u64 {
        self.version
    }

    /// Returns whether another thread is looking for tiles that will be needed soon.
    #[cfg(test)]
    pub(crate) fn looks_ahead(&self) -> bool {
        self.prefetcher.as_ref().is_some_and(Prefetcher::is_busy)
    }

    /// Returns the number of tiles cancelled before they were loaded, since the start.
    pub(crate) fn cancelled(&self) -> u64 {
        self.loader.cancelled()
    }

    /// Advances by a frame: takes finished tiles, uploads as many as a frame may, and requests missing ones. Never
    /// waits. `fade_step_s` is the time since the last frame; `None` disables fading, and requests tiles for this view
    /// only.
    pub(crate) fn update(
        &mut self,
        gpu: &Gpu,
        grid_projection: &GridProjection,
        movement: &Movement,
        frame: u64,
        now_s: f64,
        fade_step_s: Option<f64>,
    ) -> Loaded {
        self.take_finished(frame, now_s, fade_step_s.is_some());
        let streams = fade_step_s.is_some();
        if let Some(view) = movement.rule.frusta.first() {
            self.turning.advance(view.forward(), now_s, movement.has_jumped);
        }
        if self.must_find(movement, now_s, streams) {
            self.find(grid_projection, movement, frame, now_s, streams);
        }
        let mut loaded = Loaded::default();
        let wanted = self.needed.len() + self.map_neighbours.len();
        loaded.wanted = (wanted + movement.requested.len()) as u64;
        let slots = self.atlas.slots() as usize;
        let (urgent, protected) = if streams && wanted <= slots {
            (self.missing(movement, slots - wanted, frame), self.protected(frame))
        } else {
            let (urgent, without_room) = self.most_urgent(movement);
            loaded.without_room = without_room;
            (urgent, Protected { needed_since: frame, soon_since: frame })
        };
        let ground = self.ground_to_load(grid_projection.grid_from_world(movement.rule.camera_m.truncate()), frame);
        let [request, offer, offer_soon] = self.sort_out(&ground, &urgent, frame, now_s);
        self.loader.want(&request);
        loaded.loaded =
            self.send(gpu, [&offer, &offer_soon], protected, Upload { frame, now_s, frame_s: movement.frame_s });
        self.version += u64::from(loaded.loaded > 0);
        self.hits.uploaded += loaded.loaded;
        for tile in urgent.iter().filter(|tile| self.atlas.get(tile.address).is_none()) {
            let given_up = self.failures.get(&tile.address).is_some_and(|failure| failure.tries >= MAX_TRIES);
            *(if given_up { &mut loaded.failed } else { &mut loaded.pending }) += 1;
        }
        if !streams {
            let is_coming = |tile: &&TileAddress| self.cache.peek(**tile).is_none() && self.can_be_read(**tile);
            loaded.pending += ground.iter().filter(is_coming).count() as u64;
        }
        let is_missing = loaded.pending + loaded.without_room + loaded.failed > 0;
        // Where a sparse pyramid ends, the floor is never 0.
        let ends_in_view = !self.absent.is_empty();
        if is_missing || ends_in_view || !self.floor.is_empty() || loaded.loaded > 0 || !streams {
            let atlas = &self.atlas;
            let is_there = |tile: &Needed| (tile.address, atlas.get(tile.address).is_some());
            self.floor.update(by_level(self.needed.iter().map(is_there), self.absent.clone()), fade_step_s);
        }
        #[cfg(test)]
        if streams {
            for tile in urgent.iter().map(|tile| tile.address).filter(|tile| self.atlas.get(*tile).is_none()).collect::<Vec<_>>() {
                if self.is_needed_now(grid_projection, &movement.rule, tile) && self.diag_seen.insert((tile, frame / 30)) {
                    let is_near = self.foreseen.near.iter().any(|t| t.address == tile);
                    let rank = self.foreseen.later.iter().position(|t| *t == tile);
                    let parent = TileAddress { level: tile.level + 1, x: tile.x / 2, y: tile.y / 2 };
                    let parent_age = self.atlas.get(parent).map(|p| now_s - p.arrived_s);
                    let known = self.ranges.get(tile).is_some();
                    let cause = match () {
                        () if parent_age.is_none() => "parent missing",
                        () if is_near => "near, not loaded",
                        () if rank.is_some() => "later, not loaded",
                        () if parent_age.is_some_and(|a| a < 0.3) => "parent new",
                        () if known => "known (was hidden or evicted)",
                        () => "unknown, not foreseen",
                    };
                    *self.diag.entry((cause, tile.level)).or_insert(0u32) += 1;
                }
            }
        }
        loaded.late = if streams {
            let coarser: Vec<TileAddress> = self.coarser_than_needed(&urgent, ends_in_view);
            loaded.without_room > 0
                || coarser.into_iter().any(|tile| self.is_needed_now(grid_projection, &movement.rule, tile))
        } else {
            is_missing || !ends_in_view && !self.is_complete()
        };
        loaded
    }

    /// Returns the tiles that are missing or fading in.
    fn coarser_than_needed(&self, urgent: &[Needed], ends_in_view: bool) -> Vec<TileAddress> {
        let is_missing = |tile: &TileAddress| self.atlas.get(*tile).is_none();
        let missing = urgent.iter().map(|tile| tile.address).filter(is_missing);
        let is_fading = |tile: &TileAddress| self.floor.at(*tile) != [0.0; 4];
        let fades = !ends_in_view && !self.floor.is_empty();
        let fading = self.needed.iter().filter(|_| fades).map(|tile| tile.address).filter(is_fading);
        missing.chain(fading).collect()
    }

    /// Returns the missing tiles that this view needs, the most urgent first, where there are slots for all needed ones.
    /// `room` is the number of slots left for those that only the mesh requests.
    fn missing(&mut self, movement: &Movement, room: usize, frame: u64) -> Vec<Needed> {
        let atlas = &self.atlas;
        self.missing.retain(|tile| atlas.want(tile.address, frame).is_none());
        let mut missing = self.missing.clone();
        let of_mesh = |(address, urgency): (&TileAddress, &f64)| {
            let tile = Needed { address: *address, urgency: *urgency as f32, factor: 1.0 };
            (!self.needed_set.contains(address)).then_some(tile)
        };
        let mut requested = in_order(movement.requested.iter().filter_map(of_mesh).collect());
        requested.truncate(room);
        requested.retain(|tile| atlas.want(tile.address, frame).is_none());
        if !requested.is_empty() {
            missing.append(&mut requested);
            missing = in_order(missing);
        }
        missing
    }

    /// Returns the tiles that this view needs, as many as there are slots, the most urgent first, and the number of those
    /// without a slot.
    fn most_urgent(&self, movement: &Movement) -> (Vec<Needed>, u64) {
        let mut urgent = self.needed.clone();
        urgent.extend((movement.requested.iter()).map(|(address, urgency)| Needed {
            address: *address,
            urgency: *urgency as f32,
            factor: 1.0,
        }));
        let of_maps = |address: &TileAddress| Needed { address: *address, urgency: MAP_URGENCY, factor: 1.0 };
        urgent.extend(self.map_neighbours.iter().map(of_maps));
        most_urgent(urgent, self.atlas.slots() as usize)
    }

    fn protected(&self, frame: u64) -> Protected {
        let needed_since = self.found.as_ref().map_or(frame, |found| found.frame);
        Protected { needed_since, soon_since: self.soon_since }
    }

    /// Returns the tiles under the camera that are on the GPU but not in memory: the height of the ground is computed
    /// from them. Those in memory stay there.
    fn ground_to_load(&mut self, camera: DVec2, frame: u64) -> Vec<TileAddress> {
        let under: Vec<TileAddress> = self.under(camera).collect();
        let is_on_gpu_only = |tile: &TileAddress| {
            let is_in_memory = self.cache.get(*tile, frame).is_some();
            !is_in_memory && self.atlas.get(*tile).is_some()
        };
        under.into_iter().filter(is_on_gpu_only).collect()
    }

    fn can_be_read(&self, tile: TileAddress) -> bool {
        self.failures.get(&tile).is_none_or(|failure| failure.tries < MAX_TRIES)
    }

    fn take_finished(&mut self, frame: u64, now_s: f64, streams: bool) {
        for (address, tile) in self.loader.take() {
            match tile {
                Ok(tile) => {
                    self.hits.read += 1;
                    self.ranges.note(address, &tile.statistics);
                    self.failures.remove(&address);
                    self.cache.insert(address, tile, frame);
                }
                Err(PyramidError::Cancelled) => {}
                Err(error) => self.fail(address, error, now_s, streams),
            }
        }
    }

    fn fail(&mut self, address: TileAddress, error: PyramidError, now_s: f64, streams: bool) {
        let failure = self.failures.entry(address).or_insert(Failure { tries: 0, next_s: 0.0 });
        let counted = failure.tries >= MAX_TRIES;
        // The network code has already retried a request that is finally refused.
        failure.tries = (failure.tries + 1).max(if error.is_final() { MAX_TRIES } else { 0 });
        let pause_s = FIRST_PAUSE_S * f64::from(failure.tries.min(16) - 1).exp2();
        failure.next_s = now_s + pause_s.min(LONGEST_PAUSE_S);
        let text = error.message();
        if counted || failure.tries < MAX_TRIES {
            tracing::debug!("{text}");
            return;
        }
        // Rendering to a file returns the first failure as an error; in a window each is logged once.
        let is_known = self.failure.as_ref().is_some_and(|known| known.message() == text);
        if streams && !is_known {
            tracing::warn!("{text}");
        } else {
            tracing::debug!("{text}");
        }
        if self.failure.is_none() || streams {
            self.failure = Some(Arc::new(error));
        }
    }

    /// Returns the tiles to request, the needed ones to upload to the GPU, and those to upload because they are needed
    /// soon.
    fn sort_out(&mut self, ground: &[TileAddress], urgent: &[Needed], frame: u64, now_s: f64) -> [Vec<TileAddress>; 3] {
        let [mut request, mut offer, mut offer_soon] = [const { Vec::new() }; 3];
        let Self { atlas, cache, failures, .. } = self;
        let may_request = |tile: &TileAddress| failures.get(tile).is_none_or(|failure| failure.next_s <= now_s);
        request.extend(ground.iter().copied().filter(may_request));
        for tile in urgent.iter().map(|tile| tile.address) {
            if atlas.want(tile, frame).is_some() {
                continue;
            }
            if cache.get(tile, frame).is_some() {
                offer.push(tile);
            } else if may_request(&tile) {
                request.push(tile);
            }
        }
        // Tiles that are needed by now are in both lists.
        let met: FxHashSet<TileAddress> = urgent.iter().map(|tile| tile.address).collect();
        self.missing_near.retain(|tile| atlas.want(*tile, frame).is_none());
        for tile in self.missing_near.iter().copied().filter(|tile| !met.contains(tile)) {
            if cache.get(tile, frame).is_some() {
                offer.push(tile);
            } else if may_request(&tile) {
                request.push(tile);
            }
        }
        self.missing_soon.retain(|tile| atlas.get(*tile).is_none());
        for tile in self.missing_soon.iter().copied().filter(|tile| !met.contains(tile)) {
            if cache.get(tile, frame).is_some() {
                if offer_soon.len() < MAX_SOON_UPLOADS {
                    offer_soon.push(tile);
                }
            } else if may_request(&tile) {
                request.push(tile);
            }
        }
        [request, offer, offer_soon]
    }

    fn send(&mut self, gpu: &Gpu, [needed, soon]: [&[TileAddress]; 2], protected: Protected, upload: Upload) -> u64 {
        let in_cache = |address: &TileAddress| Some((*address, Arc::clone(self.cache.peek(*address)?)));
        let tiles: Vec<(TileAddress, Arc<LoadedTile>)> = needed.iter().chain(soon).filter_map(in_cache).collect();
        let tiles: Vec<(TileAddress, &LoadedTile)> = tiles.iter().map(|(address, tile)| (*address, &**tile)).collect();
        self.atlas.insert(gpu, &tiles, needed.len(), protected, upload).len() as u64
    }

    /// Returns whether no tile that can be loaded is missing or fading in.
    fn is_complete(&self) -> bool {
        let free = |tile: &Needed| self.floor.at(tile.address) == [0.0; 4];
        self.floor.is_empty() || self.needed.iter().all(free)
    }
}
