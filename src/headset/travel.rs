//! How the room moves through the world: thumb sticks, with what keeps a stomach calm.
//!
//! Turns come in steps, speed keeps the ground from rushing by, and the border of the picture darkens on the way. Nothing
//! here knows OpenXR or GPUs.

use glam::{DVec2, DVec3};

use super::stage::{Eye, Stage, middle_m};

/// A step of a turn.
const TURN_RAD: f64 = std::f64::consts::PI / 6.0;
/// A stick that is pushed as far turns or lifts; it turns once more after it came back half the way.
const PUSHED: f64 = 0.7;
/// What a stick at rest may show.
const REST: f64 = 0.15;
/// The slowest full speed, in metres of the room per second: a quick walk.
const SLOWEST_M_S: f64 = 2.0;
/// The full speed is this part of the height above the ground in a second: what is below then never passes by at more
/// than 29° per second.
const HEIGHT_PER_S: f64 = 0.5;
/// No flight is faster, in m/s.
const FASTEST_M_S: f64 = 5000.0;
/// How much faster hurrying is.
const FAST: f64 = 3.0;
/// In this time the velocity comes 63 % of its way.
const LAG_S: f64 = 0.12;
/// In this time the border darkens or clears by 63 %.
const VIGNETTE_LAG_S: f64 = 0.1;
/// A longer step is taken as this long.
const LONGEST_STEP_S: f64 = 0.25;

/// Metres of the world in a giant's metre: his eyes stand 65 m apart.
pub const GIANT: f64 = 1000.0;
/// Where a giant has the ground, in his room: at a table's height.
const TABLE_M: f64 = 0.7;
/// How near a giant's head comes to the ground.
const GIANT_CLEARANCE_M: f64 = 0.25;

/// What the hands ask for in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Asked {
    /// To the right and ahead, −1 to 1.
    pub fly: DVec2,
    /// To turn right, and up, −1 to 1.
    pub turn: DVec2,
    /// Whether to hurry.
    pub fast: bool,
    /// The next style.
    pub next_style: bool,
    /// From a person to a giant, or back.
    pub scale: bool,
    /// Back to the start.
    pub reset: bool,
}

/// Somebody on the way.
#[derive(Clone, Debug)]
pub struct Traveller {
    stage: Stage,
    start: Stage,
    /// Of the room, in m/s of the world.
    velocity_m_s: DVec3,
    has_turned: bool,
    vignette: f64,
}

impl Traveller {
    /// Begins where `start` is.
    pub fn new(start: Stage) -> Self {
        Self { stage: start, start, velocity_m_s: DVec3::ZERO, has_turned: false, vignette: 0.0 }
    }

    /// Where the room stands.
    pub fn stage(&self) -> &Stage {
        &self.stage
    }

    /// How dark the border of the picture is, 0 to 1.
    pub fn vignette(&self) -> f64 {
        self.vignette
    }

    /// Goes on by `step_s`. `ground_m` is the height of the ground at a place.
    pub fn advance(&mut self, asked: &Asked, eyes: &[Eye; 2], step_s: f64, ground_m: impl Fn(DVec2) -> f64) {
        let step_s = step_s.clamp(0.0, LONGEST_STEP_S);
        let head_m = middle_m(eyes);
        if asked.reset {
            *self = Self::new(self.start);
        }
        if asked.scale {
            self.change_scale(head_m, &ground_m);
        }
        self.turn(asked.turn.x, head_m);
        self.fly(asked, eyes, step_s, &ground_m);
        self.stay_above(head_m, &ground_m);
    }

    /// A step for each push of the stick.
    fn turn(&mut self, push: f64, head_m: DVec3) {
        if push.abs() > PUSHED && !self.has_turned {
            self.stage.turn_about(head_m, TURN_RAD.copysign(push));
            self.has_turned = true;
        } else if push.abs() < 0.5 * PUSHED {
            self.has_turned = false;
        }
    }

    fn fly(&mut self, asked: &Asked, eyes: &[Eye; 2], step_s: f64, ground_m: &impl Fn(DVec2) -> f64) {
        let pose = self.stage.pose(&eyes[0]);
        let place_m = self.stage.place_m(middle_m(eyes));
        let height_m = place_m.z - ground_m(place_m.truncate());
        let slowest_m_s = SLOWEST_M_S * self.stage.scale;
        let full_m_s = (HEIGHT_PER_S * height_m).max(slowest_m_s) * if asked.fast { FAST } else { 1.0 };
        let full_m_s = full_m_s.min(FASTEST_M_S.max(slowest_m_s));
        // A head that leans does not tilt the way to the right, and lifting is against the sky.
        let right = DVec3::new(pose.right.x, pose.right.y, 0.0).normalize_or_zero();
        let [aside, ahead, lift] = [asked.fly.x, asked.fly.y, asked.turn.y].map(past_rest);
        // A push that is meant to turn does not lift.
        let lift = if asked.turn.y.abs() > asked.turn.x.abs() { lift } else { 0.0 };
        let wish = (pose.forward * ahead + right * aside + DVec3::Z * lift).clamp_length_max(1.0);
        let reached = 1.0 - (-step_s / LAG_S).exp();
        self.velocity_m_s += (wish * full_m_s - self.velocity_m_s) * reached;
        if wish == DVec3::ZERO && self.velocity_m_s.length() < 0.01 * slowest_m_s {
            self.velocity_m_s = DVec3::ZERO;
        }
        self.stage.floor_m += self.velocity_m_s * step_s;
        let most_m = crate::scene::camera::LARGEST_COORDINATE_M;
        self.stage.floor_m = self.stage.floor_m.clamp(DVec3::splat(-most_m), DVec3::splat(most_m));
        let moves = (self.velocity_m_s.length() / full_m_s).clamp(0.0, 1.0);
        self.vignette += (moves - self.vignette) * (1.0 - (-step_s / VIGNETTE_LAG_S).exp());
        if moves == 0.0 && self.vignette < 1e-3 {
            self.vignette = 0.0;
        }
    }

    /// The place under the head stays under it.
    fn change_scale(&mut self, head_m: DVec3, ground_m: &impl Fn(DVec2) -> f64) {
        let place_m = self.stage.place_m(head_m);
        let is_giant = self.stage.scale == 1.0;
        self.stage.scale = if is_giant { GIANT } else { 1.0 };
        self.stage.floor_m += place_m - self.stage.place_m(head_m);
        let table_m = if is_giant { TABLE_M } else { 0.0 };
        self.stage.floor_m.z = ground_m(place_m.truncate()) - table_m * self.stage.scale;
        self.velocity_m_s = DVec3::ZERO;
    }

    /// A person's floor and a giant's head stay above the ground.
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

/// A stick's push without its rest, which begins at 0 all the same.
fn past_rest(push: f64) -> f64 {
    ((push.abs() - REST) / (1.0 - REST)).clamp(0.0, 1.0).copysign(push)
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

    fn run(traveller: &mut Traveller, asked: Asked, steps: u32) {
        (0..steps).for_each(|_| traveller.advance(&asked, &eyes(), 1.0 / 90.0, FLAT));
    }

    #[test]
    fn a_push_is_one_turn() {
        let mut traveller = traveller();
        let head_m = traveller.stage().place_m(middle_m(&eyes()));
        let right = Asked { turn: DVec2::new(1.0, 0.0), ..Asked::default() };
        run(&mut traveller, right, 20);
        assert!((traveller.stage().heading_rad - TURN_RAD).abs() < 1e-12);
        run(&mut traveller, Asked::default(), 1);
        run(&mut traveller, right, 20);
        run(&mut traveller, Asked::default(), 1);
        run(&mut traveller, Asked { turn: DVec2::new(-1.0, 0.0), ..Asked::default() }, 20);
        assert!((traveller.stage().heading_rad - TURN_RAD).abs() < 1e-12);
        assert!(traveller.stage().place_m(middle_m(&eyes())).distance(head_m) < 1e-9);
        assert_eq!(traveller.vignette(), 0.0);
    }

    #[test]
    fn speed_grows_with_height_and_the_border_darkens() {
        let ahead = Asked { fly: DVec2::new(0.0, 1.0), ..Asked::default() };
        let mut walker = traveller();
        run(&mut walker, ahead, 180);
        let walked_m = walker.stage().floor_m.y - 20.0;
        assert!((3.5..4.1).contains(&walked_m), "{walked_m}");
        assert!(walker.vignette() > 0.95);
        let mut flyer = Traveller::new(Stage { floor_m: DVec3::new(10.0, 20.0, 1050.0), ..START });
        run(&mut flyer, ahead, 180);
        let flown_m = flyer.stage().floor_m.y - 20.0;
        assert!((900.0..1000.0).contains(&flown_m), "{flown_m}");
        run(&mut flyer, Asked::default(), 180);
        assert_eq!((flyer.vignette(), flyer.velocity_m_s), (0.0, DVec3::ZERO));
    }

    #[test]
    fn a_giant_has_the_ground_on_a_table_and_comes_back() {
        let mut traveller = traveller();
        let under_m = traveller.stage().place_m(middle_m(&eyes())).truncate();
        let scale = Asked { scale: true, ..Asked::default() };
        run(&mut traveller, scale, 1);
        let head_m = traveller.stage().place_m(middle_m(&eyes()));
        assert!((head_m.z - 50.0 - 900.0).abs() < 1e-6, "{head_m}");
        assert!(head_m.truncate().distance(under_m) < 1e-6);
        // He does not put his head into the ground.
        run(&mut traveller, Asked { turn: DVec2::new(0.0, -1.0), ..Asked::default() }, 900);
        let height_m = traveller.stage().place_m(middle_m(&eyes())).z - 50.0;
        assert!((height_m - 250.0).abs() < 1e-6, "{height_m}");
        run(&mut traveller, scale, 1);
        assert_eq!(traveller.stage().scale, 1.0);
        assert!((traveller.stage().floor_m.z - 50.0).abs() < 1e-6);
        run(&mut traveller, Asked { reset: true, ..Asked::default() }, 1);
        assert_eq!(*traveller.stage(), START);
    }

    #[test]
    fn a_stick_at_rest_does_nothing() {
        let mut traveller = traveller();
        let rest = DVec2::new(0.1, -0.12);
        run(&mut traveller, Asked { fly: rest, turn: rest, ..Asked::default() }, 50);
        assert_eq!(*traveller.stage(), START);
        // A longer frame is no jump.
        let ahead = Asked { fly: DVec2::new(0.0, 1.0), ..Asked::default() };
        traveller.advance(&ahead, &eyes(), 1e9, FLAT);
        assert!(traveller.stage().floor_m.y < 20.0 + SLOWEST_M_S);
    }
}
