//! The thread that finds the tiles that will be needed soon, so that the frame thread does not.
//!
//! A frame hands over where the camera will be and which tiles are on the GPU, and takes the last list that is ready.
//! The list is some frames old, which does not matter for tiles that are needed in a second. Tiles of later views that
//! nearer land will hide are left out.
//!
//! Why: `docs/decisions/tile-streaming.md`.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use rustc_hash::{FxHashMap, FxHashSet};

use super::atlas::Snapshot;
use super::grid_projection::GridProjection;
use super::needed::{Land, LevelRule, Needed, TileBounds, is_hidden, needed};
use super::patch_tree::PatchTree;
use super::patches::SnapshotPatches;
use super::queues::in_order;
use super::select::select_in;
use super::selection::Viewpoint;
use super::skyline::Skyline;
use crate::pyramid::surface::statistics::TileStatistics;
use crate::pyramid::{TileAddress, TileStore};

/// The allowed error of the mesh for the skyline of a coming view, in pixels: coarser patches hide a little less.
const SKYLINE_ERROR_PX: f64 = 2.0;
/// The largest number of patches for such a skyline.
const MAX_SKYLINE_PATCHES: usize = 8192;
/// The error of a tile that was never loaded, as a fraction of its parent's: on most land, half the spacing has a bit more
/// than half the error.
const GUESS: f32 = 0.75;
/// The number of tiles whose statistics the thread remembers.
const MAX_SEEN: usize = 1 << 16;

/// A coming view.
#[derive(Clone)]
pub(crate) struct ComingView {
    pub rule: LevelRule,
    /// Lower bound of the distance to the surface, in metres.
    pub nearest_m: f64,
    /// How much steeper slopes may look than from the foreseen place, in height per distance.
    pub slack: f64,
    /// The factor by which its pixels are wider than requested.
    pub factor: f64,
    /// Whether this is the view of the near future, whose tiles get slots like those that are needed, hidden or not.
    pub is_near: bool,
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

/// The tiles that will be needed soon.
#[derive(Default)]
pub(crate) struct Foreseen {
    /// The tiles of the near future whose parents' errors are known, the most urgent first.
    pub near: Vec<Needed>,
    /// Others, in the order in which to load them: those of the near future whose need is guessed, and those of later
    /// views that nearer land does not hide there.
    pub later: Vec<TileAddress>,
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
    foreseen: Arc<Foreseen>,
    stop: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // The state is consistent between statements, so poisoning is harmless.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn run(&self, store: &dyn TileStore, grid_projection: &GridProjection) {
        let mut caches = Caches::default();
        let mut state = self.lock();
        while !state.stop {
            let Some(outlook) = state.outlook.take() else {
                state = self.wake.wait(state).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            drop(state);
            let foreseen = foresee(store, grid_projection, &mut caches, &outlook);
            state = self.lock();
            state.foreseen = Arc::new(foreseen);
            state.is_busy = state.outlook.is_some();
        }
    }
}

/// The caches of the thread, from one outlook to the next.
#[derive(Default)]
struct Caches {
    bounds: TileBounds,
    tree: PatchTree,
    /// The statistics of all tiles that were on the GPU.
    seen: FxHashMap<TileAddress, TileStatistics>,
}

/// Returns the tiles of all coming views, each once.
fn foresee(
    store: &dyn TileStore,
    grid_projection: &GridProjection,
    caches: &mut Caches,
    outlook: &Outlook,
) -> Foreseen {
    let Caches { bounds, tree, seen } = caches;
    if seen.len() > MAX_SEEN {
        seen.clear();
    }
    seen.extend(outlook.snapshot.tiles.iter().map(|(tile, (facts, _))| (*tile, facts.statistics)));
    let land = Land { store, grid_projection };
    let mut met = FxHashSet::default();
    let (mut near, mut later) = (Vec::new(), Vec::new());
    for view in &outlook.views {
        let mut tiles = needed(&land, bounds, |address| seen.get(&address), &view.rule, GUESS);
        tiles.iter_mut().for_each(|tile| tile.factor = (f64::from(tile.factor) * view.factor).min(1e30) as f32);
        let skyline = if view.is_near { None } else { skyline_of(&land, tree, &outlook.snapshot, view) };
        let mut is_hidden = |tile: &Needed, slack: f64| {
            let (Some(skyline), Some(known)) = (&skyline, seen.get(&tile.address)) else { return false };
            is_hidden(&land, bounds, &view.rule, tile.address, [known.min_m, known.max_m], skyline, slack)
        };
        for tile in in_order(tiles) {
            // While a coarse tile is missing, the finer ones around it cannot be drawn, so its need is foreseen with more slack.
            if !is_hidden(&tile, view.slack * f64::from(1 + tile.address.level)) && met.insert(tile.address) {
                let TileAddress { level, x, y } = tile.address;
                let is_certain = || seen.contains_key(&TileAddress { level: level + 1, x: x / 2, y: y / 2 });
                if view.is_near && is_certain() { near.push(tile) } else { later.push(tile.address) }
            }
        }
        skyline.into_iter().for_each(|skyline| tree.reuse(skyline));
    }
    near.truncate(outlook.most);
    later.truncate(outlook.most);
    Foreseen { near, later }
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
    let selected = select_in(tree, &patches, land.grid_projection, anchor, &viewpoint, MAX_SKYLINE_PATCHES, true);
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

    /// Returns the tiles of the last outlook.
    pub(crate) fn foreseen(&self) -> Arc<Foreseen> {
        Arc::clone(&self.shared.lock().foreseen)
    }

    /// Empties the list, after a jump of the camera.
    pub(crate) fn forget(&self) {
        self.shared.lock().foreseen = Arc::default();
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
