//! The most prominent summits so far.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::forest::{Found, Threshold};
use super::sample::{Sample, metres};

/// A summit with its prominence. The order is by prominence, then by [`Sample`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Ranked {
    pub prominence_m: f32,
    pub found: Found,
}

impl Ranked {
    fn key(&self) -> (u32, Sample) {
        // Prominences are positive: their bits are ordered as they are.
        (self.prominence_m.to_bits(), self.found.peak)
    }

    /// Returns the lowest prominence that the summit can have if land continues where it is unknown.
    pub(super) fn certain_m(&self) -> f32 {
        if self.found.runoff == Sample::NONE {
            return self.prominence_m;
        }
        self.prominence_m.min(self.found.peak.height_m() - self.found.runoff.height_m())
    }
}

impl Ord for Ranked {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.key().cmp(&other.key())
    }
}

impl PartialOrd for Ranked {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Ranked {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for Ranked {}

/// Collects the most prominent summits.
pub(super) struct Ranking {
    most: usize,
    /// The level from which the highest summits of islands are measured.
    sea_level_m: Option<f32>,
    threshold: Threshold,
    /// The least prominent summit is the greatest element.
    kept: BinaryHeap<Reverse<Ranked>>,
}

impl Ranking {
    pub(super) fn new(most: usize, least_m: f64, sea_level_m: Option<f32>) -> Self {
        Self { most, sea_level_m, threshold: Threshold { least_m }, kept: BinaryHeap::new() }
    }

    /// Returns the prominence that a summit needs. It rises once there are as many summits as there may be.
    pub(super) fn threshold(&self) -> Threshold {
        self.threshold
    }

    /// Adds a summit, and removes the least prominent one if there are too many.
    pub(super) fn add(&mut self, found: Found) {
        let height_m = found.peak.height_m();
        let is_island = found.runoff == Sample::NONE;
        let base_m = match self.sea_level_m {
            _ if found.saddle != Sample::NONE => found.saddle.height_m(),
            Some(sea_level_m) if is_island && height_m > sea_level_m => sea_level_m,
            _ => metres(found.lowest),
        };
        let prominence_m = height_m - base_m;
        if !self.threshold.keeps(prominence_m) {
            return;
        }
        self.kept.push(Reverse(Ranked { prominence_m, found }));
        if self.kept.len() > self.most {
            self.kept.pop();
        }
        if self.kept.len() == self.most
            && let Some(Reverse(least)) = self.kept.peek()
        {
            // A summit that is exactly as prominent can still be higher.
            self.threshold.least_m = self.threshold.least_m.max(f64::from(least.prominence_m));
        }
    }

    /// Returns the summits, most prominent first.
    pub(super) fn finish(self) -> Vec<Ranked> {
        self.kept.into_sorted_vec().into_iter().map(|Reverse(ranked)| ranked).collect()
    }
}
