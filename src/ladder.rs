//! The quality of a flight: a level of the style's measured front, or the settings with which a governor holds the time
//! of a frame.
//!
//! Why: `docs/decisions/governor.md`.

use std::borrow::Cow;

use crate::governor::{Frame, Governor, Limit, Pressure, Step, Tally};
use crate::measure::quality::{Front, Level, Point};
use crate::measure::setting::{FRONTS, Setting};
use crate::measure::trade;
use crate::style::set::{self, SetValue};
use crate::style::{Style, StyleError};

/// The exactness with which the picture is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) enum Quality {
    /// As exactly as the style and the other settings say.
    #[default]
    AsSet,
    /// At a level of the style's measured front.
    Level(Level),
    /// With the most expensive setting whose frames take at most this time, in milliseconds.
    Budget(f64),
}

impl Quality {
    /// Budget of a new governor, in milliseconds: 60 frames a second, and some time for the window system.
    pub(crate) const BUDGET_MS: f64 = 15.0;

    /// Returns its name in the panel.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::AsSet => "as set",
            Self::Level(level) => level.name(),
            Self::Budget(_) => "target frame time",
        }
    }

    /// Returns whether the same settings serve both.
    fn has_settings_of(self, other: Self) -> bool {
        self == other || matches!((self, other), (Self::Budget(_), Self::Budget(_)))
    }
}

/// Render scales of a style without a measured front, each with the cost that is assumed until it has been seen: part of a
/// frame does not depend on its pixels.
const SCALES: [f64; 4] = [0.5, 0.6, 0.7, 0.84];

fn assumed_cost(scale: f64) -> f64 {
    0.3 + 0.7 * scale * scale
}

/// Only settings below this share of the cost of the style as it is are used.
const CHEAPER: f64 = 0.97;
/// The bits of a tag that hold the step.
const STEP_MASK: u64 = 0xffff;
/// The step of frames at rest, of which the governor learns nothing.
const AT_REST: u64 = STEP_MASK;

/// The settings that a style can be drawn with, and the one in use.
#[derive(Debug, Default)]
pub(crate) struct Ladder {
    /// The style's name and the quality for which the settings are.
    of: Option<(String, Quality)>,
    /// The fronts that `--front` names.
    fronts: Vec<Front>,
    /// From the cheapest to the most expensive.
    settings: Vec<Setting>,
    /// Whether the settings were measured.
    is_measured: bool,
    governor: Option<Governor>,
    /// Whether nothing moves, so that the time of a frame does not matter.
    rests: bool,
    /// Number of the governor; frames of earlier ones do not count.
    number: u64,
    drawn: Option<Drawn>,
    tally: Tally,
    /// Number of changes of the setting.
    changes: u64,
}

/// A style with a setting.
#[derive(Debug)]
struct Drawn {
    /// The style to which the setting was applied.
    of: Style,
    tag: u64,
    scale: f64,
    style: Style,
    /// Values that the style cannot have, because it lacks their section.
    left_out: usize,
}

impl Ladder {
    /// Returns whether the style that is drawn has measured levels.
    pub(crate) fn has_levels(&self) -> bool {
        self.is_measured
    }

    /// Creates a ladder that uses these fronts for the styles of which they are.
    pub(crate) fn with_fronts(fronts: Vec<Front>) -> Self {
        Self { fronts, ..Self::default() }
    }

    /// Makes the settings for a style and a quality, if they are for others.
    pub(crate) fn follow(&mut self, style: &str, quality: Quality) {
        if let Some((name, of)) = self.of.as_mut().filter(|(name, of)| name == style && of.has_settings_of(quality)) {
            if *of != quality
                && let (Quality::Budget(ms), Some(governor)) = (quality, &mut self.governor)
            {
                tracing::debug!("{name}: the budget is {ms} ms");
                governor.set_budget_ms(ms);
                self.tally = Tally::default();
            }
            *of = quality;
            return;
        }
        let built_in = || {
            let (_, text) = FRONTS.iter().find(|(name, _)| *name == style)?;
            Front::parse(style, text).ok()
        };
        let front = self.fronts.iter().find(|front| front.style == style).cloned().or_else(built_in);
        let number = self.number + 1;
        *self = Self {
            of: Some((style.to_owned(), quality)),
            fronts: std::mem::take(&mut self.fronts),
            is_measured: front.is_some(),
            number,
            ..Self::default()
        };
        match (quality, front) {
            (Quality::AsSet, _) | (Quality::Level(_), None) => {}
            (Quality::Level(level), Some(front)) => self.settings.extend(front.point(level).and_then(setting_of)),
            (Quality::Budget(budget_ms), front) => {
                let steps = self.climb(front);
                let top = steps.len() - 1;
                self.governor = Some(Governor::new(budget_ms, steps, top));
            }
        }
    }

    /// Fills the settings, from the cheapest one to the style as it is, and returns their steps.
    fn climb(&mut self, front: Option<Front>) -> Vec<Step> {
        let mut rungs: Vec<(f64, Setting)> = match &front {
            Some(front) => monotonic(&front.points),
            None => {
                let at = |scale: &f64| (assumed_cost(*scale), Setting { scale: Some(*scale), ..Setting::default() });
                SCALES.iter().map(at).collect()
            }
        };
        rungs.push((1.0, Setting::default()));
        let restarts = |index: usize| index > 0 && rungs[index].1.restarts_strokes_of(&rungs[index - 1].1);
        let steps = (0..rungs.len()).map(|index| Step { cost: rungs[index].0, restarts: restarts(index) }).collect();
        self.settings = rungs.into_iter().map(|(_, setting)| setting).collect();
        steps
    }

    /// Says whether nothing moves: then the style is drawn as it is, however long a frame takes.
    pub(crate) fn rest(&mut self, rests: bool) {
        self.rests = rests && self.is_governed();
    }

    /// Returns whether a rest would be drawn more exactly than the last frame.
    pub(crate) fn waits_for_rest(&self) -> bool {
        !self.rests && self.governor.as_ref().is_some_and(|governor| governor.step() + 1 < self.settings.len())
    }

    /// Returns the current setting; `None` if there is nothing to change.
    pub(crate) fn setting(&self) -> Option<&Setting> {
        match &self.governor {
            Some(_) if self.rests => self.settings.last(),
            Some(governor) => self.settings.get(governor.step()),
            None => self.settings.first(),
        }
    }

    /// Returns whether the time of frames must be measured.
    pub(crate) fn is_governed(&self) -> bool {
        self.governor.is_some()
    }

    /// Returns the tag of a frame that is drawn with the current setting.
    pub(crate) fn tag(&self) -> u64 {
        let step = self.governor.as_ref().map_or(0, |governor| governor.step() as u64);
        (self.number << 16) | if self.rests { AT_REST } else { step }
    }

    /// Returns a style with the current setting, for pictures that are `scale` times as large as the window or the
    /// headset's images.
    pub(crate) fn applied<'a>(&'a mut self, style: &'a Style, scale: f64) -> Cow<'a, Style> {
        let values = self.setting().map(|setting| setting.values.clone()).unwrap_or_default();
        if values.is_empty() && scale == 1.0 {
            self.drawn = None;
            return Cow::Borrowed(style);
        }
        let tag = self.tag();
        let is_known = |drawn: &Drawn| (drawn.tag, drawn.scale) == (tag, scale) && drawn.of == *style;
        if !self.drawn.as_ref().is_some_and(is_known) {
            let (with, left_out) = with_values(style, &values);
            let of = style.clone();
            self.drawn = Some(Drawn { of, tag, scale, style: with.scaled(scale), left_out });
        }
        self.drawn.as_ref().map_or(Cow::Borrowed(style), |drawn| Cow::Borrowed(&drawn.style))
    }

    /// Sets what others that share the GPU leave to the frames.
    pub(crate) fn set_pressure(&mut self, pressure: Pressure) {
        if let Some(governor) = &mut self.governor {
            governor.set_pressure(pressure);
        }
    }

    /// Takes the time of a frame with its tag; `cpu_ms` is that of the processor. Returns whether the setting changes.
    pub(crate) fn record(&mut self, tag: u64, at_s: f64, gpu_ms: f64, cpu_ms: f64) -> bool {
        let Some(governor) = self.governor.as_mut().filter(|_| tag >> 16 == self.number) else { return false };
        let Some((_, Quality::Budget(budget_ms))) = self.of else { return false };
        if tag & STEP_MASK == AT_REST {
            return false;
        }
        self.tally.count(at_s, gpu_ms, budget_ms);
        let step = usize::try_from(tag & STEP_MASK).unwrap_or(usize::MAX);
        let change = governor.record(&Frame { at_s, step, gpu_ms, cpu_ms });
        self.changes += u64::from(change.is_some());
        change.is_some()
    }

    /// Returns what the current setting gives up of the user's settings, in words; `None` if nothing is. `scale` and
    /// `lod_error_px` are the resolution and the terrain error that the user has set.
    pub(crate) fn given_up(&self, scale: f64, lod_error_px: f64) -> Option<String> {
        let setting = self.setting()?;
        let resolution = setting.scale.filter(|lower| *lower < scale).map(|lower| format!("resolution {lower}"));
        let error = setting.lod_error_px.filter(|more| *more > lod_error_px);
        let error = error.map(|more_px| format!("terrain error {more_px} px"));
        let differs = |value: &&SetValue| {
            let of = self.drawn.as_ref().map(|drawn| &drawn.of);
            of.is_none_or(|style| with_values(style, std::slice::from_ref(value)).0 != *style)
        };
        let values = setting.values.iter().filter(differs).map(SetValue::to_string);
        let trees = setting.tree_detail.filter(|detail| *detail < 1.0).map(|detail| format!("tree detail {detail}"));
        let parts: Vec<String> = resolution.into_iter().chain(error).chain(trees).chain(values).collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }

    /// Returns what the panel says about the quality; `None` if it is as set. The arguments are those of
    /// [`Ladder::given_up`].
    pub(crate) fn words(&self, scale: f64, lod_error_px: f64) -> Option<String> {
        let (style, quality) = self.of.as_ref()?;
        if let (Quality::Level(_), None) = (quality, self.setting()) {
            return Some(format!(
                "{style} has no measured levels, so it is drawn as set. Measure them with hachure bench --sweep, then \
                 start hachure fly --quality draft --front front-{style}.toml."
            ));
        }
        let left_out = match self.drawn.as_ref().map_or(0, |drawn| drawn.left_out) {
            0 => "",
            _ => " This style lacks some of the measured values.",
        };
        let Quality::Budget(budget_ms) = quality else {
            return self.given_up(scale, lod_error_px).map(|words| format!("{words}.{left_out}"));
        };
        let now = self.given_up(scale, lod_error_px).unwrap_or_else(|| "as set".to_owned());
        let held = self.tally.share().map(|share| format!("; {:.1} % of frames within {budget_ms} ms", 100.0 * share));
        let held = held.unwrap_or_default();
        let limit = match self.governor.as_ref().and_then(Governor::limit) {
            Some(Limit::Cheapest) => " The cheapest setting takes longer.",
            Some(Limit::Processor) => " The processor is the limit: a lower resolution would not help.",
            None => "",
        };
        let unmeasured =
            if self.is_measured { "" } else { " This style has no measurements, so only the resolution changes." };
        Some(format!("Now {now}{held}.{limit}{unmeasured}{left_out}"))
    }

    /// Returns a line about the governor for `--frames`; `None` without one. The arguments are those of
    /// [`Ladder::given_up`].
    pub(crate) fn report(&self, scale: f64, lod_error_px: f64) -> Option<String> {
        self.governor.as_ref()?;
        let Some((_, Quality::Budget(budget_ms))) = self.of else { return None };
        let (Tally { frames, held, .. }, changes) = (self.tally, self.changes);
        let words = self.given_up(scale, lod_error_px).unwrap_or_else(|| "as set".to_owned());
        let changes = if changes == 1 { "1 change".to_owned() } else { format!("{changes} changes") };
        Some(format!("{held} of {frames} frames within {budget_ms} ms, {changes}; at the end: {words}"))
    }
}

/// Returns the settings of a front for a governor, each with its cost relative to the style as it is. Settings that
/// cost more than the style are left out, since nobody has requested them, and so are settings that are dearer and less
/// exact than another.
fn monotonic(points: &[Point]) -> Vec<(f64, Setting)> {
    let has_lines = points.iter().any(|point| point.errors.contains_key(trade::LINES_LOST));
    let key = if has_lines { trade::LINES_LOST } else { trade::TONE_ERROR };
    let mut least = f64::INFINITY;
    let cheaper = points.iter().filter(|point| point.cost_ratio < CHEAPER);
    cheaper
        .filter(|point| {
            let error = point.errors.get(key).copied().unwrap_or(0.0);
            let is_better = error < least;
            least = least.min(error);
            is_better
        })
        .filter_map(|point| Some((point.cost_ratio, setting_of(point)?)))
        .collect()
}

/// Returns the setting of a point, if it is valid.
fn setting_of(point: &Point) -> Option<Setting> {
    point.setting().inspect_err(|error| tracing::warn!("a setting of the front is left out: {error}")).ok()
}

/// Returns a style with those of the values that are valid in it, and the number of the others.
fn with_values(style: &Style, values: &[SetValue]) -> (Style, usize) {
    let with = |style: &Style, values: &[SetValue]| -> Result<Style, StyleError> {
        let text = set::with_values(&style.name, &style.text(), style, values)?;
        Style::parse_with(&style.name, &text, &style.recipe_files())
    };
    if values.is_empty() {
        return (style.clone(), 0);
    }
    if let Ok(with) = with(style, values) {
        return (with, 0);
    }
    let (mut changed, mut left_out) = (style.clone(), 0);
    for value in values {
        match with(&changed, std::slice::from_ref(value)) {
            Ok(with) => changed = with,
            Err(error) => {
                tracing::debug!("{}: {error}", style.name);
                left_out += 1;
            }
        }
    }
    (changed, left_out)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    fn style(name: &str) -> Style {
        Style::load(name).unwrap()
    }

    /// Relative cost, values by their keys, and the share of lines that is lost.
    type Measured<'a> = (f64, &'a [(&'a str, &'a str)], f64);

    fn front(style: &str, points: &[Measured<'_>]) -> Front {
        let point = |(cost_ratio, set, lost): &Measured<'_>| Point {
            cost_ratio: *cost_ratio,
            set: set.iter().map(|(key, text)| ((*key).to_owned(), (*text).to_owned())).collect(),
            errors: [(trade::LINES_LOST.to_owned(), *lost)].into(),
            ..Point::default()
        };
        Front {
            style: style.to_owned(),
            points: points.iter().map(point).collect(),
            ..Front::parse("ink", FRONTS[0].1).unwrap()
        }
    }

    #[test]
    fn a_level_is_a_point_of_the_front() {
        let mut ladder = Ladder::default();
        ladder.follow("lsa", Quality::Level(Level::Draft));
        assert!(!ladder.is_governed());
        let scale = ladder.setting().unwrap().scale.unwrap();
        assert!(scale < 1.0);
        let ink = style("lsa");
        let drawn = ladder.applied(&ink, scale).into_owned();
        assert!(drawn != ink && drawn.name == "lsa");
        // A value that the front leaves as the style has it is not given up, and neither is a resolution that the user
        // has set lower.
        let lod_error_px = ladder.setting().unwrap().lod_error_px.unwrap();
        let words = format!("resolution {scale}, terrain error {lod_error_px} px.");
        assert_eq!(ladder.words(1.0, 0.5).unwrap(), words);
        assert_eq!(ladder.words(scale, lod_error_px), None);
        // A style without a front is drawn as it is, and the panel says so.
        ladder.follow("plain", Quality::Level(Level::Draft));
        assert!(ladder.setting().is_none() && ladder.words(1.0, 1.0).unwrap().contains("no measured levels"));
        assert_eq!(*ladder.applied(&style("plain"), 1.0), style("plain"));
        ladder.follow("lsa", Quality::AsSet);
        assert!(ladder.setting().is_none() && ladder.words(1.0, 1.0).is_none());
    }

    /// A flight whose frames take `full_ms` at full resolution.
    fn fly(ladder: &mut Ladder, now_s: &mut f64, seconds: f64, full_ms: f64) {
        let end_s = *now_s + seconds;
        while *now_s < end_s {
            *now_s += 0.016;
            let scale = ladder.setting().and_then(|setting| setting.scale).unwrap_or(1.0);
            ladder.record(ladder.tag(), *now_s, full_ms * assumed_cost(scale), 1.0);
        }
    }

    #[test]
    fn a_budget_moves_along_the_front_and_back() {
        for name in ["lsa", "pencil"] {
            let (mut ladder, mut now_s) = (Ladder::default(), 0.0);
            ladder.follow(name, Quality::Budget(10.0));
            assert!(ladder.given_up(1.0, 1.0).is_none(), "it begins with the style as it is");
            fly(&mut ladder, &mut now_s, 3.0, 5.0);
            assert!(ladder.given_up(1.0, 1.0).is_none(), "{name}");
            fly(&mut ladder, &mut now_s, 3.0, 13.0);
            assert!(ladder.given_up(1.0, 1.0).unwrap().contains("resolution"), "{name}");
            let words = ladder.words(1.0, 1.0).unwrap();
            assert!(words.contains("% of frames within 10 ms"), "{words}");
            assert_eq!(words.contains("no measurements"), name == "pencil");
            // A rest is drawn as the style is, and the flight goes on as before.
            assert!(ladder.waits_for_rest());
            let (flown, frames) = (ladder.tag(), ladder.tally.frames);
            ladder.rest(true);
            assert!(ladder.given_up(1.0, 1.0).is_none() && !ladder.waits_for_rest() && ladder.tag() != flown);
            (0..50).for_each(|_| _ = ladder.record(ladder.tag(), now_s, 99.0, 1.0));
            ladder.rest(false);
            assert_eq!((ladder.tag(), ladder.tally.frames), (flown, frames));
            fly(&mut ladder, &mut now_s, 20.0, 5.0);
            assert!(ladder.given_up(1.0, 1.0).is_none(), "{name}: {:?}", ladder.tally);
            // Another budget keeps the setting.
            fly(&mut ladder, &mut now_s, 3.0, 13.0);
            let flown = ladder.tag();
            ladder.follow(name, Quality::Budget(9.0));
            assert_eq!((ladder.tag(), ladder.tally.frames), (flown, 0), "{name}");
            // Planted: frames of another style's governor change nothing.
            ladder.follow("strokes", Quality::Budget(9.0));
            (0..50).for_each(|_| _ = ladder.record(flown, 100.0, 99.0, 1.0));
            assert!(ladder.given_up(1.0, 1.0).is_none() && ladder.tally.frames == 0, "{name}");
        }
    }

    #[test]
    fn what_cannot_be_held_is_said() {
        let (mut ladder, mut now_s) = (Ladder::default(), 0.0);
        ladder.follow("pencil", Quality::Budget(10.0));
        fly(&mut ladder, &mut now_s, 3.0, 60.0);
        assert!(ladder.words(1.0, 1.0).unwrap().contains("cheapest setting takes longer"));
        for _ in 0..20 {
            now_s += 0.03;
            ladder.record(ladder.tag(), now_s, 3.0, 30.0);
        }
        assert!(ladder.words(1.0, 1.0).unwrap().contains("processor is the limit"));
        fly(&mut ladder, &mut now_s, 5.0, 3.0);
        let words = ladder.words(1.0, 1.0).unwrap();
        assert!(!words.contains("limit") && !words.contains("cheapest"), "{words}");
    }

    #[test]
    fn a_dearer_setting_is_no_worse() {
        let points: &[Measured<'_>] = &[
            (0.3, &[("scale", "0.5")], 6.0),
            (0.5, &[("lod-error", "8")], 7.0),
            (0.6, &[("scale", "0.75")], 2.0),
            (0.99, &[("lod-error", "0.9")], 0.5),
            (1.2, &[("lod-error", "0.5")], 0.1),
        ];
        let mut ladder = Ladder::with_fronts(vec![front("plain", points)]);
        ladder.follow("plain", Quality::Budget(10.0));
        let scales: Vec<_> = ladder.settings.iter().map(|setting| setting.scale).collect();
        assert_eq!(scales, [Some(0.5), Some(0.75), None]);
    }

    #[test]
    fn a_value_of_a_section_that_is_gone_is_left_out() {
        let points: &[Measured<'_>] = &[(0.5, &[("strokes.resolution", "0.5"), ("paper.grain", "0.5")], 1.0)];
        let mut front = front("plain", points);
        front.points[0].levels = vec![Level::Draft];
        let mut ladder = Ladder::with_fronts(vec![front]);
        ladder.follow("plain", Quality::Level(Level::Draft));
        let plain = style("plain");
        let drawn = ladder.applied(&plain, 1.0).into_owned();
        assert_eq!(drawn.paper.grain, 0.5, "the other value is there");
        assert!(ladder.words(1.0, 1.0).unwrap().contains("lacks some"));
    }
}
