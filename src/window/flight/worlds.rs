//! Files that are opened during a flight: another world, a style, a camera path.

use std::path::{Path, PathBuf};
use std::time::Instant;

use winit::event::WindowEvent;

use super::compare::Compared;
use super::{Flight, TOAST, ground_m};
use crate::file::message::named;
use crate::picture::imprint::More;
use crate::scene::overrides::Overrides;
use crate::source::EarthPlace;
use crate::studio::document::StyleDocument;
use crate::studio::file_kind::{FileKind, expand_home, file_kind};
use crate::tiles::terrain::{Prepared, TerrainOptions};
use crate::window::FlightWorld;
use crate::window::browse::{self, Chosen};
use crate::window::camera_history::CameraHistory;
use crate::window::fly_camera::FlyCamera;
use crate::window::light::LightPanel;
use crate::window::open_dialog::OpenRequest;
use crate::window::other_world::{OtherWorld, WorldToOpen};
use crate::window::path_flight::{self, Reading};
use crate::window::places::Places;
use crate::window::scene_history::{SceneHistory, SceneValue};
use crate::window::toasts::About;

use super::navigate::Navigation;

/// The message where the system shows no dialog.
const NO_DIALOG: &str = "This system shows no file dialog (no desktop portal answers). Drop the file on the window, or write its path here.";

impl Flight {
    /// Opens the dialog for files, or closes it.
    pub(super) fn toggle_open_dialog(&mut self) {
        self.open_dialog.toggle(self.recent.entries());
    }

    /// Carries out the user's request in the dialog that opens files.
    pub(super) fn on_open_request(&mut self, request: OpenRequest) {
        // This frame was laid out before.
        self.needs_relayout = true;
        match request {
            OpenRequest::Open(name) => self.open_named(&expand_home(&name)),
            OpenRequest::BuiltIn => self.open_world(None),
            OpenRequest::Browse(wanted) => self.browse(wanted),
        }
    }

    fn browse(&mut self, wanted: browse::DialogKind) {
        let proxy = self.proxy.clone();
        self.browser.open(wanted, &self.window, move || _ = proxy.send_event(()));
    }

    /// Takes the end of the system's dialog. Returns whether there is news.
    pub(super) fn take_chosen(&mut self) -> bool {
        let Some(chosen) = self.browser.take() else { return false };
        match chosen {
            Chosen::Path(path) => self.open_named(&path.to_string_lossy()),
            Chosen::Nothing => {}
            Chosen::NoDialog => self.cannot_open(NO_DIALOG.to_owned()),
        }
        true
    }

    /// Notices a file that was dropped on the window. All files of one drop are handled in the next frame. Returns whether
    /// the event was one.
    pub(super) fn on_dropped(&mut self, event: &WindowEvent) -> bool {
        let dropped = dropped(event);
        self.dropped.extend(dropped.map(Path::to_owned));
        dropped.is_some()
    }

    /// Opens the files that were dropped since the last frame.
    pub(super) fn open_dropped(&mut self) {
        let paths: Vec<PathBuf> = std::mem::take(&mut self.dropped);
        let named: Vec<String> = paths.iter().map(|path| path.to_string_lossy().into_owned()).collect();
        match chosen_of_drop(&named, file_kind) {
            Ok(names) => names.iter().for_each(|name| self.open_named(name)),
            Err(error) => self.cannot_open(error),
        }
    }

    /// Opens a file, an address, or a built-in scene, style or camera path of this name.
    pub(super) fn open_named(&mut self, name: &str) {
        match file_kind(name) {
            FileKind::World => self.open_world(Some(name)),
            FileKind::Style => self.open_style(name),
            FileKind::CameraPath => self.open_path(name),
            FileKind::Refused(cause) => self.cannot_open(cause),
        }
    }

    /// Reports why a file cannot be opened.
    fn cannot_open(&mut self, cause: String) {
        tracing::info!("{cause}");
        self.open_dialog.refuse(&cause);
        self.say(About::File, cause, 2 * TOAST);
    }

    /// Puts a file into the list of those that were opened last.
    pub(super) fn note_opened(&mut self, name: &str) {
        if let Err(error) = self.recent.add(name) {
            tracing::warn!("{error}");
        }
    }

    /// Begins to open another world; the current one stays until it is open.
    fn open_world(&mut self, name: Option<&str>) {
        // Another seed was meant for the current world.
        self.keep_seed();
        self.begin_to_open(name, Overrides::default(), None);
    }

    /// Begins to open the current world with another seed, once no control is dragged. Sea, trees, exaggeration and
    /// light stay.
    pub(super) fn follow_seed(&mut self) {
        let Some(seed) = self.settings.world_seed.filter(|seed| self.world.scene.world.seed() != Some(*seed)) else {
            // Another seed may have been undone while its land is being opened.
            if let Some(opening) = self.world_being_opened.take_if(|opening| opening.seed.is_some()) {
                opening.work.cancel();
                self.needs_relayout = true;
            }
            return;
        };
        let is_begun = self.world_being_opened.as_ref().is_some_and(|opening| opening.seed == Some(seed));
        if is_begun || self.overlay.is_dragging() || self.overlay.is_typing() {
            return;
        }
        let More { sea_level, trees, exaggeration, .. } = self.shot().imprint.more;
        let overrides = Overrides {
            sea_level: sea_level.and_then(|level| level.parse().ok()),
            trees: trees.and_then(|trees| trees.parse().ok()),
            seed: Some(seed),
        };
        let name = self.world.world.clone();
        self.begin_to_open(name.as_deref(), overrides, exaggeration);
    }

    /// Gives up another seed: the land stays.
    fn keep_seed(&mut self) {
        self.settings.world_seed = self.world.scene.world.seed();
        self.scene_history.refuse(SceneValue::WorldSeed, &self.settings);
    }

    fn begin_to_open(&mut self, name: Option<&str>, overrides: Overrides, exaggeration: Option<f64>) {
        if let Some(before) = self.world_being_opened.take() {
            before.work.cancel();
            self.path_of_opening = None;
        }
        let options = TerrainOptions { lod_error_px: self.settings.lod_error_px, ..*self.terrain_options() };
        let wanted = WorldToOpen {
            gpu: self.gpu.clone(),
            name: name.map(str::to_owned),
            reach: self.reach,
            overrides,
            exaggeration,
            options,
            tile_memory_mib: self.world.more.tile_memory,
            size_px: self.settings.picture_px(self.screen.size_px()),
            style: self.style().clone(),
        };
        let proxy = self.proxy.clone();
        self.world_being_opened = Some(OtherWorld::start(wanted, move || _ = proxy.send_event(())));
    }

    fn terrain_options(&self) -> &TerrainOptions {
        self.world.surfaces.terrain.options()
    }

    /// Cancels the opening of another world.
    pub(super) fn cancel_opening(&mut self) {
        if let Some(opening) = self.world_being_opened.take() {
            opening.work.cancel();
            self.path_of_opening = None;
            self.keep_seed();
            self.needs_relayout = true;
            self.say(About::File, format!("{}: cancelled", opening.work.title), TOAST);
        }
    }

    /// Shows the world that was opened, or why it could not be. Returns whether there is news.
    pub(super) fn take_opened(&mut self) -> bool {
        let Some(opening) = &self.world_being_opened else { return false };
        let Some(done) = opening.take() else {
            return true;
        };
        let Some(OtherWorld { name, seed, .. }) = self.world_being_opened.take() else { return false };
        match done {
            Ok(world) => {
                if !name.is_empty() && seed.is_none() {
                    self.note_opened(&name);
                }
                self.open_dialog.close();
                self.enter(*world, seed.is_some());
            }
            Err(error) => {
                self.keep_seed();
                let unread = self.path_of_opening.take().map(|path| format!("{}: not read either", named(&path)));
                self.cannot_open(std::iter::once(error).chain(unread).collect::<Vec<_>>().join("\n"));
            }
        }
        true
    }

    /// Replaces the world. The style and its edits, the size of the picture and the eyes stay; those of the same world
    /// with another seed, `is_same`, also its light, sea, trees and exaggeration.
    fn enter(&mut self, world: FlightWorld, is_same: bool) {
        let terrain = &world.surfaces.terrain;
        self.start = FlyCamera::new(&world.start, |at| ground_m(&world, at), terrain.extent_m());
        self.camera = self.start.clone();
        let store = terrain.store();
        let size = store.levels()[0];
        self.light_panel = LightPanel::new(EarthPlace::of_grid(store.georeference(), size.width, size.height));
        self.land_panel = world.land_panel();
        self.navigation = Navigation::new(Places::of(terrain));
        self.layer_picking.cancel();
        self.export_dialog.forget();
        (self.land_being_read, self.path_being_read) = (None, None);
        self.leave_path();
        let of_this_world = self.path_of_opening.take();
        if !is_same {
            self.settings.sun = world.sun;
            self.settings.haze_m = world.light.haze_m;
            self.settings.exaggeration = world.surfaces.exaggeration();
            self.settings.sea_level_m = world.scene.sea_level_m;
            self.settings.tree_seed = world.tree_seed();
            self.settings.focus = world.scene.focus;
        }
        self.settings.world_seed = world.scene.world.seed();
        if is_same {
            self.scene_history.follow(&self.settings);
        } else {
            self.scene_history = SceneHistory::new(&self.settings);
        }
        self.camera_history = CameraHistory::new(self.start.exact(), Instant::now());
        let pose = self.start.pose();
        self.last.pose = pose;
        self.last.prepared = Prepared::default();
        self.last.tiles_loaded = 0;
        self.window.set_title(&format!("{} — hachure", world.name));
        self.say(About::File, format!("Opened {}", world.name), TOAST);
        self.styles.set_features(world.surfaces.has_features_and_graticule());
        self.world = world;
        self.open_views();
        self.begin_again();
        self.thumbnails.wake(Instant::now());
        if let Some(path) = of_this_world {
            self.open_path(&path);
        }
    }

    /// Begins with a new renderer, because the history is of another land. The last picture stays until the first one is
    /// drawn.
    pub(super) fn begin_again(&mut self) {
        self.previous_renderer = self.renderer.take().or(self.previous_renderer.take());
        self.divided.iter_mut().for_each(Compared::begin_again);
        self.stale = true;
    }

    /// Draws with a style file.
    fn open_style(&mut self, name: &str) {
        let before = self.settings.style;
        self.settings.style = match self.styles.place_of(name) {
            Some(style) => style,
            None => match StyleDocument::open(name) {
                Ok(document) => self.styles.add(document),
                Err(error) => return self.cannot_open(error.to_string()),
            },
        };
        self.open_dialog.close();
        self.note_opened(name);
        self.say(About::Style, format!("{}: {}", named(name), self.style().name), TOAST);
        if before != self.settings.style {
            self.style_changed(before);
            self.open_document();
        }
        self.stale = true;
    }

    /// Begins to read a camera path. While another world is being opened, the path is meant for that world and waits.
    pub(super) fn open_path(&mut self, name: &str) {
        if self.world_being_opened.is_some() {
            self.path_of_opening = Some(name.to_owned());
            return;
        }
        let wanted = path_flight::PathToRead {
            path: PathBuf::from(name),
            world_name: self.world.world.clone(),
            world: self.world.scene.world.clone(),
            ground: self.world.surfaces.terrain.ground_heights(),
        };
        let proxy = self.proxy.clone();
        self.path_being_read = Some(Reading::start(wanted, move || _ = proxy.send_event(())));
    }

    /// Flies a path that was read. Returns whether there is news.
    pub(super) fn take_path(&mut self) -> bool {
        let Some(done) = self.path_being_read.as_ref().and_then(Reading::take) else { return false };
        self.path_being_read = None;
        match done {
            Ok(path_flight::Read { name, document, warning }) => {
                self.note_opened(&name.to_string_lossy());
                self.open_dialog.close();
                warning.into_iter().for_each(|warning| self.say(About::File, warning, 2 * TOAST));
                self.enter_path(document);
            }
            Err(error) => self.cannot_open(error),
        }
        true
    }
}

/// Returns the file that an event drops on the window.
fn dropped(event: &WindowEvent) -> Option<&Path> {
    match event {
        WindowEvent::DroppedFile(path) => Some(path),
        _ => None,
    }
}

/// Returns which files of one drop are opened, in order: of several height files none, because only a folder can
/// combine them into one world.
///
/// # Errors
/// A line of advice: open the folder instead of one of its files.
fn chosen_of_drop(names: &[String], kind_of: impl Fn(&str) -> FileKind) -> Result<Vec<String>, String> {
    let (worlds, others): (Vec<&String>, Vec<&String>) =
        names.iter().partition(|name| kind_of(name) == FileKind::World);
    if worlds.len() > 1 {
        let [first, last] = [worlds[0], worlds[worlds.len() - 1]].map(named);
        return Err(format!(
            "{} worlds were dropped at once ({first} to {last}); drop the folder of several height files to open them as one",
            worlds.len()
        ));
    }
    // A style or a path is for the new world.
    Ok(worlds.into_iter().chain(others).cloned().collect())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    #[test]
    fn a_drop_is_told_from_a_file_that_hovers() {
        let path = PathBuf::from("/data/alps.tif");
        assert_eq!(dropped(&WindowEvent::DroppedFile(path.clone())), Some(&*path));
        assert_eq!(dropped(&WindowEvent::HoveredFile(path)), None);
        assert_eq!(dropped(&WindowEvent::HoveredFileCancelled), None);
    }

    #[test]
    fn several_height_files_are_dropped_as_a_folder() {
        let kind_of = |name: &str| match name.rsplit_once('.') {
            Some((_, "toml")) => FileKind::Style,
            _ => FileKind::World,
        };
        let drop =
            |names: &[&str]| chosen_of_drop(&names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>(), kind_of);
        assert_eq!(drop(&[]), Ok(Vec::new()));
        assert_eq!(drop(&["a.toml", "b.tif"]), Ok(vec!["b.tif".to_owned(), "a.toml".to_owned()]));
        let error = drop(&["a.tif", "c.toml", "b.tif"]).unwrap_err();
        assert!(error.starts_with("2 worlds were dropped at once (a.tif to b.tif); drop the folder"), "{error}");
    }
}
