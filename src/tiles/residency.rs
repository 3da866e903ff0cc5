//! The scheduler of tiles: which are on the GPU, which are being loaded, and in which order.
//!
//! There are three groups, after Cesium: *urgent* tiles are needed by the view and missing; *normal* ones will be
//! needed if the camera keeps moving as it does; *preload* ones are just outside the view. Within a group the tile
//! whose parent, drawn instead, shows the largest error comes first, with a preference for the middle of the view. The
//! queue is rebuilt for every frame, so tiles that are no longer wanted are never read. A tile that cannot be read is
//! retried at increasing intervals, while its parent is drawn instead.
//!
//! Why: `docs/decisions/tile-streaming.md`.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use rustc_hash::{FxHashMap, FxHashSet};

use super::atlas::Atlas;
use super::cache::TileCache;
use super::earth_curvature::EarthCurvature;
use super::grid_projection::GridProjection;
use super::loader::Loader;
use super::map_neighbours::map_neighbours;
use super::needed::{Land, LevelRule, Needed, TilePlaces, needed};
use super::queues::{Queues, by_level, in_order, queues};
use super::residency_floor::ResidencyFloor;
use crate::gpu::Gpu;
use crate::pyramid::surface::tile_height::{height_in_tile, tile_at};
use crate::pyramid::{LoadedTile, PyramidError, TileAddress, TileStore};

/// How far ahead tiles are requested, in seconds; the second value has lower priority.
const AHEAD_S: [f64; 2] = [1.0, 3.0];
/// How far outside of the view tiles are requested, in radians.
const ASIDE_RAD: f64 = 0.35;
/// The pause after a failure, in seconds; it doubles with each failure, up to the longest pause.
const FIRST_PAUSE_S: f64 = 0.2;
const LONGEST_PAUSE_S: f64 = 30.0;
/// Number of failures after which a tile counts as unreadable. It is retried nevertheless.
const MAX_TRIES: u32 = 3;
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
    /// Time since the last frame, in seconds.
    pub frame_s: f64,
    /// Tiles that the mesh requests, with their urgency.
    pub requested: FxHashMap<TileAddress, f64>,
    /// Whether maps are computed, which depend on tiles next to the view.
    pub needs_map_neighbours: bool,
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
    /// The needed tiles for which `map_neighbours` was computed.
    map_neighbours_of: Vec<TileAddress>,
}

impl Residency {
    /// Creates a scheduler that has loaded nothing. It may use `memory_bytes` on the GPU and as much on the CPU.
    pub(crate) fn new(gpu: &Gpu, store: Arc<dyn TileStore>, memory_bytes: u64) -> Self {
        let tiles = store.levels().iter().map(|size| u64::from(size.tiles_x()) * u64::from(size.tiles_y())).sum();
        Self {
            loader: Loader::new(Arc::clone(&store)),
            cache: TileCache::new(memory_bytes),
            places: TilePlaces::default(),
            failures: FxHashMap::default(),
            failure: None,
            atlas: Atlas::new(gpu, tiles, memory_bytes),
            floor: ResidencyFloor::default(),
            needed: Vec::new(),
            map_neighbours: Vec::new(),
            map_neighbours_of: Vec::new(),
            store,
        }
    }

    /// Returns a tile that is in memory.
    pub(crate) fn in_memory(&self, address: TileAddress) -> Option<&Arc<LoadedTile>> {
        self.cache.peek(address)
    }

    /// Returns the ground's height in metres at a grid position, from the finest tile that the view needs and that is
    /// in memory. Other tiles are in memory by chance, and no picture may depend on them. The result is fine enough,
    /// because the tiles of the land in front of the camera extend under it.
    pub(crate) fn height_m(&self, grid: DVec2) -> Option<f64> {
        let levels = self.store.levels();
        // Coarse levels come first.
        let tiles = self.needed.iter().rev().map(|tile| tile.address);
        let under = tiles.filter(|tile| tile_at(levels, tile.level, grid.x, grid.y) == Some(*tile));
        under
            .filter_map(|tile| Some((tile, self.in_memory(tile)?)))
            .find_map(|(tile, loaded)| height_in_tile(levels, tile, &loaded.tile, grid.x, grid.y))
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

    /// Returns the memory of decoded tiles in bytes.
    pub(crate) fn cache_bytes(&self) -> u64 {
        self.cache.bytes()
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
        let store = Arc::clone(&self.store);
        let land = Land { store: &*store, grid_projection };
        let known = |address| self.atlas.get(address).map(|resident| &resident.statistics);
        let places = &mut self.places;
        self.needed = needed(&land, places, known, &movement.rule);
        let mut urgent = self.needed.clone();
        urgent.extend(
            movement.requested.iter().map(|(address, urgency)| Needed { address: *address, urgency: *urgency as f32 }),
        );
        self.find_map_neighbours(movement.needs_map_neighbours);
        urgent.extend(self.map_neighbours.iter().map(|address| Needed { address: *address, urgency: MAP_URGENCY }));
        let mut soon = Vec::new();
        if fade_step_s.is_some() {
            let (rule, places) = (&movement.rule, &mut self.places);
            let known = |address| self.atlas.get(address).map(|resident| &resident.statistics);
            let wider = || rule.frusta.iter().map(|view| view.widened(ASIDE_RAD)).collect();
            for ahead_s in AHEAD_S.into_iter().filter(|_| movement.velocity_m_s != DVec3::ZERO) {
                let camera_m = rule.camera_m + movement.velocity_m_s * ahead_s;
                let earth_curvature = EarthCurvature { camera_z_m: camera_m.z, ..rule.earth_curvature };
                let ahead = LevelRule { camera_m, earth_curvature, ..rule.clone() };
                soon.extend(in_order(needed(&land, places, known, &ahead)));
            }
            soon.extend(in_order(needed(&land, places, known, &LevelRule { frusta: wider(), ..rule.clone() })));
        }

        let wanted = urgent.len() as u64;
        let Queues { urgent, soon, without_room } = queues(urgent, soon, self.atlas.slots() as usize);
        let mut loaded = Loaded { wanted, without_room, ..Loaded::default() };
        let (request, offer) = self.sort_out(&urgent, &soon, frame, now_s);
        self.loader.want(&request);
        loaded.loaded = self.send(gpu, &offer, frame, now_s, movement.frame_s);
        for tile in urgent.iter().filter(|tile| self.atlas.get(tile.address).is_none()) {
            let given_up = self.failures.get(&tile.address).is_some_and(|failure| failure.tries >= MAX_TRIES);
            *(if given_up { &mut loaded.failed } else { &mut loaded.pending }) += 1;
        }

        let atlas = &self.atlas;
        let is_there = |tile: &Needed| (tile.address, atlas.get(tile.address).is_some());
        let absent = self.absent_neighbours();
        // Where a sparse pyramid ends, the floor is never 0.
        let ends_in_view = !absent.is_empty();
        self.floor.update(by_level(self.needed.iter().map(is_there), absent), fade_step_s);
        let is_missing = loaded.pending + loaded.without_room + loaded.failed > 0;
        loaded.late = is_missing || !ends_in_view && !self.is_complete();
        loaded
    }

    /// Finds the tiles that the maps of needed tiles depend on, as far as there are slots.
    fn find_map_neighbours(&mut self, needs_map_neighbours: bool) {
        if !needs_map_neighbours {
            self.map_neighbours.clear();
            self.map_neighbours_of.clear();
            return;
        }
        if !self.needed.iter().map(|tile| tile.address).eq(self.map_neighbours_of.iter().copied()) {
            self.map_neighbours_of = self.needed.iter().map(|tile| tile.address).collect();
            self.map_neighbours = map_neighbours(&*self.store, &self.needed);
            self.map_neighbours.truncate((self.atlas.slots() as usize).saturating_sub(self.needed.len()));
        }
    }

    fn take_finished(&mut self, frame: u64, now_s: f64, streams: bool) {
        for (address, tile) in self.loader.take() {
            match tile {
                Ok(tile) => {
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

    /// Returns the tiles to request, and the tiles to upload to the GPU.
    fn sort_out(
        &mut self,
        urgent: &[Needed],
        soon: &[Needed],
        frame: u64,
        now_s: f64,
    ) -> (Vec<TileAddress>, Vec<TileAddress>) {
        let (mut request, mut offer) = (Vec::new(), Vec::new());
        let mut met = FxHashSet::default();
        for tile in urgent.iter().chain(soon).map(|tile| tile.address) {
            if !met.insert(tile) || self.atlas.want(tile, frame).is_some() {
                continue;
            }
            if self.cache.get(tile, frame).is_some() {
                offer.push(tile);
            } else if self.failures.get(&tile).is_none_or(|failure| failure.next_s <= now_s) {
                request.push(tile);
            }
        }
        (request, offer)
    }

    fn send(&mut self, gpu: &Gpu, offer: &[TileAddress], frame: u64, now_s: f64, frame_s: f64) -> u64 {
        let tiles: Vec<(TileAddress, Arc<LoadedTile>)> =
            offer.iter().filter_map(|address| Some((*address, Arc::clone(self.cache.peek(*address)?)))).collect();
        let tiles: Vec<(TileAddress, &LoadedTile)> = tiles.iter().map(|(address, tile)| (*address, &**tile)).collect();
        self.atlas.insert(gpu, &tiles, frame, now_s, frame_s).len() as u64
    }

    /// Returns the tiles around needed ones that do not exist, because nothing finer is known there.
    fn absent_neighbours(&self) -> Vec<(TileAddress, bool)> {
        let mut met: FxHashSet<TileAddress> = self.needed.iter().map(|tile| tile.address).collect();
        let mut absent = Vec::new();
        for Needed { address: tile, .. } in &self.needed {
            let size = self.store.levels()[tile.level as usize];
            for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
                let (Some(x), Some(y)) = (tile.x.checked_add_signed(dx), tile.y.checked_add_signed(dy)) else {
                    continue;
                };
                let map_neighbours = TileAddress { x, y, ..*tile };
                let is_inside = x < size.tiles_x() && y < size.tiles_y();
                if is_inside && met.insert(map_neighbours) && !self.store.has_tile(map_neighbours) {
                    absent.push((map_neighbours, false));
                }
            }
        }
        absent
    }

    /// Returns whether no tile that can be loaded is missing or fading in.
    fn is_complete(&self) -> bool {
        let free = |tile: &Needed| self.floor.at(tile.address) == [0.0; 4];
        self.floor.is_empty() || self.needed.iter().all(free)
    }
}
