//! Long tasks in the background: their steps, progress, cancellation and results.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use egui::{Align2, ProgressBar, Response, RichText, ScrollArea, Ui};

use super::panel::WARNING;
use crate::source::Progress;

/// Shortest time between two frames for the same bar.
const BETWEEN_FRAMES: Duration = Duration::from_millis(150);
/// Width of a row in points.
const WIDTH: f32 = 300.0;
/// Largest number of messages of work that has ended.
const MOST_ENDED: usize = 5;
/// Largest part of the window's height that they take; the rest is reached by scrolling.
const HIGHEST: f32 = 0.4;

/// Progress of work on another thread.
pub(super) struct BackgroundTask {
    /// The title of the work, such as `Opening mountain.tif`.
    pub title: String,
    state: Mutex<State>,
    stop: AtomicBool,
    wake: Box<dyn Fn() + Send + Sync>,
}

struct State {
    step: String,
    done: f32,
    woken: Option<Instant>,
}

impl BackgroundTask {
    /// Creates work that has not begun; `wake` makes the window look at it.
    pub(super) fn new(title: String, wake: impl Fn() + Send + Sync + 'static) -> Self {
        let state = Mutex::new(State { step: String::new(), done: 0.0, woken: None });
        Self { title, state, stop: AtomicBool::new(false), wake: Box::new(wake) }
    }

    /// Asks the work to stop.
    pub(super) fn cancel(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    /// Returns whether the work has been asked to stop.
    pub(super) fn is_cancelled(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Makes the window look at once.
    pub(super) fn wake(&self) {
        (self.wake)();
    }

    /// Returns the current step and its progress, from 0 to 1.
    pub(super) fn step(&self) -> (String, f32) {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        (state.step.clone(), state.done)
    }
}

impl Progress for BackgroundTask {
    fn report(&self, what: &str, done: f32) {
        // The lock guards only what is shown, so a panic elsewhere is harmless.
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if state.step != what {
            what.clone_into(&mut state.step);
            state.woken = None;
        }
        state.done = done.clamp(0.0, 1.0);
        if state.woken.is_some_and(|at| at.elapsed() < BETWEEN_FRAMES) {
            return;
        }
        state.woken = Some(Instant::now());
        drop(state);
        self.wake();
    }

    fn stop(&self) -> &AtomicBool {
        &self.stop
    }
}

/// The message of work that has ended. It stays until it is dismissed: work may take an hour, and the user may not be
/// watching.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Ended {
    pub text: String,
    /// Path of the written file, if there is one.
    pub path: Option<String>,
    pub has_failed: bool,
}

/// The messages of work that has ended, newest last.
#[derive(Debug, Default)]
pub(super) struct EndedWorks(Vec<Ended>);

impl EndedWorks {
    /// Adds a message. It replaces an equal one; if there are too many, the oldest is dropped.
    pub(super) fn add(&mut self, ended: Ended) {
        self.0.retain(|known| *known != ended);
        self.0.push(ended);
        self.0.drain(..self.0.len().saturating_sub(MOST_ENDED));
    }

    /// Removes the message with this index.
    pub(super) fn dismiss(&mut self, index: usize) {
        if index < self.0.len() {
            self.0.remove(index);
        }
    }

    /// Removes all messages. Returns whether there was one.
    pub(super) fn dismiss_all(&mut self) -> bool {
        !std::mem::take(&mut self.0).is_empty()
    }
}

/// A request of the user about a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TaskRequest {
    /// Cancel the work with this index.
    Cancel(usize),
    /// Remove the message with this index.
    Dismiss(usize),
    /// Say that a path was copied.
    Copied,
}

/// Shows work, and messages of work that has ended, at the bottom of the window. Returns the user's request.
pub(super) fn show<'a>(
    context: &egui::Context,
    works: impl Iterator<Item = &'a BackgroundTask>,
    ended: &EndedWorks,
) -> Option<TaskRequest> {
    let mut works = works.enumerate().peekable();
    if works.peek().is_none() && ended.0.is_empty() {
        return None;
    }
    let mut request = None;
    let highest = HIGHEST * context.content_rect().height();
    let id = egui::Id::unique("works");
    let size_before = context.memory(|memory| memory.area_rect(id)).map(|rect| rect.size());
    let area = egui::Area::new(id).order(egui::Order::Foreground);
    let shown = area.anchor(Align2::CENTER_BOTTOM, [0.0, -44.0]).show(context, |ui| {
        egui::Frame::window(ui.style()).show(ui, |ui| {
            ui.set_width(WIDTH);
            for (index, work) in works {
                let (step, done) = work.step();
                ui.add(egui::Label::new(RichText::new(&work.title).strong()).truncate());
                ui.horizontal(|ui| {
                    let cancel = ui.button("Cancel").on_hover_text("Stop this; the window stays as it is");
                    name(&cancel, format!("Cancel: {}", work.title));
                    if cancel.clicked() {
                        request = Some(TaskRequest::Cancel(index));
                    }
                    ui.add(ProgressBar::new(done).desired_height(14.0).text(RichText::new(step).small()));
                });
            }
            // Without the least height, a list that has grown keeps the height of the last frame.
            ScrollArea::vertical().max_height(highest).min_scrolled_height(highest).show(ui, |ui| {
                for (index, ended) in ended.0.iter().enumerate() {
                    request = row(ui, index, ended).or(request);
                }
            });
        });
    });
    // The place is that of an area as large as in the last frame.
    if size_before != Some(shown.response.rect.size()) {
        context.request_repaint();
    }
    request
}

/// Adds a message.
fn row(ui: &mut Ui, index: usize, ended: &Ended) -> Option<TaskRequest> {
    let mut request = None;
    let text = RichText::new(&ended.text);
    ui.add(egui::Label::new(if ended.has_failed { text.color(WARNING) } else { text }).wrap().selectable(true));
    ui.horizontal(|ui| {
        let dismiss = ui.button("Dismiss").on_hover_text("Remove this message (Esc removes all)");
        name(&dismiss, format!("Dismiss: {}", ended.text));
        if dismiss.clicked() {
            request = Some(TaskRequest::Dismiss(index));
        }
        if let Some(path) = &ended.path {
            let copy = ui.button("Copy the path").on_hover_text(path);
            name(&copy, format!("Copy the path: {path}"));
            if copy.clicked() {
                ui.copy_text(path.clone());
                request = Some(TaskRequest::Copied);
            }
        }
    });
    request
}

/// Names a widget for a screen reader.
fn name(response: &Response, label: String) {
    response.ctx.accesskit_node_builder(response.id, |node| node.set_label(label));
}

#[cfg(test)]
mod tests {
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable as _;

    use super::*;
    use crate::window::screen_reader::tests::unnamed;

    fn wrote(path: &str) -> Ended {
        Ended { text: format!("Wrote {path}"), path: Some(path.to_owned()), has_failed: false }
    }

    fn failed(text: &str) -> Ended {
        Ended { text: text.to_owned(), path: None, has_failed: true }
    }

    #[test]
    fn messages_of_ended_work_stay_until_they_are_dismissed() {
        let mut works = EndedWorks::default();
        works.add(wrote("/home/me/a.png"));
        works.add(failed("--pens: no"));
        let harness = Harness::builder().with_size(egui::vec2(640.0, 420.0)).with_step_dt(1.0);
        let state = (works, Vec::new());
        let mut harness = harness.with_context_setup(crate::window::panel::set_up).build_ui_state(
            |ui, (works, requests): &mut (EndedWorks, Vec<TaskRequest>)| {
                let request = show(ui.ctx(), std::iter::empty(), works);
                if let Some(TaskRequest::Dismiss(index)) = request {
                    works.dismiss(index);
                }
                requests.extend(request);
            },
            state,
        );
        (0..60).for_each(|_| harness.step());
        assert!(harness.query_by_label("Dismiss: Wrote /home/me/a.png").is_some());
        assert!(unnamed(&harness).is_empty(), "{:?}", unnamed(&harness));
        assert!(harness.query_by_label("Copy the path: --pens: no").is_none(), "a failure has no file");
        harness.get_by_label("Copy the path: /home/me/a.png").click();
        let copied = (0..4).find_map(|_| {
            harness.step();
            harness.output().platform_output.commands.iter().find_map(|command| match command {
                egui::OutputCommand::CopyText(text) => Some(text.clone()),
                _ => None,
            })
        });
        assert_eq!(copied.as_deref(), Some("/home/me/a.png"));
        harness.get_by_label("Dismiss: Wrote /home/me/a.png").click();
        (0..4).for_each(|_| harness.step());
        assert!(harness.query_by_label("Dismiss: Wrote /home/me/a.png").is_none());
        assert!(harness.query_by_label("Dismiss: --pens: no").is_some(), "the other one stays");
        assert_eq!(harness.state().1, [TaskRequest::Copied, TaskRequest::Dismiss(0)]);
        assert!(harness.state_mut().0.dismiss_all() && !harness.state_mut().0.dismiss_all());
        harness.step();
        assert!(harness.query_by_label("Dismiss: --pens: no").is_none());
    }

    #[test]
    fn a_message_in_place_of_a_progress_bar_is_shown_as_a_whole() {
        let work = BackgroundTask::new("Exporting a.svg".to_owned(), || {});
        let text = format!("Wrote /home/me/a.svg\nWARN a.svg: leaves out tones\n{}", "19 strokes; ".repeat(20));
        let mut ended = EndedWorks::default();
        ended.add(Ended { text: text.clone(), ..wrote("/home/me/a.svg") });
        let harness = Harness::builder().with_size(egui::vec2(640.0, 420.0));
        let mut harness = harness.build_ui_state(
            |ui, has_ended: &mut bool| {
                let (running, none) = ((!*has_ended).then_some(&work), EndedWorks::default());
                show(ui.ctx(), running.into_iter(), if *has_ended { &ended } else { &none });
            },
            false,
        );
        harness.run();
        let area = |harness: &Harness<'_, bool>| {
            harness.ctx.memory(|memory| memory.area_rect(egui::Id::unique("works"))).expect("it has an area")
        };
        let before = area(&harness);
        *harness.state_mut() = true;
        harness.run();
        let (after, dismiss) = (area(&harness), harness.get_by_label(&format!("Dismiss: {text}")).rect());
        assert!(
            after.contains_rect(dismiss) && after.height() > before.height() + 60.0,
            "{before:?} {after:?} {dismiss:?}"
        );
    }

    #[test]
    fn the_list_is_of_limited_length_and_height() {
        let mut works = EndedWorks::default();
        (0..9).for_each(|number| works.add(failed(&format!("{number}: {}", "a long warning ".repeat(90)))));
        works.add(failed("8"));
        works.add(failed("8"));
        assert_eq!(works.0.len(), MOST_ENDED);
        assert!(works.0[0].text.starts_with("5: ") && works.0[MOST_ENDED - 2].text.starts_with("8: "));
        works.dismiss(99);
        let harness = Harness::builder().with_size(egui::vec2(640.0, 420.0));
        let mut harness = harness.build_ui(|ui| _ = show(ui.ctx(), std::iter::empty(), &works));
        harness.run();
        let area = harness.ctx.memory(|memory| memory.area_rect(egui::Id::unique("works")));
        let area = area.expect("the messages have an area");
        assert!(area.top() > 100.0 && area.bottom() < 420.0, "{area:?}");
    }
}
