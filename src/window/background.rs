//! Work on a thread of its own. The window is woken when the work ends, also by an error or a panic.

use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread::JoinHandle;

/// The work ended without a result: its thread could not be started, or panicked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::window) struct NoResult;

/// Work on another thread, with its result when it is done.
pub(in crate::window) struct Background<T> {
    result: Receiver<T>,
    thread: Option<JoinHandle<()>>,
}

impl<T: Send + 'static> Background<T> {
    /// Begins work on a thread of this name, and calls `wake` when it has ended.
    pub(in crate::window) fn start(
        name: &str,
        work: impl FnOnce() -> T + Send + 'static,
        wake: impl Fn() + Send + 'static,
    ) -> Self {
        let (sender, result) = channel();
        let run = move || {
            // Dropped last, after the sender, also in a panic: the woken thread finds the channel closed.
            let _at_end = AtEnd(wake);
            let sender = sender;
            // The receiver has been dropped if the result is no longer needed.
            let _ = sender.send(work());
        };
        // Without a thread the sender is dropped here, and the first look finds no result.
        let thread = std::thread::Builder::new().name(name.to_owned()).spawn(run);
        if let Err(error) = &thread {
            tracing::warn!("cannot start a thread ({name}): {error}");
        }
        Self { result, thread: thread.ok() }
    }

    /// Takes the result; `None` while the work runs.
    pub(in crate::window) fn take(&self) -> Option<Result<T, NoResult>> {
        match self.result.try_recv() {
            Ok(result) => Some(Ok(result)),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err(NoResult)),
        }
    }

    /// Waits for the end of the work.
    pub(in crate::window) fn wait(&mut self) {
        // The thread has reported its panic itself.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}

/// Calls a function when it is dropped.
struct AtEnd<F: Fn()>(F);

impl<F: Fn()> Drop for AtEnd<F> {
    fn drop(&mut self) {
        (self.0)();
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::panic, reason = "the panic is what is tested")]

    use std::time::Duration;

    use super::*;

    fn woken_result(work: impl FnOnce() -> u32 + Send + 'static) -> Option<Result<u32, NoResult>> {
        let (sender, woken) = channel();
        let background = Background::start("test", work, move || _ = sender.send(()));
        woken.recv_timeout(Duration::from_secs(20)).ok()?;
        background.take()
    }

    #[test]
    fn the_end_of_work_wakes_the_window_even_if_it_panics() {
        assert_eq!(woken_result(|| 7), Some(Ok(7)));
        assert_eq!(woken_result(|| panic!("planted")), Some(Err(NoResult)));
    }
}
