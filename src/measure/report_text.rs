//! The report for a terminal: a row for each run, with its ratio to the first run; warnings; the work of a frame on any
//! GPU; hit rates; a table of steadiness; and what changed since an earlier report.

use std::collections::BTreeSet;

use super::comparison::{Change, Comparison};
use super::report::{Report, Run};
use super::trade::Trade;
use super::work::{CacheUse, FrameWork, cache_label, percent};

/// Headings of the columns.
const HEADS: [&str; 12] = [
    "style",
    "frames",
    "frame ms p50",
    "p95",
    "p99",
    "frame ÷ first",
    "GPU ms p50",
    "GPU ÷ first",
    "height error px max",
    "triangles",
    "strokes",
    "late frames",
];

/// Columns of steadiness: heading, name of the metric, factor, decimals.
const STEADINESS: [(&str, &str, f64, usize); 12] = [
    ("pairs", "pairs", 1.0, 0),
    ("lines %", "line_coverage", 100.0, 2),
    ("flicker %", "flicker", 100.0, 2),
    ("updates %", "flicker_updates", 100.0, 2),
    ("between %", "flicker_between", 100.0, 2),
    ("by ink %", "flicker_ink", 100.0, 2),
    ("births/frame", "births_per_frame", 1.0, 2),
    ("deaths/frame", "deaths_per_frame", 1.0, 2),
    ("identity %", "identity_change", 100.0, 2),
    ("slip px p50", "slip_px_p50", 1.0, 2),
    ("p95", "slip_px_p95", 1.0, 2),
    ("E_warp ×1e-6", "e_warp", 1e6, 1),
];

/// A column of the work of a frame: heading, value, decimals.
type WorkColumn = (&'static str, fn(FrameWork) -> f64, usize);
/// A column of a run.
type RunColumn = (&'static str, fn(&Run) -> Option<f64>, usize);

/// Columns of the work that a frame gives the GPU.
const WORK: [WorkColumn; 7] = [
    ("GB read", |work| work.bytes_read as f64 / 1e9, 3),
    ("GB written", |work| work.bytes_written as f64 / 1e9, 3),
    ("wgpu passes", |work| work.wgpu_passes as f64, 0),
    ("dispatches", |work| work.dispatches as f64, 0),
    ("draws", |work| work.draws as f64, 0),
    ("copies", |work| work.copies as f64, 0),
    ("barriers", |work| work.barriers as f64, 0),
];

/// The memory that a frame binds.
const MEMORY: RunColumn = ("MB of memory", |run| Some(run.memory.drawing_bytes? as f64 / 1e6), 1);

/// Columns of the last frames, drawn again without a timer around each pass and without a pause, and of the first frame.
const AGAIN: [RunColumn; 8] = [
    ("prepare ms", |run| Some(run.untimed?.prepare_ms), 3),
    ("record ms", |run| Some(run.untimed?.record_ms), 3),
    ("submit ms", |run| Some(run.untimed?.submit_ms), 3),
    ("latency ms", |run| Some(run.untimed?.latency_ms.p50), 2),
    ("throughput ms", |run| Some(run.untimed?.throughput_ms), 2),
    ("busy GPU ms", |run| Some(run.busy.as_ref()?.gpu_ms.p50), 3),
    ("pipelines", |run| Some(run.start?.pipelines as f64), 0),
    ("compile s", |run| Some(run.start?.compile_ms / 1000.0), 2),
];

/// Returns the table of the work of frames on any GPU; empty if nothing was measured.
fn work(report: &Report) -> String {
    if report.runs.iter().all(|run| run.work.is_none() && run.untimed.is_none()) {
        return String::new();
    }
    let heads = std::iter::once("style".to_owned())
        .chain(WORK.iter().map(|(head, ..)| (*head).to_owned()))
        .chain([MEMORY].iter().chain(&AGAIN).map(|(head, ..)| (*head).to_owned()));
    let rows = report.runs.iter().map(|run| {
        let of_work = WORK.iter().map(|(_, value, decimals)| number(run.work.map(value), *decimals));
        let again = [MEMORY].into_iter().chain(AGAIN).map(|(_, value, decimals)| number(value(run), decimals));
        std::iter::once(run.style.clone()).chain(of_work).chain(again).collect()
    });
    format!("\n{}", columns(std::iter::once(heads.collect()).chain(rows).collect()))
}

/// Returns the table of the hit rates of caches; empty if there are none.
fn hit_rates(report: &Report) -> String {
    let caches: BTreeSet<&String> = report.runs.iter().flat_map(|run| run.caches.keys()).collect();
    if caches.is_empty() {
        return String::new();
    }
    let heads = std::iter::once("style, hit rates %".to_owned()).chain(caches.iter().map(|name| cache_label(name)));
    let rows = report.runs.iter().map(|run| {
        let rate = |name: &&String| run.caches.get(*name).and_then(CacheUse::hit_rate);
        let rates = caches.iter().map(|name| rate(name).map_or("–".to_owned(), percent));
        std::iter::once(run.style.clone()).chain(rates).collect()
    });
    format!("\n{}", columns(std::iter::once(heads.collect()).chain(rows).collect()))
}

/// Returns what changed since an earlier report: a line for each figure, the worse ones first.
fn changes(comparison: &Comparison) -> String {
    let mut text = format!("\ncompared with {}\n", comparison.with);
    text.extend(comparison.notes.iter().map(|note| format!("{note}\n")));
    let row = |word: &str, change: &Change| {
        let Change { style, eyes, figure, old, new, .. } = change;
        let [old, new] = [*old, *new].map(|value| number(Some(value), if value.fract() == 0.0 { 0 } else { 3 }));
        [word, style, eyes, figure, &old, &new, &change.percent()].map(str::to_owned).to_vec()
    };
    let worse = comparison.worse.iter().map(|change| row("worse", change));
    let rows: Vec<_> = worse.chain(comparison.better.iter().map(|change| row("better", change))).collect();
    if !rows.is_empty() {
        let heads = ["", "style", "eyes", "figure", "old", "new", "change ± 2 standard errors"].map(str::to_owned);
        text += &columns(std::iter::once(heads.to_vec()).chain(rows).collect());
    }
    text + &comparison.unchanged().map_or_else(String::new, |sentence| sentence + "\n")
}

/// Returns the tables: the cost of frames; their steadiness, if it was measured; and the changes, if there is an
/// earlier report. A dash (–) marks values that were not measured.
pub(crate) fn table(report: &Report) -> String {
    let changes = report.comparison.as_ref().map_or_else(String::new, changes);
    measured(report) + &changes
}

fn measured(report: &Report) -> String {
    let first = report.runs.first();
    let rows = report.runs.iter().map(|run| row(run, first.unwrap_or(run)).to_vec());
    let mut costs = columns(std::iter::once(HEADS.map(str::to_owned).to_vec()).chain(rows).collect());
    costs.extend(report.warnings().into_iter().map(|line| line + "\n"));
    for run in &report.runs {
        costs.extend(run.governed.as_ref().map(|governed| format!("{}: {}\n", run.style, governed.text())));
    }
    for trade in Trade::all(report) {
        let (heads, rows) = trade.table();
        costs += &format!("\n{}", columns(std::iter::once(heads).chain(rows).collect()));
    }
    costs += &work(report);
    costs += &hit_rates(report);
    if report.runs.iter().all(|run| run.temporal.is_none()) {
        return costs;
    }
    let heads = std::iter::once("style").chain(STEADINESS.map(|(head, ..)| head)).map(str::to_owned).collect();
    let rows = report.runs.iter().map(|run| {
        let value = |name| run.temporal.as_ref().and_then(|metrics| *metrics.get(name)?);
        let cells = STEADINESS
            .map(|(_, name, factor, decimals)| number(value(name).map(|value: f64| value * factor), decimals));
        std::iter::once(run.style.clone()).chain(cells).collect()
    });
    format!("{costs}\n{}", columns(std::iter::once(heads).chain(rows).collect()))
}

/// Formats rows of equal length as a table; the first column is left-aligned, the others right-aligned.
pub(super) fn columns(rows: Vec<Vec<String>>) -> String {
    let widest = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..rows.first().map_or(0, Vec::len)).map(widest).collect();
    let lines = rows.iter().map(|row| {
        let cells = row.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| match column {
            0 => format!("{cell:<width$}"),
            _ => format!("{cell:>width$}"),
        });
        cells.collect::<Vec<_>>().join("  ") + "\n"
    });
    lines.collect()
}

fn row(run: &Run, first: &Run) -> [String; 12] {
    let frame_ms = |run: &Run| run.frame_ms.map(|ms| ms.p50);
    let gpu_ms = |run: &Run| run.gpu_ms.map(|ms| ms.p50);
    [
        run.style.clone(),
        run.frames.to_string(),
        number(frame_ms(run), 2),
        number(run.frame_ms.map(|ms| ms.p95), 2),
        number(run.frame_ms.map(|ms| ms.p99), 2),
        number(ratio(frame_ms(run), frame_ms(first)), 2),
        number(gpu_ms(run), 3),
        number(ratio(gpu_ms(run), gpu_ms(first)), 2),
        number(run.lod_error_px.map(|px| px.max), 2),
        number(run.triangles.map(|count| count as f64), 0),
        number(run.strokes.map(|count| count as f64), 0),
        number(run.tiles.late_frames.map(|count| count as f64), 0),
    ]
}

fn ratio(of: Option<f64>, to: Option<f64>) -> Option<f64> {
    Some(of? / to.filter(|to| *to > 0.0)?)
}

fn number(value: Option<f64>, decimals: usize) -> String {
    value.map_or("–".to_owned(), |value| format!("{value:.decimals$}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lines::strokes::LeftOut;
    use crate::measure::report::{Memory, TileCounts};
    use crate::measure::statistics::Percentiles;
    use crate::measure::work::{BusyGpu, Untimed};

    fn run(style: &str, p50: Option<f64>) -> Run {
        let frame_ms = p50.map(|p50| Percentiles { p50, p95: 2.0 * p50, p99: 3.0 * p50, max: 4.0 * p50 });
        Run { style: style.to_owned(), frames: 7, frame_ms, tiles: TileCounts::default(), ..Run::default() }
    }

    #[test]
    fn ratios_are_to_the_first_run() {
        let report = Report {
            runs: vec![run("ink", Some(2.0)), run("plain", Some(5.0)), run("unmeasured", None)],
            ..Report::default()
        };
        let table = table(&report);
        let cells: Vec<Vec<&str>> = table.lines().skip(1).map(|line| line.split_whitespace().collect()).collect();
        assert_eq!(cells[0], ["ink", "7", "2.00", "4.00", "6.00", "1.00", "–", "–", "–", "–", "–", "–"]);
        assert_eq!(cells[1][..6], ["plain", "7", "5.00", "10.00", "15.00", "2.50"]);
        assert_eq!(cells[2][..6], ["unmeasured", "7", "–", "–", "–", "–"]);
        let widths: Vec<usize> = table.lines().map(|line| line.chars().count()).collect();
        assert!(widths.iter().all(|width| *width == widths[0]), "{table}");
    }

    #[test]
    fn strokes_without_room_have_a_line() {
        let with = |left_out| Report {
            runs: vec![Run { strokes_left_out: Some(left_out), ..run("pen", None) }, run("ink", None)],
            ..Report::default()
        };
        let text = table(&with(LeftOut { strokes: 12, ..LeftOut::default() }));
        assert_eq!(text.lines().count(), 4, "{text}");
        let line = text.lines().last().expect("four lines");
        assert!(line.starts_with("pen: ") && line.contains("12 strokes exceed the limits"), "{line}");
        assert_eq!(table(&with(LeftOut::default())).lines().count(), 3);
    }

    #[test]
    fn what_a_frame_does_has_a_table() {
        let work =
            FrameWork { bytes_read: 1_250_000_000, bytes_written: 2_000_000, wgpu_passes: 9, ..FrameWork::default() };
        let caches = [("bind_groups".to_owned(), CacheUse { hits: 999, misses: 1 })].into();
        let untimed = Some(Untimed { throughput_ms: 3.25, record_ms: 0.5, ..Untimed::default() });
        let gpu_ms = Percentiles { p50: 1.5, ..Percentiles::default() };
        let busy = Some(BusyGpu { gpu_ms, ..BusyGpu::default() });
        let memory = Memory { drawing_bytes: Some(12_500_000), ..Memory::default() };
        let measured = Run { work: Some(work), memory, untimed, busy, caches, ..run("ink", Some(2.0)) };
        let table = table(&Report { runs: vec![measured, run("plain", None)], ..Report::default() });
        let below = table.split("\n\n").nth(1).expect("a second table");
        let rows: Vec<Vec<&str>> = below.lines().skip(1).map(|line| line.split_whitespace().collect()).collect();
        let expected = [
            "ink", "1.250", "0.002", "9", "0", "0", "0", "0", "12.5", "0.000", "0.500", "0.000", "0.00", "3.25",
            "1.500", "–", "–",
        ];
        assert_eq!(rows[0], expected);
        assert_eq!(rows[1][1..], ["–"; 16]);
        let rates = table.split("\n\n").nth(2).expect("a third table");
        let rows: Vec<Vec<&str>> = rates.lines().map(|line| line.split_whitespace().collect()).collect();
        assert_eq!(rows[0][rows[0].len() - 2..], ["bind", "groups"]);
        assert_eq!((&rows[1][..], &rows[2][..]), (&["ink", "99.90"][..], &["plain", "–"][..]));
    }

    #[test]
    fn what_became_worse_is_printed_before_what_became_better() {
        let change = |figure: &str, new, noise| Change {
            style: "ink".to_owned(),
            eyes: "mono".to_owned(),
            figure: figure.to_owned(),
            old: 2.0,
            new,
            ratio: Some(new / 2.0),
            noise,
        };
        let comparison = Comparison {
            with: "old/report.json".to_owned(),
            worse: vec![change("GPU ms", 2.5, Some(0.01)), change("wgpu passes", 3.0, None)],
            better: vec![change("bytes read", 1.0, None)],
            compared: 10,
            ..Comparison::default()
        };
        let table = table(&Report { comparison: Some(comparison), runs: vec![run("ink", None)], ..Report::default() });
        let lines: Vec<&str> = table.lines().skip_while(|line| !line.starts_with("compared")).collect();
        assert_eq!(lines[0], "compared with old/report.json");
        assert!(
            lines[2].starts_with("worse") && lines[2].contains("GPU ms") && lines[2].ends_with("+25.0 % ± 2.5"),
            "{table}"
        );
        assert!(
            lines[3].ends_with("+50.0 %") && lines[4].starts_with("better") && lines[4].ends_with("-50.0 %"),
            "{table}"
        );
        assert!(lines[5].starts_with("7 other figures are unchanged (a time counts as changed beyond 3 %"), "{table}");
        // Planted: without a comparison, no figure is called unchanged.
        let nothing = Comparison { notes: vec!["nothing is compared".to_owned()], ..Comparison::default() };
        let table = super::table(&Report { comparison: Some(nothing), ..Report::default() });
        assert!(table.ends_with("nothing is compared\n"), "{table}");
    }

    #[test]
    fn steadiness_is_printed_below_the_times() {
        let measured = [("flicker", 0.0123), ("line_coverage", 0.5), ("e_warp", 2.5e-4), ("pairs", 3.0)];
        let metrics = measured.map(|(name, value)| (name.to_owned(), Some(value)));
        let steady = Run { temporal: Some(metrics.into()), ..run("ink", None) };
        let report = Report { runs: vec![steady, run("plain", None)], ..Report::default() };
        let table = table(&report);
        let below = table.split("\n\n").nth(1).expect("a second table");
        let cells: Vec<Vec<&str>> = below.lines().skip(1).map(|line| line.split_whitespace().collect()).collect();
        assert_eq!(cells[0], ["ink", "3", "50.00", "1.23", "–", "–", "–", "–", "–", "–", "–", "–", "250.0"]);
        assert_eq!(cells[1], ["plain", "–", "–", "–", "–", "–", "–", "–", "–", "–", "–", "–", "–"]);
    }
}
