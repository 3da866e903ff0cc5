//! The dialog that opens a file: a field for its path, the system's dialog, and the files that were opened last.

use egui::{Key, RichText, Ui};

use super::browse::DialogKind;
use super::panel::WARNING;
use crate::file::message::named;
use crate::studio::recent::Entry;

/// Width in points.
const WIDTH: f32 = 420.0;
/// Distance from the border of the window in points.
const MARGIN: f32 = 16.0;

/// A request of the user in the dialog.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum OpenRequest {
    /// Open this file, address or name.
    Open(String),
    /// Show the dialog of the system.
    Browse(DialogKind),
    /// Open the built-in world.
    BuiltIn,
}

/// The dialog, if it is open.
#[derive(Debug, Default)]
pub(super) struct OpenDialog {
    is_open: bool,
    text: String,
    entries: Vec<Entry>,
    /// The error of the last request, if it failed.
    error: Option<String>,
    takes_focus: bool,
}

impl OpenDialog {
    /// Opens the dialog with the files that were opened last, or closes it.
    pub(super) fn toggle(&mut self, entries: Vec<Entry>) {
        *self = Self { is_open: !self.is_open, takes_focus: true, entries, ..Self::default() };
    }

    /// Returns whether the dialog is open.
    pub(super) fn is_open(&self) -> bool {
        self.is_open
    }

    /// Closes the dialog.
    pub(super) fn close(&mut self) {
        self.is_open = false;
    }

    /// Shows why something failed, if the dialog is open.
    pub(super) fn refuse(&mut self, error: &str) {
        self.error = Some(error.to_owned());
        self.takes_focus = true;
    }

    /// Lays out the dialog and returns the user's request.
    pub(super) fn show(&mut self, context: &egui::Context) -> Option<OpenRequest> {
        if !self.is_open {
            return None;
        }
        let mut request = None;
        let mut stays = true;
        let free = context.content_rect().shrink(MARGIN);
        let window = egui::Window::new("Open a file").id(egui::Id::unique("open")).open(&mut stays).collapsible(false);
        let window = window.anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0]).resizable(false);
        window.order(egui::Order::Foreground).show(context, |ui| {
            ui.set_width(WIDTH.min(free.width() - 2.0 * MARGIN));
            request = self.content(ui, free.height() - 150.0);
        });
        let escapes = context.input(|input| input.key_pressed(Key::Escape));
        if !stays || escapes {
            self.is_open = false;
            context.request_repaint();
        }
        request
    }

    fn content(&mut self, ui: &mut Ui, tallest: f32) -> Option<OpenRequest> {
        let mut request = None;
        ui.add(egui::Label::new("A scene, a DEM, a folder of DEMs, a model (OBJ), an address, a style or a camera path. Files may also be dropped on the window.").wrap());
        ui.horizontal(|ui| {
            let width = (ui.available_width() - 52.0).max(60.0);
            let hint = "/path/to/mountain.tif";
            let field = ui.add(egui::TextEdit::singleline(&mut self.text).hint_text(hint).desired_width(width));
            ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("Path of a file or folder"));
            if std::mem::take(&mut self.takes_focus) {
                field.request_focus();
            }
            if field.changed() {
                self.error = None;
            }
            let has_enter = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            let is_named = !self.text.trim().is_empty();
            let open = ui.add_enabled(is_named, egui::Button::new("Open")).on_hover_text("Open it (Enter)");
            if (open.clicked() || has_enter) && is_named {
                request = Some(OpenRequest::Open(self.text.trim().to_owned()));
            }
        });
        ui.horizontal(|ui| {
            if ui.button("Choose a file…").clicked() {
                request = Some(OpenRequest::Browse(DialogKind::File));
            }
            if ui.button("Choose a folder…").clicked() {
                request = Some(OpenRequest::Browse(DialogKind::Folder));
            }
            if ui.button("Built-in world").on_hover_text("Procedural mountains").clicked() {
                request = Some(OpenRequest::BuiltIn);
            }
        });
        if let Some(error) = &self.error {
            ui.add(egui::Label::new(RichText::new(error).color(WARNING)).wrap());
        }
        ui.separator();
        ui.label(RichText::new("Opened last").strong());
        if self.entries.is_empty() {
            ui.label(RichText::new("Nothing yet.").weak());
        }
        egui::ScrollArea::vertical().max_height(tallest.max(60.0)).show(ui, |ui| {
            for entry in &self.entries {
                if recent(ui, entry) {
                    request = Some(OpenRequest::Open(entry.name.clone()));
                }
            }
        });
        request
    }
}

/// Adds a file that was opened before. Returns whether it was clicked.
fn recent(ui: &mut Ui, entry: &Entry) -> bool {
    let name = named(&entry.name);
    let text = match &entry.missing {
        None => name,
        Some(reason) => format!("{name}: {reason}"),
    };
    let button = egui::Button::new(text).truncate().frame(false);
    ui.add_enabled(entry.missing.is_none(), button).on_hover_text(&entry.name).clicked()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use egui_kittest::Harness;
    use egui_kittest::kittest::{NodeT as _, Queryable as _};

    use super::*;

    #[derive(Default)]
    struct Bench {
        dialog: OpenDialog,
        requests: Vec<OpenRequest>,
    }

    fn entries() -> Vec<Entry> {
        let gone = Some("the file no longer exists".to_owned());
        vec![
            Entry { name: "/data/alps.tif".to_owned(), missing: None },
            Entry { name: "/data/gone.tif".to_owned(), missing: gone },
        ]
    }

    fn harness<'a>(size: egui::Vec2) -> Harness<'a, Bench> {
        let harness = Harness::builder().with_size(size).with_context_setup(crate::window::panel::set_up);
        let mut harness = harness.build_ui_state(
            |ui, bench: &mut Bench| {
                let request = bench.dialog.show(ui.ctx());
                bench.requests.extend(request);
            },
            Bench::default(),
        );
        harness.state_mut().dialog.toggle(entries());
        harness.run();
        harness
    }

    #[test]
    fn a_path_is_typed_chosen_or_opened_again() {
        let mut harness = harness(egui::vec2(960.0, 540.0));
        assert!(harness.get_by_label("Open").accesskit_node().is_disabled(), "nothing is typed yet");
        // The field has the keyboard at once.
        harness.get_by_label("Path of a file or folder").type_text(" /data/new.tif ");
        harness.run();
        harness.key_press(Key::Enter);
        harness.run();
        for label in ["Choose a file…", "Choose a folder…", "Built-in world", "/data/alps.tif"] {
            harness.get_by_label(label).click();
            harness.run();
        }
        let gone = "/data/gone.tif: the file no longer exists";
        assert!(harness.get_by_label(gone).accesskit_node().is_disabled());
        harness.get_by_label(gone).click();
        harness.run();
        let wanted = [
            OpenRequest::Open("/data/new.tif".to_owned()),
            OpenRequest::Browse(DialogKind::File),
            OpenRequest::Browse(DialogKind::Folder),
            OpenRequest::BuiltIn,
            OpenRequest::Open("/data/alps.tif".to_owned()),
        ];
        assert_eq!(harness.state().requests, wanted);
    }

    #[test]
    fn an_error_is_shown_and_esc_closes() {
        let mut harness = harness(egui::vec2(640.0, 360.0));
        harness.state_mut().dialog.refuse("x.tif: there is no such file");
        harness.run();
        assert!(harness.query_by_label("x.tif: there is no such file").is_some());
        harness.key_press(Key::Escape);
        harness.run();
        assert!(!harness.state().dialog.is_open() && harness.query_by_label("Open a file").is_none());
        harness.state_mut().dialog.toggle(entries());
        harness.run();
        assert!(harness.query_by_label("x.tif: there is no such file").is_none(), "an old error");
    }
}
