//! Compares a benchmark with an earlier one, and names what became worse.
//!
//! Reports of other frames are not compared: the notes name each setting that differs. Times are compared frame by
//! frame, with their noise ([`super::paired`]); everything else as [`super::figures`] says.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::figures;
use super::paired::{FRAME_TIME, LEAST_FRAMES, PASS_TIME, Paired, Sample, Threshold};
use super::report::{Report, Run};
use super::settings::Settings;
use super::statistics::{FrameRecord, Percentiles, RunFrames, read_frames_csv};
use crate::file::{FileError, input};

/// Largest report that is read: hundreds of styles.
const LARGEST_REPORT_BYTES: u64 = 64 << 20;
/// A pass, or a part of the processor's time, is named only if it changes the frame by this share: a change of 10 % in a
/// pass that takes 2.5 % of the frame.
const OF_FRAME: f64 = 0.0025;

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
    /// Notes of one sentence: each names figures that were not compared, with the reason, or another difference of the
    /// reports.
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
        let conflicts = self.conflicts(report);
        if !conflicts.is_empty() {
            comparison.notes = conflicts;
            return comparison;
        }
        comparison.notes = match (&self.report.settings, &report.settings) {
            (Some(old), Some(new)) => new.remarks(old),
            _ => vec![
                "the old report does not say how it was made: compare only if --path, --frames, --real-time, \
                 --lod-error and --tile-memory were the same"
                    .to_owned(),
            ],
        };
        let has_times = self.report.adapter == report.adapter;
        if !has_times {
            comparison.notes.push(format!("times are not compared: the GPU was {}", self.report.adapter));
        } else if self.frames.is_empty() {
            comparison
                .notes
                .push(format!("times are not compared: there is no {FRAMES_CSV} in the folder of the old report"));
        }
        let real_time = report.settings.as_ref().is_some_and(|settings| settings.real_time);
        if real_time {
            comparison.notes.push(
                "bytes, passes and other work of frames are not compared: with --real-time, each report is of other frames"
                    .to_owned(),
            );
        }
        for (run, frames) in report.runs.iter().zip(frames) {
            comparison.run(self, run, frames, has_times, real_time);
        }
        comparison
    }

    /// Returns why a benchmark cannot be compared with this one, a sentence for each reason.
    fn conflicts(&self, report: &Report) -> Vec<String> {
        let mut conflicts = Vec::new();
        if self.report.size_px != report.size_px {
            let [[a, b], [c, d]] = [self.report.size_px, report.size_px];
            conflicts.push(format!("nothing is compared: the pictures had {a}x{b} pixels, and now {c}x{d}"));
        }
        if self.report.world != report.world {
            conflicts.push("nothing is compared: the worlds differ in size".to_owned());
        }
        let settings: Option<(&Settings, &Settings)> = self.report.settings.as_ref().zip(report.settings.as_ref());
        conflicts.extend(settings.into_iter().flat_map(|(old, new)| new.conflicts(old)));
        conflicts
    }
}

const FRAMES_CSV: &str = "frames.csv";

/// The result of comparing one time.
#[derive(Clone, Copy, PartialEq)]
enum Compared {
    Yes,
    /// Both runs have it, but in too few frames.
    TooFewFrames,
    /// A run does not have it.
    NotMeasured,
}

impl Comparison {
    /// Compares a run with that of the same style and eyes in the old report.
    fn run(&mut self, old: &Baseline, run: &Run, frames: &RunFrames, has_times: bool, real_time: bool) {
        let name = format!("{}, {}", run.style, run.eyes);
        let is_same = |style: &str, eyes: &str| style == run.style && eyes == run.eyes;
        let Some(known) = old.report.runs.iter().find(|old| is_same(&old.style, &old.eyes)) else {
            self.notes.push(format!("{name}: is not in the old report"));
            return;
        };
        if known.antialias != run.antialias {
            let [before, now] = [&known.antialias, &run.antialias];
            self.notes.push(format!(
                "{name}: is not compared: the old report was made with --antialias {before}, this one with --antialias {now}"
            ));
            return;
        }
        if !real_time && known.frames != run.frames {
            let [before, now] = [known.frames, run.frames];
            self.notes.push(format!(
                "{name}: bytes, passes and other work of frames are not compared: the old report has {before} frames, this \
                 one {now}"
            ));
        }
        for (sign, change) in figures::of(known, run, !real_time && known.frames == run.frames) {
            self.add(sign, change);
        }
        if let Some(known) = old.frames.iter().find(|old| has_times && is_same(&old.style, &old.eyes)) {
            self.times(&known.frames, frames);
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
        let mut skipped: Vec<&str> = Vec::new();
        for (name, time) in parts {
            let values = [samples(old, time), samples(new, time)];
            if self.time((style, eyes, name), &values, frame_ms, FRAME_TIME) == Compared::TooFewFrames {
                skipped.push(name);
            }
        }
        if !skipped.is_empty() {
            let names = skipped.join(", ");
            self.notes.push(format!(
                "{style}, {eyes}: not compared: {names}; at least {LEAST_FRAMES} frames of each report must have a time"
            ));
        }
        let mut passes: Vec<&str> = Vec::new();
        for (pass, _) in new.iter().flat_map(|frame| &frame.pass_gpu_ms) {
            if !passes.contains(&pass.as_str()) {
                passes.push(pass);
            }
        }
        let mut rare = 0;
        for pass in passes {
            let of = |frame: &FrameRecord| {
                frame.pass_gpu_ms.iter().find(|(name, _)| name == pass).map(|(_, time_ms)| *time_ms)
            };
            let values = [samples(old, of), samples(new, of)];
            let compared = self.time((style, eyes, &format!("GPU ms of {pass}")), &values, frame_ms, PASS_TIME);
            rare += u32::from(compared == Compared::TooFewFrames);
        }
        if rare > 0 {
            self.notes
                .push(format!("{style}, {eyes}: not compared: the times of {rare} passes, which too few frames ran"));
        }
    }

    /// Compares one time, if enough frames have it.
    fn time(
        &mut self,
        (style, eyes, figure): (&str, &str, &str),
        [old, new]: &[Vec<Sample>; 2],
        frame_ms: Option<f64>,
        threshold: Threshold,
    ) -> Compared {
        let (Some(before), Some(after)) = (typical(old), typical(new)) else { return Compared::NotMeasured };
        let Some(paired) = Paired::of(old, new) else { return Compared::TooFewFrames };
        let matters = frame_ms.is_none_or(|frame_ms| (paired.ratio - 1.0).abs() * before > OF_FRAME * frame_ms);
        let sign = if matters { paired.sign(threshold) } else { 0 };
        let change = Change::of(style.to_owned(), eyes.to_owned(), figure.to_owned(), before, after);
        self.add(sign, Change { ratio: Some(paired.ratio), noise: Some(paired.noise), ..change });
        Compared::Yes
    }

    fn add(&mut self, sign: i32, change: Change) {
        self.compared += 1;
        match sign {
            1 => self.worse.push(change),
            -1 => self.better.push(change),
            _ => {}
        }
    }

    /// Returns the sentence about the figures that were compared and did not change; `None` if there are none.
    pub(crate) fn unchanged(&self) -> Option<String> {
        let others = self.compared - (self.worse.len() + self.better.len()) as u64;
        let beyond =
            |Threshold { share, errors }: Threshold| format!("{} % and {errors} standard errors", share * 100.0);
        (others > 0).then(|| {
            format!(
                "{others} other figures are unchanged (a time counts as changed beyond {}; that of a pass beyond {})",
                beyond(FRAME_TIME),
                beyond(PASS_TIME)
            )
        })
    }
}

impl Change {
    pub(super) fn of(style: String, eyes: String, figure: String, old: f64, new: f64) -> Self {
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
mod tests;
