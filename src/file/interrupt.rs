//! The end of the program from outside (Ctrl-C, a closed terminal, a scheduler): files that are being written are
//! removed, unless the running command stops in its own way.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

/// The temporary files and folders that are being written.
static UNFINISHED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// The action of the running command at the first request to end. The second one ends the program.
static STOP: Mutex<Option<Box<dyn Fn() + Send>>> = Mutex::new(None);

/// Keeps a temporary file in the list of files that are removed if the program is ended. Dropping it takes the file off
/// the list, and does not remove the file.
#[derive(Debug)]
pub(crate) struct Unfinished(PathBuf);

impl Unfinished {
    /// Creates a temporary file or folder and puts its path on the list, as one step: a program that ends in between
    /// would leave it behind.
    pub(crate) fn create<T>(
        create: impl FnOnce() -> std::io::Result<T>,
        path_of: impl FnOnce(&T) -> &Path,
    ) -> std::io::Result<(T, Self)> {
        let mut list = lock(&UNFINISHED);
        let created = create()?;
        let path = path_of(&created).to_owned();
        list.insert(path.clone());
        Ok((created, Self(path)))
    }
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        lock(&UNFINISHED).remove(&self.0);
    }
}

/// Sets the action of the running command at the first request to end, which then does not end the program at once.
pub(crate) fn on_first_request(stop: impl Fn() + Send + 'static) {
    *lock(&STOP) = Some(Box::new(stop));
}

/// Handles requests to end from now on. A file that exceeds the limit of the shell (`ulimit -f`) becomes an error of the
/// write, which names the file, instead of a signal that ends the program.
pub(crate) fn handle_requests() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        if let Err(error) = install() {
            tracing::debug!("requests to end are not handled: {error}");
        }
    });
}

#[cfg(unix)]
fn install() -> std::io::Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
    // Somebody who starts a program with `nohup` wants it to outlive the terminal; a handler would end that.
    let is_ignored = std::fs::read_to_string("/proc/self/status").is_ok_and(|status| ignores(&status, SIGHUP));
    let hangup = (!is_ignored).then_some(SIGHUP);
    signal_hook::flag::register(SIGXFSZ, std::sync::Arc::default())?;
    let mut requests = signal_hook::iterator::Signals::new([SIGINT, SIGTERM].into_iter().chain(hangup))?;
    std::thread::Builder::new().name("requests to end".into()).spawn(move || {
        for signal in requests.forever() {
            if !stops_itself() {
                remove_unfinished();
                // The status is that of a program that the signal ended.
                let _ = signal_hook::low_level::emulate_default_handler(signal);
            }
        }
    })?;
    Ok(())
}

/// Returns whether a process ignores a signal, from its `/proc/PID/status`.
#[cfg(unix)]
fn ignores(status: &str, signal: i32) -> bool {
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}

#[cfg(not(unix))]
fn install() -> std::io::Result<()> {
    let end = || {
        if !stops_itself() {
            remove_unfinished();
            std::process::exit(130);
        }
    };
    ctrlc::set_handler(end).map_err(std::io::Error::other)
}

/// Lets the running command stop by itself; returns false if it cannot or was asked before.
fn stops_itself() -> bool {
    let stop = lock(&STOP).take();
    stop.inspect(|stop| stop()).is_some()
}

/// Removes all unfinished files. The list stays locked, so that no thread creates another one before the program ends.
fn remove_unfinished() {
    let list = lock(&UNFINISHED);
    for path in &*list {
        // The names are random and were created by this process, so that nothing else is removed.
        let _ = if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
    }
    let _locked = std::mem::ManuallyDrop::new(list);
}

/// Locks a list; a thread that panicked leaves it whole.
fn lock<T>(list: &Mutex<T>) -> MutexGuard<'_, T> {
    list.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn ignored_signals_are_read_from_the_mask() {
        assert!(ignores("Name:\tx\nSigIgn:\t0000000000000001\n", 1));
        assert!(!ignores("SigIgn:\t0000000000001000\n", 1) && !ignores("", 1));
    }
}
