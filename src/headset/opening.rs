//! The world of a flight in a headset, while a thread opens it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::error::HeadsetError;
use super::{HeadsetWorld, OpenFn};
use crate::gpu::Gpu;
use crate::source::Progress;

/// Longest time that the end of the program waits for the thread.
const LONGEST_END: Duration = Duration::from_secs(2);

/// The progress that the thread reports.
#[derive(Default)]
struct Report {
    what: Mutex<(String, f32)>,
    stop: AtomicBool,
}

impl Progress for Report {
    fn report(&self, what: &str, done: f32) {
        let mut now = self.what.lock().unwrap_or_else(PoisonError::into_inner);
        if now.0 != what {
            what.clone_into(&mut now.0);
        }
        now.1 = done.clamp(0.0, 1.0);
    }

    fn stop(&self) -> &AtomicBool {
        &self.stop
    }
}

/// A world that is being opened. It uses the device, but submits nothing: the queue belongs to the thread of the frames.
pub(super) struct Opening {
    world: Receiver<anyhow::Result<HeadsetWorld>>,
    report: Arc<Report>,
    thread: Option<JoinHandle<()>>,
    begun: Instant,
}

impl Opening {
    /// Begins to open a world.
    ///
    /// # Errors
    /// Fails if there is no thread for it.
    pub(super) fn start(gpu: &Gpu, open: OpenFn) -> Result<Self, HeadsetError> {
        let (sender, world) = channel();
        let (gpu, report) = (gpu.clone(), Arc::new(Report::default()));
        let of_thread = Arc::clone(&report);
        // The receiver is gone if the flight has ended.
        let work = move || _ = sender.send(open(&gpu, &*of_thread));
        let thread = std::thread::Builder::new().name("world".to_owned()).spawn(work);
        let thread = thread.map_err(|error| HeadsetError::World(error.into()))?;
        Ok(Self { world, report, thread: Some(thread), begun: Instant::now() })
    }

    /// Returns the world if it is open.
    ///
    /// # Errors
    /// Returns why it cannot be opened.
    pub(super) fn take(&mut self) -> Result<Option<HeadsetWorld>, HeadsetError> {
        match self.world.try_recv() {
            Ok(world) => world.map(Some).map_err(HeadsetError::World),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err(HeadsetError::World(anyhow::anyhow!("the world cannot be opened"))),
        }
    }

    /// Returns the current work and its progress.
    pub(super) fn doing(&self) -> (String, Option<f32>) {
        let (what, done) = self.report.what.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if what.is_empty() {
            return (format!("Opening the world, {} s", self.begun.elapsed().as_secs()), None);
        }
        // Only whole percents: the panel is drawn again when its text changes.
        let percent = (100.0 * done).floor();
        (format!("Opening: {what}, {percent} %"), Some(0.01 * percent))
    }
}

impl Drop for Opening {
    fn drop(&mut self) {
        self.report.stop.store(true, Ordering::Relaxed);
        // The thread holds the device, which must not outlive the runtime.
        if matches!(self.world.recv_timeout(LONGEST_END), Err(RecvTimeoutError::Timeout)) {
            tracing::warn!("the world is still being opened");
            return;
        }
        if let Some(thread) = self.thread.take() {
            // A panic there was printed there.
            let _ = thread.join();
        }
    }
}
