//! Navigation by the place under the cursor: the line at the bottom, and orbit, pan, zoom and look.

use std::time::{Duration, Instant};

use glam::{DVec2, DVec3};

use super::{Flight, ground_m};
use crate::scene::stereo::Eyes;
use crate::scene::view::View;
use crate::surface::DISTANCE;
use crate::window::camera_moves::{Viewpoint, ray_through};
use crate::window::input::DragKind;
use crate::window::place_picking::{PlacePicker, PlaceRequest, PlaceUnderCursor};
use crate::window::places::{Places, TypedPlace, box_m};
use crate::window::status::{self, GoTo};

/// Interval at which the program checks for an answer of the GPU while nothing else happens.
pub(super) const ANSWER_CHECK: Duration = Duration::from_millis(4);
/// Turn of an orbit for each pixel of the window.
const ORBIT_DEG_PER_PX: f64 = 0.3;
/// A place is known for a position of the cursor within this distance, in pixels.
const SAME_PX: f64 = 1.5;
/// Pitch from which a place is looked at that is gone to, if the camera looks higher.
const GO_TO_PITCH_DEG: f64 = -25.0;

/// An action that waits for the place under the cursor.
#[derive(Clone, Copy, Debug, PartialEq)]
enum CursorAction {
    /// Zoom by notches of the wheel.
    Zoom(f64),
    /// Turn toward the place.
    Look,
    /// Look straight down at the place.
    Top,
    /// Place the focus.
    Focus,
}

/// A place that is grabbed by a drag.
#[derive(Clone, Copy, Debug, PartialEq)]
struct GraspedPoint {
    from_px: DVec2,
    place_m: DVec3,
    ray: DVec3,
}

/// The state of navigation between two frames.
pub(super) struct Navigation {
    picker: PlacePicker,
    /// The newest place.
    under_cursor: Option<PlaceUnderCursor>,
    /// The last request: position of the cursor in pixels, and number of the picture.
    requested: Option<(DVec2, u64)>,
    /// The number of pictures so far.
    picture: u64,
    /// The eyes of the last picture, without jitter.
    eyes: Vec<View>,
    grasp: Option<GraspedPoint>,
    waiting_action: Option<(CursorAction, DVec2)>,
    places: Places,
    pub(super) go_to: GoTo,
    /// Whether the next click places the focus.
    pub(super) places_focus: bool,
    next_check: Instant,
}

impl Navigation {
    /// Creates the state for a world that has not been drawn.
    pub(super) fn new(places: Places) -> Self {
        Self {
            picker: PlacePicker::new(),
            under_cursor: None,
            requested: None,
            picture: 0,
            eyes: Vec::new(),
            grasp: None,
            waiting_action: None,
            places,
            go_to: GoTo::default(),
            places_focus: false,
            next_check: Instant::now(),
        }
    }

    /// Records the eyes of a picture that was drawn.
    pub(super) fn drew(&mut self, eyes: &[View]) {
        self.picture += 1;
        self.eyes = eyes.to_vec();
    }

    /// Returns the number of pictures so far.
    pub(super) fn picture(&self) -> u64 {
        self.picture
    }

    /// Returns the eyes of the last picture, without jitter.
    pub(super) fn eyes(&self) -> &[View] {
        &self.eyes
    }

    /// Returns when to check for an answer, if one is pending.
    pub(super) fn due_at(&self) -> Option<Instant> {
        self.picker.is_waiting().then_some(self.next_check)
    }

    /// Returns the words of the line at the bottom, and the name of the reference system.
    pub(super) fn words(&self, exaggeration: f64) -> (Vec<String>, Option<&str>) {
        let words = self.under_cursor.map(|under_cursor| status::words(&under_cursor, &self.places, exaggeration));
        (words.unwrap_or_default(), self.places.projection())
    }

    /// Returns the place that the last answer gave for a position of the cursor; `None` if the answer is for another.
    fn known(&self, cursor_px: DVec2) -> Option<&PlaceUnderCursor> {
        self.under_cursor.as_ref().filter(|under_cursor| {
            under_cursor.picture == self.picture && under_cursor.cursor_px.distance(cursor_px) <= SAME_PX
        })
    }
}

impl Flight {
    /// Takes the newest place that the GPU has sent. Returns whether one has arrived.
    pub(super) fn take_place(&mut self) -> bool {
        self.navigation.next_check = Instant::now() + ANSWER_CHECK;
        let Some(under_cursor) = self.navigation.picker.take() else { return false };
        self.navigation.under_cursor = Some(under_cursor);
        self.run_waiting_action();
        true
    }

    /// Requests the place under the cursor in the picture that was just presented, unless it is known.
    pub(super) fn request_place(&mut self) {
        let drag = self.input.drag();
        if drag.is_some_and(|drag| drag.moves && drag.kind == DragKind::Look) {
            self.navigation.under_cursor = None;
            return;
        }
        let waiting_px = self.navigation.waiting_action.map(|(_, px)| px);
        let pressed_px = drag.filter(|_| self.navigation.grasp.is_none()).map(|drag| drag.from_px);
        let over_picture = self.input.cursor_px().filter(|_| !self.overlay.is_over_panel());
        let Some(cursor_px) = pressed_px.or(waiting_px).or(over_picture) else {
            self.navigation.under_cursor = None;
            return;
        };
        let picture = self.navigation.picture;
        if self.navigation.requested == Some((cursor_px, picture)) {
            return;
        }
        let Some((eye, part)) = self.eye_at(cursor_px) else { return };
        let distance = self.renderer.as_ref().and_then(|renderer| renderer.eye_target(eye, &DISTANCE));
        let view = self.navigation.eyes.get(eye).copied();
        let Some((distance, view)) = distance.zip(view) else { return };
        let earth = self.world.surfaces.terrain.earth_curvature(view.pose.position_m.z);
        let request = PlaceRequest { distance, view, earth, cursor_px, part, picture };
        if self.navigation.picker.request(&self.gpu, &request) {
            self.navigation.requested = Some((cursor_px, picture));
            self.navigation.next_check = Instant::now() + ANSWER_CHECK;
        }
    }

    /// Returns the eye whose picture is at a position of the window, and where in the picture, 0 to 1.
    pub(super) fn eye_at(&self, cursor_px: DVec2) -> Option<(usize, DVec2)> {
        let [width, height] = self.screen.size_px().map(f64::from);
        let part = cursor_px / DVec2::new(width, height);
        let is_inside = part.cmpge(DVec2::ZERO).all() && part.cmplt(DVec2::ONE).all();
        is_inside.then(|| match self.settings.eyes {
            Eyes::SideBySide if part.x >= 0.5 => (1, DVec2::new(2.0 * part.x - 1.0, part.y)),
            Eyes::SideBySide => (0, DVec2::new(2.0 * part.x, part.y)),
            Eyes::Right => (1, part),
            _ => (0, part),
        })
    }

    /// Carries out the motion of a drag since the last frame. Returns whether the camera moves.
    pub(super) fn drag(&mut self) -> bool {
        let dragged_px = self.input.take_dragged_px();
        let Some(drag) = self.input.drag().copied().filter(|drag| drag.kind != DragKind::Look) else {
            self.navigation.grasp = None;
            return false;
        };
        let from_px = drag.from_px;
        if self.navigation.grasp.is_none_or(|grasp| grasp.from_px != from_px) {
            // A drag begins when the place is known where the button was pressed.
            let Some(under_cursor) = self.navigation.known(from_px).copied() else { return false };
            let Some((_, part)) = self.eye_at(from_px) else { return false };
            let ray = ray_through(&self.camera.pose(), part, self.eye_px());
            let place_m = under_cursor.place_m.unwrap_or_else(|| self.place_in_sky(ray));
            self.navigation.grasp = Some(GraspedPoint { from_px, place_m, ray });
        }
        let (Some(grasp), Some(cursor_px)) = (self.navigation.grasp, self.input.cursor_px()) else { return false };
        if !drag.moves {
            return false;
        }
        let before = self.camera.viewpoint();
        match drag.kind {
            DragKind::Orbit => {
                self.camera.orbit(grasp.place_m, DVec2::new(dragged_px.x, -dragged_px.y) * ORBIT_DEG_PER_PX);
            }
            DragKind::Pan => {
                if let Some((_, part)) = self.eye_at(cursor_px) {
                    self.camera.pan(grasp.place_m, grasp.ray, part, self.eye_px());
                }
            }
            DragKind::Look => {}
        }
        self.camera.viewpoint() != before
    }

    /// Returns the size of one eye's picture at the window's resolution.
    fn eye_px(&self) -> [u32; 2] {
        self.settings.eye_px(self.screen.size_px())
    }

    /// Returns a place for a ray into the sky: as far away as land usually is from this height.
    fn place_in_sky(&self, ray: DVec3) -> DVec3 {
        self.camera.position_m + ray.normalize_or_zero() * (3.0 * self.height_above_ground_m()).max(10.0)
    }

    fn height_above_ground_m(&self) -> f64 {
        let position_m = self.camera.position_m;
        (position_m.z - ground_m(&self.world, position_m.truncate())).abs()
    }

    /// Zooms toward the place under the cursor, by notches of the wheel.
    pub(super) fn zoom(&mut self, notches: f64) {
        let cursor_px = self.input.cursor_px().unwrap_or_else(|| self.middle_px());
        let waiting = match self.navigation.waiting_action {
            Some((CursorAction::Zoom(waiting), px)) if px == cursor_px => waiting,
            _ => 0.0,
        };
        self.act_on_place(CursorAction::Zoom(waiting + notches), cursor_px);
    }

    /// Handles a click on the picture.
    pub(super) fn click(&mut self, cursor_px: DVec2) {
        if std::mem::take(&mut self.navigation.places_focus) {
            self.act_on_place(CursorAction::Focus, cursor_px);
        } else {
            self.pick_layer(cursor_px);
        }
    }

    /// Turns toward the place at a position of the window.
    pub(super) fn look_at(&mut self, cursor_px: DVec2) {
        // The first click of a double click selects nothing.
        self.layer_picking.cancel();
        self.act_on_place(CursorAction::Look, cursor_px);
    }

    /// Looks straight down at the place under the cursor, or in the middle of the picture.
    pub(super) fn top_view(&mut self) {
        let over_picture = self.input.cursor_px().filter(|_| !self.overlay.is_over_panel());
        self.act_on_place(CursorAction::Top, over_picture.unwrap_or_else(|| self.middle_px()));
    }

    fn middle_px(&self) -> DVec2 {
        let [width, height] = self.eye_px().map(f64::from);
        0.5 * DVec2::new(width, height)
    }

    /// Carries out an action when the place under the cursor is known.
    fn act_on_place(&mut self, action: CursorAction, cursor_px: DVec2) {
        self.navigation.waiting_action = Some((action, cursor_px));
        self.run_waiting_action();
    }

    /// Carries out the waiting action, if the place under the cursor is known.
    fn run_waiting_action(&mut self) {
        let Some((action, cursor_px)) = self.navigation.waiting_action else { return };
        // While the camera zooms toward a place, the place stays under the cursor.
        let zooms = self.camera.zoom_place_m().filter(|_| matches!(action, CursorAction::Zoom(_)));
        let same_px = |under_cursor: &&PlaceUnderCursor| under_cursor.cursor_px.distance(cursor_px) <= SAME_PX;
        let at_once = zooms.filter(|_| self.navigation.under_cursor.as_ref().is_some_and(|it| same_px(&it)));
        let known = match (at_once, self.navigation.known(cursor_px)) {
            (Some(place_m), _) => Some(place_m),
            (None, Some(under_cursor)) => under_cursor.place_m,
            (None, None) => return,
        };
        self.navigation.waiting_action = None;
        let Some((_, part)) = self.eye_at(cursor_px) else { return };
        let ray = ray_through(&self.camera.pose(), part, self.eye_px());
        let place_m = known.unwrap_or_else(|| self.place_in_sky(ray));
        match action {
            CursorAction::Zoom(notches) => self.camera.zoom_to(place_m, notches),
            CursorAction::Focus => {
                if let Some(place_m) = known {
                    self.focus_on(place_m);
                }
            }
            CursorAction::Look => self.camera.glide_to(self.camera.looking_at(place_m)),
            CursorAction::Top => {
                let distance_m = place_m.distance(self.camera.position_m);
                self.camera.glide_to(Viewpoint::before(place_m, distance_m, 0.0, -90.0));
            }
        }
    }

    /// Shows all of the land, from the current direction, but at least a little from above.
    pub(super) fn frame_all(&mut self) {
        let of_land = || self.world.surfaces.terrain.range_m().map(f64::from);
        let heights_m = self.world.model_heights_m.unwrap_or_else(of_land);
        let corners_m = box_m(self.world.data_corners_m, heights_m);
        let [width, height] = self.eye_px().map(f64::from);
        let up = (0.5 * self.camera.fov_deg.to_radians()).tan();
        let lens = DVec2::new(up * width / height, up);
        let pitch_deg = self.camera.pitch_deg.min(GO_TO_PITCH_DEG);
        self.camera.glide_to(Viewpoint::framing(&corners_m, lens, self.camera.yaw_deg, pitch_deg));
    }

    /// Flies to coordinates that were typed.
    pub(super) fn go_to(&mut self, text: &str) {
        // This frame was laid out before.
        self.needs_relayout = true;
        match self.typed(text) {
            Ok(stand) => {
                self.camera.glide_to(stand);
                self.navigation.go_to.close();
                self.overlay.stop_typing();
            }
            Err(error) => self.navigation.go_to.refuse(error),
        }
    }

    fn typed(&mut self, text: &str) -> Result<Viewpoint, String> {
        let typed: TypedPlace = text.parse()?;
        let at_m = self.navigation.places.world_m(&typed, text)?;
        let ground_m = ground_m(&self.world, at_m);
        if let TypedPlace::Camera(camera) = typed {
            let camera = camera.on_ground(|_, _| ground_m);
            self.camera.fov_deg = camera.fov_deg;
            let (yaw_deg, pitch_deg) = (camera.yaw_deg.rem_euclid(360.0), camera.pitch_deg);
            return Ok(Viewpoint { position_m: camera.position_m, yaw_deg, pitch_deg });
        }
        let distance_m = (2.5 * self.height_above_ground_m()).max(50.0);
        let pitch_deg = self.camera.pitch_deg.min(GO_TO_PITCH_DEG);
        Ok(Viewpoint::before(at_m.extend(ground_m), distance_m, self.camera.yaw_deg, pitch_deg))
    }
}
