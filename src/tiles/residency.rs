//! The scheduler of tiles: which are on the GPU, which are being loaded, and in which order.
//!
//! Tiles are requested in this order: those that the view needs and that are missing; those of the near future; those
//! that only maps depend on; others that are foreseen. Within each list, the tile whose parent, drawn instead, shows the
//! largest error comes first, with a preference for the middle of the view. The loader drops requests that are no longer
//! made. A tile that cannot be read is retried at increasing intervals, while its parent is drawn instead
//! (`residency/load.rs`).
//!
//! Which tiles a view needs changes slowly, so the list is found with a margin and used for as long as the camera stays
//! within it (`residency/find.rs`). If a view needs more tiles than there are slots, its pixels count as wider by a
//! factor (`memory_factor`). What will be needed soon is found by another thread (`prefetch`).
//!
//! Why: `docs/decisions/tile-streaming.md`.

mod find;
mod load;

use std::sync::Arc;

use glam::{DVec2, DVec3};
use rustc_hash::{FxHashMap, FxHashSet};

use self::find::Found;
use super::atlas::{Atlas, Protected, Upload};
use super::cache::TileCache;
use super::camera_motion::Turning;
use super::grid_projection::GridProjection;
use super::loader::Loader;
use super::memory_factor::{FULL, MemoryFactor};
use super::needed::{LevelRule, Needed, TileBounds};
use super::prefetch::{Foreseen, Prefetcher};
use super::queues::by_level;
use super::residency_floor::ResidencyFloor;
use crate::gpu::Gpu;
use crate::pyramid::surface::tile_height::{height_in_tile, tile_at};
use crate::pyramid::{LoadedTile, PyramidError, TileAddress, TileStore};

/// Number of failures after which a tile counts as unreadable. It is retried nevertheless.
const MAX_TRIES: u32 = 3;

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
    /// Whether the land or its maps are late.
    pub late: bool,
    /// Whether some land is coarser than its allowed error requires, also while detail fades in.
    pub late_land: bool,
    /// Whether maps of water or shadows are missing, could be better, or fade in.
    pub late_maps: bool,
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
    /// For a frame that waits for its tiles: the frame since which needed tiles keep their slots. Each pass over the tiles
    /// counts as a frame.
    pub needed_since: u64,
    /// Whether maps are computed, which depend on tiles next to the view.
    pub needs_map_neighbours: bool,
}

/// The ground under a camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ground {
    /// Height in metres.
    pub height_m: f64,
    /// Largest error of the height, in metres, because finer tiles are missing.
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
    tile_bounds: TileBounds,
    failures: FxHashMap<TileAddress, Failure>,
    /// The error of the first tile that counts as unreadable.
    failure: Option<Arc<PyramidError>>,
    /// The tiles on the GPU.
    pub atlas: Atlas,
    /// The residency floor, by which the surface stays above the levels of missing tiles.
    pub floor: ResidencyFloor,
    /// The tiles that the view of this frame needs, coarse levels first.
    pub needed: Vec<Needed>,
    /// The tiles that only the maps of this view depend on.
    pub map_neighbours: Vec<TileAddress>,
    /// The tiles of the near future that are on the GPU, if maps are computed: their maps are computed in advance, so that
    /// they do not fade in when the view needs the tiles.
    pub mapped_ahead: Vec<TileAddress>,
    /// The tiles of `needed`, for lookups.
    needed_set: FxHashSet<TileAddress>,
    /// The view for which `needed` and `map_neighbours` were found.
    found: Option<Found>,
    /// The tiles of `needed` that are not on the GPU, the most urgent first.
    missing: Vec<Needed>,
    /// The tiles around needed ones that do not exist, because nothing finer is known there.
    absent: Vec<(TileAddress, bool)>,
    /// The tiles that will probably be needed soon.
    foreseen: Arc<Foreseen>,
    /// The tiles of the near future that are not on the GPU, the most urgent first, and then those of `map_neighbours`.
    missing_near: Vec<TileAddress>,
    /// The tiles that are missing for a smaller factor of the error, if there is room for them.
    missing_finer: Vec<TileAddress>,
    /// The tiles that a file may turn out to need: they are read in advance, where there is plenty of memory.
    uncertain: Vec<TileAddress>,
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
    memory_factor: MemoryFactor,
    /// Changes whenever `needed`, `map_neighbours`, which of them are on the GPU, or `mapped_ahead` changes.
    version: u64,
    /// Changes whenever a tile comes to the GPU that may change what is needed.
    arrivals: u64,
    hits: Hits,
}

/// Tiles that were or were not on the GPU when they were needed, counted since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Hits {
    /// Number of tiles that were on the GPU when a view began to need them.
    pub on_gpu: u64,
    /// Number of tiles that were not.
    pub not_on_gpu: u64,
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
            tile_bounds: TileBounds::default(),
            failures: FxHashMap::default(),
            failure: None,
            atlas,
            floor: ResidencyFloor::default(),
            needed: Vec::new(),
            map_neighbours: Vec::new(),
            mapped_ahead: Vec::new(),
            needed_set: FxHashSet::default(),
            found: None,
            missing: Vec::new(),
            absent: Vec::new(),
            foreseen: Arc::default(),
            missing_near: Vec::new(),
            missing_finer: Vec::new(),
            uncertain: Vec::new(),
            missing_soon: Vec::new(),
            soon_since: 0,
            prefetcher: None,
            turning: Turning::default(),
            looked_s: f64::NEG_INFINITY,
            memory_factor: MemoryFactor::default(),
            version: 0,
            arrivals: 0,
            hits: Hits::default(),
            store,
        }
    }

    /// Returns a tile that is in memory.
    pub(crate) fn in_memory(&self, address: TileAddress) -> Option<&Arc<LoadedTile>> {
        self.cache.peek(address)
    }

    /// Returns the ground at a grid position, from the finest tile that the view needs and that is in memory. Other
    /// tiles are in memory by chance, and no picture may depend on them. The result is fine enough once all of them are
    /// in memory, because the tiles of the land in front of the camera extend under it.
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

    /// Returns whether the list of needed tiles has no margin, because the camera rests.
    pub(crate) fn list_is_exact(&self) -> bool {
        self.found.as_ref().is_some_and(|found| found.is_exact)
    }

    /// Returns the hits and misses of tiles.
    pub(crate) fn hits(&self) -> Hits {
        self.hits
    }

    /// Returns the factor by which the surface is coarser than requested because its tiles would not fit into memory.
    pub(crate) fn memory_factor(&self) -> f64 {
        self.memory_factor.value()
    }

    /// Sets that factor for a frame that waits for its tiles; a frame that streams chooses it itself.
    pub(crate) fn set_memory_factor(&mut self, factor: f64) {
        self.memory_factor = MemoryFactor::fixed(factor);
    }

    /// Returns whether the tiles that the view needs do not fit into memory. Once the factor had to grow, some room has to
    /// be left, so that what the mesh requests fits too.
    pub(crate) fn is_short_of_slots(&self) -> bool {
        let slots = f64::from(self.atlas.slots());
        self.needed.len() as f64 > if self.memory_factor() > 1.0 { FULL * slots } else { slots }
    }

    /// Returns whether the view needs more than a quarter of the slots: then a file must not depend on tiles that are
    /// on the GPU by chance, because those that its mesh requests may not fit.
    pub(crate) fn is_tight(&self) -> bool {
        !self.fits_all && 4 * self.needed.len() > self.atlas.slots() as usize
    }

    /// Returns the tiles that the view needs and `others`.
    pub(crate) fn needed_and(&self, others: &FxHashSet<TileAddress>) -> FxHashSet<TileAddress> {
        self.needed_set.union(others).copied().collect()
    }

    /// Returns whether there are slots for the tiles that the view needs and for `others`.
    pub(crate) fn has_slots_for(&self, others: &FxHashSet<TileAddress>) -> bool {
        let more = others.iter().filter(|tile| !self.needed_set.contains(*tile)).count();
        self.needed.len() + more <= self.atlas.slots() as usize
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
        self.take_finished(now_s, fade_step_s.is_some());
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
            let needed_since = if streams { frame } else { movement.needed_since };
            (urgent, Protected { needed_since, soon_since: frame })
        };
        let ground = self.ground_to_load(grid_projection.grid_from_world(movement.rule.camera_m.truncate()));
        let [request, offer, offer_soon] = self.sort_out(&ground, &urgent, frame, now_s, protected);
        self.loader.want(&request);
        let upload = Upload { frame, now_s, frame_s: movement.frame_s };
        let sent = self.send(gpu, [&offer, &offer_soon], protected, upload);
        loaded.loaded = sent.len() as u64;
        // Tiles for the future change nothing for this view.
        let is_of_view = |tile: &TileAddress| self.needed_set.contains(tile) || self.map_neighbours.contains(tile);
        let has_come = !streams || sent.iter().any(is_of_view);
        self.version += u64::from(has_come && !sent.is_empty());
        // Errors at a corner are those of all tiles that meet there, so those for maps may change what is needed. While the
        // camera moves, the list is found often enough.
        let changes_list = |tile: &TileAddress| self.list_is_exact() || self.needed_set.contains(tile);
        self.arrivals += u64::from(!streams || has_come && sent.iter().any(changes_list));
        self.hits.uploaded += loaded.loaded;
        for tile in urgent.iter().filter(|tile| self.atlas.get(tile.address).is_none()) {
            let given_up = self.failures.get(&tile.address).is_some_and(|failure| failure.tries >= MAX_TRIES);
            *(if given_up { &mut loaded.failed } else { &mut loaded.pending }) += 1;
        }
        let is_missing_for_maps = |tile: &&TileAddress| self.atlas.get(**tile).is_none() && self.can_be_read(**tile);
        let missing_of_maps = self.map_neighbours.iter().filter(is_missing_for_maps).count() as u64;
        loaded.pending += missing_of_maps;
        if !streams {
            let is_coming = |tile: &&TileAddress| self.cache.peek(**tile).is_none() && self.can_be_read(**tile);
            loaded.pending += ground.iter().filter(is_coming).count() as u64;
        }
        let is_missing = loaded.pending + loaded.without_room + loaded.failed > 0;
        // Where a sparse pyramid ends, the floor is never 0.
        let ends_in_view = !self.absent.is_empty();
        if is_missing || ends_in_view || !self.floor.is_empty() || has_come || !streams {
            let atlas = &self.atlas;
            let is_there = |tile: &Needed| (tile.address, atlas.get(tile.address).is_some());
            self.floor.update(by_level(self.needed.iter().map(is_there), self.absent.clone()), fade_step_s);
        }
        loaded.late = if streams {
            let coarser: Vec<TileAddress> = self.coarser_than_needed(&urgent, ends_in_view);
            // At rest, the maps wait for the tiles around them, and the list is found again after the last tile.
            let is_list_old = self.found.as_ref().is_some_and(|found| found.arrivals != self.arrivals);
            loaded.without_room > 0
                || self.list_is_exact() && (missing_of_maps > 0 || is_list_old)
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

    /// Returns whether no tile that can be loaded is missing or fading in.
    fn is_complete(&self) -> bool {
        let free = |tile: &Needed| self.floor.at(tile.address) == [0.0; 4];
        self.floor.is_empty() || self.needed.iter().all(free)
    }
}
