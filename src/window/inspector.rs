//! The inspector: every parameter of the style that is drawn, by layer and section, from the definitions.
//!
//! The inspector only reads the document and returns the user's requests as [`Edit`]s; [`apply`] carries them out.
//! `values` has the widgets for the kinds of values.

mod controls;
mod icons;
mod previews;
mod values;

#[cfg(test)]
mod tests;

use std::path::Path;

use egui::collapsing_header::CollapsingState;
use egui::{Align, Color32, Layout, Response, RichText, Ui};
use toml_edit::Value;

use self::icons::Icon;
use super::panel::may_hint;
use crate::studio::document::StyleDocument;
use crate::studio::export::quote;
use crate::studio::rows::{Place, Row, Section, layer_definitions};
use crate::style::StyleError;
use crate::style::controls::Control;
use crate::style::differences::nearest_preset;
use crate::style::layers::{LayerEdit, most_of_kind};

/// Width of the names of parameters in points.
const LABEL_WIDTH: f32 = 122.0;
/// Number of frames in which a section is moved into view.
const SHOWN_FRAMES: u8 = 3;
/// Colour of the bar at the section that drew what was clicked on.
const MARK: Color32 = Color32::from_rgb(255, 190, 90);

/// A request of the user in the inspector.
#[derive(Clone, Debug)]
pub(super) enum Edit {
    /// Set a parameter.
    Set(String, Value),
    /// Move a control to a position.
    Control(Control, i8),
    /// Set a parameter to the text of the clipboard.
    Paste(String),
    /// Give a parameter its default.
    Restore(String),
    /// Change layers, sections or entries of lists.
    Layers(LayerEdit),
    /// Hide a layer or show it again.
    Hide(String),
    /// Draw a layer alone, or all again.
    Solo(String),
    /// Draw all layers.
    ShowAll,
    /// Undo the last step of the style or of the scene.
    Undo,
    /// Repeat the step that was undone.
    Redo,
    /// Write the file.
    Save,
    /// Write a new file: its name, and the preset from which it has only differences.
    SaveAs(String, Option<String>),
    /// Return to what is saved.
    Revert,
    /// The mouse was released: the next change is another step.
    Release,
}

/// The result of a frame of the inspector.
#[derive(Debug, Default)]
pub(super) struct Shown {
    /// The requests of the user, in their order.
    pub edits: Vec<Edit>,
}

/// The state of the inspector that is not part of the style.
#[derive(Debug, Default)]
pub(super) struct Inspector {
    search: String,
    /// The new file, while the user is asked for its name.
    new_file: Option<NewFile>,
    /// Whether all sections are to be opened or closed in the next frame.
    opens_all: Option<bool>,
    /// Key of the section that is marked, because it drew the clicked place.
    selected: Option<String>,
    /// Number of frames in which the marked section is still to be opened and moved into view: the size of widgets that
    /// are laid out for the first time is known in the next frame.
    shows_selected: u8,
}

/// A file that is to be written.
#[derive(Clone, Debug)]
struct NewFile {
    name: String,
    /// The preset from which the file may have only differences.
    preset: Option<String>,
    /// Whether the file has only differences.
    extends: bool,
}

impl Inspector {
    /// Opens the field for the name of a new file.
    pub(super) fn ask_for_name(&mut self, document: &StyleDocument) {
        self.new_file.get_or_insert_with(|| {
            let nearest = || nearest_preset(document.name(), document.text()).map(str::to_owned);
            let preset = document.preset().map(str::to_owned).or_else(nearest);
            NewFile { name: proposed_name(document), preset, extends: document.is_extension() }
        });
    }

    /// Marks a section, opens it, and moves it into view.
    pub(super) fn select(&mut self, key: String) {
        // A search would hide it.
        self.search.clear();
        self.selected = Some(key);
        self.shows_selected = SHOWN_FRAMES;
    }

    /// Returns the key of the section that is marked.
    #[cfg(test)]
    pub(super) fn selected(&self) -> Option<&str> {
        self.selected.as_deref()
    }

    /// Lays out the inspector. `steps` are the names of the steps that can be undone and redone, of the style or of the
    /// scene.
    pub(super) fn show(&mut self, ui: &mut Ui, document: &StyleDocument, steps: [Option<&str>; 2]) -> Shown {
        let mut shown = Shown::default();
        self.head(ui, document, steps, &mut shown.edits);
        let area = egui::ScrollArea::vertical().auto_shrink(false);
        area.show(ui, |ui| self.sections(ui, document, &mut shown.edits));
        if !ui.input(|input| input.pointer.any_down()) {
            shown.edits.push(Edit::Release);
        }
        shown
    }

    /// Adds the name of the file, the history and the search.
    fn head(&mut self, ui: &mut Ui, document: &StyleDocument, [undo, redo]: [Option<&str>; 2], edits: &mut Vec<Edit>) {
        ui.horizontal(|ui| {
            let mark = if document.is_edited() { "• " } else { "" };
            let name = match document.path() {
                Some(path) => path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                None => format!("{} (preset)", document.style().name),
            };
            let hint = match (document.is_edited(), document.path()) {
                (true, _) => "There are edits that are not saved.".to_owned(),
                (false, Some(path)) => path.display().to_string(),
                (false, None) => "A built-in style. Save it under a name to keep edits.".to_owned(),
            };
            ui.add(egui::Label::new(RichText::new(format!("{mark}{name}")).strong()).truncate()).on_hover_text(hint);
        });
        ui.horizontal(|ui| {
            step_button(ui, "Undo", "Ctrl Z", undo, || edits.push(Edit::Undo));
            step_button(ui, "Redo", "Ctrl Y or Ctrl Shift Z", redo, || edits.push(Edit::Redo));
            ui.separator();
            let can_save = document.is_edited() && document.path().is_some();
            if ui.add_enabled(can_save, egui::Button::new("Save")).on_hover_text("Write the file (Ctrl S)").clicked() {
                edits.push(Edit::Save);
            }
            if ui.button("Save as…").on_hover_text("Write a new file (Ctrl Shift S)").clicked() {
                self.ask_for_name(document);
            }
            let revert = ui.add_enabled(document.is_edited(), egui::Button::new("Revert"));
            if revert.on_hover_text("Return to what is saved; this can be undone").clicked() {
                edits.push(Edit::Revert);
            }
        });
        self.file_name(ui, edits);
        controls::show(ui, document, edits);
        ui.horizontal(|ui| {
            let field = egui::TextEdit::singleline(&mut self.search).hint_text("Search").desired_width(170.0);
            named(&ui.add(field), "Search parameters");
            if ui.button("Open all").on_hover_text("Open all sections").clicked() {
                self.opens_all = Some(true);
            }
            if ui.button("Close all").on_hover_text("Close all sections").clicked() {
                self.opens_all = Some(false);
            }
        });
        ui.separator();
    }

    /// Adds the field for the name of a new file, while there is one.
    fn file_name(&mut self, ui: &mut Ui, edits: &mut Vec<Edit>) {
        let Some(NewFile { name, preset, extends }) = &mut self.new_file else { return };
        let mut is_done = false;
        if let Some(preset) = preset {
            let hint = "The file names the preset and has only the values that differ from it (extends)";
            ui.checkbox(extends, format!("Only differences from {preset}")).on_hover_text(hint);
        }
        ui.horizontal(|ui| {
            let field = ui.add(egui::TextEdit::singleline(name).hint_text("name.toml").desired_width(180.0));
            named(&field, "Name of the new style file");
            let enter = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
            if ui.button("Save").on_hover_text("Write the style into this file").clicked() || enter {
                edits.push(Edit::SaveAs(name.clone(), preset.clone().filter(|_| *extends)));
                is_done = true;
            }
            is_done |= ui.button("Cancel").clicked();
        });
        if is_done {
            self.new_file = None;
        }
    }

    fn sections(&mut self, ui: &mut Ui, document: &StyleDocument, edits: &mut Vec<Edit>) {
        let opens_all = self.opens_all.take();
        let shows_selected = self.shows_selected > 0;
        self.shows_selected = self.shows_selected.saturating_sub(1);
        let groups = groups(document.sections());
        let is_layer = |group: &&[Section]| matches!(group[0].place, Place::Layer { .. });
        let mut adds_layer = false;
        // Layers are listed from the top to the bottom, after the first section, as they cover each other.
        let layers = groups.iter().copied().filter(is_layer).rev();
        let (first, others) =
            groups.split_first().map_or((None, [].as_slice()), |(first, others)| (Some(*first), others));
        let others = others.iter().copied().filter(|group| !is_layer(group));
        let count = layers.clone().count();
        for (number, group) in first.into_iter().chain(layers).chain(others).enumerate() {
            if number == 1 + count {
                adds_layer = true;
                self.add_layer(ui, document, edits);
            }
            let is_selected = self.selected.as_deref() == Some(group[0].key.as_str());
            let opens = opens_all.or((is_selected && shows_selected).then_some(true));
            let top = ui.cursor().top();
            self.group(ui, document, group, opens, edits);
            if is_selected {
                mark(ui, top, shows_selected);
            }
        }
        if !adds_layer {
            self.add_layer(ui, document, edits);
        }
    }

    /// Adds the button for a new layer.
    fn add_layer(&self, ui: &mut Ui, document: &StyleDocument, edits: &mut Vec<Edit>) {
        if !self.search.trim().is_empty() {
            return;
        }
        let button = ui.menu_button("Add layer…", |ui| {
            for kind in layer_definitions() {
                let count = document.style().layers.iter().filter(|layer| layer.kind() == kind.key).count();
                let is_allowed = count < most_of_kind(kind.key);
                let name = crate::studio::rows::title(kind.key);
                if ui.add_enabled(is_allowed, egui::Button::new(name)).on_hover_text(kind.help).clicked() {
                    edits.push(Edit::Layers(LayerEdit::Add(kind.key)));
                    ui.close();
                }
            }
        });
        button.response.on_hover_text("Add a layer with the values of a preset");
        ui.add_space(4.0);
    }

    /// Adds a section that may be closed, with the sections within it.
    fn group(
        &self,
        ui: &mut Ui,
        document: &StyleDocument,
        group: &[Section],
        opens_all: Option<bool>,
        edits: &mut Vec<Edit>,
    ) {
        let words = self.search.trim();
        let is_found = |section: &&Section| words.is_empty() || section.rows.iter().any(|row| row.is_found(words));
        if !group.iter().any(|section| is_found(&section)) {
            return;
        }
        let head = &group[0];
        if head.place == Place::Absent {
            absent(ui, head, edits);
            return;
        }
        let id = ui.make_persistent_id(("section", &head.key));
        let opens = matches!(head.place, Place::Layer { .. });
        let mut state = CollapsingState::load_with_default_open(ui.ctx(), id, opens);
        if let Some(open) = opens_all.or((!words.is_empty()).then_some(true)) {
            state.set_open(open);
        }
        let mut toggles = false;
        let is_open = state.is_open();
        let header = state.show_header(ui, |ui| {
            let title = RichText::new(&head.title).strong();
            let title = ui.add(egui::Label::new(title).sense(egui::Sense::click())).on_hover_text(head.help);
            toggles = title.clicked();
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| buttons(ui, document, head, edits));
        });
        let mut header = header;
        if toggles {
            header.toggle();
        }
        let folder = document.path().and_then(Path::parent).unwrap_or(Path::new(""));
        let of_style = (folder, document.revision());
        let (button, ..) = header.body_unindented(|ui| {
            for section in group.iter().filter(is_found) {
                if section.key != head.key {
                    within(ui, section, edits);
                }
                for row in section.rows.iter().filter(|row| words.is_empty() || row.is_found(words)) {
                    parameter(ui, section, row, of_style, edits);
                }
            }
            add_entries(ui, group, words, edits);
            ui.add_space(4.0);
        });
        named(&button, &format!("{}: {}", head.title, if is_open { "close" } else { "open" }));
    }
}

/// Marks the section between `top` and the cursor by a bar on its left, and moves its beginning into view if it is to be
/// shown.
fn mark(ui: &mut Ui, top: f32, is_shown: bool) {
    let left = ui.max_rect().left();
    let bar = egui::Rect::from_min_max(egui::pos2(left - 3.0, top), egui::pos2(left - 1.0, ui.cursor().top() - 4.0));
    ui.painter().rect_filled(bar, 1.0, MARK);
    if is_shown {
        let head = egui::Rect::from_min_size(egui::pos2(left, top), egui::vec2(1.0, 60.0));
        ui.scroll_to_rect(head, Some(Align::Min));
        ui.ctx().request_repaint();
    }
}

/// Carries out an edit of a document, apart from those that write files. `pasted` is the text of the clipboard. Returns
/// what the user needs to know.
///
/// # Errors
/// The edit is not allowed; then nothing changes.
pub(super) fn apply(
    document: &mut StyleDocument,
    edit: Edit,
    pasted: Option<&str>,
) -> Result<Option<String>, StyleError> {
    match edit {
        Edit::Set(key, value) => document.set(&key, value)?,
        Edit::Control(control, position) => document.set_control(control, position)?,
        Edit::Paste(key) => match pasted {
            Some(text) => document.set_text(&key, text)?,
            None => return Ok(Some("The clipboard has no text".to_owned())),
        },
        Edit::Restore(key) => document.restore(&key)?,
        Edit::Layers(edit) => document.edit_layers(&edit)?,
        Edit::Revert => document.revert()?,
        Edit::Hide(layer) => document.toggle_hidden(&layer),
        Edit::Solo(layer) => document.toggle_solo(&layer),
        Edit::ShowAll => document.show_all_layers(),
        Edit::Undo => return Ok(document.undo().map(|name| format!("Undo: {name}"))),
        Edit::Redo => return Ok(document.redo().map(|name| format!("Redo: {name}"))),
        Edit::Release => document.release(),
        Edit::Save | Edit::SaveAs(..) => {}
    }
    Ok(None)
}

/// Returns the sections in groups: one that is not part of another, followed by those within it.
fn groups(sections: &[Section]) -> Vec<&[Section]> {
    let first = |section: &Section| section.key.split('.').next().unwrap_or_default().to_owned();
    sections.chunk_by(|a, b| first(a) == first(b)).collect()
}

fn proposed_name(document: &StyleDocument) -> String {
    match document.path() {
        Some(path) => path.display().to_string(),
        None => format!("my-{}.toml", document.style().name),
    }
}

/// Adds a button of the history, which says what it would do.
fn step_button(ui: &mut Ui, name: &str, keys: &str, step: Option<&str>, act: impl FnOnce()) {
    let hint = step.map_or_else(|| keys.to_owned(), |step| format!("{step} ({keys})"));
    if ui.add_enabled(step.is_some(), egui::Button::new(name)).on_hover_text(hint).clicked() {
        act();
    }
}

/// Adds the line of an optional section that is not there.
fn absent(ui: &mut Ui, section: &Section, edits: &mut Vec<Edit>) {
    ui.horizontal(|ui| {
        ui.add_space(18.0);
        ui.label(RichText::new(&section.title).weak()).on_hover_text(section.help);
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let button = ui.small_button("Add");
            named(&button, &format!("Add {}", section.title));
            if button.on_hover_text(section.help).clicked() {
                edits.push(Edit::Layers(LayerEdit::AddSection(section.key.clone())));
            }
        });
    });
}

/// Adds the buttons of a section's header, from right to left.
fn buttons(ui: &mut Ui, document: &StyleDocument, section: &Section, edits: &mut Vec<Edit>) {
    let mut button = |ui: &mut Ui, icon: Icon, words: &str, is_enabled: bool, is_on: bool, edit: Edit| {
        let response = icons::button(ui, icon, is_enabled, is_on);
        named(&response, &format!("{}: {words}", section.title));
        if response.on_hover_text(words).clicked() {
            edits.push(edit);
        }
    };
    let key = || section.key.clone();
    match section.place {
        Place::Layer { index, may_repeat } => {
            let count = document.style().layers.len();
            let kind = document.style().layers[index].kind();
            let of_kind = document.style().layers.iter().filter(|layer| layer.kind() == kind).count();
            let can_repeat = may_repeat && of_kind < most_of_kind(kind);
            button(ui, Icon::Remove, "Remove", kind != "rims", false, Edit::Layers(LayerEdit::Remove(index)));
            if may_repeat {
                button(ui, Icon::Copy, "Duplicate", can_repeat, false, Edit::Layers(LayerEdit::Duplicate(index)));
            }
            let lower = LayerEdit::Move(index, index.saturating_sub(1));
            button(ui, Icon::Down, "Lower", index > 0, false, Edit::Layers(lower));
            let raise = LayerEdit::Move(index, index + 1);
            button(ui, Icon::Up, "Raise", index + 1 < count, false, Edit::Layers(raise));
            button(ui, Icon::Alone, "Draw alone", true, document.is_solo(&section.key), Edit::Solo(key()));
            let is_hidden = !document.is_drawn(&section.key);
            button(ui, Icon::Eye, "Hide", true, is_hidden, Edit::Hide(key()));
        }
        Place::Optional => {
            button(ui, Icon::Remove, "Remove", true, false, Edit::Layers(LayerEdit::RemoveSection(key())));
        }
        _ => {}
    }
}

/// Adds the line above the parameters of a section within another.
fn within(ui: &mut Ui, section: &Section, edits: &mut Vec<Edit>) {
    if section.place == Place::Absent {
        absent(ui, section, edits);
        return;
    }
    ui.horizontal(|ui| {
        let title = RichText::new(&section.title).italics();
        ui.label(title).on_hover_text(section.help);
        let removal = match &section.place {
            Place::Entry { list, index } => Some(LayerEdit::RemoveEntry(list.clone(), *index)),
            Place::Optional => Some(LayerEdit::RemoveSection(section.key.clone())),
            _ => None,
        };
        let Some(removal) = removal else { return };
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            let button = icons::button(ui, Icon::Remove, true, false);
            named(&button, &format!("{}: Remove", section.title));
            if button.on_hover_text("Remove").clicked() {
                edits.push(Edit::Layers(removal));
            }
        });
    });
}

/// Adds a button for a new entry of each list of a group.
fn add_entries(ui: &mut Ui, group: &[Section], words: &str, edits: &mut Vec<Edit>) {
    let mut lists: Vec<&str> = group
        .iter()
        .filter_map(|section| match &section.place {
            Place::Entry { list, .. } => Some(list.as_str()),
            _ => None,
        })
        .collect();
    lists.dedup();
    for list in lists.into_iter().filter(|_| words.is_empty()) {
        let button = ui.small_button(format!("Add to {}", list.rsplit('.').next().unwrap_or(list)));
        if button.on_hover_text("Add an entry like the last one").clicked() {
            edits.push(Edit::Layers(LayerEdit::AddEntry(list.to_owned())));
        }
    }
}

/// Adds the row of a parameter: its name on the left, and its widgets on the right.
fn parameter(ui: &mut Ui, section: &Section, row: &Row, of_style: (&Path, u64), edits: &mut Vec<Edit>) {
    ui.push_id(&row.key, |ui| {
        let line = ui.horizontal(|ui| {
            let is_changed = !row.is_default() && !row.definition.is_required;
            let text = RichText::new(&row.label);
            let text = if is_changed { text.color(Color32::WHITE) } else { text.weak() };
            let size = egui::vec2(LABEL_WIDTH, ui.spacing().interact_size.y);
            let label = ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
                ui.set_min_width(LABEL_WIDTH);
                let label = egui::Label::new(text).truncate().sense(egui::Sense::click());
                ui.add(label)
            });
            let name = format!("{}: {}", section.title, row.label);
            let mut widgets = vec![label.inner];
            ui.add_enabled_ui(row.without_effect.is_none(), |ui| {
                widgets.extend(values::widgets(ui, &name, row, of_style, edits));
            });
            for widget in &widgets {
                on_widget(ui, widget, row, edits);
            }
        });
        menu(&line.response, row, edits);
    });
}

/// Adds to a widget of a parameter what all of them have: help, and the key that restores the default.
fn on_widget(ui: &Ui, widget: &Response, row: &Row, edits: &mut Vec<Edit>) {
    if may_hint(ui.ctx()) {
        widget.clone().on_hover_ui(|ui| _ = ui.label(row.help()));
    }
    widget.clone().on_disabled_hover_text(row.help());
    let is_aimed_at = widget.hovered() || widget.has_focus();
    let is_typing = ui.ctx().text_edit_focused();
    if is_aimed_at && !is_typing && ui.input(|input| input.key_pressed(egui::Key::Backspace)) {
        edits.push(Edit::Restore(row.key.clone()));
    }
}

/// Adds the menu of a parameter, which a right click anywhere on its row opens.
fn menu(line: &Response, row: &Row, edits: &mut Vec<Edit>) {
    line.container_context_menu(|ui| {
        if ui.button("Copy key").clicked() {
            ui.copy_text(row.key.clone());
            ui.close();
        }
        if ui.button("Copy value").clicked() {
            let text = row.value.as_ref().map_or(String::new(), |value| value.to_string().trim().to_owned());
            ui.copy_text(text);
            ui.close();
        }
        let set = row.set_value();
        let on_line = ui.add_enabled(set.is_some(), egui::Button::new("Copy for the command line"));
        let on_line = on_line.on_hover_text("The option of hachure render that gives the parameter this value");
        if let Some(set) = set.filter(|_| on_line.clicked()) {
            ui.copy_text(quote(&format!("--set={set}")));
            ui.close();
        }
        if ui.button("Paste value").clicked() {
            edits.push(Edit::Paste(row.key.clone()));
            ui.close();
        }
        let can_restore = !row.definition.is_required && !row.is_default();
        if ui.add_enabled(can_restore, egui::Button::new("Restore default")).clicked() {
            edits.push(Edit::Restore(row.key.clone()));
            ui.close();
        }
    });
}

/// Names a widget for AccessKit.
fn named(widget: &Response, name: &str) {
    widget.ctx.accesskit_node_builder(widget.id, |node| node.set_label(name));
}
