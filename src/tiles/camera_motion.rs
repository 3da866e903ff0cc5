//! How the camera moves from frame to frame, and when it jumps.

use glam::DVec3;

/// After a jump, detail does not fade in but stands as it comes, for so long in seconds.
const JUMP_S: f64 = 1.5;
/// A step so many times as long as the one before is a jump.
const JUMP: f64 = 20.0;
/// So many samples at least: the first step of a movement looks like a jump as well.
const JUMP_SAMPLES: f64 = 256.0;
/// A pause so long in seconds ends a movement.
const PAUSE_S: f64 = 1.0;

/// The camera's way over the last frames.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CameraMotion {
    before: Option<Step>,
}

/// The way to a frame, for what comes next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    camera_m: DVec3,
    /// How fast the camera moves, in metres per second.
    pub velocity_m: DVec3,
    at_s: f64,
    /// Time since the frame before, in seconds.
    pub step_s: f64,
    /// When the camera last jumped, in seconds of the terrain's clock.
    jumped_s: f64,
}

impl CameraMotion {
    /// Goes on to a frame at `now_s`. A step much longer than the one before is a jump, and says nothing of the next;
    /// the first frame is one.
    pub fn go_on(&mut self, camera_m: DVec3, now_s: f64, spacing_m: f64) -> Step {
        let step = match self.before {
            None => Step { camera_m, velocity_m: DVec3::ZERO, at_s: now_s, step_s: 0.0, jumped_s: now_s },
            Some(before) => before.go_on(camera_m, now_s, spacing_m),
        };
        self.before = Some(step);
        step
    }
}

impl Step {
    fn go_on(&self, camera_m: DVec3, now_s: f64, spacing_m: f64) -> Self {
        let (step_m, step_s) = (camera_m - self.camera_m, now_s - self.at_s);
        let way_m = step_m.length();
        let is_uneven = way_m > JUMP * (self.velocity_m.length() * step_s + spacing_m);
        let is_jump = is_uneven && way_m > JUMP_SAMPLES * spacing_m;
        let is_start = is_jump || step_s > PAUSE_S;
        let now_m = if is_start { DVec3::ZERO } else { step_m / step_s.max(1e-3) };
        let velocity_m = if is_uneven { now_m } else { self.velocity_m.lerp(now_m, 0.5) };
        Self { camera_m, velocity_m, at_s: now_s, step_s, jumped_s: if is_jump { now_s } else { self.jumped_s } }
    }

    /// Whether this was a jump.
    pub fn has_jumped(&self) -> bool {
        self.jumped_s == self.at_s
    }

    /// Whether the last jump is long enough ago for detail to fade in.
    pub fn fades(&self) -> bool {
        self.at_s - self.jumped_s > JUMP_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jumps_are_told_from_flight() {
        let mut motion = CameraMotion::default();
        let mut at = |x_m: f64, now_s: f64| motion.go_on(DVec3::X * x_m, now_s, 10.0);
        assert!(at(0.0, 0.0).has_jumped(), "the first frame");
        // Off it goes at 300 m/s: a first step, and no jump.
        for frame in 1..100 {
            let step = at(10.0 * f64::from(frame), f64::from(frame) / 30.0);
            assert!(!step.has_jumped());
            assert_eq!(step.fades(), f64::from(frame) / 30.0 > JUMP_S);
        }
        let step = at(1000.0, 100.0 / 30.0);
        assert!((step.velocity_m.x - 300.0).abs() < 1.0 && (step.step_s - 1.0 / 30.0).abs() < 1e-9);
        let jump = at(50_000.0, 3.4);
        assert!(jump.has_jumped() && !jump.fades() && jump.velocity_m == DVec3::ZERO);
        let pause = at(50_010.0, 5.0);
        assert!(!pause.has_jumped() && pause.fades() && pause.velocity_m == DVec3::ZERO);
    }
}
