//! Screen readers: passes the names of widgets to them through AccessKit, and their requests to egui.
//!
//! AccessKit calls its handlers on other threads. The handlers send the requests to the thread of the window, and wake
//! it.

#[cfg(test)]
pub(super) mod tests;

use std::sync::mpsc::{Receiver, Sender, channel};

use egui::accesskit::{ActionHandler, ActionRequest, ActivationHandler, DeactivationHandler, TreeUpdate};
use egui_winit::accesskit_winit::Adapter;
use winit::event_loop::ActiveEventLoop;
use winit::window::Window;

/// A request of a screen reader.
#[derive(Debug)]
enum Asked {
    /// The names of all widgets, from now on.
    Names,
    /// An action of a widget.
    Action(ActionRequest),
    /// The screen reader has gone.
    Nothing,
}

/// The requests of screen readers.
pub(super) struct ScreenReader(Receiver<Asked>);

/// A handler of AccessKit.
struct Handler<F> {
    asked: Sender<Asked>,
    wake: F,
}

impl<F: Fn()> Handler<F> {
    fn send(&self, asked: Asked) {
        // The receiver is gone if the window was closed.
        let _ = self.asked.send(asked);
        (self.wake)();
    }
}

impl<F: Fn()> ActivationHandler for Handler<F> {
    fn request_initial_tree(&mut self) -> Option<TreeUpdate> {
        self.send(Asked::Names);
        None
    }
}

impl<F: Fn()> ActionHandler for Handler<F> {
    fn do_action(&mut self, request: ActionRequest) {
        self.send(Asked::Action(request));
    }
}

impl<F: Fn()> DeactivationHandler for Handler<F> {
    fn deactivate_accessibility(&mut self) {
        self.send(Asked::Nothing);
    }
}

impl ScreenReader {
    /// Creates the adapter of a window that has not been shown yet. `wake` wakes the thread of the window.
    pub(super) fn new(
        events: &ActiveEventLoop,
        window: &Window,
        wake: impl Fn() + Clone + Send + 'static,
    ) -> (Adapter, Self) {
        let (sender, asked) = channel();
        let handler = || Handler { asked: sender.clone(), wake: wake.clone() };
        let adapter = Adapter::with_direct_handlers(events, window, handler(), handler(), handler());
        (adapter, Self(asked))
    }

    /// Carries out the requests of a screen reader. Returns whether there were any.
    pub(super) fn take(&self, context: &egui::Context, state: &mut egui_winit::State) -> bool {
        let mut any = false;
        for asked in self.0.try_iter() {
            any = true;
            match asked {
                Asked::Names => context.enable_accesskit(),
                Asked::Action(request) => state.on_accesskit_action_request(request),
                Asked::Nothing => context.disable_accesskit(),
            }
        }
        any
    }
}
