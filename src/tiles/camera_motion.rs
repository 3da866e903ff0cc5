//! The motion of the camera from frame to frame, and the detection of jumps.

use glam::{DQuat, DVec3};

/// Time in seconds after a jump in which new detail appears at once instead of fading in.
const JUMP_S: f64 = 1.5;
/// A step is sudden if it is more than this many times as long as the previous velocity and one sample of the terrain
/// would explain.
const SUDDEN_FACTOR: f64 = 20.0;
/// Length from which a sudden step is a jump, in samples of the terrain; otherwise the first step of a movement would
/// be one.
const JUMP_SAMPLES: f64 = 256.0;
/// A longer time between frames, in seconds, ends a movement.
const PAUSE_S: f64 = 1.0;

/// A slower turn does not count.
const MIN_TURN_RAD_S: f64 = 1e-3;
/// The largest turn that is foreseen.
const MAX_TURN_RAD: f64 = 1.0;

/// The motion of the camera up to the last frame.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CameraMotion {
    last: Option<Step>,
}

/// The camera's step to a frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// Position of the camera at the frame, in the world.
    camera_m: DVec3,
    /// Velocity of the camera, averaged over recent steps. A sudden step is not averaged with those before it, and
    /// after a jump or a pause the velocity is 0.
    pub velocity_m_s: DVec3,
    /// Time of the frame, in seconds of the terrain's clock.
    at_s: f64,
    /// Time since the previous frame, in seconds.
    pub elapsed_s: f64,
    /// Time of the last jump, in seconds of the same clock.
    jumped_s: f64,
}

impl CameraMotion {
    /// Advances to a frame at `now_s` with the camera at `camera_m`; `spacing_m` is the distance between the terrain's
    /// samples, those of full resolution. The first frame is a jump.
    pub(super) fn advance(&mut self, camera_m: DVec3, now_s: f64, spacing_m: f64) -> Step {
        let step = match self.last {
            None => Step { camera_m, velocity_m_s: DVec3::ZERO, at_s: now_s, elapsed_s: 0.0, jumped_s: now_s },
            Some(last) => last.next(camera_m, now_s, spacing_m),
        };
        self.last = Some(step);
        step
    }
}

impl Step {
    /// Returns the step that follows this one.
    fn next(&self, camera_m: DVec3, now_s: f64, spacing_m: f64) -> Self {
        let (moved_m, elapsed_s) = (camera_m - self.camera_m, now_s - self.at_s);
        let distance_m = moved_m.length();
        let is_sudden = distance_m > SUDDEN_FACTOR * (self.velocity_m_s.length() * elapsed_s + spacing_m);
        let is_jump = is_sudden && distance_m > JUMP_SAMPLES * spacing_m;
        let velocity_m_s = if is_jump || elapsed_s > PAUSE_S {
            DVec3::ZERO
        } else {
            let of_step_m_s = moved_m / elapsed_s.max(1e-3);
            if is_sudden { of_step_m_s } else { self.velocity_m_s.lerp(of_step_m_s, 0.5) }
        };
        Self { camera_m, velocity_m_s, at_s: now_s, elapsed_s, jumped_s: if is_jump { now_s } else { self.jumped_s } }
    }

    /// Returns whether this step was a jump.
    pub(super) fn has_jumped(&self) -> bool {
        self.jumped_s == self.at_s
    }

    /// Returns whether new detail fades in: not shortly after a jump.
    pub(super) fn fades(&self) -> bool {
        self.at_s - self.jumped_s > JUMP_S
    }
}

/// How a view turns.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Turning {
    last: Option<(DVec3, f64)>,
    /// Angular velocity of the view in radians per second, along the axis of the turn; averaged over recent frames.
    angular_velocity_rad_s: DVec3,
}

impl Turning {
    /// Advances to a frame at `now_s` whose view is along `forward`. A frame after a jump begins again.
    pub(super) fn advance(&mut self, forward: DVec3, now_s: f64, has_jumped: bool) {
        if !forward.is_normalized() {
            // An empty view sees nothing.
            *self = Self::default();
            return;
        }
        let before = self.last.replace((forward, now_s)).filter(|(_, at_s)| !has_jumped && now_s - at_s < PAUSE_S);
        let Some((last, at_s)) = before else {
            self.angular_velocity_rad_s = DVec3::ZERO;
            return;
        };
        if now_s > at_s {
            let turn = DQuat::from_rotation_arc(last, forward).to_scaled_axis() / (now_s - at_s);
            self.angular_velocity_rad_s = self.angular_velocity_rad_s.lerp(turn, 0.5);
        }
    }

    /// Returns whether the view turns.
    pub(super) fn is_turning(&self) -> bool {
        self.angular_velocity_rad_s.length() > MIN_TURN_RAD_S
    }

    /// Returns the turn after some seconds, if it goes on.
    pub(super) fn after(&self, seconds: f64) -> DQuat {
        DQuat::from_scaled_axis((self.angular_velocity_rad_s * seconds).clamp_length_max(MAX_TURN_RAD))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jumps_are_distinguished_from_flight() {
        let mut motion = CameraMotion::default();
        let mut at = |x_m: f64, now_s: f64| motion.advance(DVec3::X * x_m, now_s, 10.0);
        assert!(at(0.0, 0.0).has_jumped(), "the first frame");
        // The camera starts at 300 m/s: a first step, not a jump.
        for frame in 1..100 {
            let step = at(10.0 * f64::from(frame), f64::from(frame) / 30.0);
            assert!(!step.has_jumped());
            assert_eq!(step.fades(), f64::from(frame) / 30.0 > JUMP_S);
        }
        let step = at(1000.0, 100.0 / 30.0);
        assert!((step.velocity_m_s.x - 300.0).abs() < 1.0 && (step.elapsed_s - 1.0 / 30.0).abs() < 1e-9);
        let jump = at(50_000.0, 3.4);
        assert!(jump.has_jumped() && !jump.fades() && jump.velocity_m_s == DVec3::ZERO);
        let pause = at(50_010.0, 5.0);
        assert!(!pause.has_jumped() && pause.fades() && pause.velocity_m_s == DVec3::ZERO);
    }

    #[test]
    fn a_pause_ends_a_movement() {
        for (pause_s, velocity_m_s) in [(0.9, 150.0), (1.1, 0.0)] {
            let mut motion = CameraMotion::default();
            let mut at = |x_m: f64, now_s: f64| motion.advance(DVec3::X * x_m, now_s, 10.0);
            for frame in 0..100 {
                at(10.0 * f64::from(frame), f64::from(frame) / 30.0);
            }
            let step = at(990.0, 99.0 / 30.0 + pause_s);
            assert!((step.velocity_m_s.x - velocity_m_s).abs() < 1.0, "{pause_s} s: {}", step.velocity_m_s);
        }
    }

    #[test]
    fn a_turn_goes_on_and_ends_with_a_jump() {
        let forward = |yaw_rad: f64| DVec3::new(yaw_rad.sin(), yaw_rad.cos(), 0.0);
        let mut turning = Turning::default();
        for frame in 0..30 {
            let now_s = f64::from(frame) / 30.0;
            turning.advance(forward(0.2 * now_s), now_s, false);
        }
        let now_rad = 0.2 * 29.0 / 30.0;
        let ahead = turning.after(1.0) * forward(now_rad);
        assert!(turning.is_turning() && (ahead - forward(now_rad + 0.2)).length() < 1e-6, "{ahead}");
        turning.advance(forward(2.0), 1.0, true);
        assert!(!turning.is_turning() && turning.after(3.0) * DVec3::Y == DVec3::Y);
        turning.advance(DVec3::ZERO, 1.1, false);
        assert!(!turning.is_turning());
    }
}
