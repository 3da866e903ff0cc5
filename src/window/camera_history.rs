//! The views that the camera has left, so that the user can return to them.
//!
//! A view counts when the camera has rested there: views that are passed on the way to another one are not remembered.
//! Whether it has is decided when the camera leaves, so no clock has to run while nothing moves.

use std::time::{Duration, Instant};

use glam::DVec3;

use crate::scene::camera::Camera;

/// Largest number of views in each direction; the oldest is dropped.
const MAX_VIEWS: usize = 50;
/// Time at rest after which a view is remembered. It is longer than the time between two notches of the wheel, or two
/// presses of a key.
const REST: Duration = Duration::from_millis(400);
/// Views are nearly equal if they are at most this part of the height above the ground apart,
const NEAR_PART: f64 = 0.002;
/// and their directions and fields of view differ by at most this angle.
const NEAR_DEG: f64 = 0.2;

/// A step in the history of the camera.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ViewStep {
    /// To the previous view.
    Back,
    /// To the view that was left by [`ViewStep::Back`].
    Forward,
}

/// The views before and after the current one.
#[derive(Clone, Debug)]
pub(super) struct CameraHistory {
    back: Vec<Camera>,
    forward: Vec<Camera>,
    /// The view at which the camera has rested last, as it was first seen. Small moves are compared with it, so that
    /// many of them together count as a new view.
    here: Camera,
    /// The view [`Self::here`] after small moves; the camera returns to it.
    latest: Camera,
    /// The view of the last frame.
    seen: Camera,
    /// Since when the camera has been at rest there; `None` while it moves.
    rests_since: Option<Instant>,
}

impl CameraHistory {
    /// Begins at a view.
    pub(super) fn new(start: Camera, now: Instant) -> Self {
        let (back, forward) = (Vec::new(), Vec::new());
        Self { back, forward, here: start, latest: start, seen: start, rests_since: Some(now) }
    }

    /// Records the view of a frame. `is_still` says whether nothing moves the camera, `height_m` is its height above the
    /// ground.
    pub(super) fn note(&mut self, view: Camera, is_still: bool, height_m: f64, now: Instant) {
        if view != self.seen {
            let has_rested = self.rests_since.is_some_and(|since| now.saturating_duration_since(since) >= REST);
            if has_rested {
                self.arrive(height_m);
            }
            self.seen = view;
            self.rests_since = None;
        }
        if is_still {
            self.rests_since.get_or_insert(now);
        }
    }

    /// Records the last seen view as one to which the camera can return.
    fn arrive(&mut self, height_m: f64) {
        if is_near(&self.here, &self.seen, height_m) {
            self.latest = self.seen;
            return;
        }
        push(&mut self.back, self.latest);
        self.forward.clear();
        (self.here, self.latest) = (self.seen, self.seen);
    }

    /// Returns the previous view, or the next one, from the current view `view`; `None` if there is none.
    pub(super) fn go(&mut self, step: ViewStep, view: Camera, height_m: f64, now: Instant) -> Option<Camera> {
        self.note(view, true, height_m, now);
        // A view that the camera has just reached can be returned to, too.
        self.arrive(height_m);
        let (from, to) = match step {
            ViewStep::Back => (&mut self.back, &mut self.forward),
            ViewStep::Forward => (&mut self.forward, &mut self.back),
        };
        let view = from.pop()?;
        push(to, self.latest);
        (self.here, self.latest, self.seen, self.rests_since) = (view, view, view, Some(now));
        Some(view)
    }

    /// Returns whether there is a previous view and a next one.
    pub(super) fn has_views(&self, view: &Camera, height_m: f64) -> [bool; 2] {
        let is_away = !is_near(&self.here, view, height_m);
        [is_away || !self.back.is_empty(), !is_away && !self.forward.is_empty()]
    }

    /// Multiplies the heights of all views, because those of the land were.
    pub(super) fn scale_heights(&mut self, factor: f64) {
        let all = self.back.iter_mut().chain(&mut self.forward);
        let present = [&mut self.here, &mut self.latest, &mut self.seen];
        all.chain(present).for_each(|view| view.position_m.z *= factor);
    }
}

fn push(views: &mut Vec<Camera>, view: Camera) {
    views.push(view);
    if views.len() > MAX_VIEWS {
        views.remove(0);
    }
}

/// Returns whether a user sees the same from two cameras.
fn is_near(a: &Camera, b: &Camera, height_m: f64) -> bool {
    // Angles between directions, since a yaw means nothing where the camera looks straight down.
    let angle_deg = |a: DVec3, b: DVec3| a.angle_between(b).to_degrees();
    a.position_m.distance(b.position_m) <= NEAR_PART * height_m.abs()
        && angle_deg(a.forward(), b.forward()) <= NEAR_DEG
        && angle_deg(a.up(), b.up()) <= NEAR_DEG
        && (a.fov_deg - b.fov_deg).abs() <= NEAR_DEG
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::*;

    const HEIGHT_M: f64 = 500.0;

    fn at(x_m: f64) -> Camera {
        Camera {
            position_m: DVec3::new(x_m, 0.1, 1500.7),
            height_above_ground: false,
            yaw_deg: 20.3,
            pitch_deg: -10.1,
            fov_deg: 45.0,
        }
    }

    /// A camera with a clock.
    struct Bench {
        history: CameraHistory,
        now: Instant,
        view: Camera,
    }

    impl Bench {
        fn new() -> Self {
            let now = Instant::now();
            Self { history: CameraHistory::new(at(0.0), now), now, view: at(0.0) }
        }

        /// Moves the camera in steps to a view, where it rests.
        fn fly(&mut self, to: Camera) {
            self.now += Duration::from_secs(1);
            let from = self.view.position_m;
            for step in 1..=4 {
                // A slow frame is not a rest.
                self.now += Duration::from_secs(1);
                self.view = Camera { position_m: from.lerp(to.position_m, f64::from(step) / 4.0), ..to };
                self.history.note(self.view, false, HEIGHT_M, self.now);
            }
            self.jump(to);
        }

        /// Shows a view at once, where the camera rests.
        fn jump(&mut self, to: Camera) {
            self.view = to;
            self.history.note(to, true, HEIGHT_M, self.now);
            self.now += Duration::from_secs(1);
            self.history.note(to, true, HEIGHT_M, self.now);
        }

        fn go(&mut self, step: ViewStep) -> Option<Camera> {
            let has_views = self.has_views();
            let to = self.history.go(step, self.view, HEIGHT_M, self.now);
            assert_eq!(has_views[usize::from(step == ViewStep::Forward)], to.is_some(), "{step:?}");
            self.view = to.unwrap_or(self.view);
            to
        }

        fn has_views(&self) -> [bool; 2] {
            self.history.has_views(&self.view, HEIGHT_M)
        }
    }

    #[test]
    fn the_camera_returns_to_the_views_at_which_it_rested() {
        let mut bench = Bench::new();
        assert_eq!(bench.has_views(), [false, false]);
        assert_eq!(bench.go(ViewStep::Back), None);
        bench.fly(at(1000.0));
        bench.fly(at(2000.0));
        bench.jump(at(-300.0));
        assert_eq!(bench.has_views(), [true, false]);
        let back: Vec<Camera> = std::iter::from_fn(|| bench.go(ViewStep::Back)).collect();
        // Bit for bit, and nothing of the ways between.
        assert_eq!(back, [at(2000.0), at(1000.0), at(0.0)]);
        let forward: Vec<Camera> = std::iter::from_fn(|| bench.go(ViewStep::Forward)).collect();
        assert_eq!(forward, [at(1000.0), at(2000.0), at(-300.0)]);
        // Another view ends the way forward.
        bench.go(ViewStep::Back).unwrap();
        bench.fly(at(7.0));
        assert_eq!(bench.has_views(), [true, false]);
        assert_eq!(bench.go(ViewStep::Forward), None);
        assert_eq!(bench.go(ViewStep::Back), Some(at(2000.0)));
    }

    #[test]
    fn the_way_back_begins_in_motion() {
        let mut bench = Bench::new();
        bench.now += Duration::from_millis(16);
        bench.view = at(40.0);
        bench.history.note(bench.view, false, HEIGHT_M, bench.now);
        assert_eq!(bench.go(ViewStep::Back), Some(at(0.0)));
        assert_eq!(bench.go(ViewStep::Forward), Some(at(40.0)));
        // Short stops are passed: notches of the wheel, presses of a key.
        let mut bench = Bench::new();
        for x_m in [100.0, 200.0, 300.0] {
            bench.now += Duration::from_millis(300);
            bench.view = at(x_m);
            bench.history.note(bench.view, true, HEIGHT_M, bench.now);
        }
        assert_eq!(bench.go(ViewStep::Back), Some(at(0.0)));
        assert_eq!(bench.has_views(), [false, true]);
    }

    #[test]
    fn nearly_equal_views_count_once() {
        let mut bench = Bench::new();
        bench.jump(at(500.0));
        bench.jump(at(500.5));
        bench.jump(Camera { yaw_deg: 20.4, ..at(500.5) });
        bench.jump(at(0.0));
        // The last of them is the one to which the camera returns.
        assert_eq!(bench.go(ViewStep::Back), Some(Camera { yaw_deg: 20.4, ..at(500.5) }));
        assert_eq!(bench.go(ViewStep::Back), Some(at(0.0)));
        assert_eq!(bench.go(ViewStep::Back), None);
        // Many small moves are a view at last.
        (1..=5).for_each(|step| bench.jump(at(0.5 * f64::from(step))));
        assert_eq!(bench.go(ViewStep::Back), Some(at(1.0)));
        assert_eq!(bench.go(ViewStep::Back), None);
        // Another direction or field of view is another view.
        for other in [Camera { yaw_deg: 21.0, ..at(0.0) }, Camera { fov_deg: 46.0, ..at(0.0) }] {
            assert!(!is_near(&at(0.0), &other, HEIGHT_M), "{other}");
        }
        let down = |yaw_deg| Camera { pitch_deg: -90.0, yaw_deg, ..at(0.0) };
        assert!(!is_near(&down(0.0), &down(90.0), HEIGHT_M), "the picture is turned");
        assert!(is_near(&down(359.95), &down(0.05), HEIGHT_M));
    }

    #[test]
    fn the_oldest_views_are_dropped_and_heights_follow_the_land() {
        let mut bench = Bench::new();
        (1..80).for_each(|step| bench.jump(at(100.0 * f64::from(step))));
        bench.history.scale_heights(2.0);
        bench.view.position_m.z *= 2.0;
        let views: Vec<Camera> = std::iter::from_fn(|| bench.go(ViewStep::Back)).collect();
        assert_eq!(views.len(), MAX_VIEWS);
        let last = at(100.0 * (79 - MAX_VIEWS) as f64);
        assert_eq!(views[MAX_VIEWS - 1].position_m, last.position_m * DVec3::new(1.0, 1.0, 2.0));
    }
}
