//! Stores of tiles that are slow, that fail, or that are wrong.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use hachure::pyramid::store::Decode;
use hachure::pyramid::{Cancel, LevelSize, PatchStatistics, PyramidError, TileAddress, TileStore};
use hachure::source::georeference::Georeference;

/// What happens to a tile on its way: the number of times that it has been asked for before comes with it.
pub type Accident = Box<dyn Fn(TileAddress, u64) -> Fate + Send + Sync>;

/// What becomes of a fetch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// It comes.
    Comes,
    /// It fails.
    Fails,
    /// It comes, but as another tile than it is: heights raised by so many metres.
    ComesRaised(f32),
}

/// Another store, with a delay for every tile and accidents.
pub struct Bumpy {
    inner: Arc<dyn TileStore>,
    delay: Duration,
    accident: Accident,
    asked: Mutex<std::collections::HashMap<TileAddress, u64>>,
    pub fetches: AtomicU64,
}

impl Bumpy {
    pub fn new(inner: Arc<dyn TileStore>, delay_ms: u64, accident: Accident) -> Arc<Self> {
        let delay = Duration::from_millis(delay_ms);
        Arc::new(Self { inner, delay, accident, asked: Mutex::default(), fetches: AtomicU64::new(0) })
    }
}

impl TileStore for Bumpy {
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
