//! The export dialog: the kind of output, its page, and the command line that does the same.
//!
//! Why: `docs/decisions/exports.md`.

mod options;
mod preview;
pub(super) mod run;

#[cfg(test)]
mod tests;

use std::path::PathBuf;

use egui::{Response, RichText, ScrollArea, Ui};

use super::panel::WARNING;
use crate::file::message::named;
use crate::studio::export::{Export, Kind, Page, ShownView, quoted};

/// Width of the column with the options and of that with the page, in points.
const COLUMNS: [f32; 2] = [238.0, 250.0];
/// Distance from the border of the window in points.
const MARGIN: f32 = 16.0;

/// The message about a path that is not saved.
const COPY: &str = "The camera path has edits that are not saved. The film is drawn from a copy in hachure's cache; save \
                    the path to draw the film again later.";

/// A request of the user in the dialog.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ExportRequest {
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
    /// The style has edits that are not saved.
    Edited,
    /// Some layers of the style are not drawn.
    Hidden,
}

impl Refusal {
    fn words(self) -> &'static str {
        match self {
            Self::Edited => "The style has edits that are not saved, so no command line draws it.",
            Self::Hidden => "Layers of the style are hidden, or one is drawn alone; a command line draws all of them.",
        }
    }

    /// Returns the text of the button that removes the reason, and its request.
    fn remedy(self) -> (&'static str, ExportRequest) {
        match self {
            Self::Edited => ("Save the style", ExportRequest::SaveStyle),
            Self::Hidden => ("Show all layers", ExportRequest::ShowLayers),
        }
    }
}

/// The view of the window, which the dialog exports.
pub(super) struct WindowView<'a> {
    /// The view as it would be drawn.
    pub view: &'a ShownView,
    /// The reason why no command line draws the view; `None` if one does.
    pub refusal: Option<Refusal>,
    /// Size of the window's picture.
    pub window_px: [u32; 2],
}

/// The export dialog, open or closed.
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
    /// The question about files that the export would replace although hachure did not draw them.
    question: Option<Question>,
}

/// The question whether files of the user may be replaced. It is void when the options change.
#[derive(Debug)]
struct Question {
    /// The export about which the user was asked.
    export: Export,
    files: Vec<PathBuf>,
}

impl Question {
    fn words(&self) -> String {
        let first = self.files.first().map(named).unwrap_or_default();
        match self.files.len() {
            0 | 1 => format!("{first} exists, and hachure did not draw it. Replace it?"),
            count => format!("{first} and {} others exist, and hachure did not draw them. Replace them?", count - 1),
        }
    }

    /// Returns the names of the buttons that replace the files and that keep them.
    fn answers(&self) -> [&'static str; 2] {
        if self.files.len() == 1 { ["Replace it", "Keep it"] } else { ["Replace them", "Keep them"] }
    }
}

impl Default for ExportDialog {
    fn default() -> Self {
        Self {
            is_open: false,
            export: Export::new([1280, 720], 1),
            is_new: true,
            copied: None,
            copy: None,
            question: None,
        }
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
        (self.is_open, self.question) = (false, None);
    }

    /// Closes the dialog and forgets its settings, because the name of the output belongs to another world.
    pub(super) fn forget(&mut self) {
        self.close();
        self.is_new = true;
    }

    /// Lays out the dialog and returns the user's request.
    pub(super) fn show(&mut self, context: &egui::Context, shown: &WindowView<'_>) -> Option<ExportRequest> {
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
            self.close();
            context.request_repaint();
        }
        request
    }

    fn content(&mut self, ui: &mut Ui, shown: &WindowView<'_>) -> Option<ExportRequest> {
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
                options::show(ui, &mut self.export);
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
    fn command(&mut self, ui: &mut Ui, shown: &WindowView<'_>) -> Option<ExportRequest> {
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
        if refusal.is_some() || self.question.as_ref().is_some_and(|question| question.export != self.export) {
            self.question = None;
        }
        let mut arguments = self.export.arguments(shown.view);
        if self.question.is_some() {
            arguments.push("--overwrite".to_owned());
        }
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
        if let Some(question) = &self.question {
            warning(ui, &question.words());
        }
        ui.horizontal(|ui| {
            let may = refusal.is_none();
            request = self.answer(ui, may, arguments);
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

    /// Adds the button that exports, or those that answer the question about files of the user. `arguments` are those of
    /// the program.
    fn answer(&mut self, ui: &mut Ui, may: bool, arguments: Vec<String>) -> Option<ExportRequest> {
        let run = |export: &Export| ExportRequest::Run(arguments, export.output_path());
        let Some(question) = &self.question else {
            let export = ui.add_enabled(may, egui::Button::new("Export"));
            if !export.on_hover_text("Draw it in the background, with this command line").clicked() {
                return None;
            }
            let files = self.export.foreign();
            if files.is_empty() {
                return Some(run(&self.export));
            }
            self.question = Some(Question { export: self.export.clone(), files });
            ui.ctx().request_repaint();
            return None;
        };
        let [replace, keep] = question.answers().map(|answer| ui.button(answer).clicked());
        if replace || keep {
            self.question = None;
            ui.ctx().request_repaint();
        }
        replace.then(|| run(&self.export))
    }
}

/// Names a widget for a screen reader.
fn name(response: &Response, label: &str) {
    response.ctx.accesskit_node_builder(response.id, |node| node.set_label(label));
}

fn warning(ui: &mut Ui, text: &str) -> Response {
    ui.add(egui::Label::new(RichText::new(text).color(WARNING)).wrap())
}
