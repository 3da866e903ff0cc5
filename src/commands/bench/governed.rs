//! `--budget`: a flight in real time whose settings a governor chooses on the style's measured front.

use anyhow::bail;

use super::BenchArgs;
use super::style_run::StyleRun;
use super::sweep::Variant;
use crate::commands::misuse::Misuse;
use crate::governor::{Frame, Governor, Step, Tally};
use crate::measure::governed::{GovernedRun, GovernedStep, SettingChange};
use crate::measure::quality::{Front, Level, Point};
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
    tally: Tally,
}

impl Governed {
    /// Returns the governor for a style, which is a preset or a file; `None` without `--budget`.
    ///
    /// # Errors
    /// [`Misuse`] if the style has no measured front, and the errors of invalid settings.
    pub(super) fn of(args: &BenchArgs, name: &str) -> anyhow::Result<Option<Self>> {
        let Some(budget_ms) = args.budget else { return Ok(None) };
        let (front, from) = args.quality.front_of(name)?;
        let Front { points, .. } = front;
        if points.len() < 2 {
            bail!(Misuse(format!("--budget: {from} has only one setting, so there is nothing to choose")));
        }
        let settings = points.iter().map(Point::setting).collect::<Result<Vec<_>, _>>();
        let settings = settings.map_err(|error| anyhow::anyhow!("{from}: {error}"))?;
        let variants = settings.iter().map(|setting| Variant::of_setting(args, name, setting));
        let variants = variants.collect::<anyhow::Result<Vec<_>>>()?;
        let steps = points.iter().enumerate().map(|(index, point)| Step {
            cost: point.cost,
            restarts: index > 0 && settings[index].restarts_strokes_of(&settings[index - 1]),
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
            tally: Tally::default(),
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
        self.tally.count(at_s, gpu_ms, self.budget_ms);
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
            held: self.tally.share(),
            changes: self.changes.clone(),
            steps: steps.map(|(point, frames)| GovernedStep { set: point.set.clone(), frames: *frames }).collect(),
        }
    }
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
