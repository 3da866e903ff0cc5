//! Undo and redo of the scene, in one order with the edits of the style, and the previous views of the camera.

use std::time::Instant;

use super::{Flight, ground_m};
use crate::studio::document::StyleDocument;
use crate::window::camera_history::ViewStep;
use crate::window::scene_history::{is_held, is_later};

impl Flight {
    /// Records what has changed in the scene since the last frame.
    pub(super) fn note_scene(&mut self) {
        let is_held = is_held(self.overlay.context());
        self.scene_history.note(&self.settings, is_held);
    }

    /// Returns whether the next step belongs to the scene, not to a style: the next one to undo (`side` 0) or to redo (1).
    pub(super) fn is_scene_next(&mut self, side: usize, style: usize) -> bool {
        // What this frame has changed comes first.
        self.scene_history.note(&self.settings, false);
        let of_style = self.styles.document(style).map_or([None, None], StyleDocument::steps);
        is_later(self.scene_history.steps()[side], of_style[side])
    }

    /// Undoes the last step of the scene. Returns what the user needs to know.
    pub(super) fn undo_scene(&mut self) -> Option<String> {
        let name = self.scene_history.undo(&mut self.settings)?;
        self.scene_stepped();
        Some(format!("Undo: {name}"))
    }

    /// Repeats the step of the scene that was undone last. Returns what the user needs to know.
    pub(super) fn redo_scene(&mut self) -> Option<String> {
        let name = self.scene_history.redo(&mut self.settings)?;
        self.scene_stepped();
        Some(format!("Redo: {name}"))
    }

    /// Draws the changes of a step. The next frame reads the land again where that is necessary, as after any change.
    fn scene_stepped(&mut self) {
        self.stale = true;
        self.needs_relayout = true;
    }

    /// Records where the camera is at the end of a frame. `is_still` says whether nothing moves it.
    pub(super) fn note_view(&mut self, is_still: bool) {
        let is_held = self.input.drag().is_some() || is_held(self.overlay.context());
        let (view, height_m) = (self.camera.exact(), self.camera_height_m());
        self.camera_history.note(view, is_still && !is_held, height_m, Instant::now());
    }

    /// Returns whether there is a previous view, and a next one.
    pub(super) fn has_views(&self) -> [bool; 2] {
        self.camera_history.has_views(&self.camera.exact(), self.camera_height_m())
    }

    /// Shows a view that the camera has left, at once.
    pub(super) fn go_to_remembered(&mut self, step: ViewStep) {
        let (view, height_m) = (self.camera.exact(), self.camera_height_m());
        if let Some(view) = self.camera_history.go(step, view, height_m, Instant::now()) {
            self.paths.player.pause();
            self.camera.stand_at(&view);
            self.stale = true;
            self.needs_relayout = true;
        }
    }

    /// Returns the height of the camera above the ground, in metres.
    fn camera_height_m(&self) -> f64 {
        let position_m = self.camera.position_m;
        position_m.z - ground_m(&self.world, position_m.truncate())
    }
}
