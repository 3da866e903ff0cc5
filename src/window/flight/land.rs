//! Changes of the land and of its light during a flight: exaggeration, sea, trees and focus.

use glam::DVec3;

use super::{Flight, TOAST};
use crate::scene::overrides::Trees;
use crate::scene::view::{Rig, View};
use crate::scene::{Forest, Scene, SceneFocus};
use crate::tiles::terrain::TerrainOptions;
use crate::window::reopening::{LandToRead, Reopening};
use crate::window::scene_history::SceneValue;
use crate::window::settings::Settings;
use crate::window::toasts::About;

/// Radius of a new focus, as a part of its distance from the camera.
const FOCUS_PART: f64 = 0.25;
/// Share of the contrast that is lost far from a new focus.
const FOCUS_STRENGTH: f64 = 0.7;

impl Flight {
    /// Draws the sea and the trees of the settings. Begins to read the land again if another exaggeration is wanted, or
    /// trees whose files have not been read. Nothing but the sea follows a control while it is being dragged.
    pub(super) fn follow_land(&mut self) {
        let present = self.world.surfaces.exaggeration();
        self.world.surfaces.set_sea_level(self.settings.sea_level_m.map(|level_m| level_m * present));
        let Settings { exaggeration: wanted, tree_seed, .. } = self.settings;
        let is_alike = wanted == present && tree_seed == self.world.tree_seed();
        if is_alike && self.land_being_read.take().is_some() {
            // The land that was being read is no longer needed.
            self.needs_relayout |= self.update_lasting_messages();
        }
        if self.land_being_read.is_some() || is_alike || self.overlay.is_dragging() || self.overlay.is_typing() {
            return;
        }
        let own = self.world.lasting.own_forest.as_ref();
        let forest = tree_seed.and_then(|seed| Trees::Seed(seed).apply_to(own.cloned()));
        if wanted == present && forest.as_ref().is_none_or(|forest| self.world.surfaces.has_files_of(forest)) {
            self.world.surfaces.set_forest(forest.as_ref().map(|forest| forest.exaggerated(present)));
            self.note_forest(forest);
            self.begin_again();
            return;
        }
        let terrain = &self.world.surfaces.terrain;
        let options = TerrainOptions { lod_error_px: self.settings.lod_error_px, ..*terrain.options() };
        let mut pose = self.camera.pose();
        pose.position_m.z *= wanted / present;
        let picture_px = self.settings.picture_px(self.screen.size_px());
        let before = &self.world.scene;
        let request = LandToRead {
            gpu: self.gpu.clone(),
            scene: Scene { vertical_exaggeration: wanted, forest, sun_time: None, ..before.clone() },
            heights: self.world.lasting.heights.clone(),
            options,
            rig: Rig::mono(View::whole(pose, pose, picture_px)),
            style: self.style().clone(),
            light: self.light(),
        };
        let proxy = self.proxy.clone();
        self.land_being_read = Some(Reopening::start(request, move || _ = proxy.send_event(())));
        self.update_lasting_messages();
    }

    /// Shows the land with another exaggeration, or other trees, if it has been read. Returns whether something has
    /// changed.
    pub(super) fn take_reopened(&mut self) -> bool {
        let Some(done) = self.land_being_read.as_ref().and_then(Reopening::take) else { return false };
        let Some(Reopening { factor, forest, .. }) = self.land_being_read.take() else { return false };
        match done {
            Ok(surfaces) => {
                let ratio = factor / self.world.surfaces.exaggeration();
                self.world.surfaces = surfaces;
                self.note_forest(forest);
                if ratio != 1.0 {
                    self.world.scene.vertical_exaggeration = factor;
                    self.world.more.exaggeration = Some(factor);
                    // The same part of the land stays in the picture: heights count from sea level.
                    for camera in [&mut self.camera, &mut self.start] {
                        camera.position_m.z *= ratio;
                        camera.stop_moves();
                    }
                    self.camera_history.scale_heights(ratio);
                }
                self.begin_again();
                self.read_grounds();
                // What was changed while the land was being read.
                self.follow_land();
            }
            Err(error) => {
                self.settings.exaggeration = self.world.surfaces.exaggeration();
                self.settings.tree_seed = self.world.tree_seed();
                for value in [SceneValue::Exaggeration, SceneValue::TreeSeed] {
                    self.scene_history.refuse(value, &self.settings);
                }
                self.say(About::Edit, error, TOAST);
            }
        }
        self.update_lasting_messages();
        true
    }

    /// Records the forest that is drawn, for the imprints of pictures.
    fn note_forest(&mut self, forest: Option<Forest>) {
        self.world.scene.forest = forest;
        let trees = Trees::between(self.world.lasting.own_forest.as_ref(), self.world.tree_seed());
        self.world.more.trees = trees.map(|trees| trees.to_string());
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
