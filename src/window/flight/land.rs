//! Changes of the land and of its light during a flight: exaggeration and focus.

use glam::DVec3;

use super::{Flight, TOAST};
use crate::scene::view::{Rig, View};
use crate::scene::{Scene, SceneFocus};
use crate::tiles::terrain::TerrainOptions;
use crate::window::reopening::{Reopening, Wanted};
use crate::window::toasts::About;

/// Radius of a new focus, as a part of its distance from the camera.
const FOCUS_PART: f64 = 0.25;
/// Share of the contrast that is lost far from a new focus.
const FOCUS_STRENGTH: f64 = 0.7;

impl Flight {
    /// Begins to read the land again if another exaggeration is wanted, and no control is being dragged.
    pub(super) fn follow_exaggeration(&mut self) {
        let wanted = self.settings.exaggeration;
        let present = self.world.surfaces.exaggeration();
        if self.reopening.is_some() || wanted == present || self.overlay.is_dragging() || self.overlay.is_typing() {
            return;
        }
        let terrain = &self.world.surfaces.terrain;
        let options = TerrainOptions { lod_error_px: self.settings.lod_error_px, ..*terrain.options() };
        let mut pose = self.camera.pose();
        pose.position_m.z *= wanted / present;
        let picture_px = self.settings.picture_px(self.screen.size_px());
        let request = Wanted {
            gpu: self.gpu.clone(),
            scene: Scene { vertical_exaggeration: wanted, sun_time: None, ..self.world.scene.clone() },
            heights: self.world.heights.clone(),
            options,
            rig: Rig::mono(View::whole(pose, pose, picture_px)),
            style: self.style().clone(),
            light: self.light(),
        };
        let proxy = self.proxy.clone();
        self.reopening = Some(Reopening::start(request, move || _ = proxy.send_event(())));
        self.show_shader_errors();
    }

    /// Shows the land with another exaggeration if it has been read. Returns whether something has changed.
    pub(super) fn take_reopened(&mut self) -> bool {
        let Some(done) = self.reopening.as_ref().and_then(Reopening::take) else { return false };
        let Some(Reopening { factor, .. }) = self.reopening.take() else { return false };
        match done {
            Ok(surfaces) => {
                let ratio = factor / self.world.surfaces.exaggeration();
                self.world.surfaces = surfaces;
                self.world.scene.vertical_exaggeration = factor;
                self.world.more.exaggeration = Some(factor);
                // The same part of the land stays in the picture: heights count from sea level.
                for camera in [&mut self.camera, &mut self.start] {
                    camera.position_m.z *= ratio;
                    camera.stop_moves();
                }
                self.begin_again();
                self.read_grounds();
            }
            Err(error) => {
                self.settings.exaggeration = self.world.surfaces.exaggeration();
                self.say(About::Edit, error, TOAST);
            }
        }
        self.show_shader_errors();
        true
    }

    /// Waits for a click on the picture, which places the focus.
    pub(super) fn place_focus(&mut self) {
        self.navigation.places_focus = true;
        self.say(About::Edit, "Click on the place of the strongest contrast".to_owned(), TOAST);
    }

    /// Places the focus at a place in the world.
    pub(super) fn focus_on(&mut self, place_m: DVec3) {
        let distance_m = place_m.distance(self.camera.position_m);
        let before = self.settings.focus;
        let (radius_m, strength) =
            before.map_or((FOCUS_PART * distance_m, FOCUS_STRENGTH), |it| (it.radius_m, it.strength));
        // To the metre, so that an imprint is short.
        let (place_m, radius_m) = (place_m.truncate().round(), radius_m.round().max(1.0));
        self.settings.focus = Some(SceneFocus { place_m, height_m: None, radius_m, strength });
        self.stale = true;
    }
}
