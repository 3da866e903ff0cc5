//! Pictures of the frame that are looked at, and what is remembered of the panels.

use std::time::Instant;

use super::Flight;
use super::navigate::ANSWER_LOOK;
use crate::gpu::target::Target;
use crate::scene::stereo::Eyes;
use crate::studio::recent;
use crate::window::dock::Pane;
use crate::window::inside::{Entry, Looked, entries};

impl Flight {
    fn looked_eye(&self) -> usize {
        usize::from(self.settings.eyes == Eyes::Right)
    }

    /// Returns what can be looked at in the last frame.
    pub(super) fn entries(&self) -> Vec<Entry> {
        let Some(renderer) = self.renderer.as_ref().filter(|_| self.shows_chosen_style()) else { return Vec::new() };
        let eye = self.looked_eye();
        entries(self.style(), |layer| renderer.ink_target(eye, layer).is_some(), &renderer.eye_targets(eye))
    }

    /// Requests what is looked at of the picture that was presented.
    pub(super) fn ask_inside(&mut self) {
        if !self.dock.is_shown(Pane::Inside) && self.inside.looked().is_some() {
            self.inside.close();
            self.inspector_is_old = true;
        }
        let Some(looked) = self.inside.looked() else { return };
        let (Some(renderer), eye) = (&self.renderer, self.looked_eye()) else { return };
        let target: Option<&Target> = match looked {
            Looked::Ink(layer) => renderer.ink_target(eye, *layer),
            Looked::Picture(name, number) => renderer
                .eye_targets(eye)
                .into_iter()
                .find(|(known, target)| known == number && target.name == *name)
                .map(|(_, target)| target),
        };
        self.inside.ask(&self.gpu, target, self.navigation.picture());
        self.inside.next_look = Instant::now() + ANSWER_LOOK;
    }

    /// Takes what the GPU has sent of a picture that is looked at.
    pub(super) fn take_inside(&mut self) {
        self.inside.next_look = Instant::now() + ANSWER_LOOK;
        let proxy = self.proxy.clone();
        self.inside.take_texels(move || _ = proxy.send_event(()));
    }

    /// Ends the sentences of the first start.
    pub(super) fn end_welcome(&mut self) {
        self.welcomes = false;
        self.inspector_is_old = true;
        self.remembered.is_welcomed = true;
        if let Err(error) = self.remembered.keep() {
            tracing::warn!("{error}");
        }
    }

    /// Remembers window, world, style and panels for the next run.
    pub(in crate::window) fn remember(&mut self) {
        if self.frames_left.is_some() {
            return;
        }
        if let Err(error) = self.paths.views.keep_names() {
            tracing::warn!("{error}");
        }
        let is_whole = self.window.fullscreen().is_none() && !self.window.is_maximized();
        if is_whole && !self.hidden {
            self.remembered.size_px = Some(self.screen.size_px());
        }
        self.remembered.world = self.world.world.as_deref().and_then(recent::kept);
        self.remembered.style = Some(self.styles.lasting_name(self.settings.style));
        self.remembered.panels = self.dock.text();
        if let Err(error) = self.remembered.keep() {
            tracing::warn!("{error}");
        }
    }
}
