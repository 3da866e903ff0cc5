//! A style that is being edited: its text, the parsed style, its history, and its file.
//!
//! The text is always that of a valid style: an edit that would make it invalid is refused, and its error says why.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use toml_edit::{DocumentMut, Item, Value};

use super::controls::Controls;
use super::history::{History, StepName};
use super::rows::{self, Row, Section, title};
use crate::file::input::{LARGEST_STYLE_BYTES, read_text};
use crate::style::extends::{extended, whole};
use crate::style::layers::{LayerEdit, with_layer_edit};
use crate::style::parameters::{find, restore, set, uncapitalised};
use crate::style::set::{ON_MAPS, SetValue, value_of, with_values};
use crate::style::{Style, StyleError, preset_text};
use crate::tones::hatching::maps;

/// A style that is being edited.
#[derive(Debug)]
pub(crate) struct StyleDocument {
    /// Name for errors: the path of the file, or the name of the preset.
    name: String,
    /// The file of the style; a preset has none.
    pub(super) path: Option<PathBuf>,
    text: String,
    style: Style,
    sections: Vec<Section>,
    /// The text of the style that is saved, or of the preset. If the file extends a preset, this is the text of the
    /// whole style.
    pub(super) saved: String,
    /// How the file extends a preset, if it does.
    pub(super) extends: Option<Extends>,
    history: History,
    pub(super) controls: Controls,
    /// Keys of layers that are not drawn.
    hidden: BTreeSet<String>,
    /// Key of the only layer that is drawn.
    solo: Option<String>,
    /// Number of changes, by which others notice them.
    revision: u64,
}

impl StyleDocument {
    /// Opens a preset by its name, or a style file by its path.
    ///
    /// # Errors
    /// [`StyleError`].
    pub(crate) fn open(name: &str) -> Result<Self, StyleError> {
        if let Some(text) = preset_text(name) {
            return Self::of_text(name, None, text.to_owned());
        }
        let path = Path::new(name);
        if path.extension().is_none_or(|extension| extension != "toml") {
            return Err(StyleError::Unknown { name: name.to_owned() });
        }
        let text = read_text(path, LARGEST_STYLE_BYTES)
            .map_err(|source| StyleError::Read { path: name.to_owned(), source })?;
        Self::of_file(path, &text)
    }

    /// Returns the document of a file with this text.
    pub(super) fn of_file(path: &Path, text: &str) -> Result<Self, StyleError> {
        let name = path.display().to_string();
        // Errors have the lines of the file.
        parsed(&name, Some(path), text, None)?;
        let document = Self::of_text(&name, Some(path.to_owned()), whole(&name, text)?)?;
        Ok(Self { extends: Extends::of(text), ..document })
    }

    fn of_text(name: &str, path: Option<PathBuf>, text: String) -> Result<Self, StyleError> {
        let style = parsed(name, path.as_deref(), &text, None)?;
        Ok(Self {
            name: name.to_owned(),
            path,
            saved: text.clone(),
            extends: None,
            text,
            sections: rows::sections(&style),
            style,
            history: History::default(),
            controls: Controls::default(),
            hidden: BTreeSet::new(),
            solo: None,
            revision: 0,
        })
    }

    /// Returns the name of the preset, or the path of the file.
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Returns the file of the style; a preset has none.
    pub(crate) fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Returns the text of the file, or of the preset.
    pub(super) fn file_text(&self) -> &str {
        self.extends.as_ref().map_or(&self.saved, |extends| &extends.text)
    }

    /// Returns the preset that the file extends, if it does, or the preset itself.
    pub(crate) fn preset(&self) -> Option<&str> {
        match &self.extends {
            Some(extends) => Some(&extends.preset),
            None => self.path.is_none().then_some(&self.name),
        }
    }

    /// Returns whether the file extends a preset.
    pub(crate) fn is_extension(&self) -> bool {
        self.extends.is_some()
    }

    /// Returns the style that is saved; `None` if it is not valid any more.
    pub(crate) fn saved_style(&self) -> Option<Style> {
        self.parsed_edit(&self.saved).ok()
    }

    /// Returns the text of the style that is saved.
    pub(super) fn saved_text(&self) -> &str {
        &self.saved
    }

    /// Returns the style, all layers included.
    pub(crate) fn style(&self) -> &Style {
        &self.style
    }

    /// Returns the style as it is drawn: without the layers that are hidden.
    pub(crate) fn drawn(&self) -> Style {
        self.style.clone().without_layers(|key| !self.is_drawn(key))
    }

    /// Returns the key of a layer by its index in the style as it is drawn ([`StyleDocument::drawn`]).
    pub(crate) fn key_of_drawn(&self, index: usize) -> Option<String> {
        let keys = (0..self.style.layers.len()).map(|index| self.style.layers.key(index));
        keys.filter(|key| self.is_drawn(key)).nth(index)
    }

    /// Returns the sections of the style, in the order of the text.
    pub(crate) fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// Returns the parameter with a key.
    pub(crate) fn row(&self, key: &str) -> Option<&Row> {
        self.sections.iter().flat_map(|section| &section.rows).find(|row| row.key == key)
    }

    /// Returns the values that turn the style that is saved into the current one; `None` if values alone do not,
    /// because layers were added, removed or moved.
    pub(crate) fn set_values(&self) -> Option<Vec<SetValue>> {
        let saved: DocumentMut = self.saved.parse().ok()?;
        let rows = self.sections.iter().flat_map(|section| &section.rows);
        let changed = rows.filter_map(|row| {
            let before = find(saved.as_item(), &row.key).and_then(Item::as_value);
            let before = before.or_else(|| row.definition.default.as_ref()?.as_value());
            row.set_value().filter(|now| before.map(rows::bare).as_ref() != Some(&now.text))
        });
        let mut values: Vec<SetValue> = changed.collect();
        // A value that is set would otherwise count on maps too.
        let is_changed = |key: &str| values.iter().any(|set| set.key == key);
        if self.style.on_maps.iter().any(|on_maps| is_changed(&on_maps.key)) && !is_changed(ON_MAPS) {
            values.extend(self.row(ON_MAPS).and_then(Row::set_value));
        }
        let text = with_values(&self.name, &self.saved, &self.style, &values).ok()?;
        (self.parsed_edit(&text).ok()? == self.style).then_some(values)
    }

    /// Returns a number that grows with every change of what is drawn.
    pub(crate) fn revision(&self) -> u64 {
        self.revision
    }

    /// Returns whether the text differs from the file, or from the preset.
    pub(crate) fn is_edited(&self) -> bool {
        self.text != self.saved
    }

    /// Returns whether a layer is drawn.
    pub(crate) fn is_drawn(&self, layer: &str) -> bool {
        self.solo.as_deref().map_or_else(|| !self.hidden.contains(layer), |solo| solo == layer)
    }

    /// Returns whether a layer is the only one that is drawn.
    pub(crate) fn is_solo(&self, layer: &str) -> bool {
        self.solo.as_deref() == Some(layer)
    }

    /// Hides a layer or shows it again. The file does not say which layers are hidden, so the text stays as it is.
    pub(crate) fn toggle_hidden(&mut self, layer: &str) {
        if !self.hidden.remove(layer) {
            self.hidden.insert(layer.to_owned());
        }
        self.solo = None;
        self.revision += 1;
    }

    /// Draws a layer alone, or all of them again.
    pub(crate) fn toggle_solo(&mut self, layer: &str) {
        self.solo = if self.is_solo(layer) { None } else { Some(layer.to_owned()) };
        self.revision += 1;
    }

    /// Draws all layers.
    pub(crate) fn show_all_layers(&mut self) {
        self.hidden.clear();
        self.solo = None;
        self.revision += 1;
    }

    /// Sets the value of a parameter. While the mouse is held, further values of the same parameter belong to the same
    /// step; [`StyleDocument::release`] ends it.
    ///
    /// # Errors
    /// The value is not allowed; then nothing changes.
    pub(crate) fn set(&mut self, key: &str, value: impl Into<Value>) -> Result<(), StyleError> {
        let text = set::<Style>(&self.name, &self.text, key, value)?;
        self.change(text, Some(key), |document| document.named(key))
    }

    /// Sets a value that was given as text: TOML, or the bare text of a name, a colour or a text.
    ///
    /// # Errors
    /// The value is not allowed; then nothing changes.
    pub(crate) fn set_text(&mut self, key: &str, text: &str) -> Result<(), StyleError> {
        let value = value_of(self.row(key).map(|row| &row.definition.kind), text);
        self.set(key, value)
    }

    /// Gives a parameter its default value.
    ///
    /// # Errors
    /// The parameter has no default and is required; then nothing changes.
    pub(crate) fn restore(&mut self, key: &str) -> Result<(), StyleError> {
        let default = self.row(key).and_then(|row| row.definition.default.as_ref()?.as_value().cloned());
        let text = restore::<Style>(&self.name, &self.text, key, default)?;
        self.change(text, None, |document| format!("Default of {}", document.named(key)))
    }

    /// Adds, removes, duplicates or moves a layer, a section or an entry of a list.
    ///
    /// # Errors
    /// The style would not be valid; then nothing changes.
    pub(crate) fn edit_layers(&mut self, edit: &LayerEdit) -> Result<(), StyleError> {
        let text = with_layer_edit(&self.name, &self.text, edit)?;
        let layer = |index: usize| match index < self.style.layers.len() {
            true => title(&self.style.layers.key(index)),
            false => String::new(),
        };
        let name = match edit {
            LayerEdit::Add(kind) => format!("New layer: {}", title(kind)),
            LayerEdit::Remove(index) => format!("Removed layer: {}", layer(*index)),
            LayerEdit::Duplicate(index) => format!("Copy of layer: {}", layer(*index)),
            LayerEdit::Move(from, to) if to > from => format!("Raised layer: {}", layer(*from)),
            LayerEdit::Move(from, _) => format!("Lowered layer: {}", layer(*from)),
            LayerEdit::AddSection(key) => format!("Added: {}", title(key)),
            LayerEdit::RemoveSection(key) => format!("Removed: {}", title(key)),
            LayerEdit::AddEntry(list) => format!("New entry: {}", title(list)),
            LayerEdit::RemoveEntry(list, number) => format!("Removed: {}", title(&format!("{list}[{number}]"))),
        };
        self.change(text, None, |_| name)
    }

    /// Ends a step that consists of several changes, because the mouse was released.
    pub(crate) fn release(&mut self) {
        self.history.close(&self.text);
        self.controls.release();
    }

    /// Undoes the last step and returns its name.
    pub(crate) fn undo(&mut self) -> Option<String> {
        let (name, text) = self.history.undo(&self.text)?;
        self.take_text(text).then_some(name)
    }

    /// Repeats the step that was undone last and returns its name.
    pub(crate) fn redo(&mut self) -> Option<String> {
        let (name, text) = self.history.redo(&self.text)?;
        self.take_text(text).then_some(name)
    }

    /// Returns the steps that can be undone and redone.
    pub(crate) fn steps(&self) -> [Option<StepName<'_>>; 2] {
        self.history.steps()
    }

    /// Returns the names of the steps that can be undone and redone.
    #[cfg(test)]
    pub(crate) fn step_names(&self) -> [Option<&str>; 2] {
        self.history.names()
    }

    /// Returns to what is saved. This can be undone.
    ///
    /// # Errors
    /// A recipe or image that the saved style names is not valid any more.
    pub(crate) fn revert(&mut self) -> Result<(), StyleError> {
        self.change(self.saved.clone(), None, |_| "Return to what is saved".to_owned())
    }

    /// Replaces the text, as one step.
    ///
    /// # Errors
    /// The text is not a valid style; then nothing changes.
    pub(crate) fn replace(&mut self, text: String, step: &str) -> Result<(), StyleError> {
        self.change(text, None, |_| step.to_owned())
    }

    /// Handles a change of the style's files. `text` is the current text of the style file; a preset has none.
    ///
    /// # Errors
    /// The files are not valid; the last valid style stays.
    pub(crate) fn reload(&mut self, text: Option<String>) -> Result<Reloaded, StyleError> {
        if let Some(text) = text.filter(|text| text != self.file_text()) {
            // Errors are found before the user decides for the file.
            self.parsed(&text)?;
            let is_new = self.text != whole(&self.name, &text)?;
            if self.is_edited() && is_new {
                return Ok(Reloaded::Conflict(text));
            }
            self.load(&text)?;
            return Ok(if is_new { Reloaded::Changed } else { Reloaded::Unchanged });
        }
        // Perhaps a recipe or an image has changed.
        let style = self.parsed(&self.text)?;
        if style == self.style {
            return Ok(Reloaded::Unchanged);
        }
        self.take(self.text.clone(), style);
        Ok(Reloaded::Changed)
    }

    /// Takes the text of the file, which another program has changed; edits can be restored by undoing.
    ///
    /// # Errors
    /// The text is not a valid style; then nothing changes.
    pub(crate) fn load(&mut self, text: &str) -> Result<(), StyleError> {
        let style_text = whole(&self.name, text)?;
        self.change(style_text.clone(), None, |_| "Change of the file".to_owned())?;
        self.saved = style_text;
        self.extends = Extends::of(text);
        self.find_positions();
        Ok(())
    }

    /// Marks a text as that of the file, without changing the style: another program has written the file, and the
    /// edits are to stay.
    pub(crate) fn keep_edits_over(&mut self, text: String) {
        self.extends = Extends::of(&text);
        // A text that is not valid was refused before.
        self.saved = whole(&self.name, &text).unwrap_or(text);
        self.find_positions();
    }

    /// Takes another text as one step.
    pub(super) fn change(
        &mut self,
        text: String,
        key: Option<&str>,
        name: impl FnOnce(&Self) -> String,
    ) -> Result<(), StyleError> {
        if text == self.text {
            return Ok(());
        }
        let style = self.parsed_edit(&text)?;
        let before = std::mem::take(&mut self.text);
        self.take(text, style);
        let name = name(self);
        self.history.record(name, key, &before);
        Ok(())
    }

    /// Takes a text of the history. Returns whether it is still valid: recipes may have changed since.
    fn take_text(&mut self, text: String) -> bool {
        match self.parsed(&text) {
            Ok(style) => {
                self.take(text, style);
                true
            }
            Err(error) => {
                tracing::warn!("{error}");
                false
            }
        }
    }

    fn parsed(&self, text: &str) -> Result<Style, StyleError> {
        parsed(&self.name, self.path.as_deref(), text, None)
    }

    /// Reads an edit of the style. Files that it has read already are not read again, where that could take long.
    pub(super) fn parsed_edit(&self, text: &str) -> Result<Style, StyleError> {
        parsed(&self.name, self.path.as_deref(), text, Some(&self.style))
    }

    fn take(&mut self, text: String, style: Style) {
        self.text = text;
        self.sections = rows::sections(&style);
        self.style = style;
        let keys: Vec<String> = (0..self.style.layers.len()).map(|index| self.style.layers.key(index)).collect();
        self.hidden.retain(|key| keys.contains(key));
        self.solo = self.solo.take().filter(|key| keys.contains(key));
        self.revision += 1;
        self.find_positions();
    }

    /// Returns a parameter and its current value in words: "Strokes: width 1.2 px".
    fn named(&self, key: &str) -> String {
        let section = self.sections.iter().find(|section| section.rows.iter().any(|row| row.key == key));
        let row = section.and_then(|section| section.rows.iter().find(|row| row.key == key));
        match (section, row) {
            (Some(section), Some(row)) => {
                format!("{}: {} {}", section.title, uncapitalised(&row.label), row.shown())
            }
            _ => key.to_owned(),
        }
    }
}

/// How a file extends a preset.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Extends {
    pub preset: String,
    /// The text of the file, which has only differences.
    pub text: String,
}

impl Extends {
    fn of(text: &str) -> Option<Self> {
        Some(Self { preset: extended(text)?, text: text.to_owned() })
    }
}

/// The result of reading the files of a document again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Reloaded {
    /// No change: the files agree with the document.
    Unchanged,
    /// The document has taken over the new content of the files.
    Changed,
    /// The file has this text, but the document has edits that are not saved; they stay.
    Conflict(String),
}

/// Reads a style as [`Style::load`] does, with the files that it was read from. If it is an edit of the style `before`,
/// images that both name are neither read nor checked again.
fn parsed(name: &str, path: Option<&Path>, text: &str, before: Option<&Style>) -> Result<Style, StyleError> {
    let mut style = match before {
        Some(before) => Style::parse_edit(name, text, before)?,
        None => Style::parse(name, text)?,
    };
    let recipes = |style: &Style| style.recipe_files().marks;
    let has_new = |marks: &_| before.is_none_or(|before| recipes(before) != *marks);
    let marks = recipes(&style);
    if !marks.is_empty() && has_new(&marks) {
        maps::check(&style)?;
    }
    style.files.extend(path.map(Path::to_owned));
    Ok(style)
}
