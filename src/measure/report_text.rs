//! The report on a terminal: a row for each run, with its ratio to the first.

use super::report::{Report, Run};

/// The heads of the columns.
const HEADS: [&str; 11] =
    ["style", "frames", "frame ms p50", "p95", "p99", "×", "GPU ms p50", "×", "LOD px max", "triangles", "late"];

/// The table. – is what was not measured.
pub fn table(report: &Report) -> String {
    let first = report.runs.first();
    let rows = report.runs.iter().map(|run| row(run, first.unwrap_or(run)));
    let rows: Vec<[String; 11]> = std::iter::once(HEADS.map(str::to_owned)).chain(rows).collect();
    let widths: [usize; 11] =
        std::array::from_fn(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0));
    let lines = rows.iter().map(|row| {
        let cells = row.iter().zip(widths).enumerate().map(|(column, (cell, width))| match column {
            0 => format!("{cell:<width$}"),
            _ => format!("{cell:>width$}"),
        });
        cells.collect::<Vec<_>>().join("  ") + "\n"
    });
    lines.collect()
}

fn row(run: &Run, first: &Run) -> [String; 11] {
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
        assert_eq!(cells[0], ["ink", "7", "2.00", "4.00", "6.00", "1.00", "–", "–", "–", "–", "–"]);
        assert_eq!(cells[1][..6], ["plain", "7", "5.00", "10.00", "15.00", "2.50"]);
        assert_eq!(cells[2][..6], ["unmeasured", "7", "–", "–", "–", "–"]);
        let widths: Vec<usize> = table.lines().map(|line| line.chars().count()).collect();
        assert!(widths.iter().all(|width| *width == widths[0]), "{table}");
    }
}
