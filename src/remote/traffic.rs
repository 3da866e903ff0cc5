//! Counts network traffic.

use std::sync::atomic::{AtomicU64, Ordering};

/// The traffic of a file so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Number of requests, including failed ones.
    pub requests: u64,
    /// Number of bytes received.
    pub bytes: u64,
    /// Number of requests that were repeated.
    pub retries: u64,
    /// Number of reads that failed after their retries.
    pub failures: u64,
    /// Number of blocks that were found in memory.
    pub memory_hits: u64,
    /// Number of blocks that were found in the disk cache.
    pub disk_hits: u64,
    /// Number of blocks that a decoder rejected.
    pub invalidated: u64,
}

/// The counters behind [`Traffic`].
#[derive(Default)]
pub(super) struct Counters {
    pub requests: Counter,
    pub bytes: Counter,
    pub retries: Counter,
    pub failures: Counter,
    pub memory_hits: Counter,
    pub disk_hits: Counter,
    pub invalidated: Counter,
}

/// A counter that any thread may increase.
#[derive(Default)]
pub(super) struct Counter(AtomicU64);

impl Counter {
    pub(super) fn add(&self, count: u64) {
        self.0.fetch_add(count, Ordering::Relaxed);
    }

    fn get(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

impl Counters {
    pub(super) fn traffic(&self) -> Traffic {
        Traffic {
            requests: self.requests.get(),
            bytes: self.bytes.get(),
            retries: self.retries.get(),
            failures: self.failures.get(),
            memory_hits: self.memory_hits.get(),
            disk_hits: self.disk_hits.get(),
            invalidated: self.invalidated.get(),
        }
    }
}
