//! Threads that resample tiles for frames that do not wait.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};

use rustc_hash::FxHashSet;
use thread_priority::{ThreadPriority, set_current_thread_priority};

use super::resample::Texels;
use super::{ImageTile, Imagery};
use crate::source::SourceError;

/// Number of threads.
const THREADS: usize = 2;

/// A tile with its texels, or the reason why it has none.
pub(super) type Finished = (ImageTile, Result<Texels, SourceError>);

/// Threads that resample the most urgent tiles.
pub(super) struct ImageLoader {
    shared: Arc<Shared>,
    finished: Receiver<Finished>,
}

/// What the threads share with the frame thread.
#[derive(Default)]
struct Shared {
    queue: Mutex<Queue>,
    wakes: Condvar,
    stops: AtomicBool,
}

#[derive(Default)]
struct Queue {
    /// The most urgent tile is the last.
    wanted: Vec<ImageTile>,
    /// Tiles that are being resampled, or wait for the frame thread.
    under_way: FxHashSet<ImageTile>,
}

impl ImageLoader {
    pub(super) fn new(imagery: &Arc<Imagery>) -> Self {
        let shared = Arc::new(Shared::default());
        let (sender, finished) = channel();
        for _ in 0..THREADS {
            let (imagery, shared, sender) = (Arc::clone(imagery), Arc::clone(&shared), sender.clone());
            let thread = std::thread::Builder::new().name("image tiles".to_owned());
            // Without a thread the images stay coarse.
            if let Err(error) = thread.spawn(move || work(&imagery, &shared, &sender)) {
                tracing::warn!("no thread for tiles of images could be started: {error}");
            }
        }
        Self { shared, finished }
    }

    /// Replaces the tiles that are wanted, the most urgent first.
    pub(super) fn want(&self, tiles: &[ImageTile]) {
        let mut queue = self.shared.queue.lock().unwrap_or_else(PoisonError::into_inner);
        let Queue { wanted, under_way } = &mut *queue;
        wanted.clear();
        wanted.extend(tiles.iter().rev().filter(|tile| !under_way.contains(tile)));
        drop(queue);
        self.shared.wakes.notify_all();
    }

    /// Returns a finished tile, if there is one.
    pub(super) fn take(&self) -> Option<Finished> {
        let finished = self.finished.try_recv().ok()?;
        let mut queue = self.shared.queue.lock().unwrap_or_else(PoisonError::into_inner);
        queue.under_way.remove(&finished.0);
        Some(finished)
    }
}

impl Drop for ImageLoader {
    fn drop(&mut self) {
        // A thread that has just found nothing to do holds this lock until it waits.
        let queue = self.shared.queue.lock().unwrap_or_else(PoisonError::into_inner);
        self.shared.stops.store(true, Ordering::Relaxed);
        drop(queue);
        self.shared.wakes.notify_all();
    }
}

fn work(imagery: &Imagery, shared: &Shared, sender: &Sender<Finished>) {
    // Drawing has priority; if the system refuses to set it, loading works all the same.
    if let Err(error) = set_current_thread_priority(ThreadPriority::Min) {
        tracing::debug!("the priority of a thread for tiles of images could not be set: {error:?}");
    }
    loop {
        let mut queue = shared.queue.lock().unwrap_or_else(PoisonError::into_inner);
        let tile = loop {
            if shared.stops.load(Ordering::Relaxed) {
                return;
            }
            match queue.wanted.pop() {
                Some(tile) => break tile,
                None => queue = shared.wakes.wait(queue).unwrap_or_else(PoisonError::into_inner),
            }
        };
        queue.under_way.insert(tile);
        drop(queue);
        if sender.send((tile, imagery.resample(tile))).is_err() {
            return;
        }
    }
}
