//! Quality: the measured front of a style, from draft to exact, as a file.
//!
//! `bench --sweep` writes the file, and `--quality` draws with one of its points.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::report::{Report, Run};
use super::setting::{Setting, TILE_ERROR};
use super::trade::{self, Trade};
use crate::file::FileError;
use crate::file::atomic;
use crate::file::toml_text;
use crate::file::unnamed::head;

/// Begins every file.
const MARK: &str = "# A measured front of hachure bench --sweep";

/// Least line recall of `balanced`, relative to that of `exact`.
const BALANCED_RECALL: f64 = 0.98;
/// Largest tone error of `balanced` beyond that of `exact`, as a share of the range from black to white.
const BALANCED_TONE: f64 = 0.01;

/// The measured front of a style.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Front {
    /// Name of the style.
    pub style: String,
    /// The GPU that measured it, and its driver.
    pub adapter: String,
    /// Width and height of the pictures.
    pub size: [u32; 2],
    /// World, path, frames and allowed error of the benchmark.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub measured: String,
    /// Quantity and unit of the costs, as in the heading of the column: "GPU ms".
    pub cost: String,
    /// The settings on the front, from the cheapest to the most expensive.
    pub points: Vec<Point>,
}

/// A setting on the front.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Point {
    /// Whether it is the point for `draft`, `balanced` or `exact`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub levels: Vec<Level>,
    /// Cost of a frame, in the unit of [`Front::cost`].
    pub cost: f64,
    /// Cost relative to the style as it is.
    pub cost_ratio: f64,
    /// The values of the setting by their keys, those of `--sweep`.
    #[serde(default)]
    pub set: BTreeMap<String, String>,
    /// Errors against a converged reference, by the key of their column in a report.
    pub errors: BTreeMap<String, f64>,
}

impl Point {
    /// Returns the setting.
    ///
    /// # Errors
    /// The errors of [`Setting::of`].
    pub(crate) fn setting(&self) -> Result<Setting, String> {
        let setting = Setting::of(self.set.iter().map(|(key, text)| (key.as_str(), text.as_str())))?;
        Ok(Setting { tile_error_m: None, ..setting })
    }
}

/// A named point on the front.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Level {
    /// The cheapest setting.
    Draft,
    /// The cheapest setting with at least 98 % of the lines of the exact one, and tones as exact within one percentage point.
    Balanced,
    /// The setting that loses fewest lines, or the one with the smallest error of tones in a style without lines.
    Exact,
}

impl Level {
    pub(crate) const ALL: [Self; 3] = [Self::Draft, Self::Balanced, Self::Exact];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Balanced => "balanced",
            Self::Exact => "exact",
        }
    }
}

impl Front {
    /// Returns the fronts of all styles of a report that were measured with several settings.
    pub(crate) fn all(report: &Report) -> Vec<Self> {
        Trade::all(report).iter().filter_map(|trade| Self::of(report, trade)).collect()
    }

    fn of(report: &Report, trade: &Trade<'_>) -> Option<Self> {
        let first = trade.runs.first()?;
        let as_it_is = trade.cost.of(first)?;
        // Rounded heights save a frame nothing.
        let is_rounded = |run: &Run| run.setting.get(TILE_ERROR).is_some_and(|error_m| error_m.parse() != Ok(0.0));
        let on_front = trade.runs.iter().zip(trade.on_front());
        let on_front = on_front.filter(|(run, is_on_front)| *is_on_front && !is_rounded(run));
        let mut runs: Vec<(f64, &Run)> = on_front.filter_map(|(run, _)| Some((trade.cost.of(run)?, *run))).collect();
        runs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut points: Vec<Point> = runs
            .iter()
            .map(|(cost, run)| Point {
                levels: Vec::new(),
                cost: *cost,
                cost_ratio: cost / as_it_is,
                set: effective(report, run),
                errors: trade::errors(run),
            })
            .collect();
        name(&mut points);
        (!points.is_empty()).then(|| Self {
            style: first.style.clone(),
            adapter: report.adapter.clone(),
            size: report.size_px,
            measured: report.settings.as_ref().map_or_else(String::new, |settings| settings.sentence()),
            cost: trade.cost.head().to_owned(),
            points,
        })
    }

    /// Returns the front of pictures of full size: without points of another render scale, and with levels among the
    /// others.
    pub(crate) fn at_full_size(&self) -> Self {
        let is_full = |point: &&Point| point.set.get(trade::SCALE).is_none_or(|scale| scale.parse() == Ok(1.0));
        let mut points: Vec<Point> = self.points.iter().filter(is_full).cloned().collect();
        points.iter_mut().for_each(|point| point.levels.clear());
        name(&mut points);
        Self { points, ..self.clone() }
    }

    /// Returns the point of a level.
    pub(crate) fn point(&self, level: Level) -> Option<&Point> {
        self.points.iter().find(|point| point.levels.contains(&level))
    }

    /// Returns the name of the front's file.
    pub(crate) fn file_name(&self) -> String {
        file_name(&self.style)
    }

    /// Parses a file; errors begin with `name`. Whether the style has the values of the settings is not checked.
    ///
    /// # Errors
    /// The defect of the text, in one line.
    pub(crate) fn parse(name: &str, text: &str) -> Result<Self, String> {
        let front: Self = toml_text::read(name, text).map_err(|error| error.to_string())?;
        // Settings are compared by their errors, so each must have all of them.
        let known: BTreeSet<&String> = front.points.iter().flat_map(|point| point.errors.keys()).collect();
        if known.is_empty() {
            return Err(format!("{name}: its points have no errors, by which settings are chosen"));
        }
        for (number, point) in (1..).zip(&front.points) {
            if let Some(key) = known.iter().find(|key| !point.errors.contains_key(**key)) {
                return Err(format!("{name}: point {number}: {key} is missing in its errors, and others have it"));
            }
            point.setting().map_err(|error| format!("{name}: point {number}: {error}"))?;
        }
        Ok(front)
    }

    /// Writes the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(crate) fn write(&self, path: &Path) -> Result<(), FileError> {
        let text = toml::to_string(self).unwrap_or_else(|error| unreachable!("{error}"));
        let text = format!("{MARK}: --quality draws with one of its points.\n\n{text}");
        atomic::write(path, text.as_bytes()).map_err(|error| FileError::write(path, error))
    }

    /// Returns whether the file at `path` is a front that hachure wrote.
    pub(crate) fn is_own(path: &Path) -> bool {
        head(path, MARK.len()) == MARK.as_bytes()
    }
}

/// Returns the values of a run's setting, with the options of the benchmark that the setting does not change.
fn effective(report: &Report, run: &Run) -> BTreeMap<String, String> {
    let error_px = report.settings.as_ref().map(|settings| ("lod-error", settings.lod_error_px.to_string()));
    let antialias = Some(("antialias", run.antialias.clone())).filter(|(_, antialias)| !antialias.is_empty());
    let options = error_px.into_iter().chain(antialias).map(|(key, value)| (key.to_owned(), value));
    options.chain(run.setting.clone()).filter(|(key, _)| key != TILE_ERROR).collect()
}

/// Returns the name of the file for the front of a style.
pub(crate) fn file_name(style: &str) -> String {
    let name: String = style.chars().map(|it| if it.is_ascii_alphanumeric() || it == '_' { it } else { '-' }).collect();
    format!("front-{name}.toml")
}

/// Gives the levels to points, which are in the order of their costs.
fn name(points: &mut [Point]) {
    let error = |point: &Point, key: &str| point.errors.get(key).copied();
    // A style without lines is judged by its tones.
    let lost = |point: &Point| error(point, trade::LINES_LOST);
    let tone = |point: &Point| error(point, trade::TONE_ERROR).unwrap_or(0.0);
    let by_errors = |point: &Point| [lost(point).unwrap_or(0.0), tone(point)];
    let Some(exact) = (0..points.len()).min_by(|a, b| {
        let [a, b] = [*a, *b].map(|index| by_errors(&points[index]));
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
    }) else {
        return;
    };
    let recall = |point: &Point| 1.0 - lost(point).unwrap_or(0.0) / 100.0;
    let (least_recall, largest_tone) =
        (BALANCED_RECALL * recall(&points[exact]), tone(&points[exact]) + 100.0 * BALANCED_TONE);
    let is_good = |point: &Point| recall(point) >= least_recall && tone(point) <= largest_tone;
    let balanced = points.iter().position(is_good).unwrap_or(exact);
    for (level, index) in Level::ALL.into_iter().zip([0, balanced, exact]) {
        points[index].levels.push(level);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::measure::work::FrameWork;

    fn run(setting: &str, gigabytes: f64, recall: f64, tone: f64) -> Run {
        let metrics = [("line_recall", recall), ("line_precision", 1.0), ("tone_error", tone)];
        Run {
            style: format!("ink {setting}").trim().to_owned(),
            setting: setting
                .split_once('=')
                .map(|(key, value)| (key.to_owned(), value.to_owned()))
                .into_iter()
                .collect(),
            work: Some(FrameWork { bytes_read: (gigabytes * 1e9) as u64, ..FrameWork::default() }),
            exactness: Some(metrics.map(|(name, value)| (name.to_owned(), Some(value))).into()),
            ..Run::default()
        }
    }

    fn front() -> Front {
        let runs = vec![
            run("", 1.0, 0.99, 0.004),
            run("lod-error=0.5", 2.0, 0.999, 0.001),
            run("lod-error=2", 0.8, 0.985, 0.006),
            // Lines as good, tones not.
            run("lod-error=4", 0.7, 0.984, 0.02),
            run("lod-error=16", 0.4, 0.6, 0.08),
            // Planted: dearer than the style as it is, and less exact.
            run("lod-error=3", 1.5, 0.9, 0.01),
        ];
        let report = Report { is_software: true, size_px: [64, 36], runs, ..Report::default() };
        Front::all(&report).remove(0)
    }

    #[test]
    fn levels_are_points_of_the_front() {
        let front = front();
        assert_eq!((front.style.as_str(), front.cost.as_str(), front.points.len()), ("ink", "GB moved", 5));
        assert!(front.points.iter().all(|point| point.set.get("lod-error").is_none_or(|error| error != "3")));
        let set = |level| front.point(level).unwrap().set.get("lod-error").map(String::as_str);
        assert_eq!(Level::ALL.map(set), [Some("16"), Some("2"), Some("0.5")]);
        assert_eq!(front.point(Level::Draft).unwrap().cost_ratio, 0.4);
        assert_eq!(front.points[3].set.len(), 0);
    }

    #[test]
    fn pictures_of_full_size_have_levels_of_their_own() {
        let mut front = front();
        front.points[0].set.insert("scale".to_owned(), "0.5".to_owned());
        front.points[1].set.insert("scale".to_owned(), "1".to_owned());
        let full = front.at_full_size();
        assert_eq!(full.points.len(), 4);
        assert_eq!(full.point(Level::Draft).unwrap().set.get("lod-error").map(String::as_str), Some("4"));
    }

    #[test]
    fn options_that_no_sweep_changes_are_in_every_point() {
        let runs = vec![run("", 1.0, 0.9, 0.0), run("scale=2", 4.0, 1.0, 0.0), run("lod-error=2", 0.5, 0.8, 0.0)];
        let settings = crate::measure::settings::Settings { lod_error_px: 4.0, ..Default::default() };
        let front =
            Front::all(&Report { is_software: true, runs, settings: Some(settings), ..Report::default() }).remove(0);
        let errors: Vec<&str> = front.points.iter().map(|point| point.set["lod-error"].as_str()).collect();
        assert_eq!(errors, ["2", "4", "4"]);
    }

    #[test]
    fn one_point_may_have_all_levels() {
        let report = Report {
            is_software: true,
            runs: vec![run("", 1.0, 1.0, 0.0), run("scale=2", 4.0, 1.0, 0.0)],
            ..Report::default()
        };
        let front = Front::all(&report).remove(0);
        assert_eq!(front.points[0].levels, Level::ALL);
        // A report without sweeps has no front.
        assert!(Front::all(&Report { runs: vec![run("", 1.0, 1.0, 0.0)], ..Report::default() }).is_empty());
    }

    #[test]
    fn a_front_is_written_and_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(front().file_name());
        front().write(&path).unwrap();
        assert!(Front::is_own(&path) && path.ends_with("front-ink.toml"));
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(Front::parse("front-ink.toml", &text).unwrap(), front(), "{text}");
        // Planted: another key, and a file of somebody else.
        let wrong = text.replacen("cost_ratio", "cost_ration", 1);
        assert!(Front::parse("front-ink.toml", &wrong).unwrap_err().contains("cost_ration"));
        // Settings without errors cannot be chosen among.
        let error = |text: String| Front::parse("front-ink.toml", &text).unwrap_err();
        let lines = || text.lines().filter(|line| !line.starts_with("lines_lost_percent"));
        assert!(error(text.replacen("lines_lost_percent", "lines_percent", 1)).contains("is missing in its errors"));
        assert!(Front::parse("front-ink.toml", &lines().collect::<Vec<_>>().join("\n")).is_ok());
        let none = lines().filter(|line| !line.contains("_percent")).collect::<Vec<_>>().join("\n");
        assert!(error(none).contains("no errors"));
        assert!(error(text.replacen("lod-error", "lod_error", 1)).contains("did you mean \"lod-error\""));
        atomic::write(&path, b"style = 1").unwrap();
        assert!(!Front::is_own(&path));
        assert_eq!(file_name("my style/2"), "front-my-style-2.toml");
    }
}
