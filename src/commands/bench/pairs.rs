//! Which frames of a flight are looked at more closely, and which are compared with the next.

use std::collections::BTreeSet;

/// What is measured on a frame beside its times.
#[derive(Clone, Copy)]
pub(super) struct Checks {
    pub lod_error: bool,
    /// Whether this frame and the next are compared.
    pub begins_pair: bool,
}

/// Which frames are compared with the next: one in each of as many equal parts of the path, at another place in each
/// (multiples of the golden ratio), so that no rhythm of a style hides between them.
pub(super) struct PairPlan {
    begins: BTreeSet<usize>,
}

impl PairPlan {
    /// So many pairs, or as many as there are, of `frames` frames.
    pub fn new(frames: usize, pairs: u32) -> Self {
        let all = frames.saturating_sub(1);
        let pairs = (pairs as usize).min(all);
        let begin = |i: usize| {
            let (first, end) = (i * all / pairs, (i + 1) * all / pairs);
            first + ((i as f64 * 0.618_034).fract() * (end - first) as f64) as usize
        };
        Self { begins: (0..pairs).map(begin).collect() }
    }

    /// Whether this frame is compared with the next; frames count from 0.
    pub fn begins_at(&self, frame: usize) -> bool {
        self.begins.contains(&frame)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn begins(frames: usize, pairs: u32) -> Vec<usize> {
        let plan = PairPlan::new(frames, pairs);
        // Far beyond the end too: a frame that never comes begins nothing.
        (0..frames + 50).filter(|frame| plan.begins_at(*frame)).collect()
    }

    #[test]
    fn pairs_are_as_many_as_asked_for_and_one_in_each_part() {
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
        // Evenly spread ones begin at multiples of thirty.
        assert_eq!(beats.len(), 10, "{beats:?}");
    }
}
