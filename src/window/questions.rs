//! Questions over the picture that stay until they are answered.

use egui::{Align2, Button};

/// A question about a style of the list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Question {
    /// Index of the style in the list.
    pub style: usize,
    /// The subject of the question.
    pub about: QuestionKind,
    /// Name of the style for people.
    pub name: String,
    /// The text that is taken or left.
    pub text: String,
}

/// The subject of a question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum QuestionKind {
    /// Edits of an earlier run were not saved.
    Unsaved,
    /// Another program has changed the file, and there are edits that are not saved.
    ChangedFile,
}

impl Question {
    fn words(&self) -> String {
        match self.about {
            QuestionKind::Unsaved => format!("{}: an earlier run ended with edits that were not saved.", self.name),
            QuestionKind::ChangedFile => {
                format!("{} was changed by another program, and has edits here that are not saved.", self.name)
            }
        }
    }

    /// Returns the names of the buttons that take the text and that leave it.
    fn answers(&self) -> [&'static str; 2] {
        match self.about {
            QuestionKind::Unsaved => ["Restore the edits", "Discard them"],
            QuestionKind::ChangedFile => ["Load the file", "Keep my edits"],
        }
    }
}

/// The questions, oldest first. Only the oldest is shown.
#[derive(Debug, Default)]
pub(super) struct Questions(Vec<Question>);

impl Questions {
    /// Asks a question, in place of an earlier one about the same.
    pub(super) fn ask(&mut self, question: Question) {
        self.0.retain(|known| (known.style, known.about) != (question.style, question.about));
        self.0.push(question);
    }

    /// Shows the oldest question at the top of the window. Returns it when it is answered, and whether the text is to be
    /// taken.
    pub(super) fn show(&mut self, context: &egui::Context) -> Option<(Question, bool)> {
        let question = self.0.first()?;
        let mut answer = None;
        let area = egui::Area::new(egui::Id::unique("question")).order(egui::Order::Foreground);
        area.anchor(Align2::CENTER_TOP, [0.0, 40.0]).show(context, |ui| {
            egui::Frame::window(ui.style()).show(ui, |ui| {
                ui.set_max_width(300.0);
                ui.label(question.words());
                ui.horizontal(|ui| {
                    let [take, leave] = question.answers();
                    if ui.add(Button::new(take)).clicked() {
                        answer = Some(true);
                    }
                    if ui.add(Button::new(leave)).clicked() {
                        answer = Some(false);
                    }
                });
            });
        });
        answer.map(|is_taken| (self.0.remove(0), is_taken))
    }
}
