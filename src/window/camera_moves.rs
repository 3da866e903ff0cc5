//! Motions of the fly camera about a place: orbit, zoom, pan, and gliding to another view.

use glam::{DVec2, DVec3};

use super::fly_camera::{FlyCamera, STEEPEST_DEG, reached};
use crate::scene::camera::{Camera, LARGEST_COORDINATE_M};
use crate::scene::view::{Pose, View};

/// Part of the distance that remains after a notch of the wheel toward a place.
const ZOOM_STEP: f64 = 0.85;
/// Time constant of zooming.
const ZOOM_LAG_S: f64 = 0.06;
/// The rest of a zoom, as a logarithm of the distance, that is covered at once.
const MIN_ZOOM: f64 = 1e-3;
/// A zoom over land ends at this distance from its place.
const NEAREST_M: f64 = 1.0;
/// Duration of gliding to another view.
const GLIDE_S: f64 = 0.6;
/// A place that is grabbed at a ray this steep or steeper moves on its level plane, others in a plane parallel to the
/// picture: sine of the angle below the horizon.
const LEVEL_SINE: f64 = 0.17;
/// Farthest that a place is moved by a pan, in distances from the eye.
const FARTHEST_PAN: f64 = 4.0;

/// The rest of a zoom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Zoom {
    place_m: DVec3,
    /// Logarithm of the factor by which the distance is still to be multiplied.
    left: f64,
}

/// A motion from one view to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Glide {
    from: Viewpoint,
    to: Viewpoint,
    passed_s: f64,
}

/// A position and direction of the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Viewpoint {
    /// Position in the world's frame.
    pub position_m: DVec3,
    /// Clockwise from north.
    pub yaw_deg: f64,
    /// Upwards from the horizon.
    pub pitch_deg: f64,
}

impl Viewpoint {
    fn axes(&self) -> Camera {
        let Self { position_m, yaw_deg, pitch_deg } = *self;
        Camera { position_m, height_above_ground: false, yaw_deg, pitch_deg, fov_deg: 45.0 }
    }

    /// Returns the viewpoint at a distance from a place, which is then in the middle of the picture.
    pub(super) fn before(place_m: DVec3, distance_m: f64, yaw_deg: f64, pitch_deg: f64) -> Self {
        let at_place = Self { position_m: place_m, yaw_deg, pitch_deg };
        Self { position_m: place_m - at_place.axes().forward() * distance_m, ..at_place }
    }

    /// Returns the nearest viewpoint in a direction from which all `corners_m` are in the picture. `lens` are the
    /// tangents of half the field of view, across and up.
    pub(super) fn framing(corners_m: &[DVec3], lens: DVec2, yaw_deg: f64, pitch_deg: f64) -> Self {
        let count = corners_m.len().max(1) as f64;
        let middle_m = corners_m.iter().sum::<DVec3>() / count;
        let axes = Self { position_m: middle_m, yaw_deg, pitch_deg }.axes();
        let needed_m = corners_m.iter().map(|corner_m| {
            let way_m = *corner_m - middle_m;
            let aside = DVec2::new(way_m.dot(axes.right()), way_m.dot(axes.up())).abs() / lens;
            aside.max_element() - way_m.dot(axes.forward())
        });
        Self::before(middle_m, needed_m.fold(NEAREST_M, f64::max), yaw_deg, pitch_deg)
    }
}

impl FlyCamera {
    /// Returns where the camera is.
    pub(super) fn viewpoint(&self) -> Viewpoint {
        Viewpoint { position_m: self.position_m, yaw_deg: self.yaw_deg, pitch_deg: self.pitch_deg }
    }

    /// Ends a zoom and a glide where they are.
    pub(super) fn stop_moves(&mut self) {
        (self.zoom, self.glide) = (None, None);
    }

    /// Ends all motion.
    pub(super) fn stop(&mut self) {
        self.stop_moves();
        (self.velocity_m_s, self.look_left_deg) = (DVec3::ZERO, DVec2::ZERO);
    }

    /// Zooms toward a place by notches of the wheel; positive is nearer. The place stays where it is in the picture.
    pub(super) fn zoom_to(&mut self, place_m: DVec3, notches: f64) {
        let left = self.zoom.filter(|zoom| zoom.place_m == place_m).map_or(0.0, |zoom| zoom.left);
        self.glide = None;
        self.zoom = Some(Zoom { place_m, left: left + notches * ZOOM_STEP.ln() });
    }

    /// Returns the place toward which the camera zooms.
    pub(super) fn zoom_place_m(&self) -> Option<DVec3> {
        self.zoom.map(|zoom| zoom.place_m)
    }

    /// Turns about a place, by angles to the right and up; the place stays where it is in the picture.
    pub(super) fn orbit(&mut self, place_m: DVec3, turn_deg: DVec2) {
        self.stop();
        let way_m = place_m - self.position_m;
        let before = self.viewpoint().axes();
        let seen = DVec3::new(way_m.dot(before.right()), way_m.dot(before.up()), way_m.dot(before.forward()));
        self.yaw_deg = (self.yaw_deg + turn_deg.x).rem_euclid(360.0);
        self.pitch_deg = (self.pitch_deg + turn_deg.y).clamp(-STEEPEST_DEG, STEEPEST_DEG);
        let after = self.viewpoint().axes();
        self.position_m = place_m - (after.right() * seen.x + after.up() * seen.y + after.forward() * seen.z);
        self.keep_near();
    }

    /// Moves so that a place that was grabbed is seen at a point of the picture, 0 to 1 in each direction. `grabbed_ray`
    /// is the direction in which it was seen then.
    pub(super) fn pan(&mut self, place_m: DVec3, grabbed_ray: DVec3, part: DVec2, size_px: [u32; 2]) {
        self.stop();
        let pose = self.pose();
        let ray = ray_through(&pose, part, size_px);
        let way_m = place_m - self.position_m;
        let farthest_m = FARTHEST_PAN * way_m.length();
        let level = |ray: DVec3| -ray.z / ray.length() >= LEVEL_SINE;
        // The eye stays in the plane in which it is, and so the place moves in one that is parallel to it.
        let along = if level(grabbed_ray) && level(ray) && way_m.z < 0.0 {
            way_m.z / ray.z
        } else {
            way_m.dot(pose.forward) / ray.dot(pose.forward)
        };
        let seen_m = ray * along;
        if along > 0.0 && seen_m.length() <= farthest_m {
            self.position_m += way_m - seen_m;
        }
        self.keep_near();
    }

    /// Begins to glide to another view.
    pub(super) fn glide_to(&mut self, to: Viewpoint) {
        self.stop();
        let max_m = DVec3::splat(LARGEST_COORDINATE_M);
        let to = Viewpoint { position_m: to.position_m.clamp(-max_m, max_m), ..to };
        self.glide = Some(Glide { from: self.viewpoint(), to, passed_s: 0.0 });
    }

    /// Returns the view from here in which a place is in the middle of the picture.
    pub(super) fn looking_at(&self, place_m: DVec3) -> Viewpoint {
        let way_m = place_m - self.position_m;
        let yaw_deg = if way_m.truncate().length() < 1e-6 { self.yaw_deg } else { way_m.x.atan2(way_m.y).to_degrees() };
        let pitch_deg = way_m.z.atan2(way_m.truncate().length()).to_degrees();
        Viewpoint {
            position_m: self.position_m,
            yaw_deg: yaw_deg.rem_euclid(360.0),
            pitch_deg: pitch_deg.clamp(-90.0, 90.0),
        }
    }

    pub(super) fn advance_moves(&mut self, step_s: f64) {
        if let Some(zoom) = &mut self.zoom {
            let part = if zoom.left.abs() < MIN_ZOOM { 1.0 } else { reached(step_s, ZOOM_LAG_S) };
            let step = zoom.left * part;
            zoom.left -= step;
            let way_m = self.position_m - zoom.place_m;
            let distance_m = way_m.length();
            let nearest_m = NEAREST_M * self.scale;
            let wanted_m = (distance_m * step.exp()).max(nearest_m.min(distance_m));
            if distance_m > 0.0 {
                self.position_m = zoom.place_m + way_m * (wanted_m / distance_m);
            }
            if zoom.left == 0.0 {
                self.zoom = None;
            }
            self.keep_near();
        }
        if let Some(glide) = &mut self.glide {
            glide.passed_s += step_s;
            let Glide { from, to, passed_s } = *glide;
            if passed_s >= GLIDE_S {
                self.glide = None;
                (self.position_m, self.yaw_deg, self.pitch_deg) = (to.position_m, to.yaw_deg, to.pitch_deg);
                return;
            }
            let t = passed_s / GLIDE_S;
            let eased = t * t * (3.0 - 2.0 * t);
            // The shorter way around.
            let turn_deg = (to.yaw_deg - from.yaw_deg + 180.0).rem_euclid(360.0) - 180.0;
            self.position_m = from.position_m.lerp(to.position_m, eased);
            self.yaw_deg = (from.yaw_deg + turn_deg * eased).rem_euclid(360.0);
            self.pitch_deg = from.pitch_deg + (to.pitch_deg - from.pitch_deg) * eased;
        }
    }

    fn keep_near(&mut self) {
        let max_m = DVec3::splat(LARGEST_COORDINATE_M);
        self.position_m = self.position_m.clamp(-max_m, max_m);
    }
}

/// Returns the direction through a point of the picture, 0 to 1 in each direction.
pub(super) fn ray_through(pose: &Pose, part: DVec2, size_px: [u32; 2]) -> DVec3 {
    let view = View::whole(*pose, *pose, size_px);
    view.ray(part * DVec2::new(f64::from(size_px[0]), f64::from(size_px[1])))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;
    use crate::window::fly_camera::FlyInput;

    const SIZE_PX: [u32; 2] = [640, 360];
    const PLACE_M: DVec3 = DVec3::new(1800.0, 2500.0, 300.0);

    fn camera() -> FlyCamera {
        let start = Camera {
            position_m: DVec3::new(0.0, 0.0, 2000.0),
            height_above_ground: false,
            yaw_deg: 20.0,
            pitch_deg: -25.0,
            fov_deg: 50.0,
        };
        FlyCamera::new(&start, |_| -100.0, [30_000.0, 30_000.0])
    }

    /// Returns where the camera sees a place, 0 to 1 in each direction.
    fn part(camera: &FlyCamera, place_m: DVec3) -> DVec2 {
        let pose = camera.pose();
        let px = View::whole(pose, pose, SIZE_PX).place_px(place_m - pose.position_m).unwrap();
        px / DVec2::new(640.0, 360.0)
    }

    fn still(camera: &mut FlyCamera, frame_s: f64) -> usize {
        let input = FlyInput::default();
        (0..500).take_while(|_| camera.advance(&input, frame_s, |_| -100.0)).count()
    }

    #[test]
    fn the_place_stays_in_the_picture() {
        let start = camera();
        let before = part(&start, PLACE_M);
        let mut turned = start.clone();
        turned.orbit(PLACE_M, DVec2::new(70.0, -20.0));
        assert!(part(&turned, PLACE_M).distance(before) < 1e-9);
        assert!((turned.position_m.distance(PLACE_M) / start.position_m.distance(PLACE_M) - 1.0).abs() < 1e-9);
        assert!((turned.yaw_deg - 90.0).abs() < 1e-9 && (turned.pitch_deg + 45.0).abs() < 1e-9);
        // Planted error: looking around instead of turning about the place.
        let mut looked = start.clone();
        looked.yaw_deg += 25.0;
        assert!(part(&looked, PLACE_M).distance(before) > 0.1);
        // Zooming ends at the same distance at any frame rate.
        for frame_s in [0.005, 0.05, 0.5] {
            let mut near = start.clone();
            near.zoom_to(PLACE_M, 2.0);
            near.zoom_to(PLACE_M, 1.0);
            assert!(!near.is_still() && still(&mut near, frame_s) < 300);
            assert!(part(&near, PLACE_M).distance(before) < 1e-9, "{frame_s}");
            let left = near.position_m.distance(PLACE_M) / start.position_m.distance(PLACE_M);
            assert!((left - ZOOM_STEP.powi(3)).abs() < 1e-3, "{frame_s}: {left}");
        }
        // It never goes through the place.
        let mut through = start.clone();
        through.zoom_to(PLACE_M, 1000.0);
        still(&mut through, 0.1);
        assert!((through.position_m.distance(PLACE_M) - NEAREST_M).abs() < 1e-6);
    }

    #[test]
    fn a_grabbed_place_follows_the_cursor() {
        let start = camera();
        let from = part(&start, PLACE_M);
        let grabbed_ray = ray_through(&start.pose(), from, SIZE_PX);
        for by in [DVec2::new(0.2, 0.0), DVec2::new(-0.1, 0.15), DVec2::new(0.05, -0.05)] {
            let mut moved = start.clone();
            moved.pan(PLACE_M, grabbed_ray, from + by, SIZE_PX);
            assert!(part(&moved, PLACE_M).distance(from + by) < 1e-9, "{by}");
            assert!((moved.position_m.z - start.position_m.z).abs() < 1e-9, "land moves on its plane");
            assert_eq!((moved.yaw_deg, moved.pitch_deg), (start.yaw_deg, start.pitch_deg));
        }
        // Toward the horizon the way is bounded.
        let mut far = start.clone();
        far.pan(PLACE_M, grabbed_ray, DVec2::new(0.5, 0.02), SIZE_PX);
        assert!(far.position_m.distance(start.position_m) < 5.0 * start.position_m.distance(PLACE_M));
    }

    #[test]
    fn a_view_glides_the_shorter_way_and_input_ends_it() {
        let mut looked = camera();
        looked.yaw_deg = 350.0;
        let to = looked.looking_at(PLACE_M);
        looked.glide_to(to);
        looked.advance(&FlyInput::default(), 0.3, |_| -100.0);
        assert!(looked.yaw_deg > 350.0 || looked.yaw_deg < 40.0, "{}", looked.yaw_deg);
        still(&mut looked, 0.05);
        assert_eq!(looked.viewpoint(), to);
        assert!(part(&looked, PLACE_M).distance(DVec2::splat(0.5)) < 1e-9);
        let mut ended = camera();
        ended.glide_to(Viewpoint::before(PLACE_M, 500.0, 0.0, -90.0));
        ended.advance(&FlyInput::default(), 0.1, |_| -100.0);
        ended.advance(&FlyInput { forward: 1.0, ..FlyInput::default() }, 0.1, |_| -100.0);
        assert!(ended.glide.is_none() && ended.pitch_deg > -89.0);
    }

    #[test]
    fn all_corners_are_in_the_frame() {
        let corners_m =
            crate::window::places::box_m([DVec2::new(-4000.0, -9000.0), DVec2::new(5000.0, 7000.0)], [0.0, 2000.0]);
        let lens = |fov_deg: f64| {
            let up = (0.5 * fov_deg.to_radians()).tan();
            DVec2::new(up * 640.0 / 360.0, up)
        };
        for (yaw_deg, pitch_deg) in [(0.0, -90.0), (30.0, -35.0), (200.0, -60.0)] {
            let mut camera = camera();
            let framed = Viewpoint::framing(&corners_m, lens(camera.fov_deg), yaw_deg, pitch_deg);
            (camera.position_m, camera.yaw_deg, camera.pitch_deg) = (framed.position_m, yaw_deg, pitch_deg);
            let parts: Vec<DVec2> = corners_m.iter().map(|corner_m| part(&camera, *corner_m)).collect();
            let is_in =
                |margin: f64| parts.iter().all(|at| at.min_element() > -margin && at.max_element() < 1.0 + margin);
            assert!(is_in(1e-9), "{parts:?}");
            // A corner touches the border: nothing nearer frames all.
            let touches = parts.iter().any(|at| at.min_element() < 1e-6 || at.max_element() > 1.0 - 1e-6);
            assert!(touches, "{parts:?}");
        }
    }
}
