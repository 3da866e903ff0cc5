//! The trade of speed for exactness: the settings of a style that were measured, their costs and errors, and their front.

use std::collections::BTreeMap;

use super::front;
use super::report::{Metrics, Report, Run};

/// A column of the trade: heading, key, value, and the least difference that counts when settings are compared.
struct Column {
    head: &'static str,
    /// Key of the column in files, with the unit.
    key: &'static str,
    value: fn(&Run) -> Option<f64>,
    /// Smallest difference that counts; `None` if settings are not compared by this column.
    least: Option<f64>,
}

/// Key of the sweep that changes the size of the picture.
pub(crate) const SCALE: &str = "scale";
/// Keys of errors in files.
pub(crate) const LINES_LOST: &str = "lines_lost_percent";
pub(crate) const TONE_ERROR: &str = "tone_error_percent";
const FLICKER: &str = "flicker_percent";

/// The errors that are compared, of which less is better.
const ERRORS: [Column; 6] = [
    Column {
        head: "lines lost %",
        key: LINES_LOST,
        value: |run| Some(100.0 * (1.0 - exactness(run, "line_recall")?)),
        least: Some(0.05),
    },
    Column {
        head: "lines added %",
        key: "lines_added_percent",
        value: |run| Some(100.0 * (1.0 - exactness(run, "line_precision")?)),
        least: Some(0.05),
    },
    Column {
        head: "tone error %",
        key: TONE_ERROR,
        value: |run| Some(100.0 * exactness(run, "tone_error")?),
        least: Some(0.02),
    },
    Column {
        head: "surface error px",
        key: "surface_error_px",
        value: |run| exactness(run, "surface_error_px"),
        least: Some(0.05),
    },
    // The visible difference of lines and tones together; it says less about each than the errors above.
    Column { head: "FLIP %", key: "flip_percent", value: |run| Some(100.0 * exactness(run, "flip")?), least: None },
    Column {
        head: "flicker %",
        key: FLICKER,
        value: |run| Some(100.0 * metric(run.temporal.as_ref(), "flicker")?),
        least: Some(0.05),
    },
];

/// The measure of a frame's cost on the front.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cost {
    /// Median GPU time, in milliseconds.
    GpuMs,
    /// Bytes that the passes read and write, in gigabytes: the time of a software driver says nothing about a GPU.
    Gigabytes,
}

impl Cost {
    /// Heading of its column.
    pub(crate) fn head(self) -> &'static str {
        match self {
            Self::GpuMs => "GPU ms",
            Self::Gigabytes => "GB moved",
        }
    }

    /// Returns the cost of a run; `None` if it was not measured.
    pub(crate) fn of(self, run: &Run) -> Option<f64> {
        match self {
            Self::GpuMs => run.busy.as_ref().map(|busy| busy.gpu_ms.p50).or(run.gpu_ms.map(|gpu_ms| gpu_ms.p50)),
            Self::Gigabytes => {
                let bytes = run.flight_bytes.or(run.work.map(|work| work.bytes()));
                bytes.map(|bytes| bytes as f64 / 1e9)
            }
        }
    }
}

/// The runs of one style with different settings. The first has the style as it is.
pub(crate) struct Trade<'a> {
    pub runs: Vec<&'a Run>,
    pub cost: Cost,
}

/// A table: its headings, and the cells of each row.
pub(crate) type Table = (Vec<String>, Vec<Vec<String>>);

impl<'a> Trade<'a> {
    /// Returns the styles of a report that were drawn with several settings.
    pub(crate) fn all(report: &'a Report) -> Vec<Self> {
        // A GPU without timestamp queries has no times.
        let has_times = report.runs.iter().all(|run| Cost::GpuMs.of(run).is_some());
        let cost = if report.is_software || !has_times { Cost::Gigabytes } else { Cost::GpuMs };
        styles(&report.runs)
            .map(|runs| Self { runs: runs.iter().collect(), cost })
            .filter(|trade| trade.runs.len() > 1)
            .collect()
    }

    /// Returns whether each setting is on the front of cost and errors. An error that was not measured for any of them,
    /// such as that of lines in a style without lines, does not count.
    pub(crate) fn on_front(&self) -> Vec<bool> {
        let columns: Vec<&Column> = self.columns().filter(|column| column.least.is_some()).collect();
        let point = |run: &&Run| {
            std::iter::once(self.cost.of(run)).chain(columns.iter().map(|column| (column.value)(run))).collect()
        };
        let points: Vec<Vec<Option<f64>>> = self.runs.iter().map(point).collect();
        let least: Vec<f64> = std::iter::once(0.0).chain(columns.iter().filter_map(|column| column.least)).collect();
        front::on_front(&points, &least)
    }

    /// Returns the errors that the settings are compared by. Flicker is measured within a reach of pixels, so that of
    /// pictures of different sizes is not compared.
    fn columns(&self) -> impl Iterator<Item = &'static Column> {
        let has_scales = self.runs.iter().any(|run| run.setting.contains_key(SCALE));
        ERRORS
            .iter()
            .filter(move |column| !(has_scales && column.key == FLICKER))
            .filter(|column| self.runs.iter().any(|run| (column.value)(run).is_some()))
    }

    /// Returns the settings as a table, with the cost relative to the first of them, and `front` where one is on it.
    pub(crate) fn table(&self) -> Table {
        let columns: Vec<&Column> = self.columns().collect();
        let first = self.runs.first().and_then(|run| self.cost.of(run));
        let heads =
            ["setting", self.cost.head(), "÷ first"].into_iter().chain(columns.iter().map(|column| column.head));
        let heads = heads.chain(["front"]).map(str::to_owned).collect();
        let number =
            |value: Option<f64>, decimals: usize| value.map_or("–".to_owned(), |value| format!("{value:.decimals$}"));
        let rows = self.runs.iter().zip(self.on_front()).map(|(run, is_on_front)| {
            let cost = self.cost.of(run);
            let ratio = cost.zip(first).map(|(cost, first)| cost / first);
            let errors = columns.iter().map(|column| number((column.value)(run), 2));
            [setting_words(run), number(cost, 3), number(ratio, 3)]
                .into_iter()
                .chain(errors)
                .chain([if is_on_front { "front" } else { "" }.to_owned()])
                .collect()
        });
        (heads, rows.collect())
    }
}

/// Returns the errors of a run that were measured, by their keys.
pub(crate) fn errors(run: &Run) -> BTreeMap<String, f64> {
    ERRORS.iter().filter_map(|column| Some((column.key.to_owned(), (column.value)(run)?))).collect()
}

/// Returns the setting of a run in words.
pub(crate) fn setting_words(run: &Run) -> String {
    if run.setting.is_empty() {
        return format!("{} as it is", run.style);
    }
    run.setting.iter().map(|(key, value)| format!("{key}={value}")).collect::<Vec<_>>().join(" ")
}

/// Fills in for each run of a report whether it is on the front of its style.
pub(crate) fn fill(report: &mut Report) {
    let mut fronts = Trade::all(report).iter().map(Trade::on_front).collect::<Vec<_>>().into_iter();
    report.runs.iter_mut().for_each(|run| run.is_on_front = None);
    for runs in report.runs.chunk_by_mut(is_setting).filter(|runs| runs.len() > 1) {
        for (run, is_on_front) in runs.iter_mut().zip(fronts.next().unwrap_or_default()) {
            run.is_on_front = Some(is_on_front);
        }
    }
}

/// Returns the runs of each style: as it is, and with its settings.
fn styles(runs: &[Run]) -> impl Iterator<Item = &[Run]> {
    runs.chunk_by(is_setting)
}

/// Returns whether a run is a setting of the style before it.
fn is_setting(_: &Run, run: &Run) -> bool {
    !run.setting.is_empty()
}

fn exactness(run: &Run, name: &str) -> Option<f64> {
    metric(run.exactness.as_ref(), name)
}

fn metric(metrics: Option<&Metrics>, name: &str) -> Option<f64> {
    *metrics?.get(name)?
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::work::FrameWork;

    fn run(name: &str, gigabytes: f64, recall: f64) -> Run {
        let setting = name.split_once(' ').and_then(|(_, setting)| setting.split_once('='));
        let metrics = [("line_recall", recall), ("line_precision", 1.0), ("tone_error", 0.01)];
        Run {
            style: name.to_owned(),
            setting: setting.map(|(key, value)| (key.to_owned(), value.to_owned())).into_iter().collect(),
            work: Some(FrameWork { bytes_read: (gigabytes * 1e9) as u64, ..FrameWork::default() }),
            exactness: Some(metrics.map(|(name, value)| (name.to_owned(), Some(value))).into()),
            ..Run::default()
        }
    }

    #[test]
    fn each_style_has_its_own_front() {
        let runs = vec![
            run("ink", 1.0, 0.99),
            run("ink lod-error=4", 0.5, 0.9),
            // Planted: dearer than the style as it is, and less exact.
            run("ink lod-error=2", 1.2, 0.95),
            // The same style again: each has its own settings.
            run("ink", 3.0, 0.99),
            run("ink lod-error=4", 2.0, 0.99),
        ];
        let mut report = Report { is_software: true, runs, ..Report::default() };
        fill(&mut report);
        let front: Vec<Option<bool>> = report.runs.iter().map(|run| run.is_on_front).collect();
        assert_eq!(front, [true, true, false, false, true].map(Some));
        let (heads, rows) = Trade::all(&report)[0].table();
        assert!(heads.contains(&"lines lost %".to_owned()) && !heads.contains(&"flicker %".to_owned()), "{heads:?}");
        assert_eq!(rows[1], ["lod-error=4", "0.500", "0.500", "10.00", "0.00", "1.00", "front"].map(str::to_owned));
        // Without sweeps there is no trade.
        report.runs.retain(|run| run.setting.is_empty());
        fill(&mut report);
        assert!(report.runs.iter().all(|run| run.is_on_front.is_none()) && Trade::all(&report).is_empty());
    }
}
