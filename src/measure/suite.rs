//! `suite.json` and `suite.html`: the results of several benchmarks, with ratios to a plain frame, and published figures
//! beside them.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::report::{Report, Run};
use crate::file::unnamed::head;
use crate::file::{FileError, atomic};

/// Begins every page of a suite.
const TITLE: &str = "<title>hachure bench --suite</title>";

/// Published times of a frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Published {
    /// Where the times were published, and on which GPU they were measured.
    pub source: String,
    /// Times in milliseconds, by the name of our style that stands for theirs.
    pub frame_ms: BTreeMap<String, f64>,
}

/// The results of a suite, the content of `suite.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct SuiteReport {
    /// Title of the suite.
    pub suite: String,
    /// What it measures.
    pub about: String,
    /// The GPU and its driver.
    pub adapter: String,
    /// Whether the GPU is the processor: its times say nothing about a GPU.
    pub is_software: bool,
    pub parts: Vec<PartReport>,
}

/// The results of one benchmark; its `report.json` has the others.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PartReport {
    /// Name of its folder.
    pub name: String,
    pub title: String,
    /// Width and height of the pictures.
    #[serde(rename = "size")]
    pub size_px: [u32; 2],
    /// Source of the published times, if there are any.
    pub published: Option<String>,
    /// A row for each style and setting, of which the first is the plain frame.
    pub rows: Vec<Row>,
}

/// The figures of one style. Times are medians; ratios are to the first row.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Row {
    pub style: String,
    pub frame_ms: Option<f64>,
    pub gpu_ms: Option<f64>,
    /// Ratio of GPU times, or of frame times where the GPU has no timers.
    pub ratio: Option<f64>,
    /// Gigabytes that the passes of a frame read and write.
    pub gigabytes: Option<f64>,
    /// Ratio of those.
    pub gigabytes_ratio: Option<f64>,
    pub published_ms: Option<f64>,
    pub published_ratio: Option<f64>,
}

impl PartReport {
    /// Returns the figures of a benchmark, with the published ones beside them.
    pub(crate) fn of(name: String, title: String, report: &Report, published: Option<Published>) -> Self {
        let published = published.unwrap_or_default();
        let first = report.runs.first();
        let ratio = |value: Option<f64>, first: Option<f64>| Some(value? / first.filter(|first| *first > 0.0)?);
        let published_ms = |run: &Run| published.frame_ms.get(&run.style).copied();
        let rows = report.runs.iter().map(|run| Row {
            style: run.style.clone(),
            frame_ms: frame_ms(run),
            gpu_ms: gpu_ms(run),
            ratio: ratio(gpu_ms(run), first.and_then(gpu_ms)).or(ratio(frame_ms(run), first.and_then(frame_ms))),
            gigabytes: gigabytes(run),
            gigabytes_ratio: ratio(gigabytes(run), first.and_then(gigabytes)),
            published_ms: published_ms(run),
            published_ratio: ratio(published_ms(run), first.and_then(published_ms)),
        });
        let rows = rows.collect();
        let source = Some(published.source).filter(|source| !source.is_empty());
        Self { name, title, size_px: report.size_px, published: source, rows }
    }
}

fn frame_ms(run: &Run) -> Option<f64> {
    run.frame_ms.map(|ms| ms.p50)
}

/// Returns the median GPU time, of frames without a pause if they were measured.
fn gpu_ms(run: &Run) -> Option<f64> {
    run.busy.as_ref().map(|busy| busy.gpu_ms.p50).or(run.gpu_ms.map(|ms| ms.p50))
}

fn gigabytes(run: &Run) -> Option<f64> {
    run.work.map(|work| work.bytes() as f64 / 1e9)
}

/// A column of the tables: heading, value, decimals.
type Column = (&'static str, fn(&Row) -> Option<f64>, usize);

const COLUMNS: [Column; 7] = [
    ("frame ms", |row| row.frame_ms, 2),
    ("GPU ms", |row| row.gpu_ms, 3),
    ("÷ first", |row| row.ratio, 2),
    ("GB moved", |row| row.gigabytes, 3),
    ("÷ first", |row| row.gigabytes_ratio, 2),
    ("published ms", |row| row.published_ms, 2),
    ("÷ first", |row| row.published_ratio, 2),
];

impl SuiteReport {
    /// Writes `suite.json` and `suite.html`.
    ///
    /// # Errors
    /// A file cannot be written.
    pub(crate) fn write(&self, json: &Path, page: &Path) -> Result<(), FileError> {
        let text = serde_json::to_string_pretty(self).unwrap_or_else(|error| unreachable!("{error}"));
        for (path, text) in [(json, text), (page, self.html())] {
            atomic::write(path, text.as_bytes()).map_err(|error| FileError::write(path, error))?;
        }
        Ok(())
    }

    /// Returns whether the file at `path` is the `suite.json` of a suite, judged by its first keys.
    pub(crate) fn is_own(path: &Path) -> bool {
        let head = String::from_utf8_lossy(&head(path, 4096)).into_owned();
        let words: Vec<&str> = head.split('"').collect();
        head.starts_with('{') && words.get(1) == Some(&"suite") && words.get(5) == Some(&"about")
    }

    /// Returns the tables for a terminal.
    pub(crate) fn text(&self) -> String {
        let mut text = String::new();
        for part in &self.parts {
            let [width, height] = part.size_px;
            text += &format!("\n{}, {width}x{height}\n{}", part.title, super::report_text::columns(part.cells()));
            text += &part.published.as_ref().map_or_else(String::new, |source| format!("published: {source}\n"));
        }
        text
    }

    fn html(&self) -> String {
        let mut page = super::report_html::page_head(TITLE);
        page += &format!("<h1>{}</h1>\n<p>{}</p>\n<p>{}</p>\n", escape(&self.suite), escape(&self.about), escape(&self.adapter));
        page += "<p class=\"faint\">Times are medians. Ratios are to the first style of each table: of GPU times, or of frame \
                 times where the GPU has no timers; of the gigabytes that the passes of a frame read and write; and of the \
                 published times. Each table is a benchmark of its own, whose report has everything else.</p>\n";
        if self.is_software {
            page += "<p class=\"warning\">The GPU is the processor: only the gigabytes say something about a GPU.</p>\n";
        }
        for part in &self.parts {
            let [width, height] = part.size_px;
            page += &format!(
                "<h2>{}</h2>\n<p class=\"faint\">{width} × {height} pixels; <a href=\"{name}/report.html\">report</a></p>\n",
                escape(&part.title),
                name = escape(&part.name)
            );
            let mut rows = part.cells().into_iter();
            let row = |cells: Vec<String>, tag: &str| {
                let cells: String = cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escape(cell))).collect();
                format!("<tr>{cells}</tr>\n")
            };
            let heads = rows.next().map_or_else(String::new, |heads| row(heads, "th"));
            let rows: String = rows.map(|cells| row(cells, "td")).collect();
            page += &format!("<div class=\"wide\"><table>\n{heads}{rows}</table></div>\n");
            if let Some(source) = &part.published {
                page += &format!("<p class=\"faint\">Published: {}</p>\n", escape(source));
            }
        }
        page + "</body></html>\n"
    }
}

impl PartReport {
    /// Returns the cells of the table, with a row of headings; columns without a value are left out.
    fn cells(&self) -> Vec<Vec<String>> {
        let columns: Vec<&Column> =
            COLUMNS.iter().filter(|(_, value, _)| self.rows.iter().any(|row| value(row).is_some())).collect();
        let heads = std::iter::once("style".to_owned()).chain(columns.iter().map(|(head, ..)| (*head).to_owned()));
        let rows = self.rows.iter().map(|row| {
            let cell = |(_, value, decimals): &&Column| value(row).map_or("–".to_owned(), |value| format!("{value:.decimals$}"));
            std::iter::once(row.style.clone()).chain(columns.iter().map(cell)).collect()
        });
        std::iter::once(heads.collect()).chain(rows).collect()
    }
}

/// Returns whether the file at `path` is the page of a suite, judged by its title.
pub(crate) fn is_page(path: &Path) -> bool {
    String::from_utf8_lossy(&head(path, 4096)).contains(TITLE)
}

fn escape(text: &str) -> String {
    super::report_html::escape(text)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::measure::statistics::Percentiles;

    fn run(style: &str, frame_ms: f64) -> Run {
        Run { style: style.to_owned(), frame_ms: Percentiles::of([frame_ms]), ..Run::default() }
    }

    fn part() -> PartReport {
        let report = Report { runs: vec![run("plain", 8.0), run("green", 12.0)], ..Report::default() };
        let frame_ms = [("plain", 10.0), ("green", 30.0)].map(|(style, ms)| (style.to_owned(), ms)).into();
        PartReport::of("wide".to_owned(), "Wide & low".to_owned(), &report, Some(Published { source: "a <paper>".to_owned(), frame_ms }))
    }

    #[test]
    fn ratios_are_to_the_first_style() {
        let part = part();
        assert_eq!(part.rows[1].ratio, Some(1.5));
        assert_eq!(part.rows[1].published_ratio, Some(3.0));
        // Planted: without the first published time there is no published ratio.
        let report = Report { runs: vec![run("plain", 8.0), run("green", 12.0)], ..Report::default() };
        let frame_ms = [("green".to_owned(), 30.0)].into();
        let published = Published { source: String::new(), frame_ms };
        let part = PartReport::of(String::new(), String::new(), &report, Some(published));
        assert_eq!((part.rows[1].published_ms, part.rows[1].published_ratio), (Some(30.0), None));
    }

    #[test]
    fn a_report_is_written_and_recognised() {
        let report = SuiteReport { suite: "T".to_owned(), parts: vec![part()], ..SuiteReport::default() };
        let folder = tempfile::tempdir().unwrap();
        let [json, page] = ["suite.json", "suite.html"].map(|name| folder.path().join(name));
        report.write(&json, &page).unwrap();
        assert!(SuiteReport::is_own(&json) && is_page(&page) && !SuiteReport::is_own(&page) && !is_page(&json));
        let text = std::fs::read_to_string(&json).unwrap();
        assert_eq!(serde_json::from_str::<SuiteReport>(&text).unwrap(), report);
        let page = std::fs::read_to_string(&page).unwrap();
        assert!(page.contains("Wide &amp; low") && page.contains("a &lt;paper&gt;") && page.contains("<td>3.00</td>"), "{page}");
        let table = report.text();
        assert!(table.contains("green") && table.contains("1.50") && !table.contains("GPU ms"), "{table}");
    }
}
