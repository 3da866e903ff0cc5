//! Tile stores that are slow, that fail, or that return wrong tiles.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use hachure::pyramid::PatchStatistics;
use hachure::pyramid::store::{Cancel, Decode};
use hachure::pyramid::{LevelSize, PyramidError, TileAddress, TileStore};
use hachure::source::georeference::Georeference;

/// Decides what happens to a fetch of a tile; the second argument is the number of earlier fetches of the same tile.
pub(crate) type Accident = Box<dyn Fn(TileAddress, u64) -> Fate + Send + Sync>;

/// The outcome of a fetch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Fate {
    /// The tile arrives.
    Comes,
    /// The fetch fails.
    Fails,
    /// A wrong tile arrives: its heights are raised by this many metres.
    ComesRaised(f32),
}

/// Implements the methods that return what the inner store returns: all but those of tiles.
macro_rules! as_inner {
    () => {
        fn name(&self) -> String {
            self.inner.name()
        }

        fn levels(&self) -> &[LevelSize] {
            self.inner.levels()
        }

        fn georeference(&self) -> &Georeference {
            self.inner.georeference()
        }

        fn range_m(&self) -> [f32; 2] {
            self.inner.range_m()
        }

        fn is_measured(&self) -> bool {
            self.inner.is_measured()
        }

        fn coarse_patches(&self) -> &[Vec<PatchStatistics>] {
            self.inner.coarse_patches()
        }

        fn is_sparse(&self) -> bool {
            self.inner.is_sparse()
        }
    };
}

/// Another store, with a delay for every tile and planted outcomes.
pub(crate) struct Bumpy {
    inner: Arc<dyn TileStore>,
    delay: Duration,
    accident: Accident,
    asked: Mutex<std::collections::HashMap<TileAddress, u64>>,
    pub fetches: AtomicU64,
}

impl Bumpy {
    pub(crate) fn new(inner: Arc<dyn TileStore>, delay_ms: u64, accident: Accident) -> Arc<Self> {
        let delay = Duration::from_millis(delay_ms);
        Arc::new(Self { inner, delay, accident, asked: Mutex::default(), fetches: AtomicU64::new(0) })
    }
}

impl TileStore for Bumpy {
    as_inner!();

    fn fetch(self: Arc<Self>, address: TileAddress, cancel: &Cancel) -> Result<Decode, PyramidError> {
        self.fetches.fetch_add(1, Ordering::Relaxed);
        std::thread::sleep(self.delay);
        let before = {
            let mut asked = self.asked.lock().unwrap();
            let times = asked.entry(address).or_insert(0);
            *times += 1;
            *times - 1
        };
        let decode = Arc::clone(&self.inner).fetch(address, cancel)?;
        match (self.accident)(address, before) {
            Fate::Comes => Ok(decode),
            Fate::Fails => Err(PyramidError::Mismatch { path: "bumpy".into(), cause: "planted".into() }),
            Fate::ComesRaised(by_m) => Ok(Box::new(move || {
                let mut tile = decode()?;
                tile.tile.samples.iter_mut().for_each(|sample| *sample += by_m);
                Ok(tile)
            })),
        }
    }
}

/// Another store whose tiles arrive in a random order, one of them last.
pub(crate) struct Shuffled {
    inner: Arc<dyn TileStore>,
    seed: u64,
    late: Option<TileAddress>,
    fetched: Mutex<Vec<TileAddress>>,
    /// The number of fetches in progress, apart from that of the late tile.
    others: AtomicU64,
}

/// The late tile arrives when no other tile has been requested for this long.
const QUIET: Duration = Duration::from_millis(15);

impl Shuffled {
    /// Wraps a store; without a `late` tile there are no delays.
    pub(crate) fn new(inner: Arc<dyn TileStore>, seed: u64, late: Option<TileAddress>) -> Arc<Self> {
        Arc::new(Self { inner, seed, late, fetched: Mutex::default(), others: AtomicU64::new(0) })
    }

    /// Returns the tiles in the order in which they were requested.
    pub(crate) fn fetched(&self) -> Vec<TileAddress> {
        self.fetched.lock().unwrap().clone()
    }

    fn wait(&self, address: TileAddress) {
        let asked = |store: &Self| store.fetched.lock().unwrap().len();
        let Some(late) = self.late else { return };
        if address != late {
            let place = i64::from(address.x + 4096 * address.level);
            let delay_ms = 4.0 * super::random(place ^ (self.seed << 32) as i64, i64::from(address.y));
            self.others.fetch_add(1, Ordering::SeqCst);
            std::thread::sleep(Duration::from_secs_f64(delay_ms * 1e-3));
            self.others.fetch_sub(1, Ordering::SeqCst);
            return;
        }
        let mut before = 0;
        for _ in 0..100 {
            if before == asked(self) && self.others.load(Ordering::SeqCst) == 0 {
                return;
            }
            before = asked(self);
            std::thread::sleep(QUIET);
        }
    }
}

impl TileStore for Shuffled {
    as_inner!();

    fn has_tile(&self, address: TileAddress) -> bool {
        self.inner.has_tile(address)
    }

    fn parallel_fetches(&self) -> usize {
        if self.late.is_some() { 6 } else { 2 }
    }

    fn fetch(self: Arc<Self>, address: TileAddress, cancel: &Cancel) -> Result<Decode, PyramidError> {
        self.fetched.lock().unwrap().push(address);
        self.wait(address);
        Arc::clone(&self.inner).fetch(address, cancel)
    }
}

/// Another store that hands out as many tiles as it is granted, so that a simulated flight has the same tiles in the
/// same frames on every machine.
pub(crate) struct Granted {
    inner: Arc<dyn TileStore>,
    grants: Mutex<u64>,
    granted: std::sync::Condvar,
}

impl Granted {
    pub(crate) fn new(inner: Arc<dyn TileStore>) -> Arc<Self> {
        Arc::new(Self { inner, grants: Mutex::new(0), granted: std::sync::Condvar::new() })
    }

    /// Replaces what is left of the last grant.
    pub(crate) fn grant(&self, tiles: u64) {
        *self.grants.lock().unwrap() = tiles;
        self.granted.notify_all();
    }

    /// Returns the number of tiles of the last grant that have not been fetched.
    pub(crate) fn left(&self) -> u64 {
        *self.grants.lock().unwrap()
    }
}

impl TileStore for Granted {
    as_inner!();

    fn parallel_fetches(&self) -> usize {
        1
    }

    fn fetch(self: Arc<Self>, address: TileAddress, cancel: &Cancel) -> Result<Decode, PyramidError> {
        let mut grants = self.grants.lock().unwrap();
        while *grants == 0 {
            if cancel.is_cancelled() {
                return Err(PyramidError::Cancelled);
            }
            grants = self.granted.wait_timeout(grants, Duration::from_millis(1)).unwrap().0;
        }
        *grants -= 1;
        drop(grants);
        Arc::clone(&self.inner).fetch(address, cancel)
    }
}
