//! Exports of a flight: the view that the dialog exports, and the exports that run.

use std::path::Path;

use super::{Flight, TOAST};
use crate::file::message::named;
use crate::studio::document::StyleDocument;
use crate::studio::export::ShownView;
use crate::style::set::SetValue;
use crate::window::export::run::{End, Run};
use crate::window::export::{ExportRequest, Refusal};
use crate::window::inspector::Edit;
use crate::window::toasts::About;
use crate::window::works::Ended;

/// Largest number of exports that run at once: each takes as much memory as a window.
const MOST: usize = 2;
/// Largest number of edited values on a command line that people read.
const MOST_VALUES: usize = 24;

/// The edited values of a style, by the style and its revision; `None` if no command line can contain them.
pub(super) type KnownValues = ((usize, u64), Option<Vec<SetValue>>);

impl Flight {
    /// Opens or closes the export dialog.
    pub(super) fn toggle_export(&mut self) {
        let world =
            self.world.world.as_deref().map_or("hachure", |name| {
                Path::new(name).file_stem().and_then(|stem| stem.to_str()).unwrap_or("hachure")
            });
        let output = format!("{world}-{}", self.style().name).replace(['/', '\\', '%'], "-");
        let size_px = self.settings.eye_px(self.screen.size_px());
        self.export_dialog.toggle(&output, size_px, self.settings.samples());
    }

    /// Returns the current view for the dialog, and the reason if no command line draws it.
    pub(super) fn shown_view(&mut self) -> (ShownView, Option<Refusal>) {
        let style = self.settings.style;
        let set = self.set_values();
        let refusal = self.styles.document(style).and_then(|document| match document {
            edited if edited.is_edited() && set.is_none() => Some(Refusal::Edited),
            hidden if hidden.drawn() != *hidden.style() => Some(Refusal::Hidden),
            _ => None,
        });
        let view = ShownView {
            imprint: self.shot().imprint,
            style: self.styles.name(style).to_owned(),
            set: set.unwrap_or_default(),
            trusts_scene: self.reach == crate::scene::reach::Reach::Anywhere,
            adapter: self.adapter_choice.clone(),
        };
        (view, refusal)
    }

    /// Returns the values of parameters that have been edited and not saved; `None` if they are too many for a command
    /// line, or not all edits are values.
    fn set_values(&mut self) -> Option<Vec<SetValue>> {
        let style = self.settings.style;
        let document = self.styles.document(style)?;
        if !document.is_edited() {
            return Some(Vec::new());
        }
        let key = (style, document.revision());
        if self.set_values.as_ref().is_none_or(|(known, _)| *known != key) {
            let values = document.set_values().filter(|values| values.len() <= MOST_VALUES);
            self.set_values = Some((key, values));
        }
        self.set_values.as_ref().and_then(|(_, values)| values.clone())
    }

    /// Carries out the user's request in the export dialog.
    pub(super) fn on_export_request(&mut self, request: ExportRequest) {
        self.needs_relayout = true;
        match request {
            ExportRequest::SaveStyle => self.save_or_ask(),
            ExportRequest::ShowLayers => self.apply(vec![Edit::ShowAll], self.settings.style),
            ExportRequest::Run(..) if self.exports.len() >= MOST => {
                self.say(About::File, format!("{MOST} exports are running; wait for one, or cancel it"), TOAST);
            }
            ExportRequest::Run(_, output) if self.exports.iter().any(|run| run.output == output) => {
                self.say(About::File, format!("{}: an export to this file is running", named(&output)), TOAST);
            }
            ExportRequest::Run(arguments, output) => match std::env::current_exe() {
                Ok(program) => {
                    let proxy = self.proxy.clone();
                    self.has_warned_of_leaving = false;
                    self.exports.push(Run::start(&program, &arguments, &output, move || _ = proxy.send_event(())));
                }
                Err(error) => self.say(About::File, format!("cannot find the program of hachure: {error}"), TOAST),
            },
        }
    }

    /// Reports the exports that have ended. Returns whether there is news.
    pub(super) fn take_exports(&mut self) -> bool {
        let has_news = !self.exports.is_empty();
        let mut ended = Vec::new();
        self.exports.retain(|run| match run.take() {
            Some(end) => {
                ended.push((run.output.clone(), end));
                false
            }
            None => true,
        });
        for (output, end) in ended {
            let path = std::path::absolute(&output).map_or_else(|_| output.clone(), |path| path.display().to_string());
            let ended = match end {
                End::Cancelled => {
                    self.say(About::File, format!("{}: cancelled", named(&output)), TOAST);
                    continue;
                }
                End::Failed(text) => Ended { text, path: None, has_failed: true },
                End::Written(messages) => {
                    let texts: Vec<String> = std::iter::once(format!("Wrote {path}")).chain(messages).collect();
                    Ended { text: texts.join("\n"), path: Some(path), has_failed: false }
                }
            };
            ended.text.lines().for_each(|line| tracing::info!("{line}"));
            self.ended.add(ended);
            self.needs_relayout = true;
        }
        has_news
    }

    /// Removes the messages of exports that have ended. Returns whether there was one.
    pub(super) fn dismiss_ended(&mut self) -> bool {
        let any = self.ended.dismiss_all();
        self.needs_relayout |= any;
        any
    }

    /// Cancels the work of a row.
    pub(super) fn on_cancel(&mut self, row: usize) {
        let of_world = usize::from(self.world_being_opened.is_some());
        if row < of_world {
            return self.cancel_opening();
        }
        if let Some(run) = self.exports.get(row - of_world) {
            run.work.cancel();
        }
    }

    /// Opens the export dialog with a film along a path. A copy of the path is in hachure's cache, because there are edits
    /// that are not saved.
    pub(super) fn export_film(&mut self, path: &str, is_copy: bool) {
        if !self.export_dialog.is_open() {
            self.toggle_export();
        }
        self.export_dialog.film(path, is_copy);
    }

    /// Returns the names of styles, and of the camera path, that have edits which are not saved.
    pub(super) fn edited_names(&self) -> Vec<String> {
        let edited = self.styles.documents().filter(|(_, document)| document.is_edited());
        let styles = edited.map(|(_, document)| StyleDocument::name(document).to_owned());
        styles.chain(self.paths.document.is_edited().then(|| self.path_name())).collect()
    }
}
