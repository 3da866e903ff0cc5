//! The picture of the frame that is shown instead of the drawing, and the memory of the panels.

use std::time::Instant;

use super::Flight;
use super::navigate::ANSWER_CHECK;
use crate::gpu::target::Target;
use crate::scene::stereo::Eyes;
use crate::studio::recent;
use crate::window::dock::Pane;
use crate::window::picture_viewer::{Entry, FramePicture, entries};

impl Flight {
    fn viewed_eye(&self) -> usize {
        usize::from(self.settings.eyes == Eyes::Right)
    }

    /// Returns the pictures of the last frame that can be shown.
    pub(super) fn viewer_entries(&self) -> Vec<Entry> {
        let Some(renderer) = self.renderer.as_ref().filter(|_| self.shows_chosen_style()) else { return Vec::new() };
        let eye = self.viewed_eye();
        entries(self.style(), |layer| renderer.ink_target(eye, layer).is_some(), &renderer.eye_targets(eye))
    }

    /// Requests the texels of the selected picture.
    pub(super) fn request_viewed_picture(&mut self) {
        if !self.dock.is_shown(Pane::Inside) && self.viewer.selected().is_some() {
            self.viewer.close();
            self.needs_relayout = true;
        }
        let Some(selected) = self.viewer.selected() else { return };
        let (Some(renderer), eye) = (&self.renderer, self.viewed_eye()) else { return };
        let target: Option<&Target> = match selected {
            FramePicture::Ink(layer) => renderer.ink_target(eye, *layer),
            FramePicture::Picture(name, number) => renderer
                .eye_targets(eye)
                .into_iter()
                .find(|(known, target)| known == number && target.name == *name)
                .map(|(_, target)| target),
        };
        self.viewer.request(&self.gpu, target, self.navigation.picture());
        self.viewer.next_check = Instant::now() + ANSWER_CHECK;
    }

    /// Takes texels of the selected picture that have arrived.
    pub(super) fn take_viewed_picture(&mut self) {
        self.viewer.next_check = Instant::now() + ANSWER_CHECK;
        let proxy = self.proxy.clone();
        self.viewer.take_texels(move || _ = proxy.send_event(()));
    }

    /// Ends the sentences of the first start.
    pub(super) fn end_welcome(&mut self) {
        self.welcomes = false;
        self.needs_relayout = true;
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
