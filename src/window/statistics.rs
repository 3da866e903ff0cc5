//! Frame times and GPU times of the last frames.

use std::collections::VecDeque;

use crate::gpu::timer::PassTime;

/// Number of frames that are stored.
pub(super) const FRAMES: usize = 120;
/// Weight of a new GPU time in the moving average.
const NEW_PART: f64 = 0.15;

/// Times from frame to frame in milliseconds, while frames follow each other.
#[derive(Debug, Default)]
pub(super) struct FrameTimes {
    times_ms: VecDeque<f64>,
}

impl FrameTimes {
    /// Adds the time of the newest frame.
    pub(super) fn push(&mut self, time_ms: f64) {
        if self.times_ms.len() == FRAMES {
            self.times_ms.pop_front();
        }
        self.times_ms.push_back(time_ms);
    }

    /// Returns the times, oldest first.
    pub(super) fn iter(&self) -> impl Iterator<Item = f64> + '_ {
        self.times_ms.iter().copied()
    }

    /// Returns the quantile `part` (0 to 1) of the frame times; `None` without frames.
    pub(super) fn quantile_ms(&self, part: f64) -> Option<f64> {
        let mut sorted: Vec<f64> = self.iter().collect();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().checked_sub(1)?;
        sorted.get((part * last as f64).round() as usize).copied()
    }
}

/// GPU times by pass, smoothed so that they are readable.
#[derive(Debug, Default)]
pub(super) struct PassTimes {
    passes: Vec<PassTime>,
}

impl PassTimes {
    /// Adds the times of a frame; a frame with other passes resets the averages.
    pub(super) fn add(&mut self, times: Vec<PassTime>) {
        let same =
            self.passes.len() == times.len() && self.passes.iter().zip(&times).all(|(old, new)| old.name == new.name);
        if !same {
            self.passes = times;
            return;
        }
        for (old, new) in self.passes.iter_mut().zip(times) {
            old.gpu_ms += (new.gpu_ms - old.gpu_ms) * NEW_PART;
        }
    }

    /// Returns the passes in the order in which they run, with the whole frame first.
    pub(super) fn passes(&self) -> &[PassTime] {
        &self.passes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_of_the_last_frames() {
        let mut times = FrameTimes::default();
        assert_eq!(times.quantile_ms(0.5), None);
        (0..1000).for_each(|time| times.push(f64::from(time)));
        assert_eq!(times.iter().count(), FRAMES);
        assert_eq!(times.quantile_ms(0.0), Some(880.0));
        assert_eq!(times.quantile_ms(1.0), Some(999.0));
        assert_eq!(times.quantile_ms(0.95), Some(993.0));
    }

    #[test]
    fn another_style_starts_over() {
        let time = |name: &str, gpu_ms| PassTime { name: name.to_owned(), gpu_ms };
        let mut passes = PassTimes::default();
        passes.add(vec![time("frame", 1.0)]);
        passes.add(vec![time("frame", 2.0)]);
        assert!((passes.passes()[0].gpu_ms - 1.15).abs() < 1e-12);
        passes.add(vec![time("frame", 5.0), time("lines", 1.0)]);
        assert_eq!(passes.passes(), [time("frame", 5.0), time("lines", 1.0)]);
    }
}
