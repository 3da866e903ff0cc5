//! The export dialog: what is written, on which page, and the command line that does the same.
//!
//! Why: `docs/decisions/exports.md`.

mod preview;
pub(super) mod run;

#[cfg(test)]
mod tests;

use egui::{DragValue, Response, RichText, ScrollArea, Ui};

use super::panel::WARNING;
use crate::picture::aov::CHANNELS;
use crate::studio::export::{Export, Kind, Page, STEREO, ShownView, quoted};

/// Width of the column with the options and of that with the page, in points.
const COLUMNS: [f32; 2] = [238.0, 250.0];
/// Distance from the border of the window in points.
const MARGIN: f32 = 16.0;
/// The sides of a picture that the dialog offers, in pixels.
const PIXELS: std::ops::RangeInclusive<u32> = 1..=1 << 20;
/// Paper sizes of the list; others are typed.
const PAPERS: [&str; 7] = ["a0", "a1", "a2", "a3", "a4", "letter", "tabloid"];

/// What the dialog says about a path that is not saved.
const COPY: &str = "The camera path has edits that are not saved. The film is drawn from a copy in hachure's cache; save \
                    the path to draw the film again later.";

/// A request of the user in the dialog.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Request {
    /// Run the program with these arguments, which write this output.
    Run(Vec<String>, String),
    /// Save the style, or ask for its name.
    SaveStyle,
    /// Show all layers of the style.
    ShowLayers,
}

/// A reason why no command line draws the style of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Refusal {
    /// It has edits that are not saved.
    Edited,
    /// Some of its layers are not drawn.
    Hidden,
}

impl Refusal {
    fn words(self) -> &'static str {
        match self {
            Self::Edited => "The style has edits that are not saved, so no command line draws it.",
            Self::Hidden => "Layers of the style are hidden, or one is drawn alone; a command line draws all of them.",
        }
    }

    /// Returns the button that removes the reason, and what it asks for.
    fn remedy(self) -> (&'static str, Request) {
        match self {
            Self::Edited => ("Save the style", Request::SaveStyle),
            Self::Hidden => ("Show all layers", Request::ShowLayers),
        }
    }
}

/// The view of the window, which the dialog exports.
pub(super) struct Shown<'a> {
    /// The view as it would be drawn.
    pub view: &'a ShownView,
    /// Why no command line draws it, if none does.
    pub refusal: Option<Refusal>,
    /// Size of the window's picture.
    pub window_px: [u32; 2],
}

/// The dialog.
#[derive(Debug)]
pub(super) struct ExportDialog {
    is_open: bool,
    export: Export,
    /// Whether the dialog takes its size and its name from the window when it opens next.
    is_new: bool,
    /// Whether the command line was copied, until something else changes.
    copied: Option<String>,
    /// The path in hachure's cache that is a copy of the one that is edited.
    copy: Option<String>,
}

impl Default for ExportDialog {
    fn default() -> Self {
        Self { is_open: false, export: Export::new([1280, 720], 1), is_new: true, copied: None, copy: None }
    }
}

impl ExportDialog {
    /// Opens or closes the dialog. `output` is the name of the first output, without an ending.
    pub(super) fn toggle(&mut self, output: &str, size_px: [u32; 2], samples: u32) {
        self.is_open = !self.is_open;
        if self.is_open && std::mem::take(&mut self.is_new) {
            self.export = Export { output: format!("{output}.png"), ..Export::new(size_px, samples) };
        }
    }

    /// Chooses a film along a path. If `is_copy`, the file is a copy in hachure's cache of a path that is not saved.
    pub(super) fn film(&mut self, path: &str, is_copy: bool) {
        self.export.set_kind(Kind::Film);
        path.clone_into(&mut self.export.path);
        self.copy = is_copy.then(|| path.to_owned());
    }

    /// Returns whether the dialog is open.
    pub(super) fn is_open(&self) -> bool {
        self.is_open
    }

    /// Closes the dialog.
    pub(super) fn close(&mut self) {
        self.is_open = false;
    }

    /// Closes the dialog and forgets its settings, because the name of the output belongs to another world.
    pub(super) fn forget(&mut self) {
        (self.is_open, self.is_new) = (false, true);
    }

    /// Lays out the dialog and returns what the user asks for.
    pub(super) fn show(&mut self, context: &egui::Context, shown: &Shown<'_>) -> Option<Request> {
        if !self.is_open {
            return None;
        }
        let mut request = None;
        let mut stays = true;
        let free = context.content_rect().shrink(MARGIN);
        let window =
            egui::Window::new("Export a drawing").id(egui::Id::unique("export")).open(&mut stays).collapsible(false);
        let window = window.anchor(egui::Align2::CENTER_TOP, [0.0, MARGIN]).resizable(false);
        let width = (COLUMNS[0] + COLUMNS[1] + 16.0).min(free.width() - 2.0 * MARGIN);
        window.order(egui::Order::Foreground).show(context, |ui| {
            ui.set_width(width);
            ScrollArea::vertical().max_height((free.height() - 40.0).max(80.0)).show(ui, |ui| {
                request = self.content(ui, shown);
            });
        });
        if !stays {
            self.is_open = false;
            context.request_repaint();
        }
        request
    }

    fn content(&mut self, ui: &mut Ui, shown: &Shown<'_>) -> Option<Request> {
        ui.horizontal_wrapped(|ui| {
            for (kind, name) in Kind::ALL {
                if ui.selectable_label(self.export.kind == kind, name).clicked() {
                    self.export.set_kind(kind);
                }
            }
        });
        ui.separator();
        let page = Page::of(&self.export);
        ui.horizontal_top(|ui| {
            ui.vertical(|ui| {
                ui.set_width(COLUMNS[0]);
                options(ui, &mut self.export);
                if self.export.kind == Kind::Film && self.copy.as_ref() == Some(&self.export.path) {
                    ui.add(egui::Label::new(RichText::new(COPY).weak()).wrap());
                }
            });
            ui.vertical(|ui| {
                let width = ui.available_width().min(COLUMNS[1]);
                match &page {
                    Ok(page) => {
                        preview::show(ui, page, width, shown.window_px, self.export.kind != Kind::Map);
                        ui.add(egui::Label::new(RichText::new(&page.words).weak()).wrap());
                    }
                    Err(error) => _ = warning(ui, error),
                }
            });
        });
        ui.separator();
        self.command(ui, shown)
    }

    /// Adds the output, the command line and the buttons.
    fn command(&mut self, ui: &mut Ui, shown: &Shown<'_>) -> Option<Request> {
        ui.horizontal(|ui| {
            ui.label(RichText::new("Write to").weak());
            let field = egui::TextEdit::singleline(&mut self.export.output).desired_width(ui.available_width() - 8.0);
            let field = ui.add(field);
            name(&field, "Path of the output");
            let absolute = std::path::absolute(self.export.output_path());
            field.on_hover_text(absolute.map_or_else(|_| String::new(), |path| path.display().to_string()));
        });
        let mut request = None;
        let refusal = shown.refusal.map(|refusal| refusal.words().to_owned()).or_else(|| self.export.refusal());
        let arguments = self.export.arguments(shown.view);
        let line = quoted(&arguments);
        match &refusal {
            Some(refusal) => _ = warning(ui, refusal),
            None => {
                ui.add(egui::Label::new(RichText::new(&line).monospace().size(9.5)).wrap().selectable(true));
                if self.export.replaces_own() {
                    ui.label(RichText::new("This replaces a picture that hachure drew.").weak());
                }
            }
        }
        ui.horizontal(|ui| {
            let may = refusal.is_none();
            let export = ui.add_enabled(may, egui::Button::new("Export"));
            if export.on_hover_text("Draw it in the background, with this command line").clicked() {
                request = Some(Request::Run(arguments, self.export.output_path()));
            }
            let is_copied = self.copied.as_ref() == Some(&line);
            let copy = egui::Button::new(if is_copied { "Copied" } else { "Copy the command" });
            if ui.add_enabled(may, copy).on_hover_text("Copy the command line").clicked() {
                ui.copy_text(line.clone());
                self.copied = Some(line);
            }
            if let Some((label, remedy)) = shown.refusal.map(Refusal::remedy)
                && ui.button(label).clicked()
            {
                request = Some(remedy);
            }
        });
        request
    }
}

/// Adds the options of a kind.
fn options(ui: &mut Ui, export: &mut Export) {
    let endings = export.kind.endings();
    if endings.len() > 1 {
        row(ui, "Format", |ui| {
            for ending in endings {
                if ui.selectable_label(export.ending() == *ending, format!(".{ending}")).clicked() {
                    export.set_ending(ending);
                }
            }
            if export.kind == Kind::Film && ui.selectable_label(export.is_frames(), "frames").clicked() {
                export.set_frames();
            }
        });
    }
    let may_be_on_paper = matches!(export.kind, Kind::Picture | Kind::Lines | Kind::Map);
    if may_be_on_paper && export.ending() != "geojson" {
        row(ui, "Size", |ui| {
            ui.selectable_value(&mut export.is_on_paper, false, "pixels");
            ui.selectable_value(&mut export.is_on_paper, true, "paper");
        });
    }
    if export.has_paper() {
        paper_options(ui, export);
    }
    if !export.has_paper() || export.kind == Kind::Lines {
        row(ui, "Pixels", |ui| {
            let [width, height] = &mut export.size_px;
            name(&ui.add(DragValue::new(width).range(PIXELS)), "Width in pixels");
            ui.label("×");
            name(&ui.add(DragValue::new(height).range(PIXELS)), "Height in pixels");
        });
    }
    if export.has_samples() {
        row(ui, "Samples per pixel", |ui| {
            name(&ui.add(DragValue::new(&mut export.samples).range(1..=64)), "Samples per pixel");
        });
    }
    kind_options(ui, export);
    if export.has_title() {
        row(ui, "Title", |ui| {
            let field = egui::TextEdit::singleline(&mut export.title).hint_text("none").desired_width(150.0);
            name(&ui.add(field), "Title below the picture");
        });
    }
}

/// Adds the options of paper.
fn paper_options(ui: &mut Ui, export: &mut Export) {
    row(ui, "Paper", |ui| {
        paper(ui, "Paper", &mut export.paper);
        if export.kind != Kind::Lines {
            ui.selectable_value(&mut export.is_portrait, false, "landscape");
            ui.selectable_value(&mut export.is_portrait, true, "portrait");
        }
    });
    if export.kind == Kind::Lines {
        row(ui, "Margin", |ui| {
            let value = DragValue::new(&mut export.margin_mm).range(0.0..=500.0).suffix(" mm");
            name(&ui.add(value), "Margin in millimetres");
        });
    } else {
        row(ui, "Dots per inch", |ui| {
            name(&ui.add(DragValue::new(&mut export.dpi).range(10.0..=2400.0)), "Dots per inch");
        });
    }
}

/// Adds the options that only one kind has.
fn kind_options(ui: &mut Ui, export: &mut Export) {
    match export.kind {
        Kind::Picture => {}
        Kind::Sheets => {
            row(ui, "Sheets", |ui| paper(ui, "Paper of the sheets", &mut export.sheets));
            row(ui, "Overlap", |ui| {
                let value = DragValue::new(&mut export.overlap_mm).range(0.0..=100.0).suffix(" mm");
                name(&ui.add(value), "Overlap in millimetres");
            });
        }
        Kind::Lines => pens(ui, export),
        Kind::Exr => {
            ui.label(RichText::new("Channels").weak());
            ui.horizontal_wrapped(|ui| {
                for channel in CHANNELS {
                    let mut is_on = export.channels.contains(&channel);
                    if ui.checkbox(&mut is_on, channel).changed() {
                        // In the order of the list, so that the command line does not depend on the clicks.
                        let before = std::mem::take(&mut export.channels);
                        let is_in = |known: &&&str| if **known == channel { is_on } else { before.contains(known) };
                        export.channels = CHANNELS.iter().filter(is_in).copied().collect();
                    }
                }
            });
        }
        Kind::Map => {
            row(ui, "Area", |ui| {
                let mut is_whole = export.map_width_m.is_none();
                ui.selectable_value(&mut is_whole, true, "all land");
                ui.selectable_value(&mut is_whole, false, "around the camera");
                if is_whole != export.map_width_m.is_none() {
                    export.map_width_m = (!is_whole).then_some(5000.0);
                }
            });
            if let Some(width_m) = &mut export.map_width_m {
                row(ui, "Width", |ui| {
                    let value = DragValue::new(width_m).range(1.0..=1e7).speed(50.0).suffix(" m");
                    name(&ui.add(value), "Width of the map in metres");
                });
            }
            if export.ending() == "geojson" {
                ui.checkbox(&mut export.is_wgs84, "Longitudes and latitudes (WGS 84)");
                pens(ui, export);
            }
        }
        Kind::Stereo => row(ui, "Eyes", |ui| {
            let list = egui::ComboBox::from_id_salt("eyes of the export").selected_text(export.eyes);
            let list = list.show_ui(ui, |ui| {
                STEREO.iter().for_each(|eyes| _ = ui.selectable_value(&mut export.eyes, *eyes, *eyes));
            });
            name(&list.response, "Layout of the eyes");
        }),
        Kind::Film => {
            row(ui, "Camera path", |ui| {
                let hint = "path.csv, or tour";
                let field = egui::TextEdit::singleline(&mut export.path).hint_text(hint).desired_width(130.0);
                name(&ui.add(field), "Camera path of the film");
            });
            row(ui, "Frames per second", |ui| {
                name(&ui.add(DragValue::new(&mut export.fps).range(1.0..=120.0)), "Frames per second");
            });
        }
    }
}

fn pens(ui: &mut Ui, export: &mut Export) {
    row(ui, "Pens", |ui| {
        ui.selectable_value(&mut export.pens, 0, "any width");
        (1..=3).for_each(|count| _ = ui.selectable_value(&mut export.pens, count, count.to_string()));
    });
}

/// Adds a list of paper sizes and a field for others.
fn paper(ui: &mut Ui, label: &str, paper: &mut String) {
    let hint = "a0 to a6, letter, legal, tabloid, or WIDTHxHEIGHT in millimetres";
    let field = ui.add(egui::TextEdit::singleline(paper).desired_width(52.0)).on_hover_text(hint);
    name(&field, label);
    let list = egui::ComboBox::from_id_salt(label).selected_text("").width(18.0).show_ui(ui, |ui| {
        PAPERS.iter().for_each(|known| _ = ui.selectable_value(paper, (*known).to_owned(), *known));
    });
    name(&list.response, &format!("{label}: list of sizes"));
}

fn row(ui: &mut Ui, label: &str, content: impl FnOnce(&mut Ui)) {
    ui.horizontal(|ui| {
        ui.label(RichText::new(label).weak());
        content(ui);
    });
}

/// Names a widget for a screen reader.
fn name(response: &Response, label: &str) {
    response.ctx.accesskit_node_builder(response.id, |node| node.set_label(label));
}

fn warning(ui: &mut Ui, text: &str) -> Response {
    ui.add(egui::Label::new(RichText::new(text).color(WARNING)).wrap())
}
