//! What went over the wire.

use std::sync::atomic::{AtomicU64, Ordering};

/// What a file cost so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Requests made, those that failed included.
    pub requests: u64,
    /// Bytes that came with them.
    pub bytes: u64,
    /// Requests that were made again.
    pub retries: u64,
    /// Reads that failed after their retries.
    pub failures: u64,
    /// Blocks that lay in memory.
    pub memory_hits: u64,
    /// Blocks that lay on disk.
    pub disk_hits: u64,
    /// Blocks that a decoder threw away.
    pub invalidated: u64,
}

/// The same while it is counted.
#[derive(Default)]
pub struct Counters {
    pub requests: Counter,
    pub bytes: Counter,
    pub retries: Counter,
    pub failures: Counter,
    pub memory_hits: Counter,
    pub disk_hits: Counter,
    pub invalidated: Counter,
}

/// Counts up, from any thread.
#[derive(Default)]
pub struct Counter(AtomicU64);

impl Counter {
    pub fn add(&self, count: u64) {
        self.0.fetch_add(count, Ordering::Relaxed);
    }

    fn get(&self) -> u64 {
        self.0.load(Ordering::Relaxed)
    }
}

impl Counters {
    pub fn traffic(&self) -> Traffic {
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
