//! Compares a benchmark with an earlier one, and names what became worse.
//!
//! Times are compared frame by frame, with their noise ([`super::paired`]). Bytes, passes and counts have no noise.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::paired::{Paired, Sample};
use super::report::{Report, Run};
use super::statistics::{FrameRecord, Percentiles, RunFrames, read_frames_csv};
use super::work::FrameWork;
use crate::file::{FileError, input};

/// Largest report that is read: hundreds of styles.
const LARGEST_REPORT_BYTES: u64 = 64 << 20;
/// A time of a frame is named if it changed by more than this share, and by more than this many standard errors.
const FRAME: (f64, f64) = (0.03, 4.0);
/// The same for a pass. There are many of them, so one that is beyond four errors by chance is likely.
const PASS: (f64, f64) = (0.1, 5.0);
/// A pass, or a part of the processor's time, is named only if it changes the frame by this share.
const OF_FRAME: f64 = 0.01;
/// Bytes are named if they grew or shrank by more than this share: buffers grow in steps.
const BYTES: f64 = 0.005;

/// An earlier benchmark.
pub(crate) struct Baseline {
    /// Name of the report's file, as given.
    pub name: String,
    pub report: Report,
    /// The frames of its runs; none if there is no `frames.csv` in the report's folder.
    pub frames: Vec<RunFrames>,
}

/// A figure that changed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Change {
    pub style: String,
    pub eyes: String,
    /// Name of the figure, with its unit.
    pub figure: String,
    /// Old and new value; of times, medians over the frames.
    pub old: f64,
    pub new: f64,
    /// New ÷ old; of times, the median over the pairs of frames. Null if the old value is 0.
    pub ratio: Option<f64>,
    /// Standard error of the ratio, as a share of it; null for a figure without noise.
    pub noise: Option<f64>,
}

/// The changes since an earlier benchmark.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Comparison {
    /// Name of the earlier report's file.
    pub with: String,
    /// Figures that could not be compared, and why: one sentence each.
    pub notes: Vec<String>,
    /// Figures that became worse, by style.
    pub worse: Vec<Change>,
    /// Figures that became better, by style.
    pub better: Vec<Change>,
    /// Number of figures that were compared.
    pub compared: u64,
}

impl Baseline {
    /// Reads a report, and the `frames.csv` in its folder if there is one.
    ///
    /// # Errors
    /// A file cannot be read, or is not a report of `bench`.
    pub(crate) fn read(path: &Path) -> Result<Self, FileError> {
        let failed = |cause: String| FileError::Read { path: path.to_owned(), cause };
        let bytes = input::read_bytes(path, LARGEST_REPORT_BYTES).map_err(|error| failed(error.to_string()))?;
        let report = serde_json::from_slice(&bytes)
            .map_err(|error| failed(format!("it is not a report.json of bench: {error}")))?;
        let table = path.with_file_name(FRAMES_CSV);
        let frames = if table.is_file() { read_frames_csv(&table)? } else { Vec::new() };
        Ok(Self { name: path.display().to_string(), report, frames })
    }

    /// Compares a benchmark with this one. `frames` are its runs, in its order.
    pub(crate) fn compare(&self, report: &Report, frames: &[RunFrames]) -> Comparison {
        let mut comparison = Comparison { with: self.name.clone(), ..Comparison::default() };
        if self.report.size_px != report.size_px {
            let [[a, b], [c, d]] = [self.report.size_px, report.size_px];
            comparison.notes.push(format!("nothing is compared: the pictures had {a}x{b} pixels, and now {c}x{d}"));
            return comparison;
        }
        if self.report.world != report.world {
            comparison.notes.push("nothing is compared: the worlds differ in size".to_owned());
            return comparison;
        }
        let has_times = self.report.adapter == report.adapter;
        if !has_times {
            comparison.notes.push(format!("times are not compared: the GPU was {}", self.report.adapter));
        } else if self.frames.is_empty() {
            comparison
                .notes
                .push(format!("times are not compared: there is no {FRAMES_CSV} in the folder of the old report"));
        }
        for (run, frames) in report.runs.iter().zip(frames) {
            let is_same = |style: &str, eyes: &str| style == run.style && eyes == run.eyes;
            let Some(old) = self.report.runs.iter().find(|old| is_same(&old.style, &old.eyes)) else {
                comparison.notes.push(format!("{}, {}: is not in the old report", run.style, run.eyes));
                continue;
            };
            comparison.exact(old, run);
            let known = self.frames.iter().find(|old| has_times && is_same(&old.style, &old.eyes));
            if let Some(known) = known {
                comparison.times(&known.frames, frames);
            }
        }
        comparison
    }
}

const FRAMES_CSV: &str = "frames.csv";

/// Returns whether a figure became worse: +1 worse, -1 better, 0 neither. The last argument is the number of frames.
type Judge = fn(f64, f64, f64) -> i32;

/// A figure: its name, how it is judged, and its old and new value if both were measured.
type Figure = (String, Judge, Option<(f64, f64)>);

fn any(old: f64, new: f64, _frames: f64) -> i32 {
    i32::from(new > old) - i32::from(new < old)
}

fn bytes(old: f64, new: f64, _frames: f64) -> i32 {
    i32::from(new > old * (1.0 + BYTES)) - i32::from(new < old * (1.0 - BYTES))
}

/// Counts of frames depend on how fast tiles arrive: a few are no change.
fn few(old: f64, new: f64, frames: f64) -> i32 {
    let allowed = (0.02 * frames).max(2.0);
    i32::from(new > old + allowed) - i32::from(new < old - allowed)
}

fn error_px(old: f64, new: f64, _frames: f64) -> i32 {
    i32::from(new > old * 1.05 + 0.02) - i32::from(new < old * 0.95 - 0.02)
}

/// A higher rate is better. One percent more or less is no change.
fn rate(old: f64, new: f64, _frames: f64) -> i32 {
    i32::from(new < old - 1.0) - i32::from(new > old + 1.0)
}

impl Comparison {
    /// Compares the figures that have no noise.
    fn exact(&mut self, old: &Run, new: &Run) {
        let work = |run: &Run, of: fn(FrameWork) -> u64| run.work.map(|work| of(work) as f64);
        let count = |value: Option<u64>| value.map(|value| value as f64);
        let both = |of: &dyn Fn(&Run) -> Option<f64>| Some((of(old)?, of(new)?));
        let mut figures: Vec<Figure> = Vec::new();
        let mut add = |name: &str, judge: Judge, values| figures.push((name.to_owned(), judge, values));
        add("bytes read", bytes, both(&|run| work(run, |work| work.bytes_read)));
        add("bytes written", bytes, both(&|run| work(run, |work| work.bytes_written)));
        add("passes", any, both(&|run| work(run, |work| work.passes)));
        add("dispatches", any, both(&|run| work(run, |work| work.dispatches)));
        add("draws", any, both(&|run| work(run, |work| work.draws)));
        add("copies", any, both(&|run| work(run, |work| work.copies)));
        add("barriers", any, both(&|run| work(run, |work| work.barriers)));
        add("GPU memory, bytes", bytes, both(&|run| count(run.memory.gpu_bytes)));
        add("triangles", bytes, both(&|run| count(run.triangles)));
        add("late frames", few, both(&|run| count(run.tiles.late_frames)));
        add("late frames, more than 1 s after a jump", few, both(&|run| count(run.tiles.late_frames_after_1s)));
        add("frames over budget", few, both(&|run| count(run.over_budget_frames)));
        add("tiles evicted", few, both(&|run| count(run.tiles.evicted)));
        add("level-of-detail error px, p99", error_px, both(&|run| Some(run.lod_error_px?.p99)));
        add("allowed error px, p99", error_px, both(&|run| Some(run.allowed_error_px?.p99)));
        for name in new.caches.keys() {
            let percent = |run: &Run| Some(100.0 * run.caches.get(name)?.hit_rate()?);
            add(&format!("hit rate %, {name}"), rate, both(&percent));
        }
        for pass in &new.passes {
            let of = |run: &Run, of: fn(&super::report::Pass) -> Option<u64>| {
                run.passes.iter().find(|known| known.name == pass.name).and_then(of).map(|value| value as f64)
            };
            let moved = |pass: &super::report::Pass| Some(pass.bytes_read? + pass.bytes_written?);
            add(&format!("bytes of {}", pass.name), bytes, both(&|run| of(run, moved)));
            add(&format!("runs of {}", pass.name), any, both(&|run| of(run, |pass| pass.runs)));
        }
        for (figure, judge, values) in figures {
            let Some((before, after)) = values else { continue };
            let ratio = (before > 0.0).then(|| after / before);
            let change = Change { ratio, ..Change::of(new.style.clone(), new.eyes.clone(), figure, before, after) };
            self.add(judge(before, after, new.frames as f64), change);
        }
    }

    /// Compares the times of frames and of passes.
    fn times(&mut self, old: &[FrameRecord], new: &RunFrames) {
        let RunFrames { style, eyes, frames: new } = new;
        type Time = fn(&FrameRecord) -> Option<f64>;
        let parts: [(&str, Time); 5] = [
            ("frame ms", |frame| frame.frame_ms),
            ("GPU ms", |frame| frame.gpu_ms),
            ("prepare ms", |frame| frame.prepare_ms),
            ("record ms", |frame| frame.record_ms),
            ("submit ms", |frame| frame.submit_ms),
        ];
        let frame_ms = typical(&samples(old, |frame| frame.frame_ms));
        for (name, time) in parts {
            let values = [samples(old, time), samples(new, time)];
            self.time((style, eyes, name), &values, frame_ms, FRAME);
        }
        let mut passes: Vec<&str> = Vec::new();
        for (pass, _) in new.iter().flat_map(|frame| &frame.pass_gpu_ms) {
            if !passes.contains(&pass.as_str()) {
                passes.push(pass);
            }
        }
        for pass in passes {
            let of = |frame: &FrameRecord| {
                frame.pass_gpu_ms.iter().find(|(name, _)| name == pass).map(|(_, time_ms)| *time_ms)
            };
            let values = [samples(old, of), samples(new, of)];
            self.time((style, eyes, &format!("GPU ms of {pass}")), &values, frame_ms, PASS);
        }
    }

    /// Compares one time.
    fn time(
        &mut self,
        (style, eyes, figure): (&str, &str, &str),
        [old, new]: &[Vec<Sample>; 2],
        frame_ms: Option<f64>,
        (floor, errors): (f64, f64),
    ) {
        let (Some(before), Some(after), Some(paired)) = (typical(old), typical(new), Paired::of(old, new)) else {
            return;
        };
        let matters = frame_ms.is_none_or(|frame_ms| (paired.ratio - 1.0).abs() * before > OF_FRAME * frame_ms);
        let sign = if matters { paired.sign(errors, floor) } else { 0 };
        let change = Change::of(style.to_owned(), eyes.to_owned(), figure.to_owned(), before, after);
        self.add(sign, Change { ratio: Some(paired.ratio), noise: Some(paired.noise), ..change });
    }

    fn add(&mut self, sign: i32, change: Change) {
        self.compared += 1;
        match sign {
            1 => self.worse.push(change),
            -1 => self.better.push(change),
            _ => {}
        }
    }
}

impl Change {
    fn of(style: String, eyes: String, figure: String, old: f64, new: f64) -> Self {
        Self { style, eyes, figure, old, new, ratio: None, noise: None }
    }

    /// Returns the change in percent with two standard errors, as text.
    pub(crate) fn percent(&self) -> String {
        let Some(ratio) = self.ratio else { return "–".to_owned() };
        let percent = format!("{:+.1} %", (ratio - 1.0) * 100.0);
        self.noise.map_or_else(|| percent.clone(), |noise| format!("{percent} ± {:.1}", 200.0 * noise * ratio))
    }
}

fn samples(frames: &[FrameRecord], value: impl Fn(&FrameRecord) -> Option<f64>) -> Vec<Sample> {
    frames.iter().filter_map(|frame| Some((frame.t_s, value(frame)?))).collect()
}

fn typical(samples: &[Sample]) -> Option<f64> {
    Percentiles::of(samples.iter().map(|sample| sample.1)).map(|values| values.p50)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a panic fails the test")]

    use super::*;
    use crate::measure::report::Pass;
    use crate::measure::statistics::write_frames_csv;
    use crate::measure::work::CacheUse;

    /// A flight in which the frame takes `frame_ms` times the load of the place, and its two passes a part of that.
    fn frames(seed: u64, factors: [f64; 2]) -> RunFrames {
        let frame = |frame: u64| {
            let noise = 1.0 + 0.04 * (((frame * 7919 + seed * 104_729) % 101) as f64 / 101.0 - 0.5);
            let load = (1.0 + 0.5 * (frame as f64 / 10.0).sin()) * noise;
            let [surface_ms, lines_ms] = [4.0 * factors[0] * load, 2.0 * factors[1] * load];
            FrameRecord {
                frame,
                t_s: frame as f64 / 30.0,
                frame_ms: Some(surface_ms + lines_ms + 1.0),
                gpu_ms: Some(surface_ms + lines_ms),
                prepare_ms: Some(0.2 * noise),
                pass_gpu_ms: vec![("surface".to_owned(), surface_ms), ("lines".to_owned(), lines_ms)],
                ..FrameRecord::default()
            }
        };
        RunFrames { style: "ink".to_owned(), eyes: "mono".to_owned(), frames: (0..90).map(frame).collect() }
    }

    fn report(frames: &RunFrames) -> Report {
        let mut run = Run::of_frames(&frames.style, &frames.eyes, &frames.frames);
        run.work = Some(FrameWork { bytes_read: 1_000_000, bytes_written: 200_000, passes: 9, ..FrameWork::default() });
        let pass = |name: &str| Pass {
            name: name.to_owned(),
            bytes_read: Some(500_000),
            bytes_written: Some(100_000),
            runs: Some(1),
            ..Pass::default()
        };
        run.passes = vec![pass("surface"), pass("lines")];
        run.caches.insert("tiles".to_owned(), CacheUse { hits: 95, misses: 5 });
        Report { adapter: "a card".to_owned(), size_px: [64, 36], runs: vec![run], ..Report::default() }
    }

    fn baseline(frames: RunFrames) -> Baseline {
        Baseline { name: "old/report.json".to_owned(), report: report(&frames), frames: vec![frames] }
    }

    fn names(changes: &[Change]) -> Vec<&str> {
        changes.iter().map(|change| change.figure.as_str()).collect()
    }

    #[test]
    fn an_equal_run_is_not_worse() {
        let old = baseline(frames(1, [1.0, 1.0]));
        for seed in 1..20 {
            let new = frames(seed, [1.0, 1.0]);
            let comparison = old.compare(&report(&new), &[new]);
            assert_eq!(
                (comparison.worse, comparison.better, comparison.notes),
                (vec![], vec![], vec![]),
                "seed {seed}"
            );
            assert!(comparison.compared >= 15, "{}", comparison.compared);
        }
    }

    #[test]
    fn a_planted_slowdown_is_named_with_its_pass() {
        let old = baseline(frames(1, [1.0, 1.0]));
        let slow = frames(2, [1.0, 1.3]);
        let comparison = old.compare(&report(&slow), std::slice::from_ref(&slow));
        assert_eq!(names(&comparison.worse), ["frame ms", "GPU ms", "GPU ms of lines"]);
        let lines = comparison.worse.last().unwrap();
        assert!((lines.ratio.unwrap() - 1.3).abs() < 0.03 && lines.noise.unwrap() < 0.02, "{lines:?}");
        assert!(lines.percent().starts_with("+2") || lines.percent().starts_with("+3"), "{}", lines.percent());
        // The other way round it is better.
        let back = baseline(slow).compare(&old.report, &old.frames);
        assert_eq!((names(&back.better), back.worse), (vec!["frame ms", "GPU ms", "GPU ms of lines"], vec![]));
    }

    #[test]
    fn planted_bytes_passes_and_misses_are_named() {
        let old = baseline(frames(1, [1.0, 1.0]));
        let new = frames(2, [1.0, 1.0]);
        let mut more = report(&new);
        let run = &mut more.runs[0];
        run.work = run.work.map(|work| FrameWork { bytes_read: 1_010_000, passes: 10, ..work });
        run.passes[1].bytes_written = Some(110_000);
        run.passes[0].runs = Some(2);
        run.caches.insert("tiles".to_owned(), CacheUse { hits: 80, misses: 20 });
        let comparison = old.compare(&more, &[new]);
        let expected = ["bytes read", "passes", "hit rate %, tiles", "runs of surface", "bytes of lines"];
        assert_eq!(names(&comparison.worse), expected);
        assert_eq!(comparison.worse[0].percent(), "+1.0 %");
    }

    #[test]
    fn what_cannot_be_compared_is_said() {
        let new = frames(2, [2.0, 2.0]);
        let compared = |change: &dyn Fn(&mut Baseline)| {
            let mut old = baseline(frames(1, [1.0, 1.0]));
            change(&mut old);
            let comparison = old.compare(&report(&new), std::slice::from_ref(&new));
            assert_eq!(comparison.worse, [], "{:?}", comparison.notes);
            comparison.notes.join("; ")
        };
        assert!(compared(&|old| old.report.adapter = "another".to_owned()).contains("the GPU was another"));
        assert!(compared(&|old| old.frames.clear()).contains("frames.csv"));
        assert!(compared(&|old| old.report.size_px = [1, 2]).contains("1x2"));
        assert!(compared(&|old| old.report.runs.clear()).contains("ink, mono"));
    }

    #[test]
    fn reports_are_read_from_their_folder() {
        let folder = tempfile::tempdir().unwrap();
        let [json, table] = ["report.json", "frames.csv"].map(|name| folder.path().join(name));
        let frames = frames(1, [1.0, 1.0]);
        report(&frames).write_json(&json).unwrap();
        assert_eq!(Baseline::read(&json).unwrap().frames, []);
        write_frames_csv(&table, std::slice::from_ref(&frames)).unwrap();
        let read = Baseline::read(&json).unwrap();
        assert_eq!(read.frames, [frames]);
        assert_eq!(read.report.runs[0].work.unwrap().passes, 9);
        crate::file::atomic::write(&json, b"{}").unwrap();
        let error = Baseline::read(&json).err().unwrap().to_string();
        assert!(error.contains("report.json") && error.contains("not a report.json of bench"), "{error}");
    }
}
