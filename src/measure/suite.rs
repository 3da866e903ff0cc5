//! `suite.json` and `suite.html`: the tables of several benchmarks, with ratios to their first row, and published
//! figures next to them.

use std::collections::BTreeMap;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::report::{Metrics, Report, Run};
use super::trade::{Cost, SCALE};
use crate::file::unnamed::head;
use crate::file::{FileError, atomic};

/// Begins every page of a suite.
const TITLE: &str = "<title>hachure bench --suite</title>";

/// Figures that others have published.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Published {
    /// The publication, and the GPU on which its figures were measured.
    pub source: String,
    /// The quantity that was measured: the key of a column.
    pub quantity: String,
    /// The published values, by the label of our corresponding row, or by the published name if no row of ours
    /// corresponds.
    pub values: BTreeMap<String, f64>,
}

/// The results of a suite, the content of `suite.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct SuiteReport {
    /// Title of the suite.
    pub suite: String,
    /// The subject of the suite, in sentences.
    pub about: String,
    /// The GPU and its driver.
    pub adapter: String,
    /// Whether the GPU is the processor: its times say nothing about a GPU.
    pub is_software: bool,
    /// Options that replaced those of the benchmarks, such as `--size 480x270`.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub replaced: Vec<String>,
    pub tables: Vec<TableReport>,
}

/// A table of a suite: the results of one benchmark or more.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct TableReport {
    pub title: String,
    /// Names of passes, or beginnings of names, whose time and bytes have columns of their own.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub passes: Vec<String>,
    /// Keys of the columns that the table shows besides the usual ones.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub columns: Vec<String>,
    pub published: Option<Published>,
    /// The benchmarks, in the order of their rows.
    pub parts: Vec<PartReport>,
    pub rows: Vec<Row>,
}

/// A benchmark of a table; its folder has everything else.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct PartReport {
    /// Name of its folder.
    pub name: String,
    /// Width and height of the pictures; null if it failed.
    #[serde(rename = "size")]
    pub size_px: Option<[u32; 2]>,
    /// Why it failed, if it did.
    pub error: Option<String>,
}

/// The figures of one style with one setting.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Row {
    /// Name of the part, if the table has several, then of the style and its setting.
    pub label: String,
    /// The quantities, by key; null if one was not measured.
    pub values: Metrics,
    /// Ratios to the first row, by key.
    pub ratios: Metrics,
}

/// Picture size and pass names of a table, which some columns need.
struct Context<'a> {
    /// Width and height of the pictures, without the render scale of a setting.
    size_px: [u32; 2],
    /// Names of passes with columns of their own ([`TableReport::passes`]).
    passes: &'a [String],
}

impl Context<'_> {
    fn has_pass(&self, name: &str) -> bool {
        self.passes.iter().any(|beginning| name.starts_with(beginning.as_str()))
    }

    /// Returns the time of the table's passes in milliseconds: of frames without a pause if they were measured.
    fn passes_ms(&self, run: &Run) -> Option<f64> {
        let busy = run.busy.iter().flat_map(|busy| &busy.passes_ms).filter(|(name, _)| self.has_pass(name));
        let busy = sum(busy.map(|(_, ms)| *ms));
        let passes = run.passes.iter().filter(|pass| self.has_pass(&pass.name));
        busy.or_else(|| sum(passes.filter_map(|pass| pass.mean_ms)))
    }

    fn passes_gigabytes(&self, run: &Run) -> Option<f64> {
        let passes = run.passes.iter().filter(|pass| self.has_pass(&pass.name));
        sum(passes.filter_map(|pass| Some((pass.bytes_read? + pass.bytes_written?) as f64 / 1e9)))
    }

    /// Returns the number of pixels of a frame, of both eyes if two are drawn.
    fn pixels(&self, run: &Run) -> f64 {
        let scale: f64 = run.setting.get(SCALE).and_then(|scale| scale.parse().ok()).unwrap_or(1.0);
        let sides = self.size_px.map(|side| (f64::from(side) * scale).round());
        let eyes = if matches!(run.eyes.as_str(), "mono" | "left" | "right") { 1.0 } else { 2.0 };
        sides[0] * sides[1] * eyes
    }
}

/// Returns the sum; `None` of no values.
fn sum(values: impl Iterator<Item = f64>) -> Option<f64> {
    values.reduce(|a, b| a + b)
}

/// A quantity that a column shows.
struct Quantity {
    /// Key in `suite.json`, with the unit.
    key: &'static str,
    head: &'static str,
    /// Explanation, for the list below the tables.
    about: &'static str,
    decimals: usize,
    value: fn(&Run, &Context<'_>) -> Option<f64>,
    /// Whether every table shows it; otherwise a table names it.
    is_usual: bool,
    /// Whether a column of ratios follows.
    has_ratio: bool,
}

/// Returns a column that a table shows if it names it, without ratios.
const fn optional(
    key: &'static str,
    head: &'static str,
    about: &'static str,
    decimals: usize,
    value: fn(&Run, &Context<'_>) -> Option<f64>,
) -> Quantity {
    Quantity { key, head, about, decimals, value, is_usual: false, has_ratio: false }
}

/// Returns a column of every table, with ratios to the first row.
const fn usual(quantity: Quantity) -> Quantity {
    Quantity { is_usual: true, has_ratio: true, ..quantity }
}

const PASSES_MS: &str = "passes_ms";
const PASSES_GIGABYTES: &str = "passes_gigabytes";

static QUANTITIES: [Quantity; 19] = [
    usual(optional("frame_ms", "frame ms", "median time of a frame by the clock", 2, |run, _| Some(run.frame_ms?.p50))),
    usual(optional("gpu_ms", "GPU ms", "median time of a frame on the GPU", 3, |run, _| Cost::GpuMs.of(run))),
    usual(optional("gigabytes", "GB moved", "what the passes of a frame read and write", 3, |run, _| {
        Cost::Gigabytes.of(run)
    })),
    optional(PASSES_MS, "passes ms", "time of the named passes on the GPU", 3, |run, context| context.passes_ms(run)),
    optional(PASSES_GIGABYTES, "passes GB", "what the named passes read and write", 3, |run, context| {
        context.passes_gigabytes(run)
    }),
    optional(
        "megapixels_per_s",
        "Mpx/s",
        "millions of pixels that the named passes draw in a second",
        0,
        |run, context| Some(context.pixels(run) / context.passes_ms(run).filter(|ms| *ms > 0.0)? / 1e3),
    ),
    optional("bytes_per_pixel", "bytes/px", "what the named passes read and write for a pixel", 1, |run, context| {
        Some(context.passes_gigabytes(run)? * 1e9 / context.pixels(run))
    }),
    optional("prepare_ms", "prepare ms", "median time of the processor for tiles and patches", 2, |run, _| {
        Some(run.prepare_ms?.p50)
    }),
    optional("prepare_p99_ms", "prepare p99", "the same time, which 1 % of the frames exceed", 2, |run, _| {
        Some(run.prepare_ms?.p99)
    }),
    optional("record_ms", "record ms", "median time of the processor for recording passes", 2, |run, _| {
        Some(run.cpu_ms.record?.p50)
    }),
    optional("triangles", "triangles", "median number of triangles of the land", 0, |run, _| {
        Some(run.triangles? as f64)
    }),
    optional("gpu_megabytes", "GPU MB", "buffers and textures on the GPU", 0, |run, _| {
        Some(run.memory.gpu_bytes? as f64 / 1e6)
    }),
    optional(
        "late_percent",
        "late %",
        "frames with land that is coarser than requested, because tiles are loading",
        1,
        |run, _| Some(100.0 * run.tiles.late_frames? as f64 / run.frames.max(1) as f64),
    ),
    optional(
        "flight_surface_error_p99_px",
        "surface px",
        "error of the drawn land, which 1 % of the frames exceed",
        2,
        |run, _| Some(run.lod_error_px?.p99),
    ),
    optional(
        "lines_lost_percent",
        "lines lost %",
        "lines of the converged reference that the picture lacks",
        2,
        |run, _| Some(100.0 * (1.0 - metric(run.exactness.as_ref(), "line_recall")?)),
    ),
    optional("lines_added_percent", "lines added %", "lines of the picture that the reference lacks", 2, |run, _| {
        Some(100.0 * (1.0 - metric(run.exactness.as_ref(), "line_precision")?))
    }),
    optional(
        "tone_error_percent",
        "tone error %",
        "difference of tones from the reference, over squares of 8 pixels",
        2,
        |run, _| Some(100.0 * metric(run.exactness.as_ref(), "tone_error")?),
    ),
    optional(
        "flicker_percent",
        "flicker %",
        "line pixels without a line within 1.5 px in the next frame",
        2,
        |run, _| Some(100.0 * metric(run.temporal.as_ref(), "flicker")?),
    ),
    optional(
        "orphans_percent",
        "orphans %",
        "ink of lines that one eye draws, and the other should but does not",
        2,
        |run, _| Some(100.0 * metric(run.stereo.as_ref(), "orphans")?),
    ),
];

fn metric(metrics: Option<&Metrics>, name: &str) -> Option<f64> {
    *metrics?.get(name)?
}

/// Returns the keys of the quantities, for messages.
pub(crate) fn keys() -> Vec<&'static str> {
    QUANTITIES.iter().map(|quantity| quantity.key).collect()
}

impl TableReport {
    /// Adds the rows of a benchmark. With `part` as its name, labels begin with it.
    pub(crate) fn add(&mut self, part: Option<&str>, report: &Report) {
        let context = Context { size_px: report.size_px, passes: &self.passes };
        let rows = report.runs.iter().map(|run| Row {
            label: part.map_or(run.style.clone(), |part| format!("{part} {}", run.style)),
            values: QUANTITIES
                .iter()
                .map(|quantity| (quantity.key.to_owned(), (quantity.value)(run, &context)))
                .collect(),
            ratios: Metrics::new(),
        });
        let rows: Vec<Row> = rows.collect();
        self.rows.extend(rows);
        self.fill_ratios();
    }

    fn fill_ratios(&mut self) {
        let Some(first) = self.rows.first().map(|row| row.values.clone()) else { return };
        for row in &mut self.rows {
            let ratio = |quantity: &Quantity| {
                let first = metric(Some(&first), quantity.key).filter(|first| *first > 0.0)?;
                Some(metric(Some(&row.values), quantity.key)? / first)
            };
            row.ratios = QUANTITIES
                .iter()
                .filter(|quantity| quantity.has_ratio)
                .map(|quantity| (quantity.key.to_owned(), ratio(quantity)))
                .collect();
        }
    }

    /// Returns the published value of a row, and its ratio to the published value of the first row.
    fn published_of(&self, label: &str) -> [Option<f64>; 2] {
        let value = |label: &str| self.published.as_ref()?.values.get(label).copied();
        let first = self.rows.first().and_then(|row| value(&row.label)).filter(|first| *first > 0.0);
        [value(label), value(label).zip(first).map(|(value, first)| value / first)]
    }

    /// Returns the columns: those that are usual, those that the table names, those of its passes. A column without a
    /// value is left out.
    fn quantities(&self) -> impl Iterator<Item = &'static Quantity> {
        let is_shown = |quantity: &&Quantity| {
            let is_of_passes = [PASSES_MS, PASSES_GIGABYTES].contains(&quantity.key) && !self.passes.is_empty();
            quantity.is_usual || is_of_passes || self.columns.iter().any(|key| key == quantity.key)
        };
        let has_value =
            |quantity: &&Quantity| self.rows.iter().any(|row| metric(Some(&row.values), quantity.key).is_some());
        QUANTITIES.iter().filter(is_shown).filter(has_value)
    }

    /// Returns the cells, with a row of headings first.
    fn cells(&self) -> Vec<Vec<String>> {
        let number =
            |value: Option<f64>, decimals: usize| value.map_or("–".to_owned(), |value| format!("{value:.decimals$}"));
        // Published figures without a corresponding row of ours are in a note.
        let matches = |which: usize| self.rows.iter().any(|row| self.published_of(&row.label)[which].is_some());
        let (has_published, has_ratio) = (matches(0), matches(1));
        let published = self.published.as_ref().filter(|_| has_published);
        let published =
            published.and_then(|published| QUANTITIES.iter().find(|quantity| quantity.key == published.quantity));
        let quantities: Vec<&Quantity> = self.quantities().collect();
        let mut heads = vec![String::new()];
        for quantity in &quantities {
            heads.push(quantity.head.to_owned());
            heads.extend(quantity.has_ratio.then(|| "÷ first".to_owned()));
        }
        if let Some(quantity) = published {
            heads.push(format!("published {}", quantity.head));
            heads.extend(has_ratio.then(|| "÷ first".to_owned()));
        }
        let rows = self.rows.iter().map(|row| {
            let mut cells = vec![row.label.clone()];
            for quantity in &quantities {
                cells.push(number(metric(Some(&row.values), quantity.key), quantity.decimals));
                cells.extend(quantity.has_ratio.then(|| number(metric(Some(&row.ratios), quantity.key), 2)));
            }
            if let Some(quantity) = published {
                let [value, ratio] = self.published_of(&row.label);
                cells.push(number(value, quantity.decimals));
                cells.extend(has_ratio.then(|| number(ratio, 2)));
            }
            cells
        });
        std::iter::once(heads).chain(rows).collect()
    }

    /// Returns the notes below the table: the source of the published figures, those without a row of ours, and what
    /// failed.
    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if let Some(published) = &self.published {
            let head = QUANTITIES.iter().find(|quantity| quantity.key == published.quantity).map_or("", |it| it.head);
            let others = published.values.iter().filter(|(label, _)| self.rows.iter().all(|row| row.label != **label));
            let others: Vec<String> = others.map(|(label, value)| format!("{label} {value} {head}")).collect();
            let others = if others.is_empty() { String::new() } else { format!(": {}", others.join(", ")) };
            notes.push(format!("Published: {}{others}", published.source));
        }
        if !self.passes.is_empty() {
            notes.push(format!("Passes: {}", self.passes.join(", ")));
        }
        notes.extend(
            self.parts.iter().filter_map(|part| Some(format!("{} failed: {}", part.name, part.error.as_ref()?))),
        );
        notes
    }

    /// Returns the title with the size of the pictures, if all have the same.
    fn heading(&self) -> String {
        let mut sizes: Vec<[u32; 2]> = self.parts.iter().filter_map(|part| part.size_px).collect();
        sizes.dedup();
        match sizes[..] {
            [[width, height]] => format!("{}, {width} × {height} pixels", self.title),
            _ => self.title.clone(),
        }
    }
}

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
        head.trim_start_matches('{').trim_start().starts_with("\"suite\"") && head.contains("\n  \"about\"")
    }

    /// Returns the names of the parts that failed.
    pub(crate) fn failed(&self) -> impl Iterator<Item = &str> {
        let parts = self.tables.iter().flat_map(|table| &table.parts);
        parts.filter(|part| part.error.is_some()).map(|part| part.name.as_str())
    }

    /// Returns the tables for a terminal.
    pub(crate) fn text(&self) -> String {
        let mut text = self.warnings().join("\n");
        for table in &self.tables {
            text += &format!("\n{}\n", table.heading());
            if !table.rows.is_empty() {
                text += &super::report_text::columns(table.cells());
            }
            table.notes().iter().for_each(|note| text += &format!("{note}\n"));
        }
        text
    }

    fn html(&self) -> String {
        let escape = super::report_html::escape;
        let mut page = super::report_html::page_head(TITLE);
        page += &format!(
            "<h1>{}</h1>\n<p>{}</p>\n<p>{}</p>\n",
            escape(&self.suite),
            escape(&self.about),
            escape(&self.adapter)
        );
        for warning in self.warnings() {
            page += &format!("<p class=\"warning\">{}</p>\n", escape(&warning));
        }
        for table in &self.tables {
            page += &format!("<h2>{}</h2>\n", escape(&table.heading()));
            let row = |cells: &[String], tag: &str| {
                let cells: String = cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escape(cell))).collect();
                format!("<tr>{cells}</tr>\n")
            };
            if let Some((heads, rows)) = table.cells().split_first().filter(|(_, rows)| !rows.is_empty()) {
                let rows: String = rows.iter().map(|cells| row(cells, "td")).collect();
                page += &format!("<div class=\"wide\"><table>\n{}{rows}</table></div>\n", row(heads, "th"));
            }
            for note in table.notes() {
                page += &format!("<p class=\"faint\">{}</p>\n", escape(&note));
            }
            let measured = table.parts.iter().filter(|part| part.error.is_none());
            let links: Vec<String> =
                measured.map(|part| format!("<a href=\"{0}/report.html\">{0}</a>", escape(&part.name))).collect();
            if !links.is_empty() {
                page += &format!("<p class=\"faint\">Reports: {}</p>\n", links.join(", "));
            }
        }
        page += "<h2>Columns</h2>\n<p class=\"faint\">A ratio is to the first row of its table.</p>\n<ul>\n";
        let is_used =
            |quantity: &&Quantity| self.tables.iter().any(|table| table.quantities().any(|it| it.key == quantity.key));
        for Quantity { head, about, .. } in QUANTITIES.iter().filter(is_used) {
            page += &format!("<li>{}: {about}</li>\n", escape(head));
        }
        page + "</ul>\n</body></html>\n"
    }

    /// Returns the notes that a reader must know before comparing figures.
    fn warnings(&self) -> Vec<String> {
        let mut warnings = Vec::new();
        if self.is_software {
            warnings.push(
                "This is a software driver: its times say nothing about a GPU. Compare the gigabytes, which are the same on \
                 every GPU."
                    .to_owned(),
            );
        }
        if !self.replaced.is_empty() {
            warnings.push(format!(
                "Not as the suite says, and as the published figures were measured: {}",
                self.replaced.join(", ")
            ));
        }
        warnings
    }
}

/// Returns whether the file at `path` is the page of a suite, judged by its title.
pub(crate) fn is_page(path: &Path) -> bool {
    String::from_utf8_lossy(&head(path, 4096)).contains(TITLE)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::measure::report::Pass;
    use crate::measure::statistics::Percentiles;

    fn run(style: &str, frame_ms: f64) -> Run {
        let pass = |name: &str, mean_ms| Pass { name: name.to_owned(), mean_ms: Some(mean_ms), ..Pass::default() };
        Run {
            style: style.to_owned(),
            eyes: "mono".to_owned(),
            frame_ms: Percentiles::of([frame_ms]),
            passes: vec![pass("lines/lsa", 2.0), pass("lines/lsa_rest", 0.5), pass("tones/toon", 7.0)],
            ..Run::default()
        }
    }

    fn table(first: &str) -> TableReport {
        let report =
            Report { size_px: [1000, 500], runs: vec![run(first, 8.0), run("green", 12.0)], ..Report::default() };
        let values = [("plain", 10.0), ("green", 30.0), ("Bunny", 14.7)];
        let published = Published {
            source: "a <paper>".to_owned(),
            quantity: "frame_ms".to_owned(),
            values: values.map(|(style, ms)| (style.to_owned(), ms)).into(),
        };
        let mut table = TableReport {
            title: "Wide & low".to_owned(),
            passes: vec!["lines/lsa".to_owned()],
            columns: vec!["megapixels_per_s".to_owned()],
            published: Some(published),
            parts: vec![PartReport { name: "wide".to_owned(), size_px: Some([1000, 500]), error: None }],
            ..TableReport::default()
        };
        table.add(None, &report);
        table
    }

    #[test]
    fn ratios_are_to_the_first_row() {
        let table = table("plain");
        assert_eq!(table.rows[1].ratios["frame_ms"], Some(1.5));
        assert_eq!(table.published_of("green"), [Some(30.0), Some(3.0)]);
        let cells = table.cells();
        let heads = ["", "frame ms", "÷ first", "passes ms", "Mpx/s", "published frame ms", "÷ first"];
        assert_eq!(cells[0], heads.map(str::to_owned));
        // Half a million pixels in 2.5 ms.
        assert_eq!(cells[2], ["green", "12.00", "1.50", "2.500", "200", "30.00", "3.00"].map(str::to_owned));
        assert_eq!(table.notes()[0], "Published: a <paper>: Bunny 14.7 frame ms");
        // Planted: the first row has no published value, so there is no ratio to it.
        let without = self::table("ink");
        assert_eq!((without.published_of("green"), without.cells()[0].len()), ([Some(30.0), None], 6));
        // Without any row that is published there is no column, and a note has the figures.
        let mut without = self::table("ink");
        without.rows.truncate(1);
        assert_eq!(without.cells()[0].len(), 5);
        assert!(without.notes()[0].contains("plain 10 frame ms"));
    }

    #[test]
    fn rows_of_several_parts_are_in_one_table() {
        let mut table = TableReport::default();
        let mut fast = run("ink scale=0.5", 4.0);
        fast.setting.insert(SCALE.to_owned(), "0.5".to_owned());
        fast.eyes = "side-by-side".to_owned();
        for (part, run) in [("one", run("ink", 8.0)), ("two", fast.clone())] {
            table.add(Some(part), &Report { runs: vec![run], ..Report::default() });
        }
        let labels: Vec<&str> = table.rows.iter().map(|row| row.label.as_str()).collect();
        assert_eq!(labels, ["one ink", "two ink scale=0.5"]);
        assert_eq!(table.rows[1].ratios["frame_ms"], Some(0.5));
        let context = Context { size_px: [100, 50], passes: &[] };
        assert_eq!(context.pixels(&fast), 2.0 * 50.0 * 25.0);
        assert_eq!(context.passes_ms(&fast), None);
    }

    #[test]
    fn a_report_is_written_and_recognised() {
        let mut failed = table("plain");
        failed.parts.push(PartReport { name: "low".to_owned(), size_px: None, error: Some("no GPU".to_owned()) });
        let report = SuiteReport { suite: "T".to_owned(), tables: vec![failed], ..SuiteReport::default() };
        let folder = tempfile::tempdir().unwrap();
        let [json, page] = ["suite.json", "suite.html"].map(|name| folder.path().join(name));
        report.write(&json, &page).unwrap();
        assert!(SuiteReport::is_own(&json) && is_page(&page) && !SuiteReport::is_own(&page) && !is_page(&json));
        let text = std::fs::read_to_string(&json).unwrap();
        assert_eq!(serde_json::from_str::<SuiteReport>(&text).unwrap(), report);
        let page = std::fs::read_to_string(&page).unwrap();
        for part in [
            "Wide &amp; low, 1000 × 500 pixels",
            "a &lt;paper&gt;",
            "<td>3.00</td>",
            "low failed: no GPU",
            "wide/report.html",
        ] {
            assert!(page.contains(part), "{part}: {page}");
        }
        assert!(!page.contains("low/report.html"));
        let text = report.text();
        assert!(text.contains("green") && text.contains("1.50") && !text.contains("GPU ms"), "{text}");
    }
}
