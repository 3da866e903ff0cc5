//! Motion of the room through the world by thumb sticks, with measures against motion sickness.
//!
//! Turns are made in steps, the speed is limited by the height above the ground, and the border of the picture darkens
//! during motion. This module depends on neither OpenXR nor GPUs.

use glam::{DVec2, DVec3};

use super::stage::{Eye, Stage, middle_m};

/// Angle of one step of a turn.
const TURN_RAD: f64 = std::f64::consts::PI / 6.0;
/// Deflection of a stick, of at most 1, that triggers a turn; the next turn requires that the stick returns below half
/// of it.
const TURN_DEFLECTION: f64 = 0.7;
/// Dead zone of a stick: smaller deflections have no effect.
const DEAD_ZONE: f64 = 0.15;
/// Full speed near the ground, in metres of the room per second: a brisk walk.
const SLOWEST_M_S: f64 = 2.0;
/// Full speed at greater heights, as a fraction of the eyes' height above the ground per second: the ground below
/// passes at 29° per second at most. It passes faster with the fast button, and where [`SLOWEST_M_S`] is more.
const HEIGHT_PER_S: f64 = 0.5;
/// Highest speed, in m/s of the world.
const FASTEST_M_S: f64 = 5000.0;
/// Factor of the speed while the fast button is held.
const FAST_FACTOR: f64 = 3.0;
/// Time constant of the velocity: after this time 63 % of a change of speed is reached.
const LAG_S: f64 = 0.12;
/// Time constant of the darkening of the border.
const VIGNETTE_LAG_S: f64 = 0.1;
/// Longest time step; the time between two slow frames is shortened to this.
const LONGEST_STEP_S: f64 = 0.25;

/// Scale of a giant, in world metres per metre of the room: a giant's eyes are 65 m apart.
pub(crate) const GIANT_SCALE: f64 = 1000.0;
/// Height of the ground above a giant's floor, in metres of the room: that of a table.
const TABLE_M: f64 = 0.7;
/// Smallest distance of a giant's head from the ground, in metres of the room.
const GIANT_CLEARANCE_M: f64 = 0.25;

/// Input of the hands in a frame. Sticks are −1 to 1 on each axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct HandInput {
    /// Motion to the right (x) and forward (y).
    pub left_stick: DVec2,
    /// Turn to the right (x) and motion upwards (y).
    pub right_stick: DVec2,
    /// Whether to fly faster: the button is held.
    pub fast: bool,
    /// Whether to change to the next style: the button was pressed in this frame.
    pub next_style: bool,
    /// Whether to switch between person and giant: the button was pressed in this frame.
    pub switch_scale: bool,
    /// Whether to return to the start: the button was pressed in this frame.
    pub reset: bool,
}

/// State of the motion through the world.
#[derive(Clone, Debug)]
pub(crate) struct Traveller {
    stage: Stage,
    start: Stage,
    /// Velocity of the room, in m/s of the world.
    velocity_m_s: DVec3,
    /// Whether the stick has triggered a turn and not returned since.
    turn_stick_is_spent: bool,
    /// Darkness of the border, 0 to 1.
    vignette: f64,
}

impl Traveller {
    /// Creates a traveller that is at rest at `start`.
    pub(crate) fn new(start: Stage) -> Self {
        Self { stage: start, start, velocity_m_s: DVec3::ZERO, turn_stick_is_spent: false, vignette: 0.0 }
    }

    /// Returns the current placement of the room.
    pub(crate) fn stage(&self) -> &Stage {
        &self.stage
    }

    /// Returns how dark the border of the picture is, 0 to 1.
    pub(crate) fn vignette(&self) -> f64 {
        self.vignette
    }

    /// Advances by `step_s`. `ground_m` returns the height of the ground at a position.
    pub(crate) fn advance(
        &mut self,
        hand_input: &HandInput,
        eyes: &[Eye; 2],
        step_s: f64,
        ground_m: impl Fn(DVec2) -> f64,
    ) {
        let step_s = step_s.clamp(0.0, LONGEST_STEP_S);
        let head_m = middle_m(eyes);
        if hand_input.reset {
            // A stick that is still pushed does not turn again.
            *self = Self { turn_stick_is_spent: self.turn_stick_is_spent, ..Self::new(self.start) };
        }
        if hand_input.switch_scale {
            self.change_scale(head_m, &ground_m);
        }
        self.turn(hand_input.right_stick.x, head_m);
        self.fly(hand_input, eyes, step_s, &ground_m);
        self.stay_above(head_m, &ground_m);
    }

    /// Turns by one step for each push of the stick.
    fn turn(&mut self, push: f64, head_m: DVec3) {
        if push.abs() > TURN_DEFLECTION && !self.turn_stick_is_spent {
            self.stage.turn_about(head_m, TURN_RAD.copysign(push));
            self.turn_stick_is_spent = true;
        } else if push.abs() < 0.5 * TURN_DEFLECTION {
            self.turn_stick_is_spent = false;
        }
    }

    fn fly(&mut self, hand_input: &HandInput, eyes: &[Eye; 2], step_s: f64, ground_m: &impl Fn(DVec2) -> f64) {
        let pose = self.stage.pose(&eyes[0]);
        let place_m = self.stage.place_m(middle_m(eyes));
        let height_m = place_m.z - ground_m(place_m.truncate());
        let slowest_m_s = SLOWEST_M_S * self.stage.scale;
        let full_m_s = (HEIGHT_PER_S * height_m).max(slowest_m_s) * if hand_input.fast { FAST_FACTOR } else { 1.0 };
        let full_m_s = full_m_s.min(FASTEST_M_S.max(slowest_m_s));
        // Sideways motion is horizontal even if the head leans, and lifting is vertical.
        let right = DVec3::new(pose.right.x, pose.right.y, 0.0).normalize_or_zero();
        let [aside, ahead, lift] =
            [hand_input.left_stick.x, hand_input.left_stick.y, hand_input.right_stick.y].map(without_dead_zone);
        // A push that is meant to turn must not lift.
        let lift = if hand_input.right_stick.y.abs() > hand_input.right_stick.x.abs() { lift } else { 0.0 };
        let direction = (pose.forward * ahead + right * aside + DVec3::Z * lift).clamp_length_max(1.0);
        let reached_fraction = 1.0 - (-step_s / LAG_S).exp();
        self.velocity_m_s += (direction * full_m_s - self.velocity_m_s) * reached_fraction;
        if direction == DVec3::ZERO && self.velocity_m_s.length() < 0.01 * slowest_m_s {
            self.velocity_m_s = DVec3::ZERO;
        }
        self.stage.floor_m += self.velocity_m_s * step_s;
        let limit_m = crate::scene::camera::LARGEST_COORDINATE_M;
        self.stage.floor_m = self.stage.floor_m.clamp(DVec3::splat(-limit_m), DVec3::splat(limit_m));
        let speed_fraction = (self.velocity_m_s.length() / full_m_s).clamp(0.0, 1.0);
        self.vignette += (speed_fraction - self.vignette) * (1.0 - (-step_s / VIGNETTE_LAG_S).exp());
        if speed_fraction == 0.0 && self.vignette < 1e-3 {
            self.vignette = 0.0;
        }
    }

    /// Switches the scale; the point below the head stays below it.
    fn change_scale(&mut self, head_m: DVec3, ground_m: &impl Fn(DVec2) -> f64) {
        let place_m = self.stage.place_m(head_m);
        let becomes_giant = self.stage.scale == 1.0;
        self.stage.scale = if becomes_giant { GIANT_SCALE } else { 1.0 };
        self.stage.floor_m += place_m - self.stage.place_m(head_m);
        let table_m = if becomes_giant { TABLE_M } else { 0.0 };
        self.stage.floor_m.z = ground_m(place_m.truncate()) - table_m * self.stage.scale;
        self.velocity_m_s = DVec3::ZERO;
    }

    /// Keeps a person's floor and a giant's head above the ground.
    fn stay_above(&mut self, head_m: DVec3, ground_m: &impl Fn(DVec2) -> f64) {
        let place_m = self.stage.place_m(head_m);
        let ground_m = ground_m(place_m.truncate());
        let lowest_m = if self.stage.scale == 1.0 {
            self.stage.floor_m.z
        } else {
            place_m.z - GIANT_CLEARANCE_M * self.stage.scale
        };
        if lowest_m < ground_m {
            self.stage.floor_m.z += ground_m - lowest_m;
            self.velocity_m_s.z = self.velocity_m_s.z.max(0.0);
        }
    }
}

/// Removes the dead zone from a deflection: −1 to 1, and continuous at the edge of the zone.
fn without_dead_zone(push: f64) -> f64 {
    ((push.abs() - DEAD_ZONE) / (1.0 - DEAD_ZONE)).clamp(0.0, 1.0).copysign(push)
}

#[cfg(test)]
mod tests {
    use glam::DQuat;

    use super::*;
    use crate::scene::view::Lens;

    const FLAT: fn(DVec2) -> f64 = |_| 50.0;
    const START: Stage = Stage { floor_m: DVec3::new(10.0, 20.0, 50.0), heading_rad: 0.0, scale: 1.0 };

    fn eyes() -> [Eye; 2] {
        let lens = Lens { left: 1.0, right: 1.0, up: 1.0, down: 1.0 };
        [-0.03, 0.03].map(|x| Eye { at_m: DVec3::new(x, 1.6, 0.2), room_from_eye: DQuat::IDENTITY, lens })
    }

    fn traveller() -> Traveller {
        Traveller::new(START)
    }

    fn run(traveller: &mut Traveller, hand_input: HandInput, steps: u32) {
        (0..steps).for_each(|_| traveller.advance(&hand_input, &eyes(), 1.0 / 90.0, FLAT));
    }

    #[test]
    fn a_push_is_one_turn() {
        let mut traveller = traveller();
        let head_m = traveller.stage().place_m(middle_m(&eyes()));
        let right = HandInput { right_stick: DVec2::new(1.0, 0.0), ..HandInput::default() };
        run(&mut traveller, right, 20);
        assert!((traveller.stage().heading_rad - TURN_RAD).abs() < 1e-12);
        run(&mut traveller, HandInput::default(), 1);
        run(&mut traveller, right, 20);
        run(&mut traveller, HandInput::default(), 1);
        run(&mut traveller, HandInput { right_stick: DVec2::new(-1.0, 0.0), ..HandInput::default() }, 20);
        assert!((traveller.stage().heading_rad - TURN_RAD).abs() < 1e-12);
        assert!(traveller.stage().place_m(middle_m(&eyes())).distance(head_m) < 1e-9);
        assert_eq!(traveller.vignette(), 0.0);
    }

    #[test]
    fn a_return_to_the_start_is_no_turn() {
        let mut traveller = traveller();
        let right = HandInput { right_stick: DVec2::new(1.0, 0.0), ..HandInput::default() };
        run(&mut traveller, right, 20);
        run(&mut traveller, HandInput { reset: true, ..right }, 1);
        run(&mut traveller, right, 20);
        assert_eq!(traveller.stage().heading_rad, START.heading_rad);
        run(&mut traveller, HandInput::default(), 1);
        run(&mut traveller, right, 1);
        assert!((traveller.stage().heading_rad - TURN_RAD).abs() < 1e-12);
    }

    #[test]
    fn speed_grows_with_height_and_the_border_darkens() {
        let ahead = HandInput { left_stick: DVec2::new(0.0, 1.0), ..HandInput::default() };
        let mut walker = traveller();
        run(&mut walker, ahead, 180);
        let walked_m = walker.stage().floor_m.y - 20.0;
        assert!((3.5..4.1).contains(&walked_m), "{walked_m}");
        assert!(walker.vignette() > 0.95);
        let mut flyer = Traveller::new(Stage { floor_m: DVec3::new(10.0, 20.0, 1050.0), ..START });
        run(&mut flyer, ahead, 180);
        let flown_m = flyer.stage().floor_m.y - 20.0;
        assert!((900.0..1000.0).contains(&flown_m), "{flown_m}");
        run(&mut flyer, HandInput::default(), 180);
        assert_eq!((flyer.vignette(), flyer.velocity_m_s), (0.0, DVec3::ZERO));
    }

    #[test]
    fn a_giant_has_the_ground_on_a_table_and_comes_back() {
        let mut traveller = traveller();
        let under_m = traveller.stage().place_m(middle_m(&eyes())).truncate();
        let switch = HandInput { switch_scale: true, ..HandInput::default() };
        run(&mut traveller, switch, 1);
        let head_m = traveller.stage().place_m(middle_m(&eyes()));
        assert!((head_m.z - 50.0 - 900.0).abs() < 1e-6, "{head_m}");
        assert!(head_m.truncate().distance(under_m) < 1e-6);
        // A giant's head stays above the ground.
        run(&mut traveller, HandInput { right_stick: DVec2::new(0.0, -1.0), ..HandInput::default() }, 900);
        let height_m = traveller.stage().place_m(middle_m(&eyes())).z - 50.0;
        assert!((height_m - 250.0).abs() < 1e-6, "{height_m}");
        run(&mut traveller, switch, 1);
        assert_eq!(traveller.stage().scale, 1.0);
        assert!((traveller.stage().floor_m.z - 50.0).abs() < 1e-6);
        run(&mut traveller, HandInput { reset: true, ..HandInput::default() }, 1);
        assert_eq!(*traveller.stage(), START);
    }

    #[test]
    fn a_stick_at_rest_does_nothing() {
        let mut traveller = traveller();
        let rest = DVec2::new(0.1, -0.12);
        run(&mut traveller, HandInput { left_stick: rest, right_stick: rest, ..HandInput::default() }, 50);
        assert_eq!(*traveller.stage(), START);
        // A long frame does not cause a jump.
        let ahead = HandInput { left_stick: DVec2::new(0.0, 1.0), ..HandInput::default() };
        traveller.advance(&ahead, &eyes(), 1e9, FLAT);
        assert!(traveller.stage().floor_m.y < 20.0 + SLOWEST_M_S);
    }
}
