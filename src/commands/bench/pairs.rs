//! The frames of a flight that are checked, and those that are compared with the next frame.

use std::collections::BTreeSet;

/// The measurements of a frame in addition to its times.
#[derive(Clone, Copy)]
pub(super) struct Checks {
    pub lod_error: bool,
    /// Whether this frame is compared with the next one.
    pub begins_pair: bool,
}

/// The frames that are compared with the next one: one in each of N equal parts of the path, at a different offset in
/// each part (multiples of the golden ratio), so that no periodic behaviour of a style goes unnoticed.
pub(super) struct PairPlan {
    begins: BTreeSet<usize>,
}

impl PairPlan {
    /// Plans `pairs` pairs over `frames` frames, or as many pairs as there are.
    pub(super) fn new(frames: usize, pairs: u32) -> Self {
        let all = frames.saturating_sub(1);
        let pairs = (pairs as usize).min(all);
        let begin = |i: usize| {
            let (first, end) = (i * all / pairs, (i + 1) * all / pairs);
            first + ((i as f64 * 0.618_034).fract() * (end - first) as f64) as usize
        };
        Self { begins: (0..pairs).map(begin).collect() }
    }

    /// Returns whether this frame, counted from 0, is compared with the next.
    pub(super) fn begins_at(&self, frame: usize) -> bool {
        self.begins.contains(&frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn begins(frames: usize, pairs: u32) -> Vec<usize> {
        let plan = PairPlan::new(frames, pairs);
        // Includes frames beyond the end, which begin no pair.
        (0..frames + 50).filter(|frame| plan.begins_at(*frame)).collect()
    }

    #[test]
    fn there_is_one_pair_in_each_part() {
        for frames in 0..40 {
            for pairs in 0..45 {
                let begins = begins(frames, pairs);
                let all = frames.saturating_sub(1);
                assert_eq!(begins.len(), all.min(pairs as usize), "{frames} frames, {pairs} pairs: {begins:?}");
                for (i, begin) in begins.iter().enumerate() {
                    let part = i * all / begins.len()..(i + 1) * all / begins.len();
                    assert!(part.contains(begin), "{frames} {pairs}: {begins:?}");
                }
            }
        }
    }

    #[test]
    fn pairs_meet_every_beat_of_a_rhythm() {
        let mut beats: Vec<usize> = begins(1801, 60).into_iter().map(|begin| begin % 10).collect();
        beats.sort_unstable();
        beats.dedup();
        // Evenly spread pairs would begin at multiples of thirty.
        assert_eq!(beats.len(), 10, "{beats:?}");
    }
}
