//! The flying camera: turns input from keys, mouse and sticks into smooth motion above the ground.
//!
//! This module depends on neither windows nor GPUs. The motion is the exact solution of a first-order lag, so that it
//! does not depend on the frame rate.

use glam::{DVec2, DVec3};

use super::camera_moves::{Glide, Viewpoint, Zoom};
use crate::scene::camera::Camera;
use crate::scene::view::Pose;

/// Time constant of the velocity: after this time it has covered 63 % of the way to the target velocity.
const MOVE_LAG_S: f64 = 0.09;
/// Time constant for looking around.
const LOOK_LAG_S: f64 = 0.03;
/// Longer steps are shortened to this, so that a pause does not become a flight.
const LONGEST_STEP_S: f64 = 1.0;
/// Smallest remaining turn; anything less is completed at once.
const MIN_TURN_DEG: f64 = 0.002;
/// Below this fraction of its speed, the camera stops.
const MIN_SPEED_PART: f64 = 0.002;
/// The pitch stays away from zenith and nadir, where yaw and roll coincide.
pub(super) const STEEPEST_DEG: f64 = 89.0;
/// Speed factor of Shift.
const FAST: f64 = 5.0;
/// Speed factor of one notch of the wheel.
const SPEED_STEP: f64 = 1.2;
/// Extent of a world from which on lengths of the flight are those of land, in metres. In a smaller world (a model on
/// its ground) they are smaller in proportion, down to a factor of [`LEAST_SCALE`].
const LAND_EXTENT_M: f64 = 600.0;
const LEAST_SCALE: f64 = 0.05;
/// The lowest speed above the ground, in m/s, before the user's factor, over land.
const SLOWEST_M_S: f64 = 2.0;
/// Time constant with which the speed follows the height above the ground.
const SPEED_LAG_S: f64 = 0.4;

/// Usual height that the camera keeps above land.
const CLEARANCE_M: f64 = 2.0;
/// Smallest allowed height of the camera above land.
const MIN_CLEARANCE_M: f64 = 0.5;
/// The smallest and the largest factor on the speed.
pub(crate) const SPEED_FACTORS: [f64; 2] = [0.02, 50.0];
/// Range of the field of view for keys and panel, in degrees; the start may be outside of it.
pub(crate) const FOV_RANGE_DEG: [f64; 2] = [5.0, 120.0];

/// Input for the camera during a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FlyInput {
    /// Motion along the view, −1 to 1.
    pub forward: f64,
    /// Motion to the right, −1 to 1.
    pub right: f64,
    /// Motion upwards, −1 to 1.
    pub up: f64,
    /// Whether Shift is down.
    pub fast: bool,
    /// Angles to look further right and up, from the mouse.
    pub look_deg: [f64; 2],
    /// Turning rates right and up, from a stick.
    pub turn_deg_s: [f64; 2],
}

impl FlyInput {
    /// Returns whether there is no input.
    pub(crate) fn is_still(&self) -> bool {
        Self { fast: false, ..*self } == Self::default()
    }

    /// Returns the sum of two inputs, clamped.
    pub(crate) fn plus(self, other: Self) -> Self {
        let sum = |a: f64, b: f64| (a + b).clamp(-1.0, 1.0);
        let add = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        Self {
            forward: sum(self.forward, other.forward),
            right: sum(self.right, other.right),
            up: sum(self.up, other.up),
            fast: self.fast || other.fast,
            look_deg: add(self.look_deg, other.look_deg),
            turn_deg_s: add(self.turn_deg_s, other.turn_deg_s),
        }
    }
}

/// A camera with inertia.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FlyCamera {
    /// Position in the world's frame.
    pub position_m: DVec3,
    /// Clockwise from north, 0 to 360.
    pub yaw_deg: f64,
    /// Upwards from the horizon.
    pub pitch_deg: f64,
    /// Vertical field of view.
    pub fov_deg: f64,
    /// Factor on the speed, set by the user.
    pub speed_factor: f64,
    /// Smallest height above the ground, set by the user.
    pub clearance_m: f64,
    pub(super) velocity_m_s: DVec3,
    pub(super) look_left_deg: DVec2,
    /// Height above the ground by which the speed is chosen; it follows the true one smoothly.
    height_m: f64,
    /// Factor on the lengths of a flight over land: 1, or less in a world that is smaller than land.
    pub(super) scale: f64,
    /// The highest speed, before the user's factor.
    fastest_m_s: f64,
    /// The rest of a zoom toward a place.
    pub(super) zoom: Option<Zoom>,
    /// The motion to another view, if there is one.
    pub(super) glide: Option<Glide>,
    /// The position at which a camera path has placed the camera. It stays exactly there, as in a film, even below the
    /// clearance.
    placed: Option<Viewpoint>,
}

impl FlyCamera {
    /// Creates a camera at `start`, whose z is in the world's frame. Its speed depends on the height above the ground
    /// and the extent: half the height per second, but the whole extent in no less than twenty seconds.
    pub(crate) fn new(start: &Camera, ground_m: impl Fn(DVec2) -> f64, extent_m: [f64; 2]) -> Self {
        let position_m = start.position_m;
        let height_m = (position_m.z - ground_m(position_m.truncate())).abs();
        let across_m = extent_m[0].hypot(extent_m[1]);
        let scale = (across_m / LAND_EXTENT_M).clamp(LEAST_SCALE, 1.0);
        let mut camera = Self {
            position_m,
            yaw_deg: start.yaw_deg.rem_euclid(360.0),
            pitch_deg: start.pitch_deg.clamp(-STEEPEST_DEG, STEEPEST_DEG),
            fov_deg: start.fov_deg,
            speed_factor: 1.0,
            clearance_m: CLEARANCE_M * scale,
            velocity_m_s: DVec3::ZERO,
            look_left_deg: DVec2::ZERO,
            height_m,
            scale,
            fastest_m_s: (across_m / 20.0).max(SLOWEST_M_S * scale),
            zoom: None,
            glide: None,
            placed: None,
        };
        camera.clear_ground(ground_m);
        camera
    }

    /// Advances by `step_s`. Returns whether the view has changed, or will change in the next step.
    pub(crate) fn advance(&mut self, input: &FlyInput, step_s: f64, ground_m: impl Fn(DVec2) -> f64) -> bool {
        let before = (self.position_m, self.yaw_deg, self.pitch_deg);
        let step_s = step_s.clamp(0.0, LONGEST_STEP_S);
        if !input.is_still() {
            self.stop_moves();
        }
        let height_m = (self.position_m.z - ground_m(self.position_m.truncate())).abs();
        if height_m.is_finite() {
            self.height_m += (height_m - self.height_m) * reached(step_s, SPEED_LAG_S);
        }
        self.look(input, step_s);
        self.fly(input, step_s);
        self.advance_moves(step_s);
        self.clear_ground(ground_m);
        before != (self.position_m, self.yaw_deg, self.pitch_deg) || !self.is_still()
    }

    /// Returns whether the camera would stay where it is without input.
    pub(crate) fn is_still(&self) -> bool {
        self.velocity_m_s == DVec3::ZERO
            && self.look_left_deg == DVec2::ZERO
            && self.zoom.is_none()
            && self.glide.is_none()
    }

    /// Returns the speed at full input, without Shift, in m/s.
    pub(crate) fn speed_m_s(&self) -> f64 {
        (0.5 * self.height_m).clamp(SLOWEST_M_S * self.scale, self.fastest_m_s) * self.speed_factor
    }

    /// Returns the smallest allowed height above the ground, in metres.
    pub(crate) fn least_clearance_m(&self) -> f64 {
        MIN_CLEARANCE_M * self.scale
    }

    /// Changes the speed by notches of the wheel; positive is faster.
    pub(crate) fn change_speed(&mut self, notches: f64) {
        let [slowest, fastest] = SPEED_FACTORS;
        self.speed_factor = (self.speed_factor * SPEED_STEP.powf(notches)).clamp(slowest, fastest);
    }

    /// Multiplies the field of view by a factor.
    pub(crate) fn zoom(&mut self, factor: f64) {
        let [narrowest, widest] = FOV_RANGE_DEG;
        self.fov_deg = (self.fov_deg * factor).clamp(narrowest, widest);
    }

    /// Returns the camera as scene files and `--camera` take it, rounded to a millimetre and a thousandth of a degree.
    pub(crate) fn camera(&self) -> Camera {
        let round = |value: f64| (value * 1000.0).round() / 1000.0;
        Camera {
            position_m: DVec3::from_array(self.position_m.to_array().map(round)),
            height_above_ground: false,
            yaw_deg: round(self.yaw_deg),
            pitch_deg: round(self.pitch_deg),
            fov_deg: round(self.fov_deg),
        }
    }

    /// Places the camera at a camera of a path, whose z is in the world's frame, and ends all motion.
    pub(crate) fn stand_at(&mut self, camera: &Camera) {
        self.stop();
        self.position_m = camera.position_m;
        self.yaw_deg = camera.yaw_deg.rem_euclid(360.0);
        self.pitch_deg = camera.pitch_deg;
        self.fov_deg = camera.fov_deg;
        self.placed = Some(self.viewpoint());
    }

    /// Returns the pose for the renderer.
    pub(crate) fn pose(&self) -> Pose {
        let axes = self.exact();
        Pose {
            position_m: self.position_m,
            forward: axes.forward(),
            right: axes.right(),
            up: axes.up(),
            fov_rad: self.fov_deg.to_radians(),
        }
    }

    /// Returns the camera with all digits.
    pub(crate) fn exact(&self) -> Camera {
        Camera {
            position_m: self.position_m,
            height_above_ground: false,
            yaw_deg: self.yaw_deg,
            pitch_deg: self.pitch_deg,
            fov_deg: self.fov_deg,
        }
    }

    fn look(&mut self, input: &FlyInput, step_s: f64) {
        // The mouse turns by the angle that it covers in the picture, which makes it precise in a narrow field of view.
        self.look_left_deg += DVec2::from_array(input.look_deg);
        let mut turn_deg = self.look_left_deg * reached(step_s, LOOK_LAG_S);
        self.look_left_deg -= turn_deg;
        if self.look_left_deg.length() < MIN_TURN_DEG {
            turn_deg += self.look_left_deg;
            self.look_left_deg = DVec2::ZERO;
        }
        turn_deg += DVec2::from_array(input.turn_deg_s) * step_s;
        if turn_deg == DVec2::ZERO {
            // A camera path may look steeper than the mouse does.
            return;
        }
        self.yaw_deg = (self.yaw_deg + turn_deg.x).rem_euclid(360.0);
        self.pitch_deg = (self.pitch_deg + turn_deg.y).clamp(-STEEPEST_DEG, STEEPEST_DEG);
    }

    fn fly(&mut self, input: &FlyInput, step_s: f64) {
        let axes = self.exact();
        let direction = axes.forward() * input.forward + axes.right() * input.right + DVec3::Z * input.up;
        let speed_m_s = self.speed_m_s() * if input.fast { FAST } else { 1.0 };
        let wanted_m_s = direction.clamp_length_max(1.0) * speed_m_s;
        // Solution of dv/dt = (wanted − v) / lag, and its integral.
        let reached = reached(step_s, MOVE_LAG_S);
        let missing_m_s = wanted_m_s - self.velocity_m_s;
        self.position_m += wanted_m_s * step_s - missing_m_s * (MOVE_LAG_S * reached);
        self.velocity_m_s += missing_m_s * reached;
        if direction == DVec3::ZERO && self.velocity_m_s.length() < MIN_SPEED_PART * self.speed_m_s() {
            self.velocity_m_s = DVec3::ZERO;
        }
        let max_m = crate::scene::camera::LARGEST_COORDINATE_M;
        self.position_m = self.position_m.clamp(DVec3::splat(-max_m), DVec3::splat(max_m));
    }

    fn clear_ground(&mut self, ground_m: impl Fn(DVec2) -> f64) {
        if self.placed == Some(self.viewpoint()) {
            return;
        }
        let lowest_m = ground_m(self.position_m.truncate()) + self.clearance_m.max(self.least_clearance_m());
        if self.position_m.z < lowest_m {
            self.position_m.z = lowest_m;
            self.velocity_m_s.z = self.velocity_m_s.z.max(0.0);
        }
    }
}

/// Returns the fraction of the way that a first-order lag covers in `step_s`.
pub(super) fn reached(step_s: f64, lag_s: f64) -> f64 {
    1.0 - (-step_s / lag_s).exp()
}

#[cfg(test)]
mod tests {
    use super::*;

    const FLAT: fn(DVec2) -> f64 = |_| 100.0;

    fn camera() -> FlyCamera {
        let start = Camera {
            position_m: DVec3::new(10.0, 20.0, 1100.0),
            height_above_ground: false,
            yaw_deg: 370.0,
            pitch_deg: 0.0,
            fov_deg: 45.0,
        };
        FlyCamera::new(&start, FLAT, [30_000.0, 40_000.0])
    }

    fn near(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance, "{a} and {b} are more than {tolerance} apart");
    }

    #[test]
    fn speed_follows_height_and_extent() {
        near(camera().speed_m_s(), 500.0, 1e-9);
        let start = Camera { position_m: DVec3::new(0.0, 0.0, 90_000.0), ..camera().camera() };
        near(FlyCamera::new(&start, FLAT, [30_000.0, 40_000.0]).speed_m_s(), 2500.0, 1e-9);
        near(FlyCamera::new(&start, FLAT, [360.0, 480.0]).speed_m_s(), 30.0, 1e-9);
        near(FlyCamera::new(&start, |_| 90_000.0, [360.0, 480.0]).speed_m_s(), 2.0, 1e-9);
        // The ground of a small model.
        near(FlyCamera::new(&start, |_| 90_000.0, [90.0, 120.0]).speed_m_s(), 0.5, 1e-9);
        near(FlyCamera::new(&start, FLAT, [1.0, 1.0]).speed_m_s(), 0.1, 1e-9);
        // The speed follows the height above the ground, not the height above sea level.
        let mut low = camera();
        low.advance(&FlyInput::default(), 0.1, |_| 1000.0);
        assert!((50.0..500.0).contains(&low.speed_m_s()), "{}", low.speed_m_s());
        (0..100).for_each(|_| _ = low.advance(&FlyInput::default(), 0.1, |_| 1000.0));
        near(low.speed_m_s(), 50.0, 0.01);
    }

    #[test]
    fn motion_does_not_depend_on_the_frame_rate() {
        let steady = FlyInput { forward: 1.0, right: 0.5, look_deg: [0.0, 0.0], ..FlyInput::default() };
        let run = |steps: u32, step_s: f64| {
            let mut camera = camera();
            for _ in 0..steps {
                assert!(camera.advance(&steady, step_s, FLAT));
            }
            camera
        };
        let (coarse, fine) = (run(10, 0.1), run(1000, 0.001));
        near(coarse.position_m.distance(fine.position_m), 0.0, 1e-6);
        near(coarse.velocity_m_s.distance(fine.velocity_m_s), 0.0, 1e-6);
        // One second at 500 m/s, minus what the acceleration took.
        near((coarse.position_m - camera().position_m).length(), 500.0 * (1.0 - MOVE_LAG_S), 1.0);
    }

    #[test]
    fn diagonal_is_no_faster_and_shift_is() {
        let mut camera = camera();
        let diagonal = FlyInput { forward: 1.0, right: 1.0, ..FlyInput::default() };
        for _ in 0..100 {
            camera.advance(&diagonal, 0.1, FLAT);
        }
        near(camera.velocity_m_s.length(), 500.0, 1e-6);
        for _ in 0..100 {
            camera.advance(&FlyInput { fast: true, ..diagonal }, 0.1, FLAT);
        }
        near(camera.velocity_m_s.length(), 500.0 * FAST, 1e-6);
    }

    #[test]
    fn comes_to_rest_and_says_so() {
        let mut camera = camera();
        camera.advance(&FlyInput { forward: 1.0, look_deg: [30.0, 5.0], ..FlyInput::default() }, 0.1, FLAT);
        let still = FlyInput::default();
        let steps = (0..200).take_while(|_| camera.advance(&still, 1.0 / 60.0, FLAT)).count();
        assert!((5..100).contains(&steps), "{steps}");
        assert!(camera.is_still());
        near(camera.yaw_deg, 40.0, 1e-9);
        near(camera.pitch_deg, 5.0, 1e-9);
        let rest = camera.viewpoint();
        assert!(!camera.advance(&still, 1.0, FLAT));
        assert_eq!(camera.viewpoint(), rest);
    }

    #[test]
    fn pitch_and_field_of_view_stop_at_their_ends() {
        let mut camera = camera();
        for _ in 0..100 {
            camera.advance(&FlyInput { look_deg: [-100.0, 100.0], ..FlyInput::default() }, 0.1, FLAT);
            camera.zoom(1.5);
        }
        assert_eq!((camera.pitch_deg, camera.fov_deg), (89.0, 120.0));
        assert!((0.0..360.0).contains(&camera.yaw_deg));
        camera.zoom(1e-9);
        assert_eq!(camera.fov_deg, 5.0);
    }

    #[test]
    fn stays_above_ground() {
        // A start view of a small model, half a metre above its ground, is not lifted; over land it is.
        let start = Camera { position_m: DVec3::new(0.0, -2.0, 0.6), ..camera().camera() };
        near(FlyCamera::new(&start, |_| 0.0, [100.0, 100.0]).position_m.z, 0.6, 1e-9);
        near(FlyCamera::new(&start, |_| 0.0, [1000.0, 1000.0]).position_m.z, 2.0, 1e-9);
        let slope = |at: DVec2| 100.0 + 0.7 * at.y;
        let mut camera = camera();
        camera.clearance_m = 0.0;
        let dive = FlyInput { forward: 1.0, up: -1.0, ..FlyInput::default() };
        for _ in 0..500 {
            camera.advance(&dive, 0.05, slope);
            assert!(camera.position_m.z >= slope(camera.position_m.truncate()) + MIN_CLEARANCE_M - 1e-9);
        }
        camera.clearance_m = 40.0;
        camera.advance(&FlyInput::default(), 0.0, slope);
        near(camera.position_m.z - slope(camera.position_m.truncate()), 40.0, 1e-9);
    }

    #[test]
    fn a_path_places_the_camera_exactly_until_it_moves() {
        let mut camera = camera();
        camera.velocity_m_s = DVec3::X;
        let low = Camera { position_m: DVec3::new(1.0, 2.0, 50.0), pitch_deg: -90.0, yaw_deg: 725.0, ..camera.exact() };
        camera.stand_at(&low);
        assert!(!camera.advance(&FlyInput::default(), 0.1, FLAT), "it stays, below the ground");
        assert_eq!(camera.exact(), Camera { yaw_deg: 5.0, ..low });
        camera.advance(&FlyInput { look_deg: [1.0, 0.0], ..FlyInput::default() }, 0.1, FLAT);
        assert_eq!(camera.position_m.z, 102.0, "and clears the ground when the user takes over");
        assert!(camera.pitch_deg >= -STEEPEST_DEG);
    }

    #[test]
    fn wheel_steps_by_a_fifth() {
        let mut camera = camera();
        camera.change_speed(2.0);
        near(camera.speed_m_s(), 720.0, 1e-9);
        camera.change_speed(1e9);
        near(camera.speed_factor, SPEED_FACTORS[1], 0.0);
    }

    #[test]
    fn its_text_is_a_camera() {
        let mut camera = camera();
        camera.advance(&FlyInput { forward: 0.3, look_deg: [1.23456, -7.0], ..FlyInput::default() }, 0.1, FLAT);
        let text = camera.camera().to_string();
        let parsed: Camera = text.parse().unwrap();
        near(parsed.position_m.distance(camera.position_m), 0.0, 0.001);
        near(parsed.yaw_deg, camera.yaw_deg, 0.0006);
        assert!(text.len() < 60, "{text}");
    }
}
