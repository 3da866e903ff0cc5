//! A cached pyramid that repairs itself while it is read: if the checksum of a tile or record is wrong, a thread of its
//! own bakes the whole pyramid again, from its input. Rendering to a file waits for that; a window goes on with coarser
//! tiles meanwhile. Pyramids that a user baked are never touched.

use std::path::Path;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::entry::Entry;
use super::pyramid::Pyramid;
use super::tile_store::{Cancel, Decode, TileStore};
use crate::pyramid::error::PyramidError;
use crate::pyramid::surface::levels::LevelSize;
use crate::pyramid::surface::loaded_tile::LoadedTile;
use crate::pyramid::surface::statistics::PatchStatistics;
use crate::pyramid::tile::TileAddress;
use crate::source::georeference::Georeference;

/// The number of repairs after which damage is assumed to have another cause.
const MAX_REPAIRS: u32 = 3;
/// The interval at which a waiting fetch checks whether it was cancelled.
const LOOK: Duration = Duration::from_millis(20);

/// A function that bakes the pyramid at a path.
pub(super) type Make = dyn Fn(&Path) -> Result<(), PyramidError> + Send + Sync;

/// A store over a cached pyramid that bakes it again when it turns out to be damaged.
pub(super) struct Healing {
    /// The pyramid as first opened. Its header was checked then, and is the same after every bake.
    first: Arc<Pyramid>,
    shared: Arc<Shared>,
}

struct Shared {
    entry: Entry,
    make: Box<Make>,
    state: Mutex<State>,
    done: Condvar,
}

struct State {
    current: Arc<Pyramid>,
    /// Whether a thread is baking the pyramid again.
    is_healing: bool,
    times: u32,
    failed: Option<String>,
}

impl Healing {
    /// Wraps an open pyramid of the cache.
    pub(super) fn new(pyramid: Pyramid, entry: Entry, make: Box<Make>) -> Self {
        let first = Arc::new(pyramid);
        let state = State { current: Arc::clone(&first), is_healing: false, times: 0, failed: None };
        let shared = Shared { entry, make, state: Mutex::new(state), done: Condvar::new() };
        Self { first, shared: Arc::new(shared) }
    }
}

/// Returns whether the error comes from the file on disk.
fn is_damage(error: &PyramidError) -> bool {
    error.wants_bake() || matches!(error, PyramidError::Io { .. })
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // The state is consistent between statements, so poisoning is harmless.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Loads the tile from the current pyramid, which is rebuilt if it is damaged.
    fn load(self: &Arc<Self>, address: TileAddress, cancel: &Cancel) -> Result<LoadedTile, PyramidError> {
        loop {
            let pyramid = Arc::clone(&self.lock().current);
            match Arc::clone(&pyramid).fetch(address, cancel).and_then(|decode| decode()) {
                Err(error) if is_damage(&error) => self.heal(&pyramid, address, error, cancel)?,
                loaded => return loaded,
            }
        }
    }

    /// Waits until the damaged pyramid has been replaced by another one.
    fn heal(
        self: &Arc<Self>,
        damaged: &Arc<Pyramid>,
        address: TileAddress,
        error: PyramidError,
        cancel: &Cancel,
    ) -> Result<(), PyramidError> {
        let mut state = self.lock();
        if Arc::ptr_eq(&state.current, damaged) && !state.is_healing && state.times < MAX_REPAIRS {
            state.times += 1;
            state.is_healing = true;
            self.entry.warn(&error);
            let shared = Arc::clone(self);
            let started = std::thread::Builder::new().name("healing".into()).spawn(move || shared.make(address));
            if let Err(error) = started {
                state.is_healing = false;
                state.failed = Some(error.to_string());
            }
        }
        while state.is_healing {
            if cancel.is_cancelled() {
                return Err(PyramidError::Cancelled);
            }
            state = self.done.wait_timeout(state, LOOK).unwrap_or_else(PoisonError::into_inner).0;
        }
        if !Arc::ptr_eq(&state.current, damaged) {
            return Ok(());
        }
        let Some(failed) = &state.failed else { return Err(error) };
        let cause = format!("the file is damaged, and rebuilding it failed: {failed}");
        Err(PyramidError::Mismatch { path: self.entry.name().into(), cause })
    }

    fn make(&self, address: TileAddress) {
        let is_whole = |pyramid: &Pyramid| pyramid.read_verified(address).is_ok();
        let made = self.entry.rebuild(is_whole, |out| (self.make)(out));
        let mut state = self.lock();
        match made {
            Ok(pyramid) => (state.current, state.failed) = (Arc::new(pyramid), None),
            Err(error) => state.failed = Some(error.message()),
        }
        state.is_healing = false;
        drop(state);
        self.done.notify_all();
    }
}

impl TileStore for Healing {
    fn name(&self) -> String {
        self.shared.entry.name().to_owned()
    }

    fn levels(&self) -> &[LevelSize] {
        Pyramid::levels(&self.first)
    }

    fn georeference(&self) -> &Georeference {
        Pyramid::georeference(&self.first)
    }

    fn range_m(&self) -> [f32; 2] {
        self.first.range_m()
    }

    fn is_measured(&self) -> bool {
        true
    }

    fn is_sparse(&self) -> bool {
        false
    }

    fn coarse_patches(&self) -> &[Vec<PatchStatistics>] {
        self.first.coarse_patches()
    }

    fn fetch(self: Arc<Self>, address: TileAddress, cancel: &Cancel) -> Result<Decode, PyramidError> {
        let (shared, cancel) = (Arc::clone(&self.shared), cancel.clone());
        let pyramid = Arc::clone(&shared.lock().current);
        match pyramid.fetch(address, &cancel) {
            Ok(decode) => Ok(Box::new(move || match decode() {
                Err(error) if is_damage(&error) => shared.load(address, &cancel),
                loaded => loaded,
            })),
            Err(error) if is_damage(&error) => {
                let loaded = shared.load(address, &cancel)?;
                Ok(Box::new(move || Ok(loaded)))
            }
            Err(error) => Err(error),
        }
    }
}
