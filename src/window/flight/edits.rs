//! Edits of the drawn style, and changes of its files.

use super::{Flight, Next};
use crate::file::input::{LARGEST_STYLE_BYTES, read_text};
use crate::studio::document::{Reloaded, StyleDocument};
use crate::style::StyleError;
use crate::window::dock::Pane;
use crate::window::inspector::{self, Edit};
use crate::window::questions::{self, Question};
use crate::window::toasts::About;

use super::controls::TOAST;

impl Flight {
    /// Opens the chosen style for editing, and offers edits that an earlier run did not save.
    pub(super) fn open_document(&mut self) {
        let style = self.settings.style;
        match self.styles.open(style) {
            Ok(_) if self.unsaved_offered.insert(style) => {
                if let Some(document) = self.styles.document(style)
                    && let Some(text) = self.unsaved.find(document)
                {
                    self.questions.ask(question(style, document, questions::QuestionKind::Unsaved, text));
                }
            }
            Ok(_) => {}
            Err(error) => self.say(About::Edit, error.to_string(), TOAST),
        }
        self.watch_files();
    }

    /// Carries out the user's edits in the inspector of a style.
    pub(super) fn apply(&mut self, edits: Vec<Edit>, style: usize) {
        for edit in edits {
            let said = self.apply_one(edit, style);
            if let Some(text) = said {
                self.say(About::Edit, text, TOAST);
            }
        }
    }

    /// Carries out one edit. Returns what the user needs to know.
    fn apply_one(&mut self, edit: Edit, style: usize) -> Option<String> {
        let pasted = match edit {
            Edit::Save => return Some(self.save(style)),
            Edit::SaveAs(path, extends) => return Some(self.save_as(style, &path, extends.as_deref())),
            Edit::Undo if self.is_scene_next(0, style) => return self.undo_scene(),
            Edit::Redo if self.is_scene_next(1, style) => return self.redo_scene(),
            Edit::Paste(_) => self.overlay.clipboard_text(),
            _ => None,
        };
        let document = self.styles.document_mut(style)?;
        let revision = document.revision();
        let done = inspector::apply(document, edit, pasted.as_deref());
        if document.revision() != revision {
            self.document_changed(style);
        }
        done.unwrap_or_else(|error| Some(error.to_string()))
    }

    /// Draws the changes of a document, and keeps them over a crash.
    fn document_changed(&mut self, style: usize) {
        self.styles.refresh(style);
        self.stale |= style == self.settings.style;
        self.has_warned_of_leaving = false;
        self.needs_relayout = true;
        if let Some(document) = self.styles.document(style) {
            self.unsaved.keep(document);
        }
        self.watch_files();
    }

    fn save(&mut self, style: usize) -> String {
        let Some(document) = self.styles.document_mut(style) else { return String::new() };
        if let Err(error) = document.save() {
            return error.to_string();
        }
        self.unsaved.keep(document);
        self.needs_relayout = true;
        format!("Wrote {}", document.name())
    }

    fn save_as(&mut self, style: usize, path: &str, extends: Option<&str>) -> String {
        let Some(document) = self.styles.document_mut(style) else { return String::new() };
        let saved = match document.save_as(path, extends) {
            Ok(saved) => saved,
            Err(error) => return error.to_string(),
        };
        let text = format!("Wrote {}", saved.name());
        // The edits are in the new file; the old style is again as it is saved.
        if let Err(error) = document.revert() {
            tracing::warn!("{error}");
        }
        self.document_changed(style);
        let new = self.styles.add(saved);
        self.unsaved_offered.insert(new);
        self.settings.style = new;
        self.document_changed(new);
        text
    }

    /// Saves the style, or asks for a name if it is a preset.
    pub(super) fn save_or_ask(&mut self) {
        let style = self.settings.style;
        match self.styles.document(style).map(StyleDocument::path) {
            Some(Some(_)) => self.apply(vec![Edit::Save], style),
            _ => self.ask_for_name(),
        }
    }

    /// Opens the field for the name of a new file.
    pub(super) fn ask_for_name(&mut self) {
        self.dock.set_shown(Pane::Style, true);
        if let Some(document) = self.styles.document(self.settings.style) {
            self.inspector.ask_for_name(document);
        }
    }

    /// Carries out the answer to a question.
    pub(super) fn answer(&mut self, question: Question, is_taken: bool) {
        let Question { style, about, text, .. } = question;
        let Some(document) = self.styles.document_mut(style) else { return };
        let done = match (about, is_taken) {
            (questions::QuestionKind::Unsaved, true) => document.replace(text, "Edits that were not saved"),
            (questions::QuestionKind::ChangedFile, true) => document.load(&text),
            (questions::QuestionKind::Unsaved, false) => Ok(()),
            (questions::QuestionKind::ChangedFile, false) => {
                document.keep_edits_over(text);
                Ok(())
            }
        };
        self.document_changed(style);
        if let Err(error) = done {
            self.say(About::Edit, error.to_string(), TOAST);
        }
    }

    /// Watches the files of all styles that are open for editing.
    fn watch_files(&mut self) {
        let files: Vec<_> = self.styles.documents().flat_map(|(_, document)| document.style().files.clone()).collect();
        if files != self.watched
            && let Some(watch) = &self.watch
        {
            watch.follow(&files);
            self.watched = files;
        }
    }

    /// Handles what other threads have reported: pictures that are finished, and files that have changed.
    pub(crate) fn on_woken(&mut self) -> Next {
        let context = self.overlay.context().clone();
        let is_new = self.overlay.take_screen_reader() | self.viewer.take_colours(&context);
        let has_news = is_new
            | self.report_pictures()
            | self.follow_labels()
            | self.take_reopened()
            | self.take_opened()
            | self.take_path()
            | self.take_grounds()
            | self.take_chosen()
            | self.take_exports();
        let next = self.on_files_changed();
        if has_news {
            self.update_lasting_messages();
            return Next::Frame;
        }
        next
    }

    /// Reads files of styles that another program has changed.
    fn on_files_changed(&mut self) -> Next {
        if !self.watch.as_ref().is_some_and(|watch| watch.take()) {
            return Next::Sleep;
        }
        let styles: Vec<usize> = self.styles.documents().map(|(style, _)| style).collect();
        for style in styles {
            let Some(document) = self.styles.document_mut(style) else { continue };
            match reload(document) {
                Ok(Reloaded::Unchanged) => _ = self.file_errors.remove(&style),
                Ok(Reloaded::Changed) => {
                    let text = format!("Read {} again", document.name());
                    self.file_errors.remove(&style);
                    self.document_changed(style);
                    self.say(About::Edit, text, TOAST);
                }
                Ok(Reloaded::Conflict(text)) => {
                    let question = question(style, document, questions::QuestionKind::ChangedFile, text);
                    self.file_errors.remove(&style);
                    self.questions.ask(question);
                }
                Err(error) => _ = self.file_errors.insert(style, error.to_string()),
            }
        }
        self.update_lasting_messages();
        Next::Frame
    }

    /// Returns whether the program may end. If there are edits that are not saved, or exports that run, the user is warned
    /// once.
    pub(super) fn may_leave(&mut self, how: &str) -> bool {
        let names = self.edited_names();
        if self.has_warned_of_leaving || names.is_empty() && self.exports.is_empty() {
            return true;
        }
        if names.is_empty() {
            self.has_warned_of_leaving = true;
            let text = format!("An export is running. To leave and cancel it, {how}.");
            self.say(About::Quitting, text, TOAST);
            return false;
        }
        let cancels = if self.exports.is_empty() { "" } else { " An export is running and would be cancelled." };
        let text = format!(
            "Edits are not saved: {}. To leave without saving, {how}; the next start offers them.{cancels}",
            names.join(", ")
        );
        self.has_warned_of_leaving = true;
        self.say(About::Quitting, text, TOAST);
        false
    }
}

fn question(style: usize, document: &StyleDocument, about: questions::QuestionKind, text: String) -> Question {
    Question { style, about, name: document.name().to_owned(), text }
}

/// Reads the files of a style again.
fn reload(document: &mut StyleDocument) -> Result<Reloaded, StyleError> {
    let text = match document.path() {
        Some(path) => Some(read_text(path, LARGEST_STYLE_BYTES).map_err(|source| {
            let path = path.display().to_string();
            StyleError::Read { path, source }
        })?),
        None => None,
    };
    document.reload(text)
}
