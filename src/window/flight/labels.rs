//! Labels of summits and places during a flight.

use std::time::Instant;

use glam::DVec2;

use super::{Flight, TOAST};
use crate::picture::legend::drawn_area;
use crate::picture::names::Ground;
use crate::scene::stereo::Eyes;
use crate::scene::view::{Part, Rig, View};
use crate::window::labels::LabelFrame;
use crate::window::toasts::About;

impl Flight {
    /// Shows labels, or hides them.
    pub(super) fn toggle_labels(&mut self) {
        self.labels.toggle();
        self.needs_relayout = true;
        let text = match (self.labels.is_on(), self.settings.eyes) {
            (true, Eyes::Anaglyph | Eyes::GreyAnaglyph) => "Labels: an anaglyph in a window has none",
            (true, _) => "Labels of summits",
            (false, _) => "No labels",
        };
        self.say(About::Edit, text.to_owned(), TOAST / 2);
    }

    /// Finds the summits of the land, and takes what has been found and seen. Returns whether a frame is needed.
    pub(super) fn follow_labels(&mut self) -> bool {
        let [of_summits, of_looks] = [self.proxy.clone(), self.proxy.clone()];
        let surfaces = &self.world.surfaces;
        let wake = move || _ = of_summits.send_event(());
        self.labels.follow(&surfaces.terrain, surfaces.exaggeration(), self.world.world.as_deref(), wake);
        match self.labels.take(move || _ = of_looks.send_event(())) {
            Ok(has_news) => has_news,
            Err(error) => {
                self.say(About::Edit, error, TOAST);
                true
            }
        }
    }

    /// Requests the distances of the last picture, if labels need them.
    pub(super) fn request_labels(&mut self) {
        let eyes = self.navigation.eyes().to_vec();
        let number = self.navigation.picture();
        let Some(renderer) = self.renderer.as_ref().filter(|_| !eyes.is_empty()) else { return };
        let origin_m = self.last.pose.position_m;
        let window_px = self.settings.eye_px(self.screen.size_px());
        let earth = self.world.surfaces.terrain.earth_curvature(origin_m.z);
        let rig = Rig { origin_m, eyes };
        let larger =
            |eye: &View| View { picture_px: window_px, part: Part::whole(window_px), jitter_px: DVec2::ZERO, ..*eye };
        let whole = Rig { origin_m, eyes: rig.eyes.iter().map(larger).collect() };
        self.labels.request(&self.gpu, renderer, [rig, whole], (earth, number));
    }

    /// Returns the labels of the frame as shapes of the overlay.
    pub(super) fn label_shapes(&mut self) -> Vec<egui::Shape> {
        let eyes = self.settings.eyes;
        if !self.labels.is_on() || eyes.are_merged() {
            return Vec::new();
        }
        let eye_px = self.settings.eye_px(self.screen.size_px());
        let pose = self.camera.pose();
        let rig = self.settings.rig(&View::whole(pose, pose, eye_px), &self.settings.pair);
        let context = self.overlay.context().clone();
        let points = f64::from(context.pixels_per_point());
        let style = self.style();
        let [columns, rows] = drawn_area(&style.paper, eye_px).map(|ends| ends.map(|side| side as f64));
        let mut area_px = [DVec2::new(columns[0], rows[0]), DVec2::new(columns[1], rows[1])];
        let shown = match eyes {
            Eyes::SideBySide => vec![(0, 0.0), (1, f64::from(eye_px[0]))],
            Eyes::Right => vec![(1, 0.0)],
            _ => vec![(0, 0.0)],
        };
        if eyes != Eyes::SideBySide {
            // Not below panels.
            let free = self.dock.free(context.content_rect());
            let corner = |at: egui::Pos2| DVec2::new(f64::from(at.x), f64::from(at.y)) * points;
            area_px = [area_px[0].max(corner(free.min)), area_px[1].min(corner(free.max))];
        }
        let (paper, ink) = (style.paper.clone(), style.ink_on_sky());
        let frame = LabelFrame {
            context: &context,
            rig: &rig,
            earth: self.world.surfaces.terrain.earth_curvature(pose.position_m.z),
            ground: Ground { area_px, paper: &paper, px: points },
            shown: &shown,
            ink,
            time_s: self.begun.elapsed().as_secs_f64(),
        };
        self.labels.shapes(&frame)
    }

    /// Returns whether labels may still fade or move although the picture is at rest.
    pub(super) fn labels_settle(&self) -> bool {
        self.labels.is_settling(Instant::now())
    }
}
