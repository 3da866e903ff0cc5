//! Work in the background that takes a while: what it is doing, how far it is, and how it is cancelled.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use egui::{Align2, ProgressBar, RichText};

use super::panel::WARNING;
use crate::source::Progress;

/// Shortest time between two frames for the same bar.
const BETWEEN_FRAMES: Duration = Duration::from_millis(150);
/// Width of a row in points.
const WIDTH: f32 = 300.0;

/// Progress of work on another thread.
pub(super) struct Work {
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

impl Work {
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

    /// Returns the present step and how much of it is done, from 0 to 1.
    pub(super) fn step(&self) -> (String, f32) {
        let state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        (state.step.clone(), state.done)
    }
}

impl Progress for Work {
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

/// A request of the user about a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Request {
    /// Cancel the work with this index.
    Cancel(usize),
    /// Remove the failure with this index.
    Dismiss(usize),
}

/// Shows work, and messages of work that failed, at the bottom of the window. Returns what the user asks for.
pub(super) fn show<'a>(
    context: &egui::Context,
    works: impl Iterator<Item = &'a Work>,
    failures: &[String],
) -> Option<Request> {
    let mut works = works.enumerate().peekable();
    if works.peek().is_none() && failures.is_empty() {
        return None;
    }
    let mut request = None;
    let area = egui::Area::new(egui::Id::unique("works")).order(egui::Order::Foreground);
    area.anchor(Align2::CENTER_BOTTOM, [0.0, -44.0]).show(context, |ui| {
        egui::Frame::window(ui.style()).show(ui, |ui| {
            ui.set_width(WIDTH);
            for (index, work) in works {
                let (step, done) = work.step();
                ui.add(egui::Label::new(RichText::new(&work.title).strong()).truncate());
                ui.horizontal(|ui| {
                    let cancel = ui.button("Cancel").on_hover_text("Stop this; the window stays as it is");
                    ui.ctx()
                        .accesskit_node_builder(cancel.id, |node| node.set_label(format!("Cancel: {}", work.title)));
                    if cancel.clicked() {
                        request = Some(Request::Cancel(index));
                    }
                    ui.add(ProgressBar::new(done).desired_height(14.0).text(RichText::new(step).small()));
                });
            }
            for (index, failure) in failures.iter().enumerate() {
                ui.horizontal(|ui| {
                    let dismiss = ui.button("Dismiss").on_hover_text("Remove this message");
                    ui.ctx().accesskit_node_builder(dismiss.id, |node| node.set_label(format!("Dismiss: {failure}")));
                    if dismiss.clicked() {
                        request = Some(Request::Dismiss(index));
                    }
                    ui.add(egui::Label::new(RichText::new(failure).color(WARNING)).wrap());
                });
            }
        });
    });
    request
}
