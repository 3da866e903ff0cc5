//! The panel: controls for the settings, frame times, and figures of what is drawn and loaded.

#[cfg(test)]
mod tests;

use egui::{Align, Color32, Layout, Response, RichText, Sense, Slider, Ui};

use super::camera_history::ViewStep;
use super::dock::Pane;
use super::fly_camera::{FOV_RANGE_DEG, FlyCamera, SPEED_FACTORS};
use super::keys;
use super::land_panel::LandPanel;
use super::light::{LightPanel, LightRequests};
use super::settings::{SCALES, Settings, Styles};
use super::statistics::{FRAMES, FrameTimes, PassTimes};
use crate::frame::Antialias;
use crate::ladder::Quality;
use crate::lines::strokes::StrokeNumbers;
use crate::measure::quality::Level;
use crate::scene::stereo::Eyes;

/// Height of the plot of frame times in points.
const PLOT_HEIGHT: f32 = 26.0;
/// Upper end of the convergence slider, which stands for infinity.
const FARTHEST_M: f64 = 1e6;
/// Colour of dialogs and menus, nearly opaque: the text below must not be readable.
const WINDOW_FILL: Color32 = Color32::from_black_alpha(245);
/// Colour of warnings.
pub(super) const WARNING: Color32 = Color32::from_rgb(255, 110, 90);

/// Numbers that the panel shows.
pub(super) struct PanelStats<'a> {
    /// Name and driver of the GPU.
    pub adapter: &'a str,
    /// Size of one eye's picture.
    pub picture_px: [u32; 2],
    /// Values of the style that the quality gives up, or the reason why it has no effect.
    pub quality: Option<&'a str>,
    /// Whether the style has measured levels.
    pub has_levels: bool,
    /// Times from frame to frame.
    pub frame_times: &'a FrameTimes,
    /// GPU times by pass.
    pub pass_times: &'a PassTimes,
    /// Triangles in the last frame.
    pub triangles: u64,
    /// Patches in the last frame.
    pub patches: u64,
    /// Numbers of strokes in a recent frame; `None` if the style has no strokes.
    pub strokes: Option<StrokeNumbers>,
    /// Tiles that are on the GPU.
    pub tiles_on_gpu: u64,
    /// Tiles loaded since the start.
    pub tiles_loaded: u64,
    /// Tiles that the last frame lacked and replaced by coarser ones.
    pub tiles_missing: u64,
    /// Allowed error of the last frame's mesh, if the triangle budget raised it above the setting.
    pub over_budget_px: Option<f64>,
    /// Allowed error of the last frame's surface, if the memory for tiles raised it above the setting.
    pub over_memory_px: Option<f64>,
    /// Bytes of all buffers and textures on the GPU.
    pub gpu_bytes: u64,
    /// Height of the camera above the ground.
    pub height_above_ground_m: f64,
    /// Whether the picture is still of another style than the chosen one.
    pub is_preparing: bool,
    /// The other panels, and whether each is shown.
    pub panels: &'a [(Pane, bool)],
    /// Whether labels of summits are shown.
    pub has_labels: bool,
    /// Whether there is a previous view, and a next one.
    pub views: [bool; 2],
}

/// The user's requests in the panel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct PanelRequests {
    /// Whether to write a picture to a file.
    pub screenshot: bool,
    /// Whether to return to the start of the flight.
    pub restart: bool,
    /// A view to return to.
    pub to_view: Option<ViewStep>,
    /// A panel to show, or to hide.
    pub toggled: Option<Pane>,
    /// Whether to open or close the gallery.
    pub gallery: bool,
    /// Whether to show or remove the divider between two styles.
    pub divider: bool,
    /// Whether to show or hide labels of summits.
    pub labels: bool,
    /// Whether the value for `--camera` was copied.
    pub copied: bool,
    /// Whether to open the dialog that opens files.
    pub open: bool,
    /// Whether to open the dialog that exports.
    pub export: bool,
    /// The requests in the controls of light.
    pub light: LightRequests,
}

/// Sets sizes and colours, once.
pub(super) fn set_up(context: &egui::Context) {
    // egui measures the duration of a click by the times of frames: with frames of a second, every click would count as
    // held and do nothing.
    context.options_mut(|options| options.input_options.max_click_duration = f64::INFINITY);
    context.all_styles_mut(|style| {
        for (kind, font) in &mut style.text_styles {
            font.size = if *kind == egui::TextStyle::Heading { 13.0 } else { 11.0 };
        }
        style.spacing.item_spacing = egui::vec2(6.0, 3.0);
        style.spacing.slider_width = 96.0;
        style.spacing.interact_size.y = 16.0;
        style.spacing.combo_width = 96.0;
        style.visuals.window_shadow = egui::Shadow::NONE;
        style.visuals.window_fill = WINDOW_FILL;
        style.visuals.override_text_color = Some(Color32::from_gray(225));
        style.interaction.tooltip_delay = 0.3;
        // Scroll bars have room of their own: they must not cover values.
        style.spacing.scroll = egui::style::ScrollStyle::thin();
    });
}

/// Lays out the panel.
pub(super) fn show(
    ui: &mut Ui,
    stats: &PanelStats<'_>,
    styles: &Styles,
    settings: &mut Settings,
    camera: &mut FlyCamera,
    (light, land): (&mut LightPanel, &mut LandPanel),
) -> PanelRequests {
    let mut requests = PanelRequests::default();
    egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        panels(ui, stats, &mut requests);
        picture(ui, stats, styles, settings);
        section(ui, "Performance", false, |ui| performance(ui, stats));
        section(ui, "Camera", true, |ui| camera_section(ui, stats, camera, &mut requests));
        section(ui, "Light", true, |ui| requests.light = light.show(ui, settings, camera.yaw_deg));
        let draws_water = styles.list()[settings.style].water().is_some();
        section(ui, "Land", true, |ui| land.show(ui, settings, draws_water));
        section(ui, "Keys", false, |ui| {
            keys::HELP.iter().flat_map(|group| group.keys).for_each(|(keys, what)| row(ui, keys, *what));
        });
    });
    requests
}

/// Adds the buttons of the other panels.
fn panels(ui: &mut Ui, stats: &PanelStats<'_>, requests: &mut PanelRequests) {
    ui.horizontal_wrapped(|ui| {
        for (pane, is_shown) in stats.panels {
            let button = ui.selectable_label(*is_shown, pane.title());
            if button.on_hover_text(format!("Show or hide this panel ({})", pane.key())).clicked() {
                requests.toggled = Some(*pane);
            }
        }
        let gallery = ui.button("Gallery");
        requests.gallery = gallery.on_hover_text("All styles as pictures of the present view (G)").clicked();
        let hint = "This style next to another one, or to itself as it is saved (X)";
        requests.divider = ui.button("Compare").on_hover_text(hint).clicked();
        let labels = ui.selectable_label(stats.has_labels, "Labels");
        requests.labels = labels.on_hover_text("Heights and names of the summits in view (U)").clicked();
        let hint = "Open another world, a style or a camera path (Ctrl O); files may also be dropped on the window";
        requests.open = ui.button("Open…").on_hover_text(hint).clicked();
        let hint = "Write a picture of any size, poster sheets, lines for pens, a map or a film (Ctrl E)";
        requests.export = ui.button("Export…").on_hover_text(hint).clicked();
    });
    ui.separator();
}

/// Adds a section that can be collapsed.
fn section(ui: &mut Ui, title: &str, open: bool, content: impl FnOnce(&mut Ui)) {
    egui::CollapsingHeader::new(RichText::new(title).strong()).default_open(open).show_unindented(ui, content);
}

/// Returns whether widgets that are dragged, such as sliders, may have a tooltip: while a button of the mouse is pressed it
/// would cover what the drag changes.
pub(super) fn may_hint(context: &egui::Context) -> bool {
    !context.input(|input| input.pointer.any_down())
}

/// Adds a tooltip to a widget that is dragged.
pub(super) fn hint(widget: Response, text: impl Into<egui::WidgetText>) -> Response {
    if may_hint(&widget.ctx) { widget.on_hover_text(text) } else { widget }
}

/// Adds a row with a name on the left and a value on the right.
pub(super) fn row(ui: &mut Ui, name: &str, value: impl Into<String>) {
    ui.horizontal(|ui| {
        ui.label(RichText::new(name).weak());
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| ui.label(RichText::new(value).monospace()));
    });
}

/// Adds a row with a name on the left and a value on the right; both show `hint` as a tooltip.
fn explained(ui: &mut Ui, name: &str, hint: &str, value: String) {
    labelled(ui, name, hint, egui::Label::new(RichText::new(value).monospace()));
}

/// Adds a row with a name on the left and a widget on the right; both show `hint` as a tooltip.
pub(super) fn labelled(ui: &mut Ui, name: &str, hint: &str, widget: impl egui::Widget) {
    ui.horizontal(|ui| {
        ui.label(RichText::new(name).weak()).on_hover_text(hint);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let before = widgets(ui, 0).len();
            let response = self::hint(ui.add(widget), hint).on_disabled_hover_text(hint);
            // A slider has a field for its number, too.
            for id in widgets(ui, before) {
                named(ui, id, &if id == response.id { name.to_owned() } else { format!("{name}, number") });
            }
        });
    });
}

/// Returns a slider that leaves its value as it is until the user moves it. The usual slider of egui rounds its value
/// to the digits that it shows, and clamps it to its ends, in every frame.
pub(super) fn steady_slider<N: egui::emath::Numeric>(value: &mut N, ends: std::ops::RangeInclusive<N>) -> Slider<'_> {
    Slider::new(value, ends).clamping(egui::SliderClamping::Edits)
}

/// Returns the widgets of this frame that can have the focus, at the level of `ui`, without the first ones.
fn widgets(ui: &Ui, first: usize) -> Vec<egui::Id> {
    let layer = ui.layer_id();
    ui.ctx().viewport(|viewport| {
        let widgets = viewport.this_pass.widgets.get_layer(layer);
        widgets.filter(|widget| widget.sense.is_focusable()).skip(first).map(|widget| widget.id).collect()
    })
}

/// Names a widget for screen readers.
fn named(ui: &Ui, id: egui::Id, name: &str) {
    ui.ctx().accesskit_node_builder(id, |node| node.set_label(name));
}

/// Adds the controls of what is drawn: style, resolution, edges, eyes and terrain error.
fn picture(ui: &mut Ui, stats: &PanelStats<'_>, styles: &Styles, settings: &mut Settings) {
    let list = styles.list();
    ui.horizontal(|ui| {
        ui.label(RichText::new("Style").weak());
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let box_of_styles = egui::ComboBox::from_id_salt("style").selected_text(&*list[settings.style].name);
            let shown = box_of_styles.show_ui(ui, |ui| {
                for (index, style) in list.iter().enumerate() {
                    ui.selectable_value(&mut settings.style, index, &*style.name).on_hover_text(&style.description);
                }
            });
            // The button of the panel "Style" has that name.
            named(ui, shown.response.id, "Drawn style");
        });
    });
    if stats.is_preparing {
        let text = "This style is being prepared; the picture is still of the one before.";
        ui.add(egui::Label::new(RichText::new(text).color(WARNING)).wrap());
    }
    ui.horizontal(|ui| {
        ui.label(RichText::new("Resolution").weak())
            .on_hover_text("Rendered pixels per pixel of the window, in each direction (− +)");
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            for (index, scale) in SCALES.iter().enumerate().rev() {
                let button = ui.selectable_value(&mut settings.scale, index, format!("{scale}"));
                named(ui, button.id, &format!("Resolution {scale}"));
            }
            ui.label(RichText::new(format!("{}×{}", stats.picture_px[0], stats.picture_px[1])).weak());
        });
    });
    quality(ui, stats, settings);
    let mut is_smooth = settings.antialias == Antialias::Temporal;
    let hint = "Temporal anti-aliasing: the mean of consecutive frames (--antialias)";
    labelled(ui, "Smooth edges", hint, egui::Checkbox::new(&mut is_smooth, ""));
    settings.antialias = if is_smooth { Antialias::Temporal } else { Antialias::None };
    eyes(ui, settings);
    let slider = steady_slider(&mut settings.lod_error_px, 0.1..=16.0).logarithmic(true).suffix(" px");
    labelled(ui, "Terrain error", "Largest error of the drawn terrain, in pixels (--lod-error)", slider);
}

/// Adds the choice of the quality, and the values of the style that it gives up.
fn quality(ui: &mut Ui, stats: &PanelStats<'_>, settings: &mut Settings) {
    let budget_ms = if let Quality::Budget(ms) = settings.quality { ms } else { Quality::BUDGET_MS };
    let levels = Level::ALL.map(Quality::Level);
    let choices = [Quality::AsSet].into_iter().chain(levels).chain([Quality::Budget(budget_ms)]);
    ui.horizontal(|ui| {
        let hint = "Measured settings of the style, from fast to exact (--quality), or those that hold a frame time \
                    (--budget)";
        ui.label(RichText::new("Quality").weak()).on_hover_text(hint);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let shown =
                egui::ComboBox::from_id_salt("quality").selected_text(settings.quality.name()).show_ui(ui, |ui| {
                    for choice in choices {
                        let is_there = stats.has_levels || !matches!(choice, Quality::Level(_));
                        let button = egui::Button::selectable(settings.quality == choice, choice.name());
                        let hint = "This style has no measured levels: hachure bench --sweep measures them.";
                        if ui.add_enabled(is_there, button).on_disabled_hover_text(hint).clicked() {
                            settings.quality = choice;
                        }
                    }
                });
            named(ui, shown.response.id, "Quality");
        });
    });
    if let Quality::Budget(ms) = &mut settings.quality {
        let slider = steady_slider(ms, 2.0..=1000.0).logarithmic(true).suffix(" ms").max_decimals(1);
        labelled(ui, "Frame time", "Largest time of a frame on the GPU, in milliseconds (--budget)", slider);
    }
    if let Some(words) = stats.quality {
        ui.add(egui::Label::new(RichText::new(words).weak()).wrap());
    }
}

/// Adds the controls for eyes and stereo pair.
fn eyes(ui: &mut Ui, settings: &mut Settings) {
    ui.horizontal(|ui| {
        ui.label(RichText::new("Eyes").weak()).on_hover_text("One eye, or a stereo pair (--eyes)");
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let box_of_eyes = egui::ComboBox::from_id_salt("eyes").selected_text(settings.eyes.to_string());
            let shown = box_of_eyes.show_ui(ui, |ui| {
                for (name, eyes) in Eyes::NAMES {
                    ui.selectable_value(&mut settings.eyes, eyes, name);
                }
            });
            named(ui, shown.response.id, "Eyes");
        });
    });
    if settings.eyes == Eyes::Mono {
        return;
    }
    labelled(
        ui,
        "Auto eye distance",
        "The distance between the eyes is a thirtieth of the distance to the nearest land (--ipd auto)",
        egui::Checkbox::new(&mut settings.follows_land, ""),
    );
    let apart = steady_slider(&mut settings.pair.ipd_m, 0.001..=1000.0).logarithmic(true).suffix(" m").max_decimals(3);
    ui.add_enabled_ui(!settings.follows_land, |ui| {
        labelled(ui, "Eye distance", "Distance between the eyes (--ipd)", apart);
    });
    let mut convergence_m = settings.pair.convergence_m.unwrap_or(FARTHEST_M);
    let plane = steady_slider(&mut convergence_m, 0.1..=FARTHEST_M).logarithmic(true).max_decimals(1);
    let plane = plane.custom_formatter(|distance_m, _| distance_words(distance_m)).custom_parser(distance_of);
    labelled(
        ui,
        "Convergence",
        "Distance of zero parallax; the right end of the slider is infinity (--convergence)",
        plane,
    );
    settings.pair.convergence_m = (convergence_m < FARTHEST_M).then_some(convergence_m);
}

/// Returns the words for a distance of zero parallax.
fn distance_words(distance_m: f64) -> String {
    if distance_m >= FARTHEST_M { "∞".to_owned() } else { format!("{distance_m:.1} m") }
}

/// Returns the distance that a text states.
fn distance_of(words: &str) -> Option<f64> {
    let words = words.trim().trim_end_matches('m').trim();
    if matches!(words, "∞" | "inf" | "infinity") { Some(FARTHEST_M) } else { words.parse().ok() }
}

/// Adds the controls of the camera, and the buttons.
fn camera_section(ui: &mut Ui, stats: &PanelStats<'_>, camera: &mut FlyCamera, requests: &mut PanelRequests) {
    row(ui, "Above ground", format!("{} m", digits(stats.height_above_ground_m)));
    row(ui, "Speed", format!("{} m/s", digits(camera.speed_m_s())));
    let [slowest, fastest] = SPEED_FACTORS;
    let slider =
        steady_slider(&mut camera.speed_factor, slowest..=fastest).logarithmic(true).suffix(" ×").max_decimals(2);
    let hint = "Factor on the speed, which follows from the height above the ground (Ctrl and the mouse wheel)";
    labelled(ui, "Speed factor", hint, slider);
    let [narrowest, widest] = FOV_RANGE_DEG;
    let slider = steady_slider(&mut camera.fov_deg, narrowest..=widest).suffix("°").max_decimals(1);
    labelled(ui, "Field of view", "Vertical field of view ([ ])", slider);
    let least_m = camera.least_clearance_m();
    let slider = steady_slider(&mut camera.clearance_m, least_m..=1000.0).logarithmic(true).suffix(" m");
    labelled(ui, "Clearance", "Smallest height of the camera above the ground", slider.max_decimals(1));
    let text = camera.camera().to_string();
    ui.add(egui::Label::new(RichText::new(&text).monospace().size(9.5)).wrap().selectable(true))
        .on_hover_text("Value for --camera");
    ui.horizontal(|ui| {
        let [has_back, has_forward] = stats.views;
        for (step, is_enabled, sign, name, hint) in [
            (ViewStep::Back, has_back, "‹", "Previous view", "Return to the previous view (Alt Left)"),
            (ViewStep::Forward, has_forward, "›", "Next view", "Go forward again to the next view (Alt Right)"),
        ] {
            let button = ui.add_enabled(is_enabled, egui::Button::new(sign));
            named(ui, button.id, name);
            if button.on_hover_text(hint).on_disabled_hover_text(hint).clicked() {
                requests.to_view = Some(step);
            }
        }
        if ui.button("Copy").on_hover_text("Copy the value for --camera").clicked() {
            ui.copy_text(text);
            requests.copied = true;
        }
        requests.restart = ui.button("Reset view").on_hover_text("Return to the start of the flight (R)").clicked();
        requests.screenshot =
            ui.button("Save picture").on_hover_text("Save the picture in the current folder (F12)").clicked();
    });
}

/// Adds times, and numbers of what is drawn and loaded.
fn performance(ui: &mut Ui, stats: &PanelStats<'_>) {
    let times = stats.frame_times;
    let quantile =
        |part: f64| times.quantile_ms(part).map_or_else(|| "—".to_owned(), |time_ms| format!("{time_ms:.1} ms"));
    explained(ui, "Frame time, median", "Half of the last frames took at most this long", quantile(0.5));
    explained(
        ui,
        "Frame time, 95 %",
        "All but one in twenty of the last frames took at most this long",
        quantile(0.95),
    );
    plot(ui, times);
    let gpu =
        stats.pass_times.passes().first().map_or_else(|| "—".to_owned(), |frame| format!("{:.2} ms", frame.gpu_ms));
    row(ui, "GPU time", gpu);
    row(ui, "Triangles", grouped(stats.triangles));
    row(ui, "Patches", grouped(stats.patches));
    if let Some(StrokeNumbers { drawn, left_out }) = stats.strokes {
        row(ui, "Strokes", grouped(drawn.into()));
        if let Some(text) = left_out.message() {
            ui.add(egui::Label::new(RichText::new(text).color(WARNING)).wrap());
        }
    }
    row(ui, "Tiles on GPU", grouped(stats.tiles_on_gpu));
    explained(ui, "Tiles loaded", "Tiles loaded since the start", grouped(stats.tiles_loaded));
    let hint = "Tiles that this view lacks now; coarser ones replace them";
    explained(ui, "Tiles missing", hint, grouped(stats.tiles_missing));
    if let Some(error_px) = stats.over_memory_px {
        let text = format!("Surface error now {error_px:.1} px: memory (more with --tile-memory)");
        ui.add(egui::Label::new(RichText::new(text).color(WARNING)).wrap());
    }
    if let Some(error_px) = stats.over_budget_px {
        let text = format!("Too many triangles: terrain error raised to {error_px:.1} px");
        ui.add(egui::Label::new(RichText::new(text).color(WARNING)).wrap());
    }
    row(ui, "GPU memory", format!("{:.1} MiB", stats.gpu_bytes as f64 / f64::from(1 << 20)));
    ui.label(RichText::new(stats.adapter).weak().size(9.0));
}

/// Plots frame times as bars, newest on the right, with a line at their median.
fn plot(ui: &mut Ui, times: &FrameTimes) {
    let (rect, _) = ui.allocate_exact_size(egui::vec2(ui.available_width(), PLOT_HEIGHT), Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, Color32::from_white_alpha(12));
    let Some(median_ms) = times.quantile_ms(0.5) else { return };
    let full_ms = (2.0 * median_ms).max(1.25 * times.quantile_ms(0.95).unwrap_or(median_ms)).max(0.1);
    let top = |time_ms: f64| rect.bottom() - rect.height() * (time_ms / full_ms).min(1.0) as f32;
    let step = rect.width() / FRAMES as f32;
    let first = FRAMES - times.iter().count();
    for (place, time_ms) in times.iter().enumerate() {
        let left = rect.left() + step * (first + place) as f32;
        let bar =
            egui::Rect::from_min_max(egui::pos2(left, top(time_ms)), egui::pos2(left + step * 0.8, rect.bottom()));
        painter.rect_filled(bar, 0.0, Color32::from_rgb(120, 160, 190));
    }
    painter.hline(rect.x_range(), top(median_ms), (1.0, Color32::from_white_alpha(90)));
}

/// Formats a length in metres: with one decimal below 100 m, otherwise with groups of digits.
fn digits(length_m: f64) -> String {
    let size_m = length_m.abs();
    let text = if size_m < 100.0 { format!("{size_m:.1}") } else { grouped(size_m.round() as u64) };
    let sign = if length_m < 0.0 && text != "0.0" { "−" } else { "" };
    format!("{sign}{text}")
}

/// Formats 1234567 as `1 234 567`.
pub(super) fn grouped(number: u64) -> String {
    let text = number.to_string();
    let mut grouped = String::with_capacity(text.len() * 4 / 3);
    for (place, digit) in text.chars().enumerate() {
        if place > 0 && (text.len() - place).is_multiple_of(3) {
            grouped.push(' ');
        }
        grouped.push(digit);
    }
    grouped
}
