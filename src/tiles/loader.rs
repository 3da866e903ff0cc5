//! The threads that load tiles: some read, some decode; the frame thread does neither.
//!
//! The frame thread passes a list of the tiles that it wants, best first, and takes the finished ones; it never waits.
//! Every new list replaces the one before: tiles that have not been started are forgotten, and tiles that are being
//! read but no longer wanted are cancelled. Readers and decoders are separate because they wait for different things,
//! and both pause while too many finished tiles have not been taken, so that memory stays bounded.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use rustc_hash::{FxHashMap, FxHashSet};

use thread_priority::{ThreadPriority, ThreadPriorityValue, set_current_thread_priority};

use crate::pyramid::store::{Cancel, Decode};
use crate::pyramid::{LoadedTile, PyramidError, TileAddress, TileStore};

/// Priority of the loading threads, of 100: a little below that of drawing (a nice value of 4 on Linux). The lowest
/// would starve them on machines that draw with the same processors.
const PRIORITY: u8 = 38;

/// Largest number of fetched tiles that wait for a decoder.
const MAX_FETCHED: usize = 16;
/// Largest number of finished tiles that wait for the frame thread: 17 MB.
const MAX_FINISHED: usize = 64;

/// A loaded tile, or the reason why it could not be loaded.
pub(crate) type Finished = (TileAddress, Result<Arc<LoadedTile>, PyramidError>);

/// The threads that fetch and decode; dropping it ends them.
pub(crate) struct Loader {
    shared: Arc<Shared>,
    threads: Vec<JoinHandle<()>>,
}

struct Shared {
    store: Arc<dyn TileStore>,
    state: Mutex<State>,
    /// Signalled when there is something to fetch, or room for it.
    fetch: Condvar,
    /// Signalled when there is something to decode, or room for it.
    decode: Condvar,
    /// Signalled when a tile is finished.
    finished: Condvar,
}

#[derive(Default)]
struct State {
    /// Tiles that have not been started, the best last.
    wanted: Vec<TileAddress>,
    fetched: VecDeque<(TileAddress, Decode)>,
    /// Tiles being fetched, waiting for a decoder, or being decoded.
    under_way: FxHashMap<TileAddress, Cancel>,
    finished: Vec<Finished>,
    /// Number of tiles that were cancelled before they were loaded.
    cancelled: u64,
    stop: bool,
}

impl Loader {
    /// Starts the threads, with an empty list.
    pub(crate) fn new(store: Arc<dyn TileStore>) -> Self {
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
                // Drawing has priority; if the system refuses to set it, loading works all the same.
                if let Err(error) = set_current_thread_priority(priority) {
                    tracing::debug!("cannot set the priority of a loading thread: {error:?}");
                }
                work(&shared);
            })
        };
        let fetchers = (0..fetchers).map(|_| start("tile reader", Shared::fetch_tiles));
        let decoders = (0..cores.clamp(1, 8)).map(|_| start("tile decoder", Shared::decode_tiles));
        let threads = fetchers.chain(decoders).filter_map(|thread| match thread {
            Ok(thread) => Some(thread),
            Err(error) => {
                tracing::error!("cannot start a thread for loading tiles: {error}");
                None
            }
        });
        let threads = threads.collect();
        Self { shared, threads }
    }

    /// Replaces the list of wanted tiles, best first, without tiles that have been taken already. Tiles in progress
    /// that are not in the list are cancelled.
    pub(crate) fn want(&self, wanted: &[TileAddress]) {
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

    /// Returns the tiles that were finished since the last call.
    pub(crate) fn take(&self) -> Vec<Finished> {
        let finished = std::mem::take(&mut self.shared.lock().finished);
        if !finished.is_empty() {
            self.shared.fetch.notify_all();
            self.shared.decode.notify_all();
        }
        finished
    }

    /// Waits until a tile is finished, nothing is pending, or `timeout` has passed. The frame thread of a window must not
    /// call it.
    pub(crate) fn wait(&self, timeout: Duration) {
        let state = self.shared.lock();
        // The lists are consistent between statements, so poisoning is harmless.
        let _unused = self
            .shared
            .finished
            .wait_timeout_while(state, timeout, |state| {
                state.finished.is_empty() && !(state.under_way.is_empty() && state.wanted.is_empty())
            })
            .unwrap_or_else(PoisonError::into_inner);
    }

    /// Returns the number of tiles cancelled before they were loaded, since the start.
    pub(crate) fn cancelled(&self) -> u64 {
        self.shared.lock().cancelled
    }

    /// Returns the number of tiles that are waiting to be fetched, and of those that are being fetched or decoded.
    #[cfg(test)]
    pub(crate) fn queued_and_under_way(&self) -> [usize; 2] {
        let state = self.shared.lock();
        [state.wanted.len(), state.under_way.len()]
    }

    /// Returns the number of tiles that are wanted, being fetched or being decoded.
    pub(crate) fn pending(&self) -> usize {
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
            // The panic of a thread was reported when it happened.
            let _ = thread.join();
        }
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, State> {
        // The lists are consistent between statements, so poisoning is harmless.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn fetch_tiles(&self) {
        let mut state = self.lock();
        while !state.stop {
            let has_room = state.fetched.len() < MAX_FETCHED && state.finished.len() < MAX_FINISHED;
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
            let has_room = state.finished.len() < MAX_FINISHED;
            let next = if has_room { state.fetched.pop_front() } else { None };
            let Some((address, decode)) = next else {
                state = self.decode.wait(state).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            drop(state);
            self.fetch.notify_one();
            let tile = guarded(&*self.store, decode).map(Arc::new);
            state = self.lock();
            // A decoded tile is worth keeping, wanted or not.
            self.finish(&mut state, address, tile);
        }
    }

    fn finish(&self, state: &mut State, address: TileAddress, tile: Result<Arc<LoadedTile>, PyramidError>) {
        state.under_way.remove(&address);
        state.finished.push((address, tile));
        self.finished.notify_all();
    }
}

/// Runs a decoder and turns a panic into an error: decoders index by what files claim, so a panic is one more kind of
/// damage.
fn guarded<T>(store: &dyn TileStore, work: impl FnOnce() -> Result<T, PyramidError>) -> Result<T, PyramidError> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| {
        let cause = "the decoder of a tile failed; the file is probably damaged".to_owned();
        Err(PyramidError::Mismatch { path: store.name().into(), cause })
    })
}
