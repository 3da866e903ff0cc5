//! `report.html`: the report for people. A self-contained page: plots as inline SVG, no scripts, no network.

use std::path::Path;

use super::comparison::{Change, Comparison};
use super::report::{Metrics, Report, Run};
use super::statistics::{FrameRecord, Percentiles, RunFrames};
use super::trade::Trade;
use super::trade_plot;
use super::work::{FrameWork, cache_label, percent};
use crate::file::unnamed::head;
use crate::file::{FileError, atomic};

/// Colours that are distinct on light and on dark backgrounds.
const COLORS: [&str; 10] =
    ["#4269d0", "#d99a0b", "#ff725c", "#5bb3a0", "#3ca951", "#f072a5", "#a463f2", "#7ba5e8", "#9c6b4e", "#8f8b86"];

const STYLE: &str = "
:root { color-scheme: light dark; --ink: #1c1a17; --paper: #fbfaf7; --faint: #8a8680; --rule: #dcd8d0; }
@media (prefers-color-scheme: dark) { :root { --ink: #e8e4dc; --paper: #191817; --faint: #98938a; --rule: #3a3733; } }
body { color: var(--ink); background: var(--paper); font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto;
  max-width: 62rem; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2rem; }
.wide { overflow-x: auto; } svg { width: 100%; height: auto; min-width: 36rem; }
svg text { fill: var(--ink); font: 11px system-ui, sans-serif; } svg .rule { stroke: var(--rule); }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .6rem; text-align: right; border-bottom: 1px solid var(--rule); white-space: nowrap; }
th:first-child, td:first-child { text-align: left; } .faint, th { color: var(--faint); font-weight: normal; }
.warning { color: #c8321e; font-weight: 600; }
.key { display: inline-block; width: .8em; height: .8em; margin: 0 .35em 0 1em; border-radius: 2px; }
";

/// Width and left margin of the plots, in SVG units.
const WIDTH: f64 = 900.0;
const LEFT: f64 = 48.0;
/// Height of a line plot without its axis, and its horizontal resolution in columns.
const PLOT_HEIGHT: f64 = 220.0;
const COLUMNS: usize = 800;

/// The title of the page, by which hachure recognises it.
const TITLE: &str = "<title>hachure bench</title>";

/// Explanation of the steadiness metrics.
const STEADINESS: &str = "Pairs of consecutive frames, compared along exact motion; pixels not visible in both are \
    masked. Flicker: the share of line pixels without a line within 1.5 px in the frame before (births) or after \
    (deaths). A stroke is born, or dies, when less than half of it continues. Updates: frames that rebuild strokes. \
    Identity: line pixels that continue only as other strokes. Slip: how far the parameter along a stroke moves at \
    a fixed place, in pixels per frame. E_warp: mean squared difference of sRGB-encoded luminance, 0 to 1.";

/// Explanation of the numbers of the flight.
const NUMBERS: &str = "Late: some land is coarser than requested, because tiles are still loading. Over budget: the requested \
    error needs more triangles than a frame may have, so the allowed error was raised. Hitch: a frame that took more than \
    twice the median, and would not have with the median work on tiles and patches. Level-of-detail error: largest \
    distance of the drawn land from the full-resolution heights, in pixels, without late frames and those over budget.";

/// Explanation of the work of a frame.
const WORK: &str = "GB, wgpu passes, dispatches, draws, copies and barriers do not depend on the GPU. They are those of the \
    frame that moved most bytes, of the last frames of the flight, drawn once more with a trace. A wgpu pass is a compute or \
    render pass of the API; dispatches that follow each other share one. With timers: during the flight, with a timer around each pass. Without timers: \
    the last frames of the flight drawn again, from the last one back, as a window draws them. Latency: each frame \
    begins when the GPU has finished the one before. Throughput: a frame begins while the GPU draws the one before. Busy \
    GPU: with timers, but without a pause between frames, because a GPU that waits lowers its clocks.";

/// Explanation of the trade-offs.
const TRADE: &str = "Errors are those of views at rest against a converged reference: lines of it that are lost, lines \
    that it does not have, the difference of tones over squares of 8 pixels, and the distance of the drawn land from the \
    heights; flicker is that of the flight. No setting on the front has another one that is better in one respect and as \
    good in all others.";

/// Writes `report.html`, as a complete file or not at all. `frames` are the report's runs, in its order, for the plots
/// along the path.
///
/// # Errors
/// The file cannot be written.
pub(crate) fn write_html(path: &Path, report: &Report, frames: &[RunFrames]) -> Result<(), FileError> {
    atomic::write(path, html(report, frames).as_bytes()).map_err(|error| FileError::write(path, error))
}

/// Returns whether the file at `path` is such a page, judged by its title.
pub(crate) fn is_page(path: &Path) -> bool {
    String::from_utf8_lossy(&head(path, 4096)).contains(TITLE)
}

/// Returns the page as text.
pub(crate) fn html(report: &Report, frames: &[RunFrames]) -> String {
    let [width_px, height_px] = report.size_px;
    let [east_m, north_m] = report.world.extent_m;
    let samples = report.world.samples;
    let mut page = format!(
        "{head}<h1>hachure bench</h1>\n\
         <p>{adapter}; {width_px} × {height_px} pixels; world of {samples} samples, {east:.2} × {north:.2} km</p>\n",
        head = page_head(TITLE),
        adapter = escape(&report.adapter),
        east = east_m / 1000.0,
        north = north_m / 1000.0,
    );
    if let Some(settings) = &report.settings {
        page += &format!("<p class=\"faint\">{}</p>\n", escape(&settings.sentence()));
    }
    for run in &report.runs {
        let text = run.governed.as_ref().map(|governed| format!("{}: {}", run.style, governed.text()));
        page += &text.map_or_else(String::new, |text| format!("<p>{}</p>\n", escape(&text)));
    }
    page += &trades(report);
    page += &report.comparison.as_ref().map_or_else(String::new, changes);
    let along = |title: &str, unit: &str, value: fn(&FrameRecord) -> Option<f64>| {
        plot(frames, value).map_or(String::new(), |svg| {
            format!("<h2>{title} along the path</h2>\n<p class=\"faint\">{unit} over time in seconds</p>\n{svg}")
        })
    };
    page += &along("Frame time", "Milliseconds", |frame| frame.frame_ms);
    page += &along("GPU time", "Milliseconds", |frame| frame.gpu_ms);
    page += &along("Level-of-detail error", "Pixels", |frame| frame.lod_error_px);
    page += &bars(&report.runs);
    page += &table(&report.runs);
    page += &work_by_frame(&report.runs);
    page += &memory_by_pass(&report.runs);
    for line in report.warnings() {
        page += &format!("<p class=\"warning\">{}</p>\n", escape(&line));
    }
    page += &metrics("Steadiness from frame to frame", STEADINESS, &report.runs, |run| run.temporal.as_ref());
    page += &metrics("Agreement between the two eyes", "", &report.runs, |run| run.stereo.as_ref());
    page += "<p class=\"faint\">p50, p95 and p99 are percentiles over the frames; – means not measured.</p>\n";
    page += "</body></html>\n";
    page
}

/// Returns the beginning of a page with this title, up to its body.
pub(super) fn page_head(title: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width\">{title}\
         <style>{STYLE}</style></head><body>\n"
    )
}

/// Returns a plot with a line for each run and a key below; `None` if nothing was measured.
fn plot(runs: &[RunFrames], value: fn(&FrameRecord) -> Option<f64>) -> Option<String> {
    let points: Vec<Vec<[f64; 2]>> = runs
        .iter()
        .map(|run| {
            let measured = run.frames.iter().filter_map(|frame| Some([frame.t_s, value(frame)?]));
            measured.filter(|point| point.iter().all(|number| number.is_finite())).collect()
        })
        .collect();
    let times_s = || points.iter().flatten().map(|point| point[0]);
    let (start_s, end_s) = (times_s().reduce(f64::min)?, times_s().reduce(f64::max)?);
    let top = points.iter().flatten().map(|point| point[1]).fold(0.0, f64::max);
    let step = nice_step(top / 4.0);
    let top = (top / step).ceil().max(1.0) * step;
    let span_s = if end_s > start_s { end_s - start_s } else { 1.0 };
    let x_of = |t_s: f64| LEFT + (t_s - start_s) / span_s * (WIDTH - LEFT - 12.0);
    let y_of = |value: f64| 10.0 + (1.0 - value / top) * PLOT_HEIGHT;

    let mut svg = format!("<div class=\"wide\"><svg viewBox=\"0 0 {WIDTH} {}\" role=\"img\">\n", PLOT_HEIGHT + 34.0);
    for tick in 0..=(top / step).round() as u32 {
        let (tick, right) = (f64::from(tick) * step, WIDTH - 12.0);
        let y = y_of(tick);
        svg += &format!("<line class=\"rule\" x1=\"{LEFT}\" x2=\"{right}\" y1=\"{y:.1}\" y2=\"{y:.1}\"/>");
        svg += &format!("<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\n", LEFT - 6.0, y + 4.0, short(tick));
    }
    let step_s = nice_step(span_s / 8.0);
    for tick in 0..=(span_s / step_s).floor() as u32 {
        let t_s = start_s + f64::from(tick) * step_s;
        let y = PLOT_HEIGHT + 26.0;
        svg += &format!("<text x=\"{:.1}\" y=\"{y}\" text-anchor=\"middle\">{}</text>\n", x_of(t_s), short(t_s));
    }
    for (run, points) in points.iter().enumerate().filter(|(_, points)| !points.is_empty()) {
        // A long run has many frames per column of the plot: the largest is drawn, so that no spike is lost.
        let per_column = points.len().div_ceil(COLUMNS).max(1);
        let peaks = points.chunks(per_column).filter_map(|chunk| chunk.iter().max_by(|a, b| a[1].total_cmp(&b[1])));
        let line: Vec<String> = peaks.map(|&[t_s, value]| format!("{:.1},{:.1}", x_of(t_s), y_of(value))).collect();
        svg += &format!(
            "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"1.3\" stroke-linecap=\"round\" points=\"{}\"/>\n",
            color(run),
            line.join(" ")
        );
    }
    svg += "</svg></div>\n";
    let names = runs.iter().map(|run| format!("{}, {}", run.style, run.eyes));
    Some(svg + &key(names))
}

/// Returns a bar for each run, stacked from the means of its passes over all frames; a pass that does not run in every
/// frame has a correspondingly lower mean.
fn bars(runs: &[Run]) -> String {
    let mut names: Vec<&str> = Vec::new();
    for pass in runs.iter().flat_map(|run| &run.passes) {
        if pass.mean_ms.is_some() && !names.contains(&pass.name.as_str()) {
            names.push(&pass.name);
        }
    }
    let total_ms = |run: &Run| run.passes.iter().filter_map(|pass| pass.mean_ms).sum::<f64>();
    let longest_ms = runs.iter().map(total_ms).fold(0.0, f64::max);
    if longest_ms <= 0.0 {
        return String::new();
    }
    let (row, bar_left) = (26.0, 170.0);
    let height = runs.len() as f64 * row + 8.0;
    let mut svg = format!("<div class=\"wide\"><svg viewBox=\"0 0 {WIDTH} {height}\" role=\"img\">\n");
    for (index, run) in runs.iter().enumerate() {
        let y = index as f64 * row + 4.0;
        let name = escape(&format!("{}, {}", run.style, run.eyes));
        svg += &format!("<text x=\"{}\" y=\"{}\" text-anchor=\"end\">{name}</text>\n", bar_left - 8.0, y + 14.0);
        let mut x = bar_left;
        for pass in &run.passes {
            let Some(mean_ms) = pass.mean_ms else { continue };
            let width = mean_ms / longest_ms * (WIDTH - bar_left - 70.0);
            let place = names.iter().position(|name| *name == pass.name).unwrap_or(0);
            svg += &format!(
                "<rect x=\"{x:.1}\" y=\"{y}\" width=\"{width:.2}\" height=\"{}\" fill=\"{}\">\
                 <title>{}: {} ms</title></rect>\n",
                row - 6.0,
                color(place),
                escape(&pass.name),
                short(mean_ms)
            );
            x += width;
        }
        svg += &format!("<text x=\"{:.1}\" y=\"{}\">{} ms</text>\n", x + 6.0, y + 14.0, short(total_ms(run)));
    }
    svg += "</svg></div>\n";
    let names = names.iter().map(|&name| name.to_owned());
    format!("<h2>Passes</h2>\n<p class=\"faint\">Mean GPU time of each pass per frame</p>\n{svg}{}", key(names))
}

/// Returns the settings of each style with their costs and errors, as tables; empty without `--sweep`.
fn trades(report: &Report) -> String {
    let of_style = |trade: Trade<'_>| {
        let (heads, rows) = trade.table();
        let heads: String = heads.iter().map(|head| format!("<th>{}</th>", escape(head))).collect();
        let row = |cells: Vec<String>| {
            let cells: String = cells.iter().map(|cell| format!("<td>{}</td>", escape(cell))).collect();
            format!("<tr>{cells}</tr>\n")
        };
        let rows: String = rows.into_iter().map(row).collect();
        let name = trade.runs.first().map_or("", |run| run.style.as_str());
        format!(
            "<h2>Speed and exactness of {}</h2>\n<p class=\"faint\">{TRADE}</p>\n\
             {plot}<div class=\"wide\"><table>\n<tr>{heads}</tr>\n{rows}</table></div>\n",
            escape(name),
            plot = trade_plot::svg(&trade).unwrap_or_default()
        )
    };
    Trade::all(report).into_iter().map(of_style).collect()
}

fn table(runs: &[Run]) -> String {
    type Cell = fn(&Run) -> String;
    fn time(time: Option<Percentiles>, part: fn(Percentiles) -> f64) -> String {
        time.map_or(none(), |time| short(part(time)))
    }
    fn count(count: Option<u64>) -> String {
        count.map_or(none(), |count| count.to_string())
    }
    fn mebibytes(bytes: Option<u64>) -> String {
        bytes.map_or(none(), |bytes| short(bytes as f64 / 1_048_576.0))
    }
    let rows: [(&str, Cell); 33] = [
        ("frames", |run| run.frames.to_string()),
        ("frame ms, p50", |run| time(run.frame_ms, |ms| ms.p50)),
        ("frame ms, p95", |run| time(run.frame_ms, |ms| ms.p95)),
        ("frame ms, p99", |run| time(run.frame_ms, |ms| ms.p99)),
        ("frame ms, max", |run| time(run.frame_ms, |ms| ms.max)),
        ("GPU ms, p50", |run| time(run.gpu_ms, |ms| ms.p50)),
        ("GPU ms, p95", |run| time(run.gpu_ms, |ms| ms.p95)),
        ("GPU ms, p99", |run| time(run.gpu_ms, |ms| ms.p99)),
        ("GPU ms, max", |run| time(run.gpu_ms, |ms| ms.max)),
        ("level-of-detail error px, p50", |run| run.lod_error_px.map_or(none(), |px| short(px.p50))),
        ("level-of-detail error px, p99", |run| run.lod_error_px.map_or(none(), |px| short(px.p99))),
        ("level-of-detail error px, max", |run| run.lod_error_px.map_or(none(), |px| short(px.max))),
        ("allowed error px, max", |run| run.allowed_error_px.map_or(none(), |px| short(px.max))),
        ("frames over budget", |run| count(run.over_budget_frames)),
        ("surface coarser because of memory, largest factor", |run| run.tiles.memory_factor.map_or(none(), short)),
        ("triangles", |run| count(run.triangles)),
        ("strokes", |run| count(run.strokes)),
        ("GPU memory, MiB", |run| mebibytes(run.memory.gpu_bytes)),
        ("GPU memory of the drawing, MiB", |run| mebibytes(run.memory.drawing_bytes)),
        ("tiles on the GPU, MiB", |run| mebibytes(run.memory.gpu_tile_bytes)),
        ("tiles in memory, MiB", |run| mebibytes(run.memory.cpu_tile_bytes)),
        ("resident memory, MiB", |run| mebibytes(run.memory.rss_bytes)),
        ("tiles loaded", |run| count(run.tiles.loaded)),
        ("tiles evicted", |run| count(run.tiles.evicted)),
        ("tiles cancelled", |run| count(run.tiles.cancelled)),
        ("tiles failed", |run| count(run.tiles.failed)),
        ("late frames", |run| count(run.tiles.late_frames)),
        ("late frames, more than 1 s after a jump", |run| count(run.tiles.late_frames_after_1s)),
        ("jumps", |run| count(run.tiles.full_detail_ms.map(|detail| detail.jumps))),
        ("time to full detail after a jump ms, p50", |run| run.tiles.full_detail_ms.map_or(none(), |ms| short(ms.p50))),
        ("time to full detail after a jump ms, max", |run| run.tiles.full_detail_ms.map_or(none(), |ms| short(ms.max))),
        ("hitches", |run| count(run.hitches)),
        ("tile and patch work on the frame thread ms, p50", |run| time(run.prepare_ms, |ms| ms.p50)),
    ];
    let rows = rows.iter().map(|(name, cell)| (name.to_string(), runs.iter().map(cell).collect()));
    format!("<h2>Numbers</h2>\n<p class=\"faint\">{NUMBERS}</p>\n{}", grid(runs, rows))
}

/// Returns a table of the bytes that the passes of each run read and write; empty if nothing was traced.
fn memory_by_pass(runs: &[Run]) -> String {
    let mut names: Vec<&str> = Vec::new();
    for pass in runs.iter().flat_map(|run| &run.passes).filter(|pass| pass.bytes_read.is_some()) {
        if !names.contains(&pass.name.as_str()) {
            names.push(&pass.name);
        }
    }
    if names.is_empty() {
        return String::new();
    }
    let mebibytes = |bytes: u64| short((bytes as f64 / 1_048_576.0 * 1000.0).round() / 1000.0);
    let cell = |run: &Run, name: &str| {
        let pass = run.passes.iter().find(|pass| pass.name == name);
        let bytes = pass.and_then(|pass| Some((pass.bytes_read?, pass.bytes_written?, pass.runs)));
        bytes.map_or(none(), |(read, written, runs)| {
            let runs = runs.filter(|runs| *runs > 1).map_or(String::new(), |runs| format!(", {runs} ×"));
            format!("{} / {}{runs}", mebibytes(read), mebibytes(written))
        })
    };
    let rows = names.iter().map(|name| ((*name).to_owned(), runs.iter().map(|run| cell(run, name)).collect()));
    format!(
        "<h2>Memory by pass</h2>\n<p class=\"faint\">MiB of the textures and buffers that a pass (all runs of a \
         named shader) reads / writes in a frame; each resource counts once: a picture whole, a list as far as the frame \
         filled it, an atlas with the tiles that the view needs; N × is a pass that runs N times</p>\n{}",
        grid(runs, rows)
    )
}

/// Returns a table of the work that a frame gives the GPU, of the processor's time, and of hit rates; empty if nothing
/// was measured.
fn work_by_frame(runs: &[Run]) -> String {
    if runs.iter().all(|run| run.work.is_none() && run.untimed.is_none()) {
        return String::new();
    }
    type Part = fn(FrameWork) -> u64;
    let gigabytes: [(&str, Part); 2] = [("GB read", |work| work.bytes_read), ("GB written", |work| work.bytes_written)];
    let counts: [(&str, Part); 5] = [
        ("wgpu passes", |work| work.wgpu_passes),
        ("dispatches", |work| work.dispatches),
        ("draws", |work| work.draws),
        ("copies and clears", |work| work.copies),
        ("barriers", |work| work.barriers),
    ];
    type Time = fn(&Run) -> Option<f64>;
    let times: [(&str, Time); 15] = [
        ("with timers: record ms, p50", |run| Some(run.cpu_ms.record?.p50)),
        ("with timers: record ms, p99", |run| Some(run.cpu_ms.record?.p99)),
        ("with timers: submit ms, p50", |run| Some(run.cpu_ms.submit?.p50)),
        ("with timers: wait for the GPU ms, p50", |run| Some(run.cpu_ms.wait?.p50)),
        ("without timers: tiles and patches ms, p50", |run| Some(run.untimed?.prepare_ms)),
        ("without timers: record ms, p50", |run| Some(run.untimed?.record_ms)),
        ("without timers: submit ms, p50", |run| Some(run.untimed?.submit_ms)),
        ("latency ms, p50", |run| Some(run.untimed?.latency_ms.p50)),
        ("latency ms, p99", |run| Some(run.untimed?.latency_ms.p99)),
        ("throughput, ms per frame", |run| Some(run.untimed?.throughput_ms)),
        ("busy GPU: frame ms, p50", |run| Some(run.busy.as_ref()?.gpu_ms.p50)),
        ("busy GPU: frame ms, p99", |run| Some(run.busy.as_ref()?.gpu_ms.p99)),
        ("first frame: pipelines compiled", |run| Some(run.start?.pipelines as f64)),
        ("first frame: ms of compiling, all threads", |run| Some(run.start?.compile_ms)),
        ("first frame, ms", |run| Some(run.start?.frame_ms)),
    ];
    let cells = |cell: &dyn Fn(&Run) -> Option<String>| runs.iter().map(|run| cell(run).unwrap_or_else(none)).collect();
    let mut rows: Vec<(String, Vec<String>)> = Vec::new();
    for (name, part) in gigabytes {
        rows.push((name.to_owned(), cells(&|run| Some(short(part(run.work?) as f64 / 1e9)))));
    }
    for (name, part) in counts {
        rows.push((name.to_owned(), cells(&|run| Some(part(run.work?).to_string()))));
    }
    rows.extend(times.map(|(name, time)| (name.to_owned(), cells(&|run| time(run).map(short)))));
    let caches: std::collections::BTreeSet<&String> = runs.iter().flat_map(|run| run.caches.keys()).collect();
    for name in caches {
        let rate = |run: &Run| run.caches.get(name)?.hit_rate().map(percent);
        rows.push((format!("hit rate %, {}", cache_label(name)), cells(&rate)));
    }
    format!("<h2>What a frame does</h2>\n<p class=\"faint\">{WORK}</p>\n{}", grid(runs, rows.into_iter()))
}

/// Returns a table of what changed since an earlier report.
fn changes(comparison: &Comparison) -> String {
    let row = |class: &str, change: &Change| {
        let Change { style, eyes, figure, old, new, .. } = change;
        format!(
            "<tr><td class=\"{class}\">{}, {}: {}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n",
            escape(style),
            escape(eyes),
            escape(figure),
            short(*old),
            short(*new),
            change.percent()
        )
    };
    let worse: String = comparison.worse.iter().map(|change| row("warning", change)).collect();
    let better: String = comparison.better.iter().map(|change| row("", change)).collect();
    let notes: String = comparison.notes.iter().map(|note| format!("<p>{}</p>\n", escape(note))).collect();
    let table = if worse.is_empty() && better.is_empty() {
        String::new()
    } else {
        format!(
            "<div class=\"wide\"><table>\n<tr><th></th><th>old</th><th>new</th><th>change ± 2 standard errors</th></tr>\n\
             {worse}{better}</table></div>\n<p class=\"faint\">What became worse is red.</p>\n"
        )
    };
    let unchanged =
        comparison.unchanged().map_or_else(String::new, |text| format!("<p class=\"faint\">{}.</p>\n", escape(&text)));
    format!("<h2>Compared with {}</h2>\n{notes}{table}{unchanged}", escape(&comparison.with))
}

fn metrics(title: &str, meaning: &str, runs: &[Run], of: fn(&Run) -> Option<&Metrics>) -> String {
    let names: std::collections::BTreeSet<&String> = runs.iter().filter_map(of).flat_map(Metrics::keys).collect();
    if names.is_empty() {
        return String::new();
    }
    let cell = |run: &Run, name: &String| of(run).and_then(|metrics| *metrics.get(name)?).map_or(none(), short);
    let rows = names.into_iter().map(|name| (name.clone(), runs.iter().map(|run| cell(run, name)).collect()));
    let meaning = if meaning.is_empty() { String::new() } else { format!("<p class=\"faint\">{meaning}</p>\n") };
    format!("<h2>{title}</h2>\n{meaning}{}", grid(runs, rows))
}

/// Returns a table with a column for each run.
fn grid(runs: &[Run], rows: impl Iterator<Item = (String, Vec<String>)>) -> String {
    let heads: String =
        runs.iter().map(|run| format!("<th>{}, {}</th>", escape(&run.style), escape(&run.eyes))).collect();
    let mut table = format!("<div class=\"wide\"><table>\n<tr><th></th>{heads}</tr>\n");
    for (name, cells) in rows {
        let cells: String = cells.iter().map(|cell| format!("<td>{}</td>", escape(cell))).collect();
        table += &format!("<tr><td>{}</td>{cells}</tr>\n", escape(&name));
    }
    table + "</table></div>\n"
}

fn key(names: impl Iterator<Item = String>) -> String {
    let entry = |(index, name): (usize, String)| {
        format!("<span class=\"key\" style=\"background:{}\"></span>{}", color(index), escape(&name))
    };
    format!("<p>{}</p>\n", names.enumerate().map(entry).collect::<String>())
}

fn color(index: usize) -> &'static str {
    COLORS[index % COLORS.len()]
}

fn none() -> String {
    "–".to_owned()
}

/// Formats a number with about three significant digits, without an exponent; much less than 1e-9 becomes 0.
pub(super) fn short(value: f64) -> String {
    let decimals = match value.abs() {
        size if size >= 100.0 || size == 0.0 => 0,
        size if size >= 10.0 => 1,
        size if size >= 1.0 => 2,
        size if size >= 0.01 => 4,
        size if size >= 1e-4 => 6,
        _ => 9,
    };
    let text = format!("{value:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Returns 1, 2 or 5 times a power of ten, at least `least`; 1 if that is 0.
pub(super) fn nice_step(least: f64) -> f64 {
    if least <= 0.0 || !least.is_finite() {
        return 1.0;
    }
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0].map(|digit| digit * power).into_iter().find(|&step| step >= least).unwrap_or(10.0 * power)
}

pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
