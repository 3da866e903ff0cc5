//! The threads that bring tiles: some read, some decode, and none of them draws.
//!
//! The frame thread hands over the tiles that it wants, best first, and takes what is finished; it never waits. Every
//! new list replaces the one before: what was not begun is forgotten, and what is being read but no longer wanted is
//! cancelled. Readers and decoders are apart because they wait for different things, and both stop when what is
//! finished has not been taken for a while, so that memory stays bounded.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use rustc_hash::{FxHashMap, FxHashSet};

use thread_priority::{ThreadPriority, ThreadPriorityValue, set_current_thread_priority};

use crate::pyramid::store::{Cancel, Decode};
use crate::pyramid::{LoadedTile, PyramidError, TileAddress, TileStore};

/// Of the loading threads, of 100: a little below that of drawing (a nice value of 4 on Linux). The lowest would
/// starve them on machines that draw with the same processors.
const PRIORITY: u8 = 38;

/// Fetched tiles that wait for a decoder, at most.
const MOST_FETCHED: usize = 16;
/// Finished tiles that wait for the frame thread, at most: 17 MB.
const MOST_FINISHED: usize = 64;

/// A tile that is there, or why not.
pub type Finished = (TileAddress, Result<Arc<LoadedTile>, PyramidError>);

/// The threads that fetch and decode; dropping it ends them.
pub struct Loader {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
}

struct Shared {
    store: Arc<dyn TileStore>,
    state: Mutex<State>,
    /// There is something to fetch, or room for it.
    fetch: Condvar,
    /// There is something to decode, or room for it.
    decode: Condvar,
    /// Something is finished.
    finished: Condvar,
}

#[derive(Default)]
struct State {
    /// What is not begun yet, the best last.
    wanted: Vec<TileAddress>,
    fetched: VecDeque<(TileAddress, Decode)>,
    /// Being fetched, waiting for a decoder, or being decoded.
    under_way: FxHashMap<TileAddress, Cancel>,
    finished: Vec<Finished>,
    /// What nobody wanted any more before it was there.
    cancelled: u64,
    stop: bool,
}

impl Loader {
    /// Starts the threads; nothing is wanted yet.
    pub fn new(store: Arc<dyn TileStore>) -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let fetchers = store.parallel_fetches();
        let shared = Arc::new(Shared {
            store,
            state: Mutex::default(),
            fetch: Condvar::new(),
            decode: Condvar::new(),
            finished: Condvar::new(),
        });
        let priority =
            ThreadPriorityValue::try_from(PRIORITY).map_or(ThreadPriority::Min, ThreadPriority::Crossplatform);
        let start = |name: &str, work: fn(&Shared)| {
            let shared = Arc::clone(&shared);
            std::thread::Builder::new().name(name.to_owned()).spawn(move || {
                // Drawing goes first; where the system says no, tiles come all the same.
                if let Err(error) = set_current_thread_priority(priority) {
                    tracing::debug!("priority of a loading thread: {error:?}");
                }
                work(&shared);
            })
        };
        let fetchers = (0..fetchers).map(|_| start("tile reader", Shared::fetch_tiles));
        let decoders = (0..cores.clamp(1, 8)).map(|_| start("tile decoder", Shared::decode_tiles));
        let threads = fetchers.chain(decoders).filter_map(|thread| match thread {
            Ok(thread) => Some(thread),
            Err(error) => {
                tracing::error!("no thread for loading tiles: {error}");
                None
            }
        });
        let threads = threads.collect();
        Self { shared, threads }
    }

    /// Replaces what is wanted; best first, without what was taken already. What is under way and not in the list
    /// is cancelled.
    pub fn want(&self, wanted: &[TileAddress]) {
        let mut state = self.shared.lock();
        let all: FxHashSet<TileAddress> = wanted.iter().copied().collect();
        let State { fetched, under_way, cancelled, .. } = &mut *state;
        fetched.retain(|(address, _)| {
            let keep = all.contains(address);
            if !keep {
                under_way.remove(address);
                *cancelled += 1;
            }
            keep
        });
        under_way.iter().filter(|(address, _)| !all.contains(address)).for_each(|(_, cancel)| cancel.cancel());
        let waiting = |address: &&TileAddress| !state.under_way.contains_key(address);
        let next: Vec<_> = wanted.iter().filter(waiting).rev().copied().collect();
        state.cancelled += state.wanted.iter().filter(|address| !all.contains(address)).count() as u64;
        state.wanted = next;
        drop(state);
        self.shared.fetch.notify_all();
        self.shared.decode.notify_all();
    }

    /// What has been finished since the last call.
    pub fn take(&self) -> Vec<Finished> {
        let finished = std::mem::take(&mut self.shared.lock().finished);
        if !finished.is_empty() {
            self.shared.fetch.notify_all();
            self.shared.decode.notify_all();
        }
        finished
    }

    /// Waits until something is finished, for `most` at most. Not for frames that must not stop.
    pub fn wait(&self, most: Duration) {
        let state = self.shared.lock();
        // A poisoned lock guards lists that are whole between statements.
        let _unused = self
            .shared
            .finished
            .wait_timeout_while(state, most, |state| {
                state.finished.is_empty() && !(state.under_way.is_empty() && state.wanted.is_empty())
            })
            .unwrap_or_else(PoisonError::into_inner);
    }

    /// Tiles that nobody wanted any more before they were there, since the start.
    pub fn cancelled(&self) -> u64 {
        self.shared.lock().cancelled
    }

    /// Tiles that are wanted, being fetched or being decoded.
    pub fn pending(&self) -> usize {
        let state = self.shared.lock();
        state.wanted.len() + state.under_way.len()
    }
}

impl Drop for Loader {
    fn drop(&mut self) {
        let mut state = self.shared.lock();
        state.stop = true;
        state.under_way.values().for_each(Cancel::cancel);
        drop(state);
        self.shared.fetch.notify_all();
        self.shared.decode.notify_all();
        for thread in self.threads.drain(..) {
            // A thread that panicked has nothing left to say.
            let _ = thread.join();
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // Every statement leaves the lists whole.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn fetch_tiles(&self) {
        let mut state = self.lock();
        while !state.stop {
            let has_room = state.fetched.len() < MOST_FETCHED && state.finished.len() < MOST_FINISHED;
            let next = if has_room { state.wanted.pop() } else { None };
            let Some(address) = next else {
                state = self.fetch.wait(state).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            let cancel = Cancel::default();
            state.under_way.insert(address, cancel.clone());
            drop(state);
            let store = Arc::clone(&self.store);
            let fetched = guarded(&*self.store, || store.fetch(address, &cancel));
            state = self.lock();
            match fetched {
                Ok(decode) if !cancel.is_cancelled() => {
                    state.fetched.push_back((address, decode));
                    self.decode.notify_one();
                }
                Err(error) if !cancel.is_cancelled() => self.finish(&mut state, address, Err(error)),
                _ => {
                    state.under_way.remove(&address);
                    state.cancelled += 1;
                    self.finished.notify_all();
                }
            }
        }
    }

    fn decode_tiles(&self) {
        let mut state = self.lock();
        while !state.stop {
            let has_room = state.finished.len() < MOST_FINISHED;
            let next = if has_room { state.fetched.pop_front() } else { None };
            let Some((address, decode)) = next else {
                state = self.decode.wait(state).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            drop(state);
            self.fetch.notify_one();
            let tile = guarded(&*self.store, decode).map(Arc::new);
            state = self.lock();
            // What is decoded is worth keeping, wanted or not.
            self.finish(&mut state, address, tile);
        }
    }

    fn finish(&self, state: &mut State, address: TileAddress, tile: Result<Arc<LoadedTile>, PyramidError>) {
        state.under_way.remove(&address);
        state.finished.push((address, tile));
        self.finished.notify_all();
    }
}

/// Decoders index into what files claim: should one of them panic, that is one more kind of damage.
fn guarded<T>(store: &dyn TileStore, work: impl FnOnce() -> Result<T, PyramidError>) -> Result<T, PyramidError> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        let cause = "a tile's decoder gave up".to_owned();
        Err(PyramidError::Mismatch { path: store.name().into(), cause })
    })
}
