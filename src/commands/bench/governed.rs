//! `--budget`: a flight in real time whose settings a governor chooses on the style's measured front.

use anyhow::bail;

use super::BenchArgs;
use super::style_run::StyleRun;
use super::sweep::Variant;
use crate::commands::misuse::Misuse;
use crate::governor::{Frame, Governor, Step};
use crate::measure::governed::{GovernedRun, GovernedStep, SettingChange};
use crate::measure::quality::{Front, Level, Point};
use crate::measure::setting::Setting;
use crate::measure::statistics::FrameRecord;

/// The governor of a run, and the settings between which it chooses.
pub(super) struct Governed {
    governor: Governor,
    budget_ms: f64,
    /// From the cheapest to the most expensive.
    variants: Vec<Variant>,
    points: Vec<Point>,
    changes: Vec<SettingChange>,
    /// Number of frames with each setting.
    frames: Vec<u64>,
    /// Frames after the first second, and those of them that were within the budget.
    counted: u64,
    held: u64,
}

/// Time at the beginning in which the governor may still search.
const SEARCHES_S: f64 = 1.0;

impl Governed {
    /// Returns the governor for a style, which is a preset or a file; `None` without `--budget`.
    ///
    /// # Errors
    /// [`Misuse`] if the style has no measured front, and whatever makes one of its settings invalid.
    pub(super) fn of(args: &BenchArgs, name: &str) -> anyhow::Result<Option<Self>> {
        let Some(budget_ms) = args.budget else { return Ok(None) };
        let (front, from) = args.quality.front_of(name)?;
        let Front { points, .. } = front;
        if points.len() < 2 {
            bail!(Misuse(format!("--budget: {from} has only one setting, so there is nothing to choose")));
        }
        let mut variants = Vec::new();
        for point in &points {
            let setting = Setting::of(point.set.iter().map(|(key, text)| (key.as_str(), text.as_str())));
            let setting = setting.map_err(|error| anyhow::anyhow!("{from}: {error}"))?;
            variants.push(Variant::of_setting(args, name, &setting)?);
        }
        let steps = points.iter().enumerate().map(|(index, point)| Step {
            cost: point.cost,
            restarts: index.checked_sub(1).is_some_and(|cheaper| restarts(&points[cheaper], point)),
        });
        let level = args.quality.quality.unwrap_or(Level::Balanced);
        let first = points.iter().position(|point| point.levels.contains(&level)).unwrap_or(0);
        Ok(Some(Self {
            governor: Governor::new(budget_ms, steps.collect(), first),
            budget_ms,
            frames: vec![0; variants.len()],
            variants,
            points,
            changes: Vec::new(),
            counted: 0,
            held: 0,
        }))
    }

    /// Returns the setting for the next frame.
    pub(super) fn variant(&self) -> &Variant {
        &self.variants[self.governor.step()]
    }

    /// Returns the size of the largest pictures, in pixels.
    pub(super) fn largest_px(&self) -> [u32; 2] {
        let sides = |axis: usize| self.variants.iter().map(move |variant| variant.size_px[axis]);
        [0, 1].map(|axis| sides(axis).max().unwrap_or(1))
    }

    /// Takes a frame that was drawn; returns whether the setting changes.
    fn record(&mut self, record: &FrameRecord) -> bool {
        let (Some(frame_ms), Some(at_s)) = (record.frame_ms, record.wall_s) else { return false };
        let step = self.governor.step();
        self.frames[step] += 1;
        let cpu_ms =
            record.prepare_ms.unwrap_or(0.0) + record.record_ms.unwrap_or(0.0) + record.submit_ms.unwrap_or(0.0);
        // Without timers on the GPU, the whole frame counts.
        let gpu_ms = record.gpu_ms.unwrap_or(frame_ms);
        if at_s > SEARCHES_S {
            self.counted += 1;
            // A benchmark waits for each frame; elsewhere processor and GPU work at the same time.
            self.held += u64::from(gpu_ms.max(cpu_ms) <= self.budget_ms);
        }
        let change = self.governor.record(&Frame { at_s, step, gpu_ms, cpu_ms });
        self.changes.extend(change.map(|change| SettingChange {
            t_s: record.t_s,
            from: change.from,
            to: change.to,
            reason: change.reason.name().to_owned(),
        }));
        change.is_some()
    }

    /// Returns the results.
    pub(super) fn run(&self) -> GovernedRun {
        let steps = self.points.iter().zip(&self.frames);
        GovernedRun {
            budget_ms: self.budget_ms,
            held: (self.counted > 0).then(|| self.held as f64 / self.counted as f64),
            changes: self.changes.clone(),
            steps: steps.map(|(point, frames)| GovernedStep { set: point.set.clone(), frames: *frames }).collect(),
        }
    }
}

/// Returns whether temporal strokes restart where the setting changes from one point to another.
fn restarts(a: &Point, b: &Point) -> bool {
    let keys = a.set.keys().chain(b.set.keys());
    keys.filter(|key| a.set.get(*key) != b.set.get(*key)).any(|key| key.starts_with("strokes."))
}

impl StyleRun {
    /// Lets the governor see the last frame, and takes its setting for the next one.
    pub(super) fn govern(&mut self) {
        let Some(mut governed) = self.governed.take() else { return };
        if self.records.last().is_some_and(|record| governed.record(record)) {
            self.take_setting(governed.variant().clone());
        }
        self.governed = Some(governed);
    }
}
