//! The panel of the camera path: play, time line, key frames, named views, files, and the film.
//!
//! The panel shows a [`PathDocument`] and returns the user's requests; [`PathPanel::apply`] carries out edits.

mod timeline;

#[cfg(test)]
mod tests;

use egui::{Align, Button, DragValue, Key, Label, Layout, Response, RichText, ScrollArea, TextEdit, Ui};

use super::panel::WARNING;
use super::path_flight::Player;
use crate::scene::camera::Camera;
use crate::scene::path::LATEST_S;
use crate::studio::camera_path::PathDocument;
use crate::studio::views::Views;

/// Height of a row of the lists in points.
const ROW: f32 = 18.0;
/// Least height of the lists in points; a lower panel scrolls as a whole.
const LEAST_LIST: f32 = 58.0;
/// Least and greatest width of the list of views in points.
const VIEWS: [f32; 2] = [150.0, 260.0];

/// A request of the user in the panel.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum PathRequest {
    /// Change the path.
    Edit(PathEdit),
    /// Move the playhead, and the camera with it.
    Seek(f64),
    /// Play, or pause.
    Play(bool),
    /// Begin again after the last key, or not.
    Loop(bool),
    /// Write the file of the path.
    Save,
    /// Write a new file.
    SaveAs(String),
    /// Begin a path without keys.
    New,
    /// Open the dialog for files.
    Open,
    /// Open the export dialog with a film of the path.
    Film,
    /// Restore the edits of an earlier run, or discard them.
    Restore(bool),
    /// Keep the current view under a name.
    AddView,
    /// Fly to a named view.
    GoTo(usize),
    /// Rename a view.
    Rename(usize, String),
    /// Write the names of the views.
    KeepViews,
    /// Forget a view.
    RemoveView(usize),
}

/// A change of the path. Keys are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum PathEdit {
    /// Add a key with the current view.
    Add,
    /// Add a key with another camera.
    AddCamera(Camera),
    /// Replace the camera of a key by the current view.
    Replace(usize),
    Remove(usize),
    /// Move a key to a time in seconds.
    Move(usize, f64),
    /// Change the ease of a key: the fraction of its speed that the camera loses there, 0 to 1.
    Ease(usize, f64),
    /// Change the duration of the whole path, in seconds.
    Duration(f64),
    /// The mouse is released: the next change is another step.
    Release,
    Undo,
    Redo,
}

/// The contents of the panel.
#[derive(Clone, Copy)]
pub(super) struct PathState<'a> {
    pub document: &'a PathDocument,
    pub player: &'a Player,
    pub views: &'a Views,
    /// Whether an earlier run has left edits of this path that are not saved.
    pub has_kept: bool,
}

/// The state of the panel.
#[derive(Debug, Default)]
pub(super) struct PathPanel {
    /// The key that is selected.
    selected: Option<usize>,
    timeline: timeline::Timeline,
    /// The name of a new file, while it is typed.
    save_as: Option<String>,
    takes_focus: bool,
    /// The error of the last request, if it failed.
    error: Option<String>,
    /// Whether the next click begins a new path although there are edits.
    discards: bool,
    /// The key to which the list scrolls in the next frame.
    scroll_to: Option<usize>,
}

impl PathPanel {
    /// Forgets what concerned the last path.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Shows why a request failed, or that it did not.
    pub(super) fn set_error(&mut self, error: Option<String>) {
        self.takes_focus = error.is_some();
        self.error = error;
    }

    /// Opens the field for the name of a new file.
    pub(super) fn ask_for_name(&mut self, name: &str) {
        self.save_as.get_or_insert_with(|| name.to_owned());
        self.takes_focus = true;
    }

    /// Closes the field for the name.
    pub(super) fn end_name(&mut self) {
        self.save_as = None;
    }

    /// Carries out an edit. `here` is the current view. Returns why it was refused.
    pub(super) fn apply(
        &mut self,
        document: &mut PathDocument,
        player: &mut Player,
        edit: PathEdit,
        here: &Camera,
    ) -> Result<(), String> {
        self.discards = false;
        match edit {
            PathEdit::Add => self.add(document, player, here)?,
            PathEdit::AddCamera(camera) => self.add(document, player, &camera)?,
            PathEdit::Replace(index) => document.replace(index, here)?,
            PathEdit::Remove(index) => {
                document.remove(index)?;
                self.selected = None;
            }
            PathEdit::Move(index, time_s) => {
                document.move_to(index, time_s)?;
                player.playhead_s = document.keys()[index].time_s;
            }
            PathEdit::Ease(index, ease) => document.set_ease(index, ease)?,
            PathEdit::Duration(duration_s) => {
                let before_s = document.span_s();
                document.set_duration(duration_s)?;
                let after_s = document.span_s();
                let part = (player.playhead_s - before_s[0]) / (before_s[1] - before_s[0]).max(1e-9);
                player.playhead_s = after_s[0] + part * (after_s[1] - after_s[0]);
            }
            PathEdit::Release => document.release(),
            PathEdit::Undo => _ = document.undo(),
            PathEdit::Redo => _ = document.redo(),
        }
        self.selected = self.selected.filter(|index| *index < document.keys().len());
        Ok(())
    }

    fn add(&mut self, document: &mut PathDocument, player: &mut Player, camera: &Camera) -> Result<(), String> {
        let index = document.add(document.time_for_new(player.playhead_s), camera)?;
        self.select(index);
        player.playhead_s = document.keys()[index].time_s;
        Ok(())
    }

    fn select(&mut self, index: usize) {
        (self.selected, self.scroll_to) = (Some(index), Some(index));
    }

    /// Lays out the panel and returns the user's requests.
    pub(super) fn show(&mut self, ui: &mut Ui, shown: &PathState<'_>) -> Vec<PathRequest> {
        let mut requests = Vec::new();
        let keys = shown.document.keys().len();
        self.selected = self.selected.filter(|index| *index < keys);
        let id = ui.scope_id().with("camera path");
        ScrollArea::vertical().id_salt(id).auto_shrink(false).show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                play_row(ui, shown, &mut requests);
                self.file_row(ui, shown, &mut requests);
            });
            self.notices(ui, shown, &mut requests);
            if let Some(index) = self.timeline.show(ui, shown, self.selected, &mut requests) {
                self.select(index);
            }
            let height = ui.available_height().max(LEAST_LIST);
            let views = (0.35 * ui.available_width()).clamp(VIEWS[0], VIEWS[1]);
            ui.horizontal_top(|ui| {
                let keys = (ui.available_width() - views - 24.0).max(100.0);
                ui.allocate_ui_with_layout(egui::vec2(keys, height), Layout::top_down(Align::Min), |ui| {
                    self.key_list(ui, shown, height, &mut requests);
                });
                ui.separator();
                ui.allocate_ui_with_layout(egui::vec2(views, height), Layout::top_down(Align::Min), |ui| {
                    view_list(ui, shown, height, &mut requests);
                });
            });
        });
        let deletes = !ui.ctx().text_edit_focused() && ui.input(|input| input.key_pressed(Key::Delete));
        requests.extend(self.selected.filter(|_| deletes).map(|index| PathRequest::Edit(PathEdit::Remove(index))));
        requests
    }

    fn file_row(&mut self, ui: &mut Ui, shown: &PathState<'_>, requests: &mut Vec<PathRequest>) {
        let document = shown.document;
        let has_keys = !document.keys().is_empty();
        ui.separator();
        let [undo, redo] = document.step_names();
        let steps = [("Undo", undo, PathEdit::Undo), ("Redo", redo, PathEdit::Redo)];
        for (text, step, edit) in steps {
            let button = ui.add_enabled(step.is_some(), Button::new(text));
            name(&button, &format!("{text} an edit of the path"));
            let hint =
                format!("{text}: {} (Ctrl Z, Ctrl Y while the mouse is over this panel)", step.unwrap_or_default());
            if button.on_hover_text(hint).clicked() {
                requests.push(PathRequest::Edit(edit));
            }
        }
        ui.separator();
        let may_save = has_keys && document.is_edited() && document.path().is_some();
        let save = ui.add_enabled(may_save, Button::new("Save"));
        name(&save, "Save the path");
        if save.on_hover_text("Write the file (Ctrl S while the mouse is over this panel)").clicked() {
            requests.push(PathRequest::Save);
        }
        let save_as = ui.add_enabled(has_keys, Button::new("Save as…"));
        name(&save_as, "Save the path as");
        if save_as.on_hover_text("Write a new CSV file for --path").clicked() {
            self.ask_for_name("path.csv");
        }
        let open = ui.button("Open…");
        name(&open, "Open a path");
        if open
            .on_hover_text("Open a CSV file or a built-in path (Ctrl O); files may also be dropped on the window")
            .clicked()
        {
            requests.push(PathRequest::Open);
        }
        let is_new = !has_keys && document.name().is_empty();
        let text = if self.discards { "Discard the edits" } else { "New" };
        let new = ui.add_enabled(!is_new, Button::new(text));
        name(&new, if self.discards { "Discard the edits of the path" } else { "New path" });
        if new.on_hover_text("Begin a path without key frames").clicked() {
            match document.is_edited() && !self.discards {
                true => self.discards = true,
                false => requests.push(PathRequest::New),
            }
        }
        let film = ui.add_enabled(has_keys, Button::new("Render film…"));
        if film.on_hover_text("A film or numbered frames along this path, drawn in the background").clicked() {
            requests.push(PathRequest::Film);
        }
        ui.separator();
        let title = match document.name() {
            "" if document.is_edited() => "not saved".to_owned(),
            "" => String::new(),
            name if document.is_edited() => format!("{}, edited", crate::file::message::named(name)),
            name => crate::file::message::named(name),
        };
        ui.add(Label::new(RichText::new(title).weak()).truncate());
    }

    /// Adds the field for a new name, the error of the last request, and the question about edits of an earlier run.
    fn notices(&mut self, ui: &mut Ui, shown: &PathState<'_>, requests: &mut Vec<PathRequest>) {
        if shown.has_kept {
            ui.horizontal_wrapped(|ui| {
                ui.label("An earlier run ended with edits of this path that were not saved.");
                for (text, restores) in [("Restore the edits", true), ("Discard them", false)] {
                    if ui.button(text).clicked() {
                        requests.push(PathRequest::Restore(restores));
                    }
                }
            });
        }
        if let Some(text) = &mut self.save_as {
            let mut closes = false;
            ui.horizontal(|ui| {
                ui.label("Write to");
                let field = ui.add(TextEdit::singleline(text).desired_width(220.0));
                name(&field, "Path of the new camera path");
                if std::mem::take(&mut self.takes_focus) {
                    field.request_focus();
                }
                let has_enter = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
                closes = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Escape));
                let write = ui.button("Save");
                name(&write, "Write the camera path");
                if write.clicked() || has_enter {
                    requests.push(PathRequest::SaveAs(text.clone()));
                }
                closes |= ui.button("Cancel").clicked();
            });
            if closes {
                (self.save_as, self.error) = (None, None);
                ui.ctx().request_repaint();
            }
        }
        if let Some(error) = &self.error {
            ui.add(Label::new(RichText::new(error).color(WARNING)).wrap());
        }
    }

    fn key_list(&mut self, ui: &mut Ui, shown: &PathState<'_>, height: f32, requests: &mut Vec<PathRequest>) {
        let keys = shown.document.keys();
        if keys.is_empty() {
            let text = "No key frames yet. Fly to a view and press N, or add a named view; the camera flies a smooth \
                        curve through all key frames.";
            ui.add(Label::new(RichText::new(text).weak()).wrap());
            return;
        }
        let mut area = ScrollArea::vertical().id_salt("key frames").auto_shrink(false).max_height(height);
        let step = ROW + ui.spacing().item_spacing.y;
        if let Some(index) = self.scroll_to.take() {
            area = area.vertical_scroll_offset((index as f32 * step - 0.5 * (height - ROW)).max(0.0));
        }
        area.show_rows(ui, ROW, keys.len(), |ui, range| {
            for index in range {
                ui.push_id(index, |ui| self.key_row(ui, shown, index, requests));
            }
        });
    }

    fn key_row(&mut self, ui: &mut Ui, shown: &PathState<'_>, index: usize, requests: &mut Vec<PathRequest>) {
        let key = &shown.document.keys()[index];
        let number = index + 1;
        ui.horizontal(|ui| {
            ui.set_height(ROW);
            let label = ui.selectable_label(self.selected == Some(index), format!("Key {number}"));
            if label.on_hover_text("Go to this key frame").clicked() {
                self.selected = Some(index);
                requests.push(PathRequest::Seek(key.time_s));
            }
            let mut time_s = key.time_s;
            let value =
                DragValue::new(&mut time_s).speed(0.02).suffix(" s").max_decimals(3).update_while_editing(false);
            let value = ui.add(value).on_hover_text("Time of this key frame");
            name(&value, &format!("Time of key {number}"));
            changed(&value, PathEdit::Move(index, time_s), requests);
            let mut ease = 100.0 * key.ease;
            let value = DragValue::new(&mut ease).speed(0.5).range(0.0..=100.0).prefix("slows ").suffix(" %");
            let value = ui.add(value.max_decimals(0).update_while_editing(false));
            let hint = "How much the camera slows down here: at 0 % it passes through, at 100 % it comes to rest";
            let value = value.on_hover_text(hint);
            name(&value, &format!("Ease of key {number}, percent"));
            changed(&value, PathEdit::Ease(index, ease / 100.0), requests);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let delete =
                    ui.small_button("Delete").on_hover_text("Delete this key frame (Delete, if it is selected)");
                name(&delete, &format!("Delete key {number}"));
                if delete.clicked() {
                    requests.push(PathRequest::Edit(PathEdit::Remove(index)));
                }
                let replace = ui.small_button("Update").on_hover_text("Replace its camera by the present view");
                name(&replace, &format!("Replace key {number} by the present view"));
                if replace.clicked() {
                    requests.push(PathRequest::Edit(PathEdit::Replace(index)));
                }
                let text = RichText::new(key.camera.to_string()).monospace().size(9.0).weak();
                ui.with_layout(Layout::left_to_right(Align::Center), |ui| ui.add(Label::new(text).truncate()));
            });
        });
    }
}

/// Adds the controls of the playhead, and the button that adds a key.
fn play_row(ui: &mut Ui, shown: &PathState<'_>, requests: &mut Vec<PathRequest>) {
    let [first_s, last_s] = shown.document.span_s();
    let has_curve = first_s < last_s;
    let plays = shown.player.is_playing();
    let play = ui.add_enabled(has_curve, Button::new(if plays { "Pause" } else { "Play" }));
    if play.on_hover_text("Fly along the path as a film does (J)").clicked() {
        requests.push(PathRequest::Play(!plays));
    }
    let mut loops = shown.player.loops;
    if ui.checkbox(&mut loops, "Loop").on_hover_text("Begin again after the last key frame").changed() {
        requests.push(PathRequest::Loop(loops));
    }
    let mut playhead_s = shown.player.playhead_s;
    let value = DragValue::new(&mut playhead_s).speed(0.05).range(first_s..=last_s).suffix(" s").fixed_decimals(2);
    let value = ui.add_enabled(has_curve, value.update_while_editing(false)).on_hover_text("Time of the playhead");
    name(&value, "Time of the playhead");
    if value.changed() && playhead_s != shown.player.playhead_s {
        requests.push(PathRequest::Seek(playhead_s));
    }
    ui.label(RichText::new("of").weak());
    let mut duration_s = last_s - first_s;
    let value = DragValue::new(&mut duration_s).speed(0.05).suffix(" s").max_decimals(2);
    // Without a curve, it is 0.
    let value = value.range(0.1..=LATEST_S).clamp_existing_to_range(false).update_while_editing(false);
    let value = ui.add_enabled(has_curve, value);
    let value = value.on_hover_text("Duration of the path: all times are stretched or shrunk");
    name(&value, "Duration of the path");
    changed(&value, PathEdit::Duration(duration_s), requests);
    ui.separator();
    let add = ui.button("Add key").on_hover_text("Add a key frame with the present view (N)");
    if add.clicked() {
        requests.push(PathRequest::Edit(PathEdit::Add));
    }
}

fn view_list(ui: &mut Ui, shown: &PathState<'_>, height: f32, requests: &mut Vec<PathRequest>) {
    ScrollArea::vertical().id_salt("views").auto_shrink(false).max_height(height).show(ui, |ui| {
        let add = ui.button("Add view").on_hover_text("Remember the present view of this world under a name (M)");
        if add.clicked() {
            requests.push(PathRequest::AddView);
        }
        for (index, view) in shown.views.list().iter().enumerate() {
            ui.push_id(index, |ui| view_row(ui, index, view, requests));
        }
    });
}

fn view_row(ui: &mut Ui, index: usize, view: &crate::studio::views::NamedView, requests: &mut Vec<PathRequest>) {
    let number = index + 1;
    ui.horizontal(|ui| {
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let delete = ui.small_button("Delete");
            name(&delete, &format!("Delete view {number}"));
            if delete.clicked() {
                requests.push(PathRequest::RemoveView(index));
            }
            let key = ui.small_button("Key").on_hover_text("Add a key frame with this view");
            name(&key, &format!("Add view {number} as a key frame"));
            if key.clicked() {
                requests.push(PathRequest::Edit(PathEdit::AddCamera(view.camera)));
            }
            let go = ui.small_button("Go").on_hover_text("Fly there");
            name(&go, &format!("Go to view {number}"));
            if go.clicked() {
                requests.push(PathRequest::GoTo(index));
            }
            let mut text = view.name.clone();
            let field = ui.add(TextEdit::singleline(&mut text).desired_width(ui.available_width()));
            name(&field, &format!("Name of view {number}"));
            if field.changed() {
                requests.push(PathRequest::Rename(index, text));
            }
            if field.lost_focus() {
                requests.push(PathRequest::KeepViews);
            }
        });
    });
}

/// Requests the edit of a number that has changed, and ends the step when it is released.
fn changed(value: &Response, edit: PathEdit, requests: &mut Vec<PathRequest>) {
    if value.changed() {
        requests.push(PathRequest::Edit(edit));
    }
    if value.drag_stopped() || value.lost_focus() {
        requests.push(PathRequest::Edit(PathEdit::Release));
    }
}

/// Names a widget for a screen reader.
fn name(response: &Response, label: &str) {
    response.ctx.accesskit_node_builder(response.id, |node| node.set_label(label));
}
