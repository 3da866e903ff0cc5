//! Statistics of the mesh's patches, which come with the tiles.

use std::cell::RefCell;
use std::sync::Arc;

use rustc_hash::{FxHashMap, FxHashSet};

pub(crate) use super::atlas::Arrival;
use super::atlas::{Atlas, Snapshot, TileFacts};
use super::residency_floor::FADE_S;
use crate::pyramid::surface::occluder_minima::OccluderMinima;
use crate::pyramid::surface::statistics::{PAGE_PATCHES, PatchPage, PatchStatistics, Voids, patch_counts};
use crate::pyramid::{LevelSize, LoadedTile, PyramidError, TileAddress, TileStore};

/// The state of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PatchState {
    /// The patch exists and its statistics are loaded.
    Loaded {
        /// Height range, mesh error and no-data of the patch.
        statistics: PatchStatistics,
        /// Slot and time of its tile's arrival on the GPU.
        arrival: Arrival,
    },
    /// The patch exists, but its tile is not loaded.
    NotLoaded,
    /// The patch does not exist.
    Absent,
}

/// The patches that a selection chooses from.
pub trait Patches {
    /// Returns the size of the finest level.
    fn size(&self) -> LevelSize;

    /// Returns the number of strides: patches of stride 2^j exist for j below it.
    fn strides(&self) -> u32;

    /// Returns the patch (`x`, `y`) of stride 2^`j`.
    fn patch(&self, j: u32, x: u32, y: u32) -> PatchState;

    /// Returns whether the tile of an arrival is still there.
    fn is_current(&self, arrival: &Arrival) -> bool;

    /// Returns the number of levels, 0 to 1, by which a patch is drawn coarser than its own level while it fades in.
    fn coarser_by(&self, arrival: &Arrival) -> f64;

    /// Returns the occluder minima of a tile, or `None` if it is not loaded.
    fn occluder_minima(&self, tile: TileAddress) -> Option<&OccluderMinima>;

    /// Requests the tile of a missing patch; the visible error without it is `urgency` times the allowed one.
    fn request(&self, j: u32, x: u32, y: u32, urgency: f64);
}

/// The patches of the tiles on the GPU.
pub(crate) struct ResidentPatches<'a> {
    /// The source of the tiles.
    pub store: &'a dyn TileStore,
    /// The tiles on the GPU.
    pub atlas: &'a Atlas,
    /// The only tiles that may be used, if not all: others are on the GPU by chance.
    pub only: Option<&'a FxHashSet<TileAddress>>,
    /// The current frame; a tile is marked as used in it when one of its patches is read.
    pub frame: u64,
    /// The time in seconds, for fading in; without it, nothing fades.
    pub now_s: Option<f64>,
    /// The requested tiles, with their urgency.
    pub requested: RefCell<FxHashMap<TileAddress, f64>>,
}

/// Returns the tile that a patch comes with.
fn tile_of(j: u32, x: u32, y: u32) -> TileAddress {
    TileAddress { level: j, x: x / PAGE_PATCHES, y: y / PAGE_PATCHES }
}

/// Extrapolates a patch that is finer than the existing ones, `up` levels below one that exists. Halving the quads of a
/// smooth surface quarters the error.
fn below(statistics: PatchStatistics, up: u32) -> PatchStatistics {
    PatchStatistics { mesh_error_m: statistics.mesh_error_m * 0.25_f32.powi(up as i32), ..statistics }
}

fn coarse(store: &dyn TileStore, j: u32, x: u32, y: u32) -> PatchState {
    let columns = patch_counts(store.levels()[0], j).0;
    let patches = store.coarse_patches().get(j as usize - store.levels().len());
    patches.and_then(|patches| patches.get((y * columns + x) as usize)).map_or(PatchState::Absent, |statistics| {
        PatchState::Loaded { statistics: *statistics, arrival: Arrival::ALWAYS }
    })
}

/// Returns the state of a patch of a store's tiles, of which `find` returns what is known and when it arrived.
fn of_tiles<'a>(
    store: &dyn TileStore,
    j: u32,
    x: u32,
    y: u32,
    find: impl Fn(TileAddress) -> Option<(&'a TileFacts, Arrival)>,
) -> PatchState {
    let levels = store.levels();
    let counts = patch_counts(levels[0], j);
    if x >= counts.0 || y >= counts.1 {
        return PatchState::Absent;
    }
    if j as usize >= levels.len() {
        return coarse(store, j, x, y);
    }
    for up in 0..levels.len() as u32 - j {
        let (x, y) = (x >> up, y >> up);
        let tile = tile_of(j + up, x, y);
        if let Some((facts, arrival)) = find(tile) {
            let statistics = below(*facts.patches.get(x % PAGE_PATCHES, y % PAGE_PATCHES), up);
            let arrival = if up > 0 { Arrival { at_s: f64::NEG_INFINITY, ..arrival } } else { arrival };
            return PatchState::Loaded { statistics, arrival };
        }
        if store.has_tile(tile) {
            return PatchState::NotLoaded;
        }
    }
    PatchState::Absent
}

/// The patches of the tiles that were on the GPU at some time.
pub(super) struct SnapshotPatches<'a> {
    /// The source of the tiles.
    pub store: &'a dyn TileStore,
    /// The tiles that were on the GPU.
    pub snapshot: &'a Snapshot,
}

impl Patches for SnapshotPatches<'_> {
    fn size(&self) -> LevelSize {
        self.store.levels()[0]
    }

    fn strides(&self) -> u32 {
        (self.store.levels().len() + self.store.coarse_patches().len()) as u32
    }

    fn patch(&self, j: u32, x: u32, y: u32) -> PatchState {
        let tiles = &self.snapshot.tiles;
        of_tiles(self.store, j, x, y, |tile| tiles.get(&tile).map(|(facts, arrival)| (&**facts, *arrival)))
    }

    fn is_current(&self, arrival: &Arrival) -> bool {
        let is_in_slot = || self.snapshot.arrivals.get(arrival.slot as usize) == Some(&arrival.number);
        arrival.slot == Arrival::NO_SLOT || is_in_slot()
    }

    fn coarser_by(&self, _: &Arrival) -> f64 {
        0.0
    }

    fn occluder_minima(&self, tile: TileAddress) -> Option<&OccluderMinima> {
        self.snapshot.tiles.get(&tile).map(|(facts, _)| &*facts.occluder_minima)
    }

    fn request(&self, _: u32, _: u32, _: u32, _: f64) {}
}

impl ResidentPatches<'_> {
    fn may_use(&self, tile: TileAddress) -> bool {
        self.only.is_none_or(|only| only.contains(&tile))
    }
}

impl Patches for ResidentPatches<'_> {
    fn size(&self) -> LevelSize {
        self.store.levels()[0]
    }

    fn strides(&self) -> u32 {
        (self.store.levels().len() + self.store.coarse_patches().len()) as u32
    }

    fn patch(&self, j: u32, x: u32, y: u32) -> PatchState {
        of_tiles(self.store, j, x, y, |tile| {
            let resident = if self.may_use(tile) { self.atlas.want(tile, self.frame)? } else { return None };
            Some((&*resident.facts, resident.arrival()))
        })
    }

    fn is_current(&self, arrival: &Arrival) -> bool {
        arrival.slot == Arrival::NO_SLOT || self.atlas.want_slot(arrival.slot, arrival.number, self.frame)
    }

    fn coarser_by(&self, arrival: &Arrival) -> f64 {
        self.now_s.map_or(0.0, |now_s| (1.0 - (now_s - arrival.at_s) / FADE_S).clamp(0.0, 1.0))
    }

    fn occluder_minima(&self, tile: TileAddress) -> Option<&OccluderMinima> {
        self.atlas.get(tile).filter(|_| self.may_use(tile)).map(|resident| &*resident.facts.occluder_minima)
    }

    fn request(&self, j: u32, x: u32, y: u32, urgency: f64) {
        let tile = tile_of(j, x, y);
        if (j as usize) < self.store.levels().len() {
            let mut requested = self.requested.borrow_mut();
            let largest = requested.entry(tile).or_insert(urgency);
            *largest = largest.max(urgency);
        }
    }
}

/// All patches of a pyramid, read at once, for measurements and tests.
pub struct AllPatches {
    size: LevelSize,
    strides: u32,
    pages: FxHashMap<TileAddress, (PatchPage, Arc<OccluderMinima>)>,
    store: Arc<dyn TileStore>,
}

impl AllPatches {
    /// Reads every tile.
    ///
    /// # Errors
    /// Returns the error of a tile that cannot be read.
    pub fn read(store: &Arc<dyn TileStore>) -> Result<Self, PyramidError> {
        let mut pages = FxHashMap::default();
        for (level, size) in store.levels().iter().enumerate() {
            for (x, y) in (0..size.tiles_y()).flat_map(|y| (0..size.tiles_x()).map(move |x| (x, y))) {
                let address = TileAddress { level: level as u32, x, y };
                let LoadedTile { patches, occluder_minima, .. } = Arc::clone(store).load(address)?;
                pages.insert(address, (patches, occluder_minima));
            }
        }
        let strides = (store.levels().len() + store.coarse_patches().len()) as u32;
        Ok(Self { size: store.levels()[0], strides, pages, store: Arc::clone(store) })
    }

    /// Returns the patch (`x`, `y`) of stride 2^`j`, or `None` if it does not exist.
    pub fn get(&self, j: u32, x: u32, y: u32) -> Option<PatchStatistics> {
        match self.patch(j, x, y) {
            PatchState::Loaded { statistics, .. } => Some(statistics),
            _ => None,
        }
    }
}

impl Patches for AllPatches {
    fn size(&self) -> LevelSize {
        self.size
    }

    fn strides(&self) -> u32 {
        self.strides
    }

    fn patch(&self, j: u32, x: u32, y: u32) -> PatchState {
        let counts = patch_counts(self.size, j);
        if x >= counts.0 || y >= counts.1 {
            return PatchState::Absent;
        }
        if j as usize >= self.store.levels().len() {
            return coarse(&*self.store, j, x, y);
        }
        self.pages.get(&tile_of(j, x, y)).map_or(PatchState::Absent, |(page, _)| {
            let statistics = *page.get(x % PAGE_PATCHES, y % PAGE_PATCHES);
            debug_assert!(statistics.voids != Voids::All || statistics.min_m.is_nan());
            PatchState::Loaded { statistics, arrival: Arrival::ALWAYS }
        })
    }

    fn is_current(&self, _: &Arrival) -> bool {
        true
    }

    fn coarser_by(&self, _: &Arrival) -> f64 {
        0.0
    }

    fn occluder_minima(&self, tile: TileAddress) -> Option<&OccluderMinima> {
        self.pages.get(&tile).map(|(_, occluder_minima)| &**occluder_minima)
    }

    fn request(&self, _: u32, _: u32, _: u32, _: f64) {}
}
