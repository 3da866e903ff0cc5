//! The figures of a run that are compared with an earlier one and have no noise to measure, each with the rule by which
//! it is worse or better.
//!
//! The work that frames give the GPU is compared exactly (bytes to half a percent), since the same frames give the same
//! work. Late frames, evicted tiles and hit rates also depend on how fast tiles arrive, so they have a tolerance.

use super::comparison::Change;
use super::report::{Pass, Run};
use super::work::{FrameWork, cache_label};

/// Bytes are named if they grew or shrank by more than this share: buffers grow in steps.
const BYTES: f64 = 0.005;
/// Counts of frames and tiles are named if they changed by more than this share of the frames, and by more than two.
const OF_FRAMES: f64 = 0.02;

/// Returns whether a figure became worse: +1 worse, -1 better, 0 neither. The last argument is the smaller number of
/// frames.
type Judge = fn(f64, f64, f64) -> i32;

fn any(old: f64, new: f64, _frames: f64) -> i32 {
    i32::from(new > old) - i32::from(new < old)
}

fn bytes(old: f64, new: f64, _frames: f64) -> i32 {
    i32::from(new > old * (1.0 + BYTES)) - i32::from(new < old * (1.0 - BYTES))
}

fn few(old: f64, new: f64, frames: f64) -> i32 {
    let allowed = (OF_FRAMES * frames).max(2.0);
    i32::from(new > old + allowed) - i32::from(new < old - allowed)
}

/// Compares like [`few`] for a share of the frames in percent.
fn few_percent(old: f64, new: f64, frames: f64) -> i32 {
    let frames = frames.max(1.0);
    few(old * frames / 100.0, new * frames / 100.0, frames)
}

fn error_px(old: f64, new: f64, _frames: f64) -> i32 {
    i32::from(new > old * 1.05 + 0.02) - i32::from(new < old * 0.95 - 0.02)
}

/// A higher rate is better. A difference of one percent counts as no change.
fn rate(old: f64, new: f64, _frames: f64) -> i32 {
    i32::from(new < old - 1.0) - i32::from(new > old + 1.0)
}

/// Figures of two runs that both have.
struct Figures<'a> {
    old: &'a Run,
    new: &'a Run,
    found: Vec<(i32, Change)>,
}

impl Figures<'_> {
    /// Adds a figure if both runs have it.
    fn add(&mut self, name: &str, judge: Judge, value: impl Fn(&Run) -> Option<f64>) {
        let Some((before, after)) = value(self.old).zip(value(self.new)) else { return };
        let frames = self.old.frames.min(self.new.frames) as f64;
        let ratio = (before > 0.0).then(|| after / before);
        let Run { style, eyes, .. } = self.new;
        let change = Change { ratio, ..Change::of(style.clone(), eyes.clone(), name.to_owned(), before, after) };
        self.found.push((judge(before, after, frames), change));
    }

    /// Adds what frames give the GPU to do.
    fn add_work(&mut self) {
        type Part = fn(FrameWork) -> u64;
        let parts: [(&str, Judge, Part); 7] = [
            ("bytes read", bytes, |work| work.bytes_read),
            ("bytes written", bytes, |work| work.bytes_written),
            ("wgpu passes", any, |work| work.wgpu_passes),
            ("dispatches", any, |work| work.dispatches),
            ("draws", any, |work| work.draws),
            ("copies", any, |work| work.copies),
            ("barriers", any, |work| work.barriers),
        ];
        for (name, judge, part) in parts {
            self.add(name, judge, |run| run.work.map(|work| part(work) as f64));
        }
        self.add("GPU memory, bytes", bytes, |run| count(run.memory.gpu_bytes));
        self.add("GPU memory of the drawing, bytes", bytes, |run| count(run.memory.drawing_bytes));
        self.add("triangles", bytes, |run| count(run.triangles));
        for pass in &self.new.passes {
            let moved = |pass: &Pass| Some((pass.bytes_read? + pass.bytes_written?) as f64);
            self.add(&format!("bytes of {}", pass.name), bytes, |run| moved(found(run, &pass.name)?));
            self.add(&format!("runs of {}", pass.name), any, |run| count(found(run, &pass.name)?.runs));
        }
    }

    /// Adds what also depends on how fast tiles arrive.
    fn add_streaming(&mut self) {
        let percent = |count: Option<u64>, run: &Run| Some(100.0 * count? as f64 / run.frames.max(1) as f64);
        self.add("late frames %", few_percent, |run| percent(run.tiles.late_frames, run));
        self.add("late frames %, more than 1 s after a jump", few_percent, |run| {
            percent(run.tiles.late_frames_after_1s, run)
        });
        self.add("frames over budget %", few_percent, |run| percent(run.over_budget_frames, run));
        self.add("tiles evicted", few, |run| count(run.tiles.evicted));
        self.add("level-of-detail error px, p99", error_px, |run| Some(run.lod_error_px?.p99));
        self.add("allowed error px, p99", error_px, |run| Some(run.allowed_error_px?.p99));
        self.add("surface coarser because of memory, largest factor", error_px, |run| run.tiles.memory_factor);
        for name in self.new.caches.keys() {
            let percent = |run: &Run| Some(100.0 * run.caches.get(name)?.hit_rate()?);
            self.add(&format!("hit rate %, {}", cache_label(name)), rate, percent);
        }
    }
}

/// Returns the figures that both runs have, each with +1 if it became worse and -1 if it became better. The work that
/// frames give the GPU is left out unless both runs drew the `same_frames`.
pub(super) fn of(old: &Run, new: &Run, same_frames: bool) -> Vec<(i32, Change)> {
    let mut figures = Figures { old, new, found: Vec::new() };
    if same_frames {
        figures.add_work();
    }
    figures.add_streaming();
    figures.found
}

fn count(value: Option<u64>) -> Option<f64> {
    value.map(|value| value as f64)
}

fn found<'a>(run: &'a Run, pass: &str) -> Option<&'a Pass> {
    run.passes.iter().find(|known| known.name == pass)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_late_frames_are_no_change_and_more_are() {
        // 2 % of 600 frames are 12.
        let late = |old: f64, new: f64| few_percent(100.0 * old / 600.0, 100.0 * new / 600.0, 600.0);
        assert_eq!([late(0.0, 11.0), late(0.0, 13.0), late(13.0, 0.0)], [0, 1, -1]);
        // Of five frames, two.
        assert_eq!([few_percent(0.0, 40.0, 5.0), few_percent(0.0, 60.0, 5.0)], [0, 1]);
        assert_eq!([rate(90.0, 89.5, 0.0), rate(90.0, 88.0, 0.0), rate(88.0, 90.0, 0.0)], [0, 1, -1]);
        assert_eq!([bytes(1000.0, 1004.0, 0.0), bytes(1000.0, 1006.0, 0.0)], [0, 1]);
    }
}
