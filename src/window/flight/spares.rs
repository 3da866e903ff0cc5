//! Pipelines that are compiled before they are needed: those of edits that would switch a pass of the chosen style, and
//! those of the other styles.

use std::collections::VecDeque;
use std::time::Instant;

use toml_edit::Value;

use super::Flight;
use crate::frame::Renderer;
use crate::scene::view::View;
use crate::studio::neighbours::Switches;
use crate::style::Style;
use crate::window::dock::Pane;

/// The styles whose pipelines have been requested before the user chooses the styles.
#[derive(Default)]
pub(super) struct Spares {
    /// Number of styles of the list that have been requested.
    styles: usize,
    /// The style of the list whose neighbours are requested, and the revision of its document.
    of: Option<(usize, u64)>,
    switches: Switches,
    /// The neighbours that are still to be requested: a parameter, and its other value.
    edits: VecDeque<(String, Value)>,
}

impl Flight {
    /// Returns whether the pipelines of a style that is not shown are to be requested. Those of the chosen style come
    /// first.
    pub(super) fn wants_spares(&self) -> bool {
        let has_neighbours = self.edits_style() && (self.is_edited_since_spares() || !self.spares.edits.is_empty());
        (has_neighbours || self.spares.styles < self.spared_styles().len()) && self.shows_chosen_style()
    }

    /// Returns the styles whose pipelines are requested before one of them is chosen: on a software driver none, because
    /// compiling would take cores from drawing.
    fn spared_styles(&self) -> &[Style] {
        if self.gpu.is_software() { &[] } else { self.styles.list() }
    }

    fn edits_style(&self) -> bool {
        self.dock.is_shown(Pane::Style)
    }

    fn is_edited_since_spares(&self) -> bool {
        let style = self.settings.style;
        self.styles.document(style).is_some_and(|document| self.spares.of != Some((style, document.revision())))
    }

    /// Requests the pipelines of the next style that the user may want: one edit away from the chosen style while the
    /// inspector is shown, then the styles of the list.
    pub(super) fn request_spares(&mut self, now: Instant) {
        let is_ready = |renderer: &Renderer| !renderer.is_building(&self.gpu) && !renderer.has_spares(&self.gpu);
        if !self.wants_spares() || !self.renderer.as_ref().is_some_and(is_ready) {
            return;
        }
        let Some(style) = self.next_spare() else { return };
        self.next_built = now;
        let picture_px = self.settings.picture_px(self.screen.size_px());
        let pose = self.camera.pose();
        let rig = self.settings.rig(&View::whole(pose, pose, picture_px), &self.last.pair);
        let light = self.light();
        if let Some(renderer) = &mut self.renderer
            && let Err(error) = renderer.request_spares(&self.gpu, &self.world.surfaces, &rig, &style, &light)
        {
            // The error is reported when the style is chosen.
            tracing::debug!("{}: {error}", style.name);
        }
    }

    fn next_spare(&mut self) -> Option<Style> {
        let style = self.settings.style;
        // A drag must stay fluent, and moves on to other neighbours anyway.
        if self.edits_style()
            && !self.stale
            && let Some(document) = self.styles.document(style)
        {
            let of = Some((style, document.revision()));
            if self.spares.of != of {
                let switches = Switches::of(document);
                let is_switched =
                    self.spares.of.is_none_or(|(before, _)| before != style) || switches != self.spares.switches;
                self.spares.of = of;
                if is_switched {
                    self.spares.switches = switches;
                    self.spares.edits = document.switchable().into();
                }
            }
            while let Some((key, value)) = self.spares.edits.pop_front() {
                if let Some(neighbour) = document.neighbour(&key, value) {
                    return Some(neighbour);
                }
            }
        }
        let next = self.spared_styles().get(self.spares.styles)?.clone();
        self.spares.styles += 1;
        Some(next)
    }
}
