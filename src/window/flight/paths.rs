//! The camera path of a flight: the requests of its panel, and its playback.

use std::time::Instant;

use super::{Flight, TOAST};
use crate::file::message::named;
use crate::scene::camera::Camera;
use crate::studio::camera_path::PathDocument;
use crate::studio::recent;
use crate::studio::views::Views;
use crate::window::FlightWorld;
use crate::window::camera_moves::Viewpoint;
use crate::window::dock::Pane;
use crate::window::path_flight::{self, Grounds, Player};
use crate::window::path_panel::{PathEdit, PathPanel, PathRequest, PathState};
use crate::window::toasts::About;

/// The camera path, and the named views of the world.
pub(super) struct Paths {
    pub document: PathDocument,
    pub player: Player,
    pub panel: PathPanel,
    pub views: Views,
    /// Edits of an earlier run that are not saved.
    pub kept: Option<String>,
    /// The ground below keys, while it is read again.
    grounds: Option<Grounds>,
}

impl Paths {
    /// Returns an empty path in a world, with the views of it.
    pub(super) fn of_world(world: &FlightWorld) -> Self {
        Self { views: Views::open(world.world.as_deref(), world.more.seed), ..Self::empty() }
    }

    /// Returns an empty path without views.
    fn empty() -> Self {
        Self {
            document: PathDocument::empty(),
            player: Player::default(),
            panel: PathPanel::default(),
            views: Views::default(),
            kept: None,
            grounds: None,
        }
    }

    /// Returns what the panel shows, and the panel.
    pub(super) fn shown(&mut self) -> (PathState<'_>, &mut PathPanel) {
        let Self { document, player, panel, views, kept, .. } = self;
        (PathState { document, player, views, has_kept: kept.is_some() }, panel)
    }
}

impl Flight {
    /// Looks for edits of the path that an earlier run has left.
    pub(super) fn find_kept_path(&mut self) {
        self.paths.kept = self.paths.document.find_kept(&self.unsaved, &self.path_world());
        if self.paths.kept.is_some() && !self.dock.is_shown(Pane::Path) {
            let text = "An earlier run ended with edits of a camera path that were not saved; V shows them".to_owned();
            self.say(About::File, text, 2 * TOAST);
        }
    }

    /// Returns the name of the world under which edits of a path without a file are kept.
    fn path_world(&self) -> String {
        let lasting = |name: &String| std::path::absolute(name).map_or(name.clone(), |path| path.display().to_string());
        let name = self.world.world.as_ref();
        let name =
            name.map_or_else(String::new, |name| if name.contains("://") { name.clone() } else { lasting(name) });
        recent::with_seed(name, self.world.more.seed)
    }

    /// Carries out the user's requests in the panel of the path.
    pub(super) fn on_path_requests(&mut self, requests: Vec<PathRequest>) {
        // This frame was laid out before.
        self.needs_relayout |= !requests.is_empty();
        for request in requests {
            self.on_path_request(request);
        }
    }

    fn on_path_request(&mut self, request: PathRequest) {
        match request {
            PathRequest::Edit(edit) => self.edit_path(edit),
            PathRequest::Seek(time_s) => {
                self.paths.player.pause();
                self.seek(time_s);
            }
            PathRequest::Play(plays) => self.play_path(plays),
            PathRequest::Loop(loops) => self.paths.player.loops = loops,
            PathRequest::Save => self.save_path(),
            PathRequest::SaveAs(name) => self.save_path_as(&name),
            PathRequest::New => self.begin_path(),
            PathRequest::Open => self.toggle_open_dialog(),
            PathRequest::Film => self.film_path(),
            PathRequest::Restore(restores) => self.restore_path(restores),
            PathRequest::AddView => self.add_view(),
            PathRequest::GoTo(index) => self.go_to_view(index),
            PathRequest::Rename(index, name) => self.paths.views.rename(index, &name),
            PathRequest::KeepViews => {
                let kept = self.paths.views.keep_names();
                self.say_error(kept);
            }
            PathRequest::RemoveView(index) => {
                let removed = self.paths.views.remove(index);
                self.say_error(removed);
            }
        }
    }

    fn say_error(&mut self, done: Result<(), String>) {
        if let Err(error) = done {
            self.say(About::Edit, error, TOAST);
        }
    }

    /// Changes the path.
    pub(super) fn edit_path(&mut self, edit: PathEdit) {
        let here = self.camera.camera();
        let edit = match edit {
            // Views have true heights.
            PathEdit::AddCamera(camera) => PathEdit::AddCamera(scaled(&camera, self.world.surfaces.exaggeration())),
            other => other,
        };
        let before = self.paths.document.text().len();
        let Paths { document, player, panel, .. } = &mut self.paths;
        let done = panel.apply(document, player, edit, &here);
        if let Ok(()) = done
            && before < self.paths.document.text().len()
            && matches!(edit, PathEdit::Add)
            && !self.dock.is_shown(Pane::Path)
        {
            let keys = self.paths.document.keys().len();
            self.say(About::Edit, format!("Added key frame {keys} (V shows the camera path)"), TOAST / 2);
        }
        self.say_error(done);
        self.has_warned_of_leaving = false;
        self.needs_relayout = true;
        let [first_s, last_s] = self.paths.document.span_s();
        self.paths.player.playhead_s = self.paths.player.playhead_s.clamp(first_s, last_s);
        if !matches!(edit, PathEdit::Release) {
            self.paths.document.keep(&self.unsaved, &self.path_world());
        }
    }

    /// Places playhead and camera at a time.
    fn seek(&mut self, time_s: f64) {
        self.paths.player.playhead_s = time_s;
        if let Some(camera) = self.paths.document.curve().map(|curve| curve.sample(time_s)) {
            self.camera.stand_at(&camera);
            self.stale = true;
        }
    }

    /// Plays the path, or pauses it.
    pub(super) fn play_path(&mut self, plays: bool) {
        if !plays {
            self.paths.player.pause();
        } else if self.paths.document.keys().len() < 2 {
            let text = "A camera path needs two key frames: fly to a view, and press N".to_owned();
            self.say(About::Edit, text, TOAST);
        } else {
            // What is left of a motion would end it.
            self.camera.stop();
            self.paths.player.play(self.paths.document.span_s());
        }
    }

    /// Plays or pauses.
    pub(super) fn toggle_play(&mut self) {
        self.play_path(!self.paths.player.is_playing());
    }

    /// Moves the camera along the path that is played, unless the user moves it. Returns whether the picture changes.
    pub(super) fn follow_path(&mut self, now: Instant, is_moved: bool) -> bool {
        if is_moved {
            return self.paths.player.pause();
        }
        let moves = self.paths.player.advance(now, self.paths.document.span_s());
        if moves {
            self.seek(self.paths.player.playhead_s);
            self.needs_relayout |= !self.paths.player.is_playing();
        }
        moves
    }

    /// Pauses the path. Returns whether it was played.
    pub(super) fn pause_path(&mut self) -> bool {
        self.needs_relayout = true;
        self.paths.player.pause()
    }

    /// Opens a path that was read, and flies it.
    pub(super) fn enter_path(&mut self, document: PathDocument) {
        self.warn_of_kept_path();
        self.paths.document = document;
        self.paths.panel.forget();
        self.find_kept_path();
        self.paths.player.rewind();
        if let Some(curve) = self.paths.document.curve() {
            let text = path_flight::begins(self.paths.document.name().as_ref(), curve);
            self.say(About::Edit, text, TOAST);
        }
        self.dock.set_shown(Pane::Path, true);
        self.paths.player.playhead_s = self.paths.document.span_s()[0];
        self.camera.stop();
        self.seek(self.paths.player.playhead_s);
        self.paths.player.play(self.paths.document.span_s());
    }

    /// Tells the user that edits of the path are kept although another one replaces it.
    fn warn_of_kept_path(&mut self) {
        if self.paths.document.is_edited() {
            let text = format!("Edits of {} are not saved; they are offered when it is opened again", self.path_name());
            self.say(About::Quitting, text, 2 * TOAST);
        }
    }

    /// Returns the name of the path for messages.
    pub(super) fn path_name(&self) -> String {
        match self.paths.document.name() {
            "" => "the camera path".to_owned(),
            name => named(name),
        }
    }

    /// Begins without a path in a world that was opened.
    pub(super) fn leave_path(&mut self) {
        self.warn_of_kept_path();
        let kept = self.paths.views.keep_names();
        self.say_error(kept);
        self.paths = Paths::empty();
    }

    /// Shows the views of the current world.
    pub(super) fn open_views(&mut self) {
        self.paths.views = Views::open(self.world.world.as_deref(), self.world.more.seed);
        self.find_kept_path();
    }

    fn begin_path(&mut self) {
        self.paths.document.forget_kept(&self.unsaved, &self.path_world());
        self.paths.document = PathDocument::empty();
        self.paths.panel.forget();
        self.paths.player.rewind();
        self.paths.kept = None;
    }

    fn restore_path(&mut self, restores: bool) {
        let Some(text) = self.paths.kept.take() else { return };
        let done = match restores {
            true => self.paths.document.replace_text(text, "Edits that were not saved"),
            false => Ok(()),
        };
        self.say_error(done);
        self.paths.document.keep(&self.unsaved, &self.path_world());
        self.read_grounds();
    }

    /// Writes the file of the path, or asks for a name.
    pub(super) fn save_path(&mut self) {
        if self.paths.document.path().is_none() {
            return self.ask_for_path_name();
        }
        let saved = self.paths.document.save().map_err(|error| error.to_string());
        self.path_saved(saved);
    }

    /// Opens the field for the name of a new file.
    pub(super) fn ask_for_path_name(&mut self) {
        self.paths.panel.ask_for_name("path.csv");
        self.needs_relayout = true;
    }

    fn save_path_as(&mut self, name: &str) {
        // The edits are in the new file then.
        self.paths.document.forget_kept(&self.unsaved, &self.path_world());
        let saved = self.paths.document.save_as(name).map_err(|error| error.to_string());
        self.path_saved(saved);
    }

    fn path_saved(&mut self, saved: Result<(), String>) {
        self.paths.document.keep(&self.unsaved, &self.path_world());
        self.paths.panel.set_error(saved.as_ref().err().cloned());
        if saved.is_ok() {
            self.paths.panel.end_name();
            self.overlay.stop_typing();
            let name = self.paths.document.name().to_owned();
            self.note_opened(&name);
            self.say(About::File, format!("wrote {}", self.path_name()), TOAST);
        }
    }

    /// Opens the export dialog with a film of the path.
    fn film_path(&mut self) {
        match self.paths.document.for_film() {
            Ok((path, is_copy)) => self.export_film(&path, is_copy),
            Err(error) => self.say(About::Edit, error.to_string(), TOAST),
        }
    }

    /// Remembers the current view of this world.
    pub(super) fn add_view(&mut self) {
        let camera = scaled(&self.camera.camera(), 1.0 / self.world.surfaces.exaggeration());
        let added = self.paths.views.add(camera);
        if added.is_ok() && !self.dock.is_shown(Pane::Path) {
            let name = self.paths.views.list().last().map_or("", |view| &view.name);
            let text = format!("Added {name} of this world (V shows the views)");
            self.say(About::Edit, text, TOAST / 2);
        }
        self.say_error(added);
    }

    fn go_to_view(&mut self, index: usize) {
        let Some(view) = self.paths.views.list().get(index) else { return };
        let Camera { position_m, yaw_deg, pitch_deg, fov_deg, .. } =
            scaled(&view.camera, self.world.surfaces.exaggeration());
        self.paths.player.pause();
        self.camera.glide_to(Viewpoint { position_m, yaw_deg, pitch_deg });
        self.camera.fov_deg = fov_deg;
        self.stale = true;
    }

    /// Reads the ground below keys again, because the land or the keys have changed.
    pub(super) fn read_grounds(&mut self) {
        let places = self.paths.document.ground_places();
        if places.is_empty() {
            return;
        }
        let proxy = self.proxy.clone();
        let ground = self.world.surfaces.terrain.ground_heights();
        self.paths.grounds = Some(Grounds::start(places, ground, move || _ = proxy.send_event(())));
    }

    /// Takes the ground that was read again. Returns whether there is news.
    pub(super) fn take_grounds(&mut self) -> bool {
        let Some(heights) = self.paths.grounds.as_ref().and_then(Grounds::take) else { return false };
        self.paths.grounds = None;
        let bits = |x: f64, y: f64| [x, y].map(f64::to_bits);
        let heights: std::collections::BTreeMap<[u64; 2], f64> =
            heights.into_iter().map(|([x, y], height_m)| (bits(x, y), height_m)).collect();
        self.paths.document.set_ground(|x, y| heights.get(&bits(x, y)).copied());
        true
    }

    /// Returns whether undo, redo and save are for the path: the mouse is over its panel.
    pub(super) fn is_over_path_panel(&self) -> bool {
        let scale = f64::from(self.overlay.context().pixels_per_point());
        let cursor = self.input.cursor_px().map(|px| px / scale);
        cursor.is_some_and(|at| self.dock.is_over_pane(Pane::Path, egui::pos2(at.x as f32, at.y as f32)))
    }
}

/// Returns a camera whose height is multiplied.
fn scaled(camera: &Camera, factor: f64) -> Camera {
    let mut camera = *camera;
    if factor != 1.0 {
        camera.position_m.z = (camera.position_m.z * factor * 1000.0).round() / 1000.0;
    }
    camera
}
