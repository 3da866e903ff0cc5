//! The cost of a frame: a bar of its passes, their memory traffic, memory, tiles, and the reductions that budgets
//! caused.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use egui::{Align, Color32, Layout, RichText, Sense, Ui, vec2};

use super::panel::{PanelStats, WARNING, grouped, row};
use crate::gpu::timer::PassTime;
use crate::gpu::trace::{PassBytes, PassTrace};

/// Height of the bar of passes in points.
const BAR_HEIGHT: f32 = 18.0;
/// Number of passes that are listed.
const LISTED: usize = 14;
/// Time between two frames whose memory traffic is counted: counting waits for the GPU.
const PERIOD: Duration = Duration::from_secs(1);
const MIB: f64 = 1024.0 * 1024.0;

/// The memory traffic of the passes of a frame.
#[derive(Debug, Default)]
pub(super) struct Traffic {
    /// Bytes that each pass reads and writes.
    bytes: BTreeMap<&'static str, PassBytes>,
    /// Time of the count, and name of the style.
    counted: Option<(Instant, String)>,
}

impl Traffic {
    /// Returns whether the next frame of a style is to be traced.
    pub(super) fn is_due(&self, style: &str, now: Instant) -> bool {
        self.counted.as_ref().is_none_or(|(at, known)| known != style || now.saturating_duration_since(*at) >= PERIOD)
    }

    /// Counts the traffic of a frame that was traced.
    pub(super) fn count(&mut self, trace: &[PassTrace], style: &str, now: Instant) {
        self.bytes = trace.iter().map(|pass| (pass.name, PassBytes::default())).collect();
        for (name, bytes) in &mut self.bytes {
            *bytes = PassBytes::of(trace, name);
        }
        self.counted = Some((now, style.to_owned()));
    }

    /// Returns the bytes that a pass reads and writes; `None` if it is not known.
    fn of(&self, name: &str) -> Option<u64> {
        self.bytes.get(name).map(|bytes| bytes.read + bytes.written)
    }

    fn total(&self) -> u64 {
        self.bytes.values().map(|bytes| bytes.read + bytes.written).sum()
    }
}

/// The numbers that only this panel shows.
pub(super) struct CostStats<'a> {
    pub traffic: &'a Traffic,
    /// GPU memory of the pictures of all eyes, in bytes.
    pub picture_bytes: u64,
    /// CPU time to choose tiles and patches, and to record and submit the frame, in milliseconds.
    pub cpu_ms: [f64; 2],
}

/// Adds the bar, the list and the numbers.
pub(super) fn show(ui: &mut Ui, stats: &PanelStats<'_>, cost: &CostStats<'_>) {
    egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| content(ui, stats, cost));
}

fn content(ui: &mut Ui, stats: &PanelStats<'_>, cost: &CostStats<'_>) {
    let passes = stats.pass_times.passes();
    let Some((frame, passes)) = passes.split_first() else {
        ui.label(RichText::new("This GPU has no timestamp queries.").weak());
        numbers(ui, stats, cost);
        return;
    };
    let rest = format!("{:.2} ms, {:.2} GB", frame.gpu_ms, cost.traffic.total() as f64 / 1e9);
    row(ui, "Frame on the GPU", rest);
    bar(ui, passes, cost);
    let mut sorted: Vec<&PassTime> = passes.iter().collect();
    sorted.sort_by(|a, b| b.gpu_ms.total_cmp(&a.gpu_ms));
    for pass in sorted.iter().take(LISTED) {
        ui.horizontal(|ui| {
            let (rect, _) = ui.allocate_exact_size(vec2(8.0, 8.0), Sense::hover());
            ui.painter().rect_filled(rect, 1.0, color(&pass.name));
            ui.add(egui::Label::new(RichText::new(&pass.name).weak()).truncate());
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                ui.label(RichText::new(words(pass, cost)).monospace());
            });
        });
    }
    let others = &sorted[sorted.len().min(LISTED)..];
    if !others.is_empty() {
        let sum_ms: f64 = others.iter().map(|pass| pass.gpu_ms).sum();
        row(ui, &format!("{} more passes", others.len()), format!("{sum_ms:.2} ms"));
    }
    ui.separator();
    numbers(ui, stats, cost);
}

fn words(pass: &PassTime, cost: &CostStats<'_>) -> String {
    let bytes = cost.traffic.of(&pass.name).map_or(String::new(), |bytes| format!(" {:5.0} MB", bytes as f64 / 1e6));
    format!("{:.2} ms{bytes}", pass.gpu_ms)
}

/// Adds the bar, in which each pass has the width of its time.
fn bar(ui: &mut Ui, passes: &[PassTime], cost: &CostStats<'_>) {
    let (rect, response) = ui.allocate_exact_size(vec2(ui.available_width(), BAR_HEIGHT), Sense::hover());
    let total_ms: f64 = passes.iter().map(|pass| pass.gpu_ms.max(0.0)).sum();
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, Color32::from_white_alpha(12));
    let mut left = rect.left();
    let mut hovered = None;
    for pass in passes {
        let width = (pass.gpu_ms.max(0.0) / total_ms.max(1e-9)) as f32 * rect.width();
        let part = egui::Rect::from_min_size(egui::pos2(left, rect.top()), vec2(width, rect.height()));
        painter.rect_filled(part.shrink2(vec2((0.15 * width).min(0.5), 0.0)), 0.0, color(&pass.name));
        if response.hover_pos().is_some_and(|at| part.x_range().contains(at.x)) {
            hovered = Some(pass);
        }
        left += width;
    }
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "GPU time by pass"));
    if let Some(pass) = hovered {
        response.on_hover_text_at_pointer(format!("{}: {}", pass.name, words(pass, cost)));
    }
}

/// Adds memory, tiles, and the reductions that budgets caused.
fn numbers(ui: &mut Ui, stats: &PanelStats<'_>, cost: &CostStats<'_>) {
    let [prepare_ms, record_ms] = cost.cpu_ms;
    row(ui, "CPU: choose tiles", format!("{prepare_ms:.2} ms"));
    row(ui, "CPU: record commands", format!("{record_ms:.2} ms"));
    row(ui, "GPU memory", format!("{:.0} MiB", stats.gpu_bytes as f64 / MIB));
    row(ui, "of that, render targets", format!("{:.0} MiB", cost.picture_bytes as f64 / MIB));
    row(ui, "Tiles on GPU", grouped(stats.tiles_on_gpu));
    row(ui, "Tiles loaded", grouped(stats.tiles_loaded));
    row(ui, "Triangles, patches", format!("{}, {}", grouped(stats.triangles), grouped(stats.patches)));
    ui.separator();
    let lost = given_up(stats);
    if lost.is_empty() {
        ui.label(RichText::new("No limit was reached.").weak());
    }
    for text in lost {
        ui.add(egui::Label::new(RichText::new(text).color(WARNING)).wrap());
    }
}

/// Returns what the budgets of the last frame gave up.
fn given_up(stats: &PanelStats<'_>) -> Vec<String> {
    let memory = stats.over_memory_px.map(|error_px| {
        format!("Memory for tiles: the error of the surface is {error_px:.1} px (more with --tile-memory)")
    });
    let triangles =
        stats.over_budget_px.map(|error_px| format!("Triangles: the error of the terrain is {error_px:.1} px"));
    let missing = (stats.tiles_missing > 0)
        .then(|| format!("{} tiles are missing; coarser ones replace them", grouped(stats.tiles_missing)));
    let strokes = stats.strokes.and_then(|strokes| strokes.left_out.message());
    [memory, triangles, missing, strokes].into_iter().flatten().collect()
}

/// Returns the colour of a pass: a hue for its folder, and a shade for its name.
fn color(name: &str) -> Color32 {
    let folder = name.split('/').next().unwrap_or_default();
    let [red, green, blue] = match folder {
        "surface" => [96, 150, 110],
        "lines" => [110, 140, 200],
        "tones" => [205, 150, 80],
        "layers" => [180, 110, 150],
        "composite" => [150, 150, 150],
        _ => [120, 180, 190],
    };
    let shade = name.bytes().fold(7_u32, |sum, byte| sum.wrapping_mul(31).wrapping_add(byte.into())) % 60;
    let part = 0.75 + shade as f32 / 120.0;
    let [red, green, blue] = [red, green, blue].map(|channel: u8| (f32::from(channel) * part).min(255.0) as u8);
    Color32::from_rgb(red, green, blue)
}

#[cfg(test)]
mod tests {
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable as _;

    use super::*;
    use crate::gpu::trace::{Traced, Work};
    use crate::window::statistics::{FrameTimes, PassTimes};

    fn pass(name: &'static str, bytes: u64) -> PassTrace {
        let read = Traced { name: "a list", content: None, texture: None, buffer: None, bytes };
        let written = Traced { name: "another", content: None, texture: None, buffer: None, bytes: 2 * bytes };
        let (submit, work, copied) = (0, Work::Dispatch, Vec::new());
        PassTrace { name, submit, work, copied, reads: vec![read], writes: vec![written] }
    }

    #[test]
    fn passes_have_their_time_and_traffic_and_budgets_are_named() {
        let now = Instant::now();
        let mut traffic = Traffic::default();
        assert!(traffic.is_due("ink", now));
        // Two runs of a pass count once for each resource.
        traffic.count(&[pass("lines/lsa", 4_000_000), pass("lines/lsa", 4_000_000), pass("tones/toon", 0)], "ink", now);
        assert!(!traffic.is_due("ink", now) && traffic.is_due("pen", now) && traffic.is_due("ink", now + PERIOD));
        let mut pass_times = PassTimes::default();
        let time = |name: &str, gpu_ms| PassTime { name: name.to_owned(), gpu_ms };
        pass_times.add(vec![time("frame", 5.0), time("tones/toon", 1.5), time("lines/lsa", 3.25)]);
        let harness = Harness::builder().with_size(vec2(280.0, 500.0));
        let harness = harness.with_context_setup(crate::window::panel::set_up).build_ui(move |ui| {
            let stats = PanelStats {
                adapter: "",
                picture_px: [640, 360],
                quality: None,
                has_levels: true,
                frame_times: &FrameTimes::default(),
                pass_times: &pass_times,
                triangles: 12_345,
                patches: 1,
                strokes: None,
                tiles_on_gpu: 3,
                tiles_loaded: 4,
                tiles_missing: 2,
                over_budget_px: None,
                over_memory_px: Some(1.75),
                gpu_bytes: 64 << 20,
                height_above_ground_m: 0.0,
                is_preparing: false,
                panels: &[],
                has_labels: false,
                views: [false, false],
            };
            show(ui, &stats, &CostStats { traffic: &traffic, picture_bytes: 16 << 20, cpu_ms: [0.5, 0.25] });
        });
        let top = |label: &str| harness.get_by_label_contains(label).rect().top();
        // The most expensive pass is first.
        assert!(top("3.25 ms    12 MB") < top("1.50 ms     0 MB"));
        assert!(top("5.00 ms, 0.01 GB") < top("3.25 ms"));
        for words in ["2 tiles are missing", "error of the surface is 1.8 px", "64 MiB", "16 MiB", "12 345, 1"] {
            assert!(harness.query_by_label_contains(words).is_some(), "{words}");
        }
        // Planted: a limit that was not reached is not named.
        assert!(harness.query_by_label_contains("Triangles: the error").is_none());
        assert!(harness.query_by_label_contains("No limit was reached").is_none());
    }
}
