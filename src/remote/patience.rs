//! Patience: limits how long a file may keep its reader waiting, over all its requests.
//!
//! Each request has its own deadlines, but a hundred requests that each use theirs up would delay a picture by an hour.
//! So the time during which at least one request is open counts for the file as a whole. Bytes that arrive give time
//! back, so that a slow server does not count as a dead one. When the time is used up, all open requests end, and new
//! ones fail at once for a while; then a single request may try again, for windows that stay open until the server is
//! back.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Number of received bytes that give back one second: the program gives up on a server that stays slower than this.
const BYTES_PER_S: u64 = 32 * 1024;
/// Time for which no request is made for a file that the program gave up on.
const REST: Duration = Duration::from_secs(30);

/// The waiting time of a file, or of files that are read together.
#[derive(Debug)]
pub(super) struct Patience {
    limit: Duration,
    /// Time that the first request after a [`REST`] may use up.
    probe: Duration,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    spent: Duration,
    /// Number of open requests.
    waiting: u32,
    /// The time at which `spent` was last updated.
    since: Instant,
    given_up: Option<GivenUp>,
}

#[derive(Debug)]
struct GivenUp {
    at: Instant,
    cause: String,
}

/// An open request: the time counts until this is dropped.
pub(super) struct Waiting<'a>(&'a Patience);

impl Patience {
    /// Creates a patience of `limit`; after a [`REST`] a single request may use up `probe`.
    pub(super) fn new(limit: Duration, probe: Duration) -> Arc<Self> {
        let state = State { spent: Duration::ZERO, waiting: 0, since: Instant::now(), given_up: None };
        Arc::new(Self { limit, probe: probe.min(limit), state: Mutex::new(state) })
    }

    /// Returns the limit in full.
    pub(super) fn limit(&self) -> Duration {
        self.limit
    }

    /// Starts to wait for the answer to a request.
    ///
    /// # Errors
    /// Returns the reason for giving up the file, until [`REST`] has passed.
    pub(super) fn start_waiting(&self) -> Result<Waiting<'_>, String> {
        let mut state = self.updated();
        if let Some(given_up) = &state.given_up {
            if given_up.at.elapsed() < REST {
                return Err(given_up.cause.clone());
            }
            state.given_up = None;
            state.spent = self.limit - self.probe;
        }
        state.waiting += 1;
        Ok(Waiting(self))
    }

    /// Records that bytes have arrived, which give time back.
    pub(super) fn add_received(&self, bytes: u64) {
        let mut state = self.updated();
        state.spent = state.spent.saturating_sub(Duration::from_secs_f64(bytes as f64 / BYTES_PER_S as f64));
    }

    /// Returns the remaining time.
    pub(super) fn remaining(&self) -> Duration {
        self.limit.saturating_sub(self.updated().spent)
    }

    /// Gives the file up for a [`REST`]; requests meanwhile fail with the cause.
    pub(super) fn give_up(&self, cause: &str) {
        let mut state = self.updated();
        if state.given_up.is_none() {
            state.given_up = Some(GivenUp { at: Instant::now(), cause: cause.to_owned() });
        }
    }

    /// Locks the state and brings `spent` up to date.
    fn updated(&self) -> MutexGuard<'_, State> {
        // No statement leaves the state inconsistent, so a poisoned lock does not matter.
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        if state.waiting > 0 {
            let waited = now - state.since;
            state.spent += waited;
        }
        state.since = now;
        state
    }
}

impl Drop for Waiting<'_> {
    fn drop(&mut self) {
        self.0.updated().waiting -= 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const A_WHILE: Duration = Duration::from_millis(40);

    #[test]
    fn only_waiting_takes_time_and_bytes_give_it_back() {
        let patience = Patience::new(Duration::from_secs(100), A_WHILE);
        std::thread::sleep(A_WHILE);
        assert_eq!(patience.remaining(), patience.limit());
        let waiting = [patience.start_waiting().unwrap(), patience.start_waiting().unwrap()];
        std::thread::sleep(A_WHILE);
        drop(waiting);
        let spent = patience.limit() - patience.remaining();
        assert!(spent >= A_WHILE && spent < Duration::from_secs(20), "{spent:?}");
        std::thread::sleep(A_WHILE);
        assert_eq!(patience.limit() - patience.remaining(), spent);
        patience.add_received(1 << 30);
        assert_eq!(patience.remaining(), patience.limit());
    }

    #[test]
    fn a_file_that_was_given_up_is_left_alone() {
        let patience = Patience::new(A_WHILE, A_WHILE);
        drop(patience.start_waiting().unwrap());
        patience.give_up("it sleeps");
        patience.give_up("it sleeps on");
        assert_eq!(patience.start_waiting().err().as_deref(), Some("it sleeps"));
    }
}
