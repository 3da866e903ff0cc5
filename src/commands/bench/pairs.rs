//! Which frames of a flight are compared with the next.

/// Which frames are compared with the next: pairs spread evenly over all that there are.
pub(super) struct PairPlan {
    pairs: usize,
    all: usize,
}

impl PairPlan {
    /// So many pairs, or as many as there are, of `frames` frames.
    pub fn new(frames: usize, pairs: u32) -> Self {
        let all = frames.saturating_sub(1);
        Self { pairs: (pairs as usize).min(all), all }
    }

    /// Whether this frame is compared with the next; frames count from 0.
    pub fn begins_at(&self, frame: usize) -> bool {
        // Pair i begins at frame i · all / pairs, rounded down.
        let pairs_before = |frame: usize| (frame * self.pairs).div_ceil(self.all.max(1));
        frame < self.all && pairs_before(frame) < pairs_before(frame + 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_as_many_as_asked_for_and_spread_evenly() {
        for frames in 0..40 {
            for pairs in 0..45 {
                let plan = PairPlan::new(frames, pairs);
                // Far beyond the end too: a frame that never comes begins nothing.
                let begins: Vec<usize> = (0..frames + 50).filter(|frame| plan.begins_at(*frame)).collect();
                let all = frames.saturating_sub(1);
                assert_eq!(begins.len(), all.min(pairs as usize), "{frames} frames, {pairs} pairs: {begins:?}");
                assert!(begins.last().is_none_or(|last| last + 1 < frames), "{frames} {pairs}: {begins:?}");
                let gaps: Vec<usize> = begins.windows(2).map(|pair| pair[1] - pair[0]).collect();
                let (least, most) = (gaps.iter().min(), gaps.iter().max());
                assert!(least.zip(most).is_none_or(|(least, most)| most - least <= 1), "{frames} {pairs}: {begins:?}");
            }
        }
    }
}
