//! The ratio of two series of times, by pairs, with its noise.
//!
//! The frames of two flights along one path show the same pictures, so each frame is compared with its twin: the ratio
//! of a pair does not depend on how much land is in view. Pairs are summed up in blocks of consecutive frames. The
//! median of a block ignores single slow frames, and the blocks differ from each other by as much as the machine's
//! speed changed during the runs. The noise is the standard error of the median of the blocks. Where neighbouring blocks
//! are alike, because the machine was slow for a while, they count as fewer blocks. A machine that is slower in one whole
//! run than in the other looks like a slower program: compare runs that were made in turns.

use super::statistics::Percentiles;

/// Largest number of blocks into which a flight is divided.
const MAX_BLOCKS: usize = 20;
/// Least number of frames in a block, and of frames of each run in a part of the path.
const MIN_BLOCK_FRAMES: usize = 3;
/// Least number of blocks, and of frames, that give a noise.
pub(super) const LEAST_FRAMES: usize = 4;
/// Largest correlation of neighbouring blocks for which the noise is corrected; the correction is then a factor of 4.4.
const MAX_CORRELATION: f64 = 0.9;
/// √(π/2): the standard error of a median, relative to that of a mean.
const MEDIAN_ERROR_FACTOR: f64 = 1.2533;

/// The least change with which a time is listed as changed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Threshold {
    /// Least change, as a share of the old time.
    pub share: f64,
    /// Least change, in standard errors.
    pub errors: f64,
}

/// Threshold of the time of a frame, or of a part of it.
pub(super) const FRAME_TIME: Threshold = Threshold { share: 0.03, errors: 4.0 };
/// Threshold of the time of a pass. There are many passes, so it is likely that one of them exceeds four errors by
/// chance. Half of the smallest change that must be found, which is 10 %.
pub(super) const PASS_TIME: Threshold = Threshold { share: 0.05, errors: 5.0 };

/// A value of one frame, with its time on the camera path in seconds.
pub(super) type Sample = (f64, f64);

/// A ratio of new to old values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Paired {
    /// Median of new ÷ old.
    pub ratio: f64,
    /// Standard error of the ratio, as a share of it.
    pub noise: f64,
}

impl Paired {
    /// Compares two series, whose values must be above 0 to count. `None` if there are too few.
    pub(super) fn of(old: &[Sample], new: &[Sample]) -> Option<Self> {
        let blocks = if are_twins(old, new) { blocks_of_pairs(old, new) } else { blocks_of_path(old, new) };
        if blocks.len() < LEAST_FRAMES {
            return None;
        }
        let middle = median(blocks.iter().copied())?;
        // Around the median, because a block of another speed should widen the noise.
        let variance = blocks.iter().map(|log| (log - middle).powi(2)).sum::<f64>() / (blocks.len() - 1) as f64;
        let correlation = correlation(&blocks).clamp(0.0, MAX_CORRELATION);
        let independent = blocks.len() as f64 * (1.0 - correlation) / (1.0 + correlation);
        let noise = MEDIAN_ERROR_FACTOR * (variance / independent).sqrt();
        Some(Self { ratio: middle.exp(), noise })
    }

    /// Returns whether the ratio is beyond a threshold: +1 if the new values are larger, -1 if they are smaller, 0 if
    /// neither is certain.
    pub(super) fn sign(self, threshold: Threshold) -> i32 {
        let log = self.ratio.ln();
        let needed = (threshold.errors * self.noise).max(threshold.share.ln_1p());
        i32::from(log > needed) - i32::from(log < -needed)
    }
}

/// Returns whether both series are of the same frames.
fn are_twins(old: &[Sample], new: &[Sample]) -> bool {
    old.len() == new.len() && old.iter().zip(new).all(|(old, new)| (old.0 - new.0).abs() < 1e-6)
}

/// Returns the median logarithm of the ratio in each block of consecutive pairs.
fn blocks_of_pairs(old: &[Sample], new: &[Sample]) -> Vec<f64> {
    let logs: Vec<f64> = old.iter().zip(new).filter_map(|(old, new)| log_ratio(old.1, new.1)).collect();
    // A block of one pair would not ignore a slow frame.
    let length = logs.len().div_ceil(MAX_BLOCKS).max(if logs.len() < LEAST_FRAMES * MIN_BLOCK_FRAMES {
        1
    } else {
        MIN_BLOCK_FRAMES
    });
    logs.chunks(length).filter_map(|block| median(block.iter().copied())).collect()
}

/// Returns the logarithm of the ratio of medians in each part of the path that both series have.
fn blocks_of_path(old: &[Sample], new: &[Sample]) -> Vec<f64> {
    let range = |samples: &[Sample]| {
        let times_s = || samples.iter().map(|sample| sample.0);
        Some((times_s().reduce(f64::min)?, times_s().reduce(f64::max)?))
    };
    let (Some(old_s), Some(new_s)) = (range(old), range(new)) else { return Vec::new() };
    let (start_s, end_s) = (old_s.0.max(new_s.0), old_s.1.min(new_s.1));
    let step_s = (end_s - start_s) / MAX_BLOCKS as f64;
    let in_block = |samples: &[Sample], block: usize| {
        let (from_s, to_s) = (start_s + step_s * block as f64, start_s + step_s * (block + 1) as f64);
        let values: Vec<f64> =
            samples.iter().filter(|sample| sample.0 >= from_s && sample.0 < to_s).map(|sample| sample.1).collect();
        if values.len() < MIN_BLOCK_FRAMES { None } else { median(values) }
    };
    (0..MAX_BLOCKS).filter_map(|block| log_ratio(in_block(old, block)?, in_block(new, block)?)).collect()
}

/// Returns the correlation of each block with the next one; 0 if all are equal.
fn correlation(blocks: &[f64]) -> f64 {
    let mean = blocks.iter().sum::<f64>() / blocks.len() as f64;
    let squares: f64 = blocks.iter().map(|log| (log - mean).powi(2)).sum();
    let products: f64 = blocks.windows(2).map(|pair| (pair[0] - mean) * (pair[1] - mean)).sum();
    if squares > 0.0 { products / squares } else { 0.0 }
}

fn log_ratio(old: f64, new: f64) -> Option<f64> {
    (old > 0.0 && new > 0.0).then(|| (new / old).ln())
}

fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    Percentiles::of(values).map(|values| values.p50)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a flight of `frames` frames: the work of a frame changes along the path, and each time has noise.
    fn flight(frames: u64, seed: u64, factor: impl Fn(u64) -> f64) -> Vec<Sample> {
        let mut state = seed;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let frame = |frame: u64| {
            let work = 3.0 + 2.0 * (frame as f64 / 9.0).sin();
            let slow = if random() < 0.03 { 4.0 } else { 1.0 };
            (frame as f64 / 30.0, work * slow * factor(frame) * (1.0 + 0.1 * (random() - 0.5)))
        };
        (0..frames).map(frame).collect()
    }

    #[test]
    fn a_slowdown_is_beyond_the_noise_and_an_equal_run_is_not() {
        let old = flight(120, 1, |_| 1.0);
        for seed in 2..40 {
            let equal = Paired::of(&old, &flight(120, seed, |_| 1.0)).map(|paired| paired.sign(FRAME_TIME));
            assert_eq!(equal, Some(0), "seed {seed}");
            // Planted: all frames take 10 % longer, or less.
            let slower = Paired::of(&old, &flight(120, seed, |_| 1.1)).map(|paired| paired.sign(FRAME_TIME));
            let faster = Paired::of(&old, &flight(120, seed, |_| 1.0 / 1.1)).map(|paired| paired.sign(FRAME_TIME));
            assert_eq!((slower, faster), (Some(1), Some(-1)), "seed {seed}");
        }
    }

    #[test]
    fn a_machine_that_is_busy_for_a_while_is_noise() {
        let busy = |frame: u64| if (20..60).contains(&frame) { 1.6 } else { 1.0 };
        let old = flight(120, 1, |_| 1.0);
        for seed in 2..40 {
            let paired = Paired::of(&old, &flight(120, seed, busy));
            assert_eq!(paired.map(|paired| paired.sign(FRAME_TIME)), Some(0), "seed {seed}");
        }
    }

    #[test]
    fn slow_stretches_of_the_machine_are_noise() {
        // The machine is slower in most of the second run, by 20 % at most, and for seconds at a time.
        let drift = |frame: u64| 1.0 + 0.2 * (frame as f64 / 120.0 * std::f64::consts::PI).sin();
        let old = flight(120, 1, |_| 1.0);
        let signs = |factor: f64| {
            let new = (2..40).map(|seed| flight(120, seed, |frame| factor * drift(frame)));
            new.map(|new| Paired::of(&old, &new).map(|paired| paired.sign(FRAME_TIME))).collect::<Vec<_>>()
        };
        assert_eq!(signs(1.0), [Some(0); 38]);
        // Planted: the same with a program that is twice as slow.
        assert_eq!(signs(2.0), [Some(1); 38]);
    }

    #[test]
    fn flights_with_other_numbers_of_frames_are_compared_by_places() {
        let old = flight(300, 1, |_| 1.0);
        // The slower flight has fewer frames along the same path.
        let new: Vec<Sample> = flight(300, 2, |_| 1.25).into_iter().step_by(2).collect();
        let paired = Paired::of(&old, &new);
        assert_eq!(paired.map(|paired| paired.sign(FRAME_TIME)), Some(1));
        assert_eq!(Paired::of(&old, &new[..5]), None);
        assert_eq!(Paired::of(&[], &[]), None);
    }
}
