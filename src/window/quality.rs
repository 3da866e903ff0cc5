//! The quality of a flight: a level of the style's measured front, or the settings with which a governor holds the time
//! of a frame.
//!
//! Why: `docs/decisions/governor.md`.

use std::borrow::Cow;

use crate::frame::Antialias;
use crate::governor::{Change, Frame, Governor, Step};
use crate::measure::quality::{Front, Level};
use crate::measure::setting::{FRONTS, Setting};
use crate::style::set::{self, SetValue};
use crate::style::{Style, StyleError};

/// How exactly the picture is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Quality {
    /// As the style and the other settings say.
    #[default]
    AsSet,
    /// At a level of the style's measured front.
    Level(Level),
    /// With the most exact setting whose frames take at most this time, in milliseconds.
    Budget(f64),
}

impl Quality {
    /// Budget of a new governor, in milliseconds: 60 frames a second, and some time for the window system.
    pub(super) const BUDGET_MS: f64 = 15.0;

    /// Returns its name in the panel.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::AsSet => "as set",
            Self::Level(level) => level.name(),
            Self::Budget(_) => "hold a frame time",
        }
    }
}

/// Render scales of a style without a measured front, each with the cost that is assumed until it has been seen: part of a
/// frame does not depend on its pixels.
const SCALES: [f64; 5] = [0.5, 0.6, 0.7, 0.84, 1.0];

fn assumed_cost(scale: f64) -> f64 {
    0.3 + 0.7 * scale * scale
}

/// Frames in the first second of a budget are not counted: the governor still searches.
const SEARCHES_S: f64 = 1.0;

/// The settings that a style can be drawn with, and the one that is.
#[derive(Debug, Default)]
pub(super) struct Ladder {
    /// The style's name and the quality for which the settings are.
    of: Option<(String, Quality)>,
    /// The front that `--front` names.
    front: Option<Front>,
    /// From the cheapest to the most expensive.
    settings: Vec<Setting>,
    /// Whether the settings were measured.
    is_measured: bool,
    governor: Option<Governor>,
    /// Index of the setting, without a governor.
    fixed: usize,
    /// Number of the governor; frames of earlier ones do not count.
    number: u64,
    /// The style with the present setting, and what it was made from.
    drawn: Option<(Style, u64, f64, Style)>,
    tally: Tally,
}

/// What a governor has done.
#[derive(Clone, Debug, Default)]
struct Tally {
    begun_s: Option<f64>,
    frames: u64,
    held: u64,
    changes: u64,
    last: Option<Change>,
}

impl Ladder {
    /// Creates a ladder that uses `front` for the style of which it is.
    pub(super) fn with_front(front: Option<Front>) -> Self {
        Self { front, ..Self::default() }
    }

    /// Makes the settings for a style and a quality, if they are for others.
    pub(super) fn follow(&mut self, style: &str, quality: Quality) {
        if self.of.as_ref().is_some_and(|(name, of)| name == style && *of == quality) {
            return;
        }
        let is_of_style = |front: &&Front| front.style == style;
        let built_in = || {
            let (_, text) = FRONTS.iter().find(|(name, _)| *name == style)?;
            Front::parse(text).ok()
        };
        let front = self.front.clone().filter(|front| is_of_style(&front)).or_else(built_in);
        self.is_measured = front.is_some();
        self.of = Some((style.to_owned(), quality));
        self.number += 1;
        self.tally = Tally::default();
        (self.governor, self.settings, self.fixed) = (None, Vec::new(), 0);
        match (quality, front) {
            (Quality::AsSet, _) | (Quality::Level(_), None) => {}
            (Quality::Level(level), Some(front)) => {
                let point = front.point(level).and_then(|point| Setting::of(pairs(&point.set)).ok());
                self.settings.extend(point);
            }
            (Quality::Budget(budget_ms), front) => {
                let steps = self.climb(front);
                let top = steps.len() - 1;
                self.governor = Some(Governor::new(budget_ms, steps, top));
            }
        }
    }

    /// Fills the settings, from the cheapest one to the style as it is, and returns their steps.
    fn climb(&mut self, front: Option<Front>) -> Vec<Step> {
        let mut rungs: Vec<(f64, Setting)> = match front {
            // What is dearer than the style as it is, nobody has asked for.
            Some(front) => front
                .points
                .iter()
                .filter(|point| point.cost_ratio < 0.97)
                .filter_map(|point| Some((point.cost_ratio, Setting::of(pairs(&point.set)).ok()?)))
                .collect(),
            None => {
                let less = SCALES.iter().filter(|scale| **scale < 1.0);
                less.map(|scale| (assumed_cost(*scale), Setting { scale: Some(*scale), ..Setting::default() }))
                    .collect()
            }
        };
        rungs.push((1.0, Setting::default()));
        let restarts = |index: usize| index > 0 && of_strokes(&rungs[index].1) != of_strokes(&rungs[index - 1].1);
        let steps = (0..rungs.len()).map(|index| Step { cost: rungs[index].0, restarts: restarts(index) }).collect();
        self.settings = rungs.into_iter().map(|(_, setting)| setting).collect();
        steps
    }

    /// Returns the present setting; `None` if there is nothing to change.
    pub(super) fn setting(&self) -> Option<&Setting> {
        self.settings.get(self.index())
    }

    fn index(&self) -> usize {
        self.governor.as_ref().map_or(self.fixed, Governor::step)
    }

    /// Returns whether the time of frames must be measured.
    pub(super) fn is_governed(&self) -> bool {
        self.governor.is_some()
    }

    /// Returns the tag of a frame that is drawn with the present setting.
    pub(super) fn tag(&self) -> u64 {
        (self.number << 16) | self.index() as u64
    }

    /// Returns the style with the present setting, for pictures that are `scale` times as large as the window.
    pub(super) fn applied<'a>(&'a mut self, style: &'a Style, scale: f64) -> Cow<'a, Style> {
        let values = self.setting().map(|setting| setting.values.clone()).unwrap_or_default();
        if values.is_empty() && scale == 1.0 {
            return Cow::Borrowed(style);
        }
        let tag = self.tag();
        let is_known =
            |(of, made_for, at, _): &(Style, u64, f64, Style)| (*made_for, *at) == (tag, scale) && of == style;
        if !self.drawn.as_ref().is_some_and(is_known) {
            // A style without the section that a value is of is drawn without that value.
            let with = with_values(style, &values).unwrap_or_else(|error| {
                tracing::debug!("{}: {error}", style.name);
                style.clone()
            });
            self.drawn = Some((style.clone(), tag, scale, with.scaled(scale)));
        }
        self.drawn.as_ref().map_or(Cow::Borrowed(style), |(.., drawn)| Cow::Borrowed(drawn))
    }

    /// Takes the time of a frame with its tag; `cpu_ms` is that of the processor. Returns whether the setting changes.
    pub(super) fn record(&mut self, tag: u64, at_s: f64, gpu_ms: f64, cpu_ms: f64) -> bool {
        let Some(governor) = self.governor.as_mut().filter(|_| tag >> 16 == self.number) else { return false };
        let Some((_, Quality::Budget(budget_ms))) = self.of else { return false };
        let begun_s = *self.tally.begun_s.get_or_insert(at_s);
        if at_s - begun_s > SEARCHES_S {
            self.tally.frames += 1;
            self.tally.held += u64::from(gpu_ms.max(cpu_ms) <= budget_ms);
        }
        let step = usize::try_from(tag & 0xffff).unwrap_or(usize::MAX);
        let change = governor.record(&Frame { at_s, step, gpu_ms, cpu_ms });
        self.tally.changes += u64::from(change.is_some());
        self.tally.last = change.or(self.tally.last);
        change.is_some()
    }

    /// Returns the smoothing of edges, if the setting has one.
    pub(super) fn antialias(&self) -> Option<Antialias> {
        self.setting().and_then(|setting| setting.antialias)
    }

    /// Returns what the present setting gives up, in words; `None` if nothing is.
    pub(super) fn given_up(&self) -> Option<String> {
        let Setting { lod_error_px, scale, antialias, values } = self.setting()?;
        let scale = scale.filter(|scale| *scale != 1.0).map(|scale| format!("resolution {scale}"));
        let lod_error = lod_error_px.filter(|px| *px > 1.0).map(|px| format!("terrain error {px} px"));
        let antialias =
            antialias.filter(|antialias| *antialias == Antialias::None).map(|_| "edges not smoothed".to_owned());
        let values = values.iter().map(SetValue::to_string);
        let parts: Vec<String> = [scale, lod_error, antialias].into_iter().flatten().chain(values).collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }

    /// Returns what the panel says about the quality; `None` if it is as set.
    pub(super) fn words(&self) -> Option<String> {
        let (style, quality) = self.of.as_ref()?;
        if let (Quality::Level(_), None) = (quality, self.setting()) {
            return Some(format!(
                "{style} has no measured levels: it is drawn as set (hachure bench --sweep measures them)"
            ));
        }
        let Quality::Budget(budget_ms) = quality else { return self.given_up() };
        let now = self.given_up().unwrap_or_else(|| "everything as set".to_owned());
        let held = (self.tally.frames > 0).then(|| 100.0 * self.tally.held as f64 / self.tally.frames as f64);
        let held = held.map_or(String::new(), |held| format!("; {held:.1} % of frames within {budget_ms} ms"));
        let unmeasured =
            if self.is_measured { "" } else { ". Not measured for this style: only the resolution changes" };
        Some(format!("{now}{held}{unmeasured}"))
    }

    /// Returns a line about the governor for `--frames`; `None` without one.
    pub(super) fn report(&self) -> Option<String> {
        self.governor.as_ref()?;
        let Tally { frames, held, changes, .. } = self.tally;
        let words = self.given_up().unwrap_or_else(|| "everything as set".to_owned());
        Some(format!("{held} of {frames} frames within the budget, {changes} changes, in the end {words}"))
    }
}

fn pairs(set: &std::collections::BTreeMap<String, String>) -> impl Iterator<Item = (&str, &str)> {
    set.iter().map(|(key, text)| (key.as_str(), text.as_str()))
}

/// Returns the values of a setting whose change restarts strokes.
fn of_strokes(setting: &Setting) -> Vec<&SetValue> {
    setting.values.iter().filter(|value| value.key.starts_with("strokes.")).collect()
}

fn with_values(style: &Style, values: &[SetValue]) -> Result<Style, StyleError> {
    if values.is_empty() {
        return Ok(style.clone());
    }
    let text = set::with_values(&style.name, &style.text(), style, values)?;
    Style::parse_with(&style.name, &text, &style.recipe_files())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    fn style(name: &str) -> Style {
        Style::load(name).unwrap()
    }

    #[test]
    fn a_level_is_a_point_of_the_front() {
        let mut ladder = Ladder::default();
        ladder.follow("ink", Quality::Level(Level::Draft));
        assert!(ladder.setting().unwrap().scale.unwrap() < 1.0 && !ladder.is_governed());
        let scale = ladder.setting().unwrap().scale.unwrap();
        let ink = style("ink");
        let drawn = ladder.applied(&ink, scale).into_owned();
        assert!(drawn != ink && drawn.name == "ink");
        assert!(ladder.words().unwrap().contains("resolution"));
        // A style without a front is drawn as it is, and the panel says so.
        ladder.follow("plain", Quality::Level(Level::Draft));
        assert!(ladder.setting().is_none() && ladder.words().unwrap().contains("no measured levels"));
        assert_eq!(*ladder.applied(&style("plain"), 1.0), style("plain"));
        ladder.follow("ink", Quality::AsSet);
        assert!(ladder.setting().is_none() && ladder.words().is_none());
    }

    #[test]
    fn a_budget_moves_along_the_front_and_back() {
        for name in ["ink", "pencil"] {
            let mut ladder = Ladder::default();
            ladder.follow(name, Quality::Budget(10.0));
            assert!(ladder.given_up().is_none(), "it begins with the style as it is");
            let mut now_s = 0.0;
            let mut fly = |ladder: &mut Ladder, seconds: f64, full_ms: f64| {
                let end_s = now_s + seconds;
                while now_s < end_s {
                    now_s += 0.016;
                    let scale = ladder.setting().and_then(|setting| setting.scale).unwrap_or(1.0);
                    ladder.record(ladder.tag(), now_s, full_ms * assumed_cost(scale), 1.0);
                }
            };
            fly(&mut ladder, 3.0, 5.0);
            assert!(ladder.given_up().is_none(), "{name}");
            fly(&mut ladder, 3.0, 13.0);
            assert!(ladder.given_up().unwrap().contains("resolution"), "{name}");
            assert!(ladder.words().unwrap().contains("% of frames within 10 ms"));
            assert_eq!(ladder.words().unwrap().contains("Not measured"), name == "pencil");
            fly(&mut ladder, 20.0, 5.0);
            assert!(ladder.given_up().is_none(), "{name}: {:?}", ladder.tally);
            // Planted: frames of another governor change nothing.
            let (before, tag) = (ladder.tally.frames, ladder.tag());
            ladder.follow(name, Quality::Budget(11.0));
            (0..50).for_each(|_| _ = ladder.record(tag, 100.0, 99.0, 1.0));
            assert!(ladder.given_up().is_none() && before > 0 && ladder.tally.frames == 0, "{name}");
        }
    }

    #[test]
    fn a_value_of_a_section_that_is_gone_is_left_out() {
        let mut front = Front::parse(FRONTS[0].1).unwrap();
        front.style = "plain".to_owned();
        for point in &mut front.points {
            point.set.insert("strokes.resolution".to_owned(), "0.5".to_owned());
        }
        let mut ladder = Ladder::with_front(Some(front));
        ladder.follow("plain", Quality::Level(Level::Exact));
        assert!(!ladder.setting().unwrap().values.is_empty());
        assert_eq!(*ladder.applied(&style("plain"), 1.0), style("plain"));
    }
}
