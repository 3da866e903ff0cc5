//! The thread that finds the tiles that will be needed soon, so that the frame thread does not.
//!
//! A frame hands over where the camera will be and which tiles are on the GPU, and takes the last list that is ready.
//! The list is some frames old, which does not matter for tiles that are needed in a second. Tiles that nearer land will
//! hide are not in it.
//!
//! Why: `docs/decisions/tile-streaming.md`.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use rustc_hash::FxHashSet;

use super::atlas::Snapshot;
use super::grid_projection::GridProjection;
use super::needed::{HeightRanges, Land, LevelRule, TilePlaces, is_hidden, needed};
use super::patch_tree::PatchTree;
use super::patches::SnapshotPatches;
use super::queues::in_order;
use super::select::select_in;
use super::selection::Viewpoint;
use super::skyline::Skyline;
use crate::pyramid::{TileAddress, TileStore};

/// The allowed error of the mesh for the skyline of a coming view, in pixels: coarser patches hide a little less.
const SKYLINE_ERROR_PX: f64 = 2.0;
/// The largest number of patches for such a skyline.
const MAX_SKYLINE_PATCHES: usize = 8192;

/// A coming view.
#[derive(Clone)]
pub(crate) struct ComingView {
    pub rule: LevelRule,
    /// Lower bound of the distance to the surface, in metres.
    pub nearest_m: f64,
}

/// The inputs from which the thread finds the tiles of the coming views.
pub(crate) struct Outlook {
    /// The coming views, those of the highest priority first.
    pub views: Vec<ComingView>,
    /// The tiles on the GPU.
    pub snapshot: Snapshot,
    /// The largest number of tiles to return.
    pub most: usize,
}

/// The thread; dropping it ends it.
pub(crate) struct Prefetcher {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Default)]
struct Shared {
    state: Mutex<State>,
    wake: Condvar,
}

#[derive(Default)]
struct State {
    outlook: Option<Outlook>,
    is_busy: bool,
    soon: Arc<Vec<TileAddress>>,
    stop: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // The state is consistent between statements, so poisoning is harmless.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn run(&self, store: &dyn TileStore, grid_projection: &GridProjection) {
        let mut memory = Memory::default();
        let mut state = self.lock();
        while !state.stop {
            let Some(outlook) = state.outlook.take() else {
                state = self.wake.wait(state).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            drop(state);
            let soon = tiles_of(store, grid_projection, &mut memory, &outlook);
            state = self.lock();
            state.soon = Arc::new(soon);
            state.is_busy = state.outlook.is_some();
        }
    }
}

/// The caches of the thread, from one outlook to the next.
#[derive(Default)]
struct Memory {
    places: TilePlaces,
    tree: PatchTree,
    ranges: HeightRanges,
}

/// Returns the tiles of all coming views that nearer land will not hide, each once, in the order in which to load them.
fn tiles_of(
    store: &dyn TileStore,
    grid_projection: &GridProjection,
    memory: &mut Memory,
    outlook: &Outlook,
) -> Vec<TileAddress> {
    let Memory { places, tree, ranges } = memory;
    outlook.snapshot.tiles.iter().for_each(|(tile, (facts, _))| ranges.note(*tile, &facts.statistics));
    let land = Land { store, grid_projection };
    let known = |address| outlook.snapshot.tiles.get(&address).map(|(facts, _)| &facts.statistics);
    let mut met = FxHashSet::default();
    let mut soon = Vec::new();
    for view in &outlook.views {
        let mut tiles = needed(&land, places, known, &view.rule);
        if let Some(skyline) = skyline_of(&land, tree, &outlook.snapshot, view) {
            tiles.retain(|tile| {
                let is_hidden = |range_m| is_hidden(&land, places, &view.rule, tile.address, range_m, &skyline);
                !ranges.get(tile.address).is_some_and(is_hidden)
            });
        }
        soon.extend(in_order(tiles).into_iter().map(|tile| tile.address).filter(|address| met.insert(*address)));
    }
    soon.truncate(outlook.most);
    soon
}

/// Returns the skyline of a coming view, as far as its tiles are known; `None` if it has too many patches.
fn skyline_of(land: &Land<'_>, tree: &mut PatchTree, snapshot: &Snapshot, view: &ComingView) -> Option<Skyline> {
    let rule = &view.rule;
    let viewpoint = Viewpoint {
        camera_m: rule.camera_m,
        frusta: rule.frusta.clone(),
        focal_px: rule.focal_px,
        error_px: SKYLINE_ERROR_PX,
        earth_curvature: rule.earth_curvature,
        is_above_ground: true,
        nearest_m: view.nearest_m,
    };
    let patches = SnapshotPatches { store: land.store, snapshot };
    let anchor = land.grid_projection.anchor(rule.camera_m.truncate());
    let selected = select_in(tree, &patches, land.grid_projection, anchor, &viewpoint, MAX_SKYLINE_PATCHES);
    selected.map(|(_, skyline)| skyline)
}

impl Prefetcher {
    /// Starts the thread.
    pub(crate) fn new(store: Arc<dyn TileStore>, grid_projection: GridProjection) -> Self {
        let shared = Arc::<Shared>::default();
        let of_thread = Arc::clone(&shared);
        let run = move || of_thread.run(&*store, &grid_projection);
        let thread = std::thread::Builder::new().name("tile prefetcher".to_owned()).spawn(run);
        let thread = thread.map_err(|error| tracing::error!("cannot start the prefetcher of tiles: {error}")).ok();
        Self { shared, thread }
    }

    /// Returns whether an outlook is waiting or being worked on.
    pub(crate) fn is_busy(&self) -> bool {
        self.thread.is_some() && self.shared.lock().is_busy
    }

    /// Replaces the outlook that is waiting, if any.
    pub(crate) fn look(&self, outlook: Outlook) {
        let mut state = self.shared.lock();
        state.outlook = Some(outlook);
        state.is_busy = true;
        drop(state);
        self.shared.wake.notify_all();
    }

    /// Returns the last list of tiles.
    pub(crate) fn soon(&self) -> Arc<Vec<TileAddress>> {
        Arc::clone(&self.shared.lock().soon)
    }

    /// Empties the list, after a jump of the camera.
    pub(crate) fn forget(&self) {
        self.shared.lock().soon = Arc::default();
    }
}

impl Drop for Prefetcher {
    fn drop(&mut self) {
        self.shared.lock().stop = true;
        self.shared.wake.notify_all();
        if let Some(thread) = self.thread.take() {
            // The panic of a thread was reported when it happened.
            let _ = thread.join();
        }
    }
}
