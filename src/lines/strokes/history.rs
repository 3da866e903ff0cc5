//! Decides whether a frame rebuilds its strokes (a full update) or advances those of the previous frame.
//!
//! Pietrok 2021, section 4.3: there is a full update every N frames, and at once when the camera turns quickly. The
//! thesis does so because motion vectors overshoot; here motion is exact, but land that a turn brings into view has no
//! strokes until the next update, and then gets all of them at once.

use glam::{DQuat, DVec3};

use crate::scene::view::{Pose, View};
use crate::style;

/// A turn that has brought a strip of this width into view since the last update, in pixels, triggers an update:
/// strokes that appear at once in a wider strip are noticed. So all but the slowest turns update in every frame.
const ENTERING_PX: f64 = 1.5;
/// A move of this fraction of the distance to the nearest land since the last update triggers an update: contours have
/// then changed place.
const QUICK_MOVE: f64 = 1.0 / 50.0;
/// A turn from one frame to the next by more than this fraction of the field of view is a cut: no strokes are carried
/// over.
const CUT: f64 = 0.5;

/// The views that were drawn last, and the state of the strokes' transitions.
#[derive(Clone, Debug, Default)]
pub(crate) struct History {
    last: Option<View>,
    /// The origin of the last frame's positions, in the world.
    origin_m: DVec3,
    /// The view of the last update.
    updated: Option<View>,
    frames_since_update: u32,
    since_update_s: f64,
    /// The view or the land has changed since the last update.
    is_stale: bool,
    frames: u32,
    /// The next frame is an update, because a value of the style has changed.
    is_edited: bool,
    /// Time for which strokes still fade in and out if the camera stays where it is, in units of the style's `fade_s`.
    restless: f64,
}

/// The change from the last frame to this one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Step {
    /// Elapsed time, in seconds.
    pub step_s: f64,
    /// Shortest time between two updates while the camera moves, in seconds; the style may have a longer one.
    pub pause_s: f64,
    /// Lower bound of the distance from the camera to any land, in metres.
    pub nearest_m: f64,
    /// The rig's origin in the world, to which positions of samples are relative.
    pub origin_m: DVec3,
    /// Whether tiles arrived or are being loaded, so that the land differs from that of the last frame.
    pub land_changes: bool,
}

/// The largest fraction of a stroke's fade that one frame shows: more would be seen as a jump.
const MAX_PROGRESS: f64 = 0.5;

impl Step {
    /// Returns the fraction of the fade time of a stroke that passes in this frame, limited to what one frame may show.
    pub(crate) fn progress(&self, strokes: &style::Strokes) -> f64 {
        (self.step_s / f64::from(strokes.fade_s.max(1e-6))).min(MAX_PROGRESS)
    }
}

/// The strokes' work in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plan {
    /// Whether strokes are rebuilt.
    pub is_update: bool,
    /// Whether new strokes continue those of the previous frame.
    pub takes_over: bool,
    /// Translation from positions of the previous frame to those of this frame, in metres.
    pub step_m: DVec3,
    /// The view of the previous update, if there was one.
    pub updated: Option<View>,
    /// Whether the camera has not moved, and the picture has the size of the last one.
    pub rests: bool,
    /// Size of the last frame's picture, in pixels.
    pub last_px: [u32; 2],
    /// Frames since the history began: 0 in the first.
    pub frame: u32,
}

impl History {
    /// Plans the frame of `view`, which is a step after the last one, and records it as the last one. The second eye of
    /// a stereo pair updates when the leading one does, which `leader` states.
    pub(crate) fn plan(&mut self, strokes: &style::Strokes, view: &View, step: Step, leader: Option<bool>) -> Plan {
        let is_edited = std::mem::take(&mut self.is_edited);
        let step_m = std::mem::replace(&mut self.origin_m, step.origin_m) - step.origin_m;
        let rests = self.last.is_some_and(|last| last.pose == view.pose && last.part == view.part);
        let last_px = self.last.map_or(view.part.size_px, |last| last.part.size_px);
        // Another sample of the same picture: its strokes stay.
        let is_sample = rests && step.step_s == 0.0 && !step.land_changes;
        let last = self.last.replace(*view).filter(|last| continues(last, view));
        let updated = self.updated.filter(|_| last.is_some());
        let plan = match updated {
            None => {
                let (is_update, takes_over, step_m) = (true, false, DVec3::ZERO);
                Plan { is_update, takes_over, step_m, updated, rests, last_px, frame: 0 }
            }
            Some(View { pose: updated_pose, .. }) => {
                let moved_m = updated_pose.position_m.distance(view.pose.position_m);
                let pause_s = step.pause_s.max(1e-3 * f64::from(strokes.rebuild_ms));
                // The times of frames are whole multiples of a pause at some rates.
                let is_over = self.since_update_s + step.step_s >= pause_s * (1.0 - 1e-6);
                // When the camera comes to rest, strokes from the time of the motion are rebuilt.
                let is_late = (self.is_stale && rests && !step.land_changes)
                    || is_over
                        && (self.frames_since_update + 1 >= strokes.update_every
                            || entering_px(&updated_pose, view) > ENTERING_PX
                            || moved_m > QUICK_MOVE * step.nearest_m);
                let is_due = is_late && !is_sample || is_edited;
                Plan {
                    is_update: leader.unwrap_or(is_due),
                    takes_over: strokes.carry,
                    step_m,
                    updated,
                    rests,
                    last_px,
                    frame: self.frames.wrapping_add(1),
                }
            }
        };
        self.is_stale |= !rests || step.land_changes || is_edited;
        self.restless = match plan.is_update && self.is_stale {
            // A line that is replaced disappears after its replacement has appeared.
            true if strokes.carry && plan.frame > 0 => 2.0,
            true => 0.0,
            false => self.restless - step.progress(strokes),
        };
        self.frames = plan.frame;
        self.frames_since_update = if plan.is_update { 0 } else { self.frames_since_update + u32::from(!is_sample) };
        self.since_update_s = if plan.is_update { 0.0 } else { self.since_update_s + step.step_s };
        if plan.is_update {
            // More tiles may be loading.
            self.is_stale = step.land_changes;
            self.updated = Some(*view);
        }
        plan
    }

    /// Returns whether the next frame of the same view would be a different picture.
    pub(crate) fn is_settling(&self) -> bool {
        self.restless > 0.0 || self.is_stale
    }

    /// Returns whether the last frame's strokes continued those of the frame before it.
    #[cfg(test)]
    pub(crate) fn continued(&self) -> bool {
        self.frames > 0
    }

    /// Makes the next frame an update that continues the strokes of the last one.
    pub(crate) fn rebuild_next(&mut self) {
        self.is_edited = true;
    }

    /// Makes the next frame the first one.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }
}

/// Returns the width of the widest strip that a turn since the last update has brought into view, in pixels: it comes in
/// at a border when the camera turns, and at the ends of the longer sides when it rolls.
fn entering_px(updated: &Pose, view: &View) -> f64 {
    let turned_rad = updated.forward.angle_between(view.pose.forward);
    let turn = DQuat::from_rotation_arc(updated.forward, view.pose.forward);
    let rolled_rad = (turn * updated.right).angle_between(view.pose.right);
    let longer_px = f64::from(view.picture_px[0].max(view.picture_px[1]));
    turned_rad * view.focal_px() + rolled_rad * 0.5 * longer_px
}

/// Returns whether a view continues the last one that was drawn: the same part of a picture, or the whole picture in
/// another size. Without room for other sizes, the history of the last size has been forgotten before.
fn continues(last: &View, view: &View) -> bool {
    let is_same_part = last.part == view.part && last.picture_px == view.picture_px;
    let is_next = last.pose == view.previous && (is_same_part || (last.is_whole() && view.is_whole()));
    is_next && last.pose.forward.angle_between(view.pose.forward) <= CUT * view.fov_rad().min(last.fov_rad())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a panic fails the test")]

    use super::*;
    use crate::scene::view::Part;
    use crate::style::Style;

    const STEP: Step = Step { step_s: 0.1, pause_s: 0.0, nearest_m: 1e6, origin_m: DVec3::ZERO, land_changes: false };

    /// Focal length of a picture 36 px high whose field of view is one radian.
    const FOCAL_PX: f64 = 32.95;

    fn pose(yaw_deg: f64) -> Pose {
        let (sin, cos) = yaw_deg.to_radians().sin_cos();
        let (forward, right) = (DVec3::new(sin, cos, 0.0), DVec3::new(cos, -sin, 0.0));
        Pose { position_m: DVec3::X * yaw_deg, forward, right, up: DVec3::Z, fov_rad: 1.0 }
    }

    fn view(previous: Pose, pose: Pose) -> View {
        View::whole(previous, pose, [64, 36])
    }

    fn strokes(update_every: u32, carry: bool) -> style::Strokes {
        style::Strokes { update_every, carry, ..Style::load("strokes").unwrap().strokes().cloned().unwrap() }
    }

    #[test]
    fn updates_come_every_n_frames_and_at_quick_turns() {
        let (mut history, strokes) = (History::default(), strokes(4, true));
        let mut updates = Vec::new();
        let mut previous = pose(0.0);
        for yaw_deg in [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 12.0, 12.1, 12.2, 12.3, 12.4] {
            let now = pose(yaw_deg);
            updates.push(history.plan(&strokes, &view(previous, now), STEP, None).is_update);
            previous = now;
        }
        assert_eq!(updates, [true, false, false, false, true, false, true, false, false, false, true]);
    }

    #[test]
    fn a_turn_updates_when_a_strip_comes_into_view() {
        for (px, every) in [(2.0, 1), (1.0, 2), (0.4, 4)] {
            let (mut history, strokes) = (History::default(), strokes(10, true));
            let mut previous = pose(0.0);
            let updates = (0..=12).filter(|frame| {
                let now = Pose { position_m: DVec3::ZERO, ..pose((f64::from(*frame) * px / FOCAL_PX).to_degrees()) };
                let view = view(std::mem::replace(&mut previous, now), now);
                assert!((view.focal_px() - FOCAL_PX).abs() < 1.0, "{}", view.focal_px());
                history.plan(&strokes, &view, STEP, None).is_update
            });
            assert_eq!(updates.count(), 1 + 12 / every, "{px} px per frame");
        }
    }

    #[test]
    fn a_head_that_rolls_brings_the_ends_of_the_sides_into_view() {
        // 64 pixels wide: a roll by 1.6 pixels at the ends of the longer sides, of which the middle moves by nothing.
        for (px, every) in [(1.6, 1), (0.8, 2)] {
            let (mut history, strokes) = (History::default(), strokes(10, true));
            let mut previous = pose(0.0);
            let updates = (0..=12).filter(|frame| {
                let roll = DQuat::from_axis_angle(DVec3::Y, f64::from(*frame) * px / 32.0);
                let now = Pose { right: roll * DVec3::X, up: roll * DVec3::Z, ..pose(0.0) };
                let view = view(std::mem::replace(&mut previous, now), now);
                history.plan(&strokes, &view, STEP, None).is_update
            });
            assert_eq!(updates.count(), 1 + 12 / every, "{px} px per frame");
        }
    }

    #[test]
    fn a_turn_updates_no_more_often_than_the_pause_allows() {
        // A headset's frames and a turn of 60 degrees in a second.
        let (step_s, turn_deg) = (1.0 / 90.0, 60.0 / 90.0);
        for (pause_s, rebuild_ms, every) in [(0.0, 0.0, 1), (2.0 / 90.0, 0.0, 2), (0.0, 1000.0 / 30.0, 3)] {
            let (mut history, mut strokes) = (History::default(), strokes(10, true));
            strokes.rebuild_ms = rebuild_ms;
            let mut previous = pose(0.0);
            let mut updates = Vec::new();
            for frame in 0..=12 {
                let now = Pose { position_m: DVec3::ZERO, ..pose(f64::from(frame) * turn_deg) };
                let view = View::whole(std::mem::replace(&mut previous, now), now, [640, 360]);
                let step = Step { step_s, pause_s, ..STEP };
                updates.push(history.plan(&strokes, &view, step, None).is_update);
            }
            let expected: Vec<bool> = (0..=12).map(|frame| frame % every == 0).collect();
            assert_eq!(updates, expected, "{pause_s} {rebuild_ms}");
        }
    }

    #[test]
    fn a_quick_move_updates_and_a_far_one_does_not() {
        let strokes = strokes(100, true);
        for (nearest_m, updates) in [(10.0, true), (1000.0, false)] {
            let mut history = History::default();
            history.plan(&strokes, &view(pose(0.0), pose(0.0)), STEP, None);
            let step = Step { nearest_m, ..STEP };
            assert_eq!(history.plan(&strokes, &view(pose(0.0), pose(1.0)), step, None).is_update, updates);
        }
    }

    #[test]
    fn a_rest_begins_with_an_update() {
        let (mut history, strokes) = (History::default(), strokes(4, true));
        history.plan(&strokes, &view(pose(0.0), pose(0.0)), STEP, None);
        history.plan(&strokes, &view(pose(0.0), pose(1.0)), STEP, None);
        let mut updates = Vec::new();
        while history.is_settling() && updates.len() < 1000 {
            updates.push(history.plan(&strokes, &view(pose(1.0), pose(1.0)), STEP, None).is_update);
        }
        assert!((10..30).contains(&updates.len()) && updates[0], "{updates:?}");
        // However long a frame takes, strokes come and go in several frames.
        let slow = Step { step_s: 100.0, ..STEP };
        history.plan(&strokes, &view(pose(1.0), pose(1.1)), slow, None);
        let mut frames = 0;
        while history.is_settling() && frames < 1000 {
            let is_update = history.plan(&strokes, &view(pose(1.1), pose(1.1)), slow, None).is_update;
            assert!(frames > 0 || is_update);
            frames += 1;
        }
        assert!((3..6).contains(&frames), "{frames}");
    }

    #[test]
    fn samples_of_a_picture_keep_its_strokes() {
        let (mut history, strokes) = (History::default(), strokes(4, true));
        history.plan(&strokes, &view(pose(0.0), pose(0.0)), STEP, None);
        let mut again = |step_s| {
            let step = Step { step_s, ..STEP };
            (0..9).filter(|_| history.plan(&strokes, &view(pose(0.0), pose(0.0)), step, None).is_update).count()
        };
        assert_eq!(again(0.0), 0);
        assert_eq!(again(0.1), 2, "planted error: time passes");
    }

    #[test]
    fn land_that_changes_at_rest_settles_again() {
        let (mut history, strokes) = (History::default(), strokes(1, true));
        let mut rest = |land_changes| {
            history.plan(&strokes, &view(pose(0.0), pose(0.0)), Step { land_changes, ..STEP }, None);
            history.is_settling()
        };
        (0..100).for_each(|_| _ = rest(false));
        assert!(!rest(false));
        // A tile arrives: its strokes have to grow, for as long as others do.
        assert!(rest(true));
        let frames = (0..1000).take_while(|_| rest(false)).count();
        assert!((5..30).contains(&frames), "{frames}");
    }

    #[test]
    fn a_frame_that_does_not_continue_the_last_one_takes_nothing_over() {
        let (mut history, strokes) = (History::default(), strokes(1, true));
        assert!(!history.plan(&strokes, &view(pose(0.0), pose(0.0)), STEP, None).takes_over);
        let step = Step { origin_m: DVec3::X, ..STEP };
        let next = history.plan(&strokes, &view(pose(0.0), pose(1.0)), step, None);
        assert!(next.takes_over && next.step_m == DVec3::X * -1.0);
        // Another camera's frame was drawn in between.
        assert!(!history.plan(&strokes, &view(pose(9.0), pose(2.0)), STEP, None).takes_over);
        // A cut.
        assert!(!history.plan(&strokes, &view(pose(2.0), pose(80.0)), STEP, None).takes_over);
        // Another part of the picture.
        let part = Part { origin_px: [64, 0], size_px: [64, 36] };
        assert!(!history.plan(&strokes, &View { part, ..view(pose(80.0), pose(80.0)) }, STEP, None).takes_over);
        history.forget();
        assert!(!history.plan(&strokes, &view(pose(80.0), pose(80.0)), STEP, None).takes_over);
    }
}
