//! Threads that request random tiles, cancel some requests, and compare what arrives with the truth.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc;
use std::time::Duration;

use hachure::pyramid::store::Cancel;
use hachure::pyramid::{LoadedTile, PyramidError, TileAddress, TileStore};

use crate::faulty_server::next;

/// Each tile's address and the fingerprint that it must have.
pub(crate) type Truth = Vec<(TileAddress, u64)>;

/// Returns a hash of all samples, bit for bit, and of the statistics.
pub(crate) fn fingerprint(loaded: &LoadedTile) -> u64 {
    let add = |hash: u64, bits: u32| (hash ^ u64::from(bits)).wrapping_mul(0x0100_0000_01b3).rotate_left(7);
    let statistics = &loaded.statistics;
    let numbers = [statistics.min_m, statistics.max_m, statistics.error_m];
    // The minimum of an empty tile is NaN, whose bits may vary.
    let numbers = numbers.map(|number| if number.is_nan() { 0 } else { number.to_bits() });
    loaded.tile.samples.iter().map(|sample| sample.to_bits()).chain(numbers).fold(1, add)
}

/// The parameters of a flight.
pub(crate) struct Flight {
    pub requests: u64,
    pub threads: u64,
    pub seed: u64,
    /// How often a tile that cannot be decoded is requested, as the loader does.
    pub tries: u32,
}

/// The number of tiles by outcome.
#[derive(Debug, Default)]
pub(crate) struct Outcome {
    pub right: u64,
    pub wrong: u64,
    pub cancelled: u64,
    pub failed: u64,
    pub panicked: u64,
    /// Tiles that arrived after a failure.
    pub retried: u64,
}

impl Outcome {
    pub(crate) fn requested(&self) -> u64 {
        self.right + self.wrong + self.cancelled + self.failed + self.panicked
    }
}

#[derive(Default)]
struct Counts {
    right: AtomicU64,
    wrong: AtomicU64,
    cancelled: AtomicU64,
    failed: AtomicU64,
    panicked: AtomicU64,
    retried: AtomicU64,
}

impl Flight {
    pub(crate) fn fly(&self, store: &Arc<dyn TileStore>, truth: &Truth) -> Outcome {
        let counts = Counts::default();
        let left = AtomicU64::new(self.requests);
        let (cancels, cancelled) = mpsc::channel::<Cancel>();
        std::thread::scope(|scope| {
            // Cancels requests while tiles are on their way.
            scope.spawn(move || {
                for cancel in cancelled {
                    std::thread::sleep(Duration::from_micros(300));
                    cancel.cancel();
                }
            });
            for thread in 0..self.threads {
                let (counts, left, cancels) = (&counts, &left, cancels.clone());
                scope.spawn(move || {
                    let mut chance = self.seed.wrapping_mul(1_000_003) + thread * 7919 + 1;
                    while left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, |left| left.checked_sub(1)).is_ok() {
                        let (address, expected) = truth[next(&mut chance) as usize % truth.len()];
                        let cancel = Cancel::default();
                        match next(&mut chance) % 20 {
                            0 => cancel.cancel(),
                            1 => cancels.send(cancel.clone()).unwrap(),
                            _ => {}
                        }
                        self.request(store, address, expected, &cancel, counts);
                    }
                });
            }
            drop(cancels);
        });
        let get = |counter: AtomicU64| counter.into_inner();
        Outcome {
            right: get(counts.right),
            wrong: get(counts.wrong),
            cancelled: get(counts.cancelled),
            failed: get(counts.failed),
            panicked: get(counts.panicked),
            retried: get(counts.retried),
        }
    }

    fn request(
        &self,
        store: &Arc<dyn TileStore>,
        address: TileAddress,
        expected: u64,
        cancel: &Cancel,
        counts: &Counts,
    ) {
        let count = |counter: &AtomicU64| counter.fetch_add(1, Ordering::Relaxed);
        for attempt in 0..self.tries {
            let load = || store.clone().fetch(address, cancel)?();
            match catch_unwind(AssertUnwindSafe(load)) {
                Ok(Ok(loaded)) => {
                    count(if fingerprint(&loaded) == expected { &counts.right } else { &counts.wrong });
                    if attempt > 0 {
                        count(&counts.retried);
                    }
                    return;
                }
                Ok(Err(PyramidError::Cancelled)) => {
                    count(&counts.cancelled);
                    return;
                }
                Ok(Err(error)) => {
                    let message = error.to_string();
                    assert!(!message.contains('\n') && message.contains(&store.name()), "{message}");
                }
                Err(_) => {
                    count(&counts.panicked);
                    return;
                }
            }
        }
        count(&counts.failed);
    }
}

/// The resources of this process.
#[derive(Debug)]
pub(crate) struct System {
    pub threads: u64,
    pub files: u64,
    pub resident_bytes: u64,
}

impl System {
    /// Reads the resources; all are 0 where there is no `/proc`.
    pub(crate) fn now() -> Self {
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let number = |name: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(name));
            line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
        };
        let files = std::fs::read_dir("/proc/self/fd").map_or(0, |files| files.count() as u64);
        Self { threads: number("Threads:"), files, resident_bytes: number("VmRSS:") << 10 }
    }
}
