//! Labels that change slowly: a label appears, disappears or moves to another slot at most once per second, and fades.
//!
//! Decisions are made at whole tenths of a second, and opacities depend on the time of the decision and not on the frame
//! that first shows it. So the same flight looks the same at 30, 60 and 90 frames per second, up to a frame.

use std::collections::BTreeMap;

use super::Hold;

/// Time that a label takes to appear or disappear, in seconds.
pub(crate) const FADE_S: f64 = 0.3;
/// Least time between two changes of a label, in seconds. A label that cannot remain where it is may leave sooner.
pub(crate) const CHANGE_S: f64 = 1.0;
/// Decisions per second.
const TICKS_PER_S: f64 = 10.0;
/// Tolerance of comparisons of times, for rounding, in seconds.
const TOLERANCE_S: f64 = 1e-6;

/// The state of all labels that are visible, or were until a short time ago. Labels have numbers that do not change.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Steady {
    labels: BTreeMap<u64, State>,
    /// Time of the frame.
    now_s: f64,
    /// Time of the decision that was made last.
    tick_s: Option<f64>,
}

/// The state of a label.
#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    /// Where the label is, or was.
    slot: usize,
    /// Whether the label disappears, or has.
    is_leaving: bool,
    /// The slot in which the label is to appear again, if it leaves in order to move.
    target: Option<usize>,
    /// When the label began to appear or disappear.
    since_s: f64,
    /// The opacity at that time.
    from: f64,
    /// When the label last changed.
    changed_s: f64,
}

impl State {
    fn opacity(&self, now_s: f64) -> f64 {
        let part = (now_s - self.since_s) / FADE_S;
        if self.is_leaving { (self.from - part).clamp(0.0, 1.0) } else { (self.from + part).clamp(0.0, 1.0) }
    }

    /// Returns whether the label has disappeared.
    fn is_gone(&self, now_s: f64) -> bool {
        self.is_leaving && self.opacity(now_s) * FADE_S < TOLERANCE_S
    }
}

impl Steady {
    /// Begins a frame. Returns the seconds since the frame before, and whether this frame makes decisions. A time before
    /// that of the last frame, as after a jump to another scene, removes all labels at once. A time that is not finite is
    /// that of the last frame.
    pub(crate) fn begin(&mut self, time_s: f64) -> (f64, bool) {
        let now_s = if time_s.is_finite() { time_s } else { self.now_s };
        if now_s < self.now_s {
            *self = Self::default();
        }
        let passed_s = if self.tick_s.is_some() { now_s - self.now_s } else { 0.0 };
        self.now_s = now_s;
        self.labels.retain(|_, state| !state.is_gone(now_s) || now_s - state.changed_s < CHANGE_S);
        let tick_s = ((now_s + TOLERANCE_S) * TICKS_PER_S).floor() / TICKS_PER_S;
        let is_due = self.tick_s.is_none_or(|last_s| tick_s > last_s + TOLERANCE_S);
        if is_due {
            self.tick_s = Some(tick_s);
        }
        (passed_s, is_due)
    }

    /// Returns the time of the decisions of this frame.
    fn decision_s(&self) -> f64 {
        self.tick_s.map_or(self.now_s, |tick_s| tick_s.min(self.now_s))
    }

    /// Returns what the state of a label requires of the next layout.
    pub(crate) fn hold(&self, id: u64) -> Hold {
        let Some(state) = self.labels.get(&id) else { return Hold::Free };
        let is_locked = self.decision_s() - state.changed_s < CHANGE_S - TOLERANCE_S;
        match (state.is_leaving, state.target) {
            (false, _) if is_locked => Hold::Fixed(state.slot),
            (false, _) => Hold::Kept(state.slot),
            (true, Some(target)) => Hold::Kept(target),
            (true, None) if is_locked => Hold::Out,
            (true, None) => Hold::Free,
        }
    }

    /// Returns the slot of a label that is visible and does not disappear.
    pub(crate) fn slot(&self, id: u64) -> Option<usize> {
        self.labels.get(&id).filter(|state| !state.is_leaving).map(|state| state.slot)
    }

    /// Returns the slot and opacity of a label that is visible, or begins to be.
    pub(crate) fn visible(&self, id: u64) -> Option<(usize, f64)> {
        let state = self.labels.get(&id).filter(|state| !state.is_gone(self.now_s))?;
        Some((state.slot, state.opacity(self.now_s)))
    }

    /// Lets a label disappear because its summit is no longer visible.
    pub(crate) fn hide(&mut self, id: u64) {
        let now_s = self.now_s;
        self.leave(id, None, now_s);
    }

    /// Follows the layout: a label that it leaves out, or places in another slot, begins to disappear.
    pub(crate) fn follow(&mut self, id: u64, wanted: Option<usize>) {
        let tick_s = self.decision_s();
        match self.labels.get_mut(&id) {
            // The layout gave up the move, or moves the label elsewhere.
            Some(state) if state.is_leaving && state.target.is_some() => state.target = wanted,
            Some(state) if !state.is_leaving && wanted != Some(state.slot) => self.leave(id, wanted, tick_s),
            _ => {}
        }
    }

    fn leave(&mut self, id: u64, target: Option<usize>, at_s: f64) {
        let Some(state) = self.labels.get_mut(&id) else { return };
        if state.is_leaving {
            // What cannot be seen does not move.
            state.target = target.and(state.target);
            return;
        }
        let from = state.opacity(at_s);
        *state = State { is_leaving: true, target, since_s: at_s, from, changed_s: at_s, ..*state };
    }

    /// Returns whether a label that is not visible may appear.
    pub(crate) fn may_appear(&self, id: u64) -> bool {
        let is_gone = self.labels.get(&id).is_none_or(|state| state.is_gone(self.decision_s()));
        is_gone && self.hold(id) != Hold::Out
    }

    /// Lets a label appear in a slot.
    pub(crate) fn appear(&mut self, id: u64, slot: usize) {
        let at_s = self.decision_s();
        let state = State { slot, is_leaving: false, target: None, since_s: at_s, from: 0.0, changed_s: at_s };
        self.labels.insert(id, state);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_fade_and_are_locked_for_a_second() {
        let mut steady = Steady::default();
        assert_eq!(steady.begin(5.0), (0.0, true));
        steady.appear(7, 2);
        assert_eq!(steady.hold(7), Hold::Fixed(2));
        assert_eq!(steady.visible(7), Some((2, 0.0)));
        assert!(!steady.begin(5.05).1);
        steady.begin(5.15);
        assert!((steady.visible(7).unwrap().1 - 0.5).abs() < 1e-9);
        steady.begin(5.9);
        assert_eq!((steady.hold(7), steady.visible(7)), (Hold::Fixed(2), Some((2, 1.0))));
        steady.begin(6.0);
        assert_eq!(steady.hold(7), Hold::Kept(2));
        // The label moves: it disappears, and may appear again as soon as it is gone.
        steady.follow(7, Some(1));
        assert_eq!((steady.hold(7), steady.slot(7)), (Hold::Kept(1), None));
        steady.begin(6.2);
        assert!(!steady.may_appear(7));
        steady.begin(6.3);
        assert!(steady.may_appear(7) && steady.visible(7).is_none());
        steady.appear(7, 1);
        // A hidden summit: the label disappears at once, and does not come back before a second has passed.
        steady.begin(6.53);
        steady.hide(7);
        steady.begin(6.63);
        assert!(steady.visible(7).unwrap().1 < 0.5 && steady.hold(7) == Hold::Out);
        steady.begin(7.5);
        assert!(steady.visible(7).is_none() && !steady.may_appear(7));
        steady.begin(7.6);
        assert!(steady.may_appear(7));
        steady.begin(f64::NAN);
        assert_eq!(steady.begin(1.0), (0.0, true));
    }
}
