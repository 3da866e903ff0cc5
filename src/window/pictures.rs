//! Pictures that are drawn in the background, one after the other, while the window goes on.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use super::screenshot::{self, Shot};

/// Largest number of pictures that wait; further ones are refused.
const MAX_OPEN: usize = 4;

type Taken = Result<PathBuf, String>;

/// The thread that draws pictures, and the finished pictures.
pub(super) struct Pictures {
    shots: Option<Sender<Shot>>,
    taken: Receiver<Taken>,
    thread: Option<JoinHandle<()>>,
    open: usize,
}

impl Pictures {
    /// Starts the thread, which calls `wake` after each picture.
    pub(super) fn start(wake: impl Fn() + Send + 'static) -> Self {
        Self::with(wake, |shot| screenshot::take(shot, Path::new(".")))
    }

    fn with(wake: impl Fn() + Send + 'static, take: impl Fn(&Shot) -> Taken + Send + 'static) -> Self {
        let (shots, waiting) = channel::<Shot>();
        let (sender, taken) = channel();
        let work = move || {
            for shot in waiting {
                let done = catch_unwind(AssertUnwindSafe(|| take(&shot)));
                // What the shot holds of the GPU is released before the picture is reported.
                drop(shot);
                let done = done.unwrap_or_else(|_| Err("the picture could not be drawn".to_owned()));
                if sender.send(done).is_err() {
                    return;
                }
                wake();
            }
        };
        let thread = std::thread::Builder::new().name("pictures".to_owned()).spawn(work);
        if let Err(error) = &thread {
            tracing::warn!("cannot start a thread for pictures: {error}");
        }
        Self { shots: Some(shots), taken, thread: thread.ok(), open: 0 }
    }

    /// Queues a picture. Returns `false` if too many are waiting.
    pub(super) fn take(&mut self, shot: Shot) -> bool {
        let is_queued = self.open < MAX_OPEN && self.shots.as_ref().is_some_and(|shots| shots.send(shot).is_ok());
        self.open += usize::from(is_queued);
        is_queued
    }

    /// Returns how many pictures are not finished.
    pub(super) fn open(&self) -> usize {
        self.open
    }

    /// Takes the file of a picture that is finished, or why there is none.
    pub(super) fn taken(&mut self) -> Option<Taken> {
        let taken = self.taken.try_recv().ok()?;
        self.open -= 1;
        Some(taken)
    }
}

impl Drop for Pictures {
    /// Waits for the pictures that were requested: their files are expected.
    fn drop(&mut self) {
        self.shots = None;
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::warn!("the thread for pictures failed");
        }
    }
}
