//! The report for a terminal: a row for each run, with its ratio to the first run; warnings; and a table of steadiness.

use super::report::{Report, Run};

/// Headings of the columns.
const HEADS: [&str; 12] = [
    "style",
    "frames",
    "frame ms p50",
    "p95",
    "p99",
    "×",
    "GPU ms p50",
    "×",
    "LOD px max",
    "triangles",
    "strokes",
    "late",
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

/// Returns the tables: what frames cost, and how steady they are if that was measured. A dash (–) marks what was not.
pub(crate) fn table(report: &Report) -> String {
    let first = report.runs.first();
    let rows = report.runs.iter().map(|run| row(run, first.unwrap_or(run)).to_vec());
    let mut costs = columns(std::iter::once(HEADS.map(str::to_owned).to_vec()).chain(rows).collect());
    costs.extend(report.warnings().into_iter().map(|line| line + "\n"));
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
fn columns(rows: Vec<Vec<String>>) -> String {
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
    use crate::measure::report::TileCounts;
    use crate::measure::statistics::Percentiles;

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
