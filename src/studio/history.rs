//! The steps of a document that can be undone and redone.
//!
//! A step holds the whole text before it: styles have a few thousand bytes, so that 200 steps need less than a megabyte,
//! and undoing is exact, comments included. Of long camera paths fewer steps are kept.
//!
//! Each step has a number in one order of time over all histories ([`next_turn`]), so that the last change among
//! several histories can be undone.

use std::sync::atomic::{AtomicU64, Ordering};

/// Largest number of steps that can be undone; the oldest is dropped.
const MAX_STEPS: usize = 200;
/// Largest number of bytes of the texts of all steps that can be undone; the last step is kept anyway.
const MAX_BYTES: usize = 64 << 20;

/// Returns a number that is greater than all before it.
pub(crate) fn next_turn() -> u64 {
    static TURN: AtomicU64 = AtomicU64::new(0);
    TURN.fetch_add(1, Ordering::Relaxed)
}

/// The turn and the name of a step.
pub(crate) type StepName<'a> = (u64, &'a str);

/// A step that can be undone or redone.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Step {
    /// Name of the step, as the buttons show it.
    name: String,
    /// The key that it changes, if it changes only one.
    key: Option<String>,
    /// Position of the last change, undo or redo of the step in the order of all histories ([`next_turn`]).
    turn: u64,
    /// The text on the other side of the step: before it if it can be undone, after it if it can be redone.
    text: String,
}

/// The steps of a document.
#[derive(Clone, Debug, Default)]
pub(super) struct History {
    undo: Vec<Step>,
    redo: Vec<Step>,
    /// Whether further changes of the same key belong to the last step, because the mouse is still held.
    is_open: bool,
}

impl History {
    /// Records a change. `before` is the text before it. A change of the key of an open step continues that step.
    pub(super) fn record(&mut self, name: String, key: Option<&str>, before: &str) {
        self.redo.clear();
        if self.is_open
            && key.is_some()
            && let Some(last) = self.undo.last_mut().filter(|last| last.key.as_deref() == key)
        {
            (last.name, last.turn) = (name, next_turn());
            return;
        }
        self.undo.push(Step { name, key: key.map(str::to_owned), turn: next_turn(), text: before.to_owned() });
        let mut bytes: usize = self.undo.iter().map(|step| step.text.len()).sum();
        while self.undo.len() > MAX_STEPS || bytes > MAX_BYTES && self.undo.len() > 1 {
            bytes -= self.undo.remove(0).text.len();
        }
        self.is_open = key.is_some();
    }

    /// Ends the open step. A step that has changed nothing in the end is forgotten; `now` is the current text.
    pub(super) fn close(&mut self, now: &str) {
        if std::mem::take(&mut self.is_open) && self.undo.last().is_some_and(|last| last.text == now) {
            self.undo.pop();
        }
    }

    /// Undoes the last step: returns its name and the text before it. `now` is the current text.
    pub(super) fn undo(&mut self, now: &str) -> Option<(String, String)> {
        self.close(now);
        take(&mut self.undo, &mut self.redo, now)
    }

    /// Repeats the step that was undone last: returns its name and the text after it.
    pub(super) fn redo(&mut self, now: &str) -> Option<(String, String)> {
        self.close(now);
        take(&mut self.redo, &mut self.undo, now)
    }

    /// Returns the number of steps that can be undone.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.undo.len()
    }

    /// Returns the steps that [`History::undo`] and [`History::redo`] would take.
    pub(super) fn steps(&self) -> [Option<StepName<'_>>; 2] {
        [&self.undo, &self.redo].map(|steps| steps.last().map(|step| (step.turn, step.name.as_str())))
    }

    /// Returns the names of the steps that [`History::undo`] and [`History::redo`] would take.
    pub(super) fn names(&self) -> [Option<&str>; 2] {
        self.steps().map(|step| step.map(|(_, name)| name))
    }
}

fn take(from: &mut Vec<Step>, to: &mut Vec<Step>, now: &str) -> Option<(String, String)> {
    let Step { name, key, text, .. } = from.pop()?;
    to.push(Step { name: name.clone(), key, turn: next_turn(), text: now.to_owned() });
    Some((name, text))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drag_is_one_step() {
        let mut history = History::default();
        for (before, name) in [("0", "a 1"), ("1", "a 2"), ("2", "a 3")] {
            history.record(name.to_owned(), Some("a"), before);
        }
        history.close("3");
        history.record("a 4".to_owned(), Some("a"), "3");
        // Another key ends a drag that nobody has ended.
        history.record("b 1".to_owned(), Some("b"), "4");
        let mut now = "5".to_owned();
        let mut steps = Vec::new();
        while let Some((name, text)) = history.undo(&now) {
            now.clone_from(&text);
            steps.push((name, text));
        }
        let wanted = [("b 1", "4"), ("a 4", "3"), ("a 3", "0")].map(|(name, text)| (name.to_owned(), text.to_owned()));
        assert_eq!(steps, wanted);
        assert_eq!(history.redo(&now), Some(("a 3".to_owned(), "3".to_owned())));
        // A new change ends what could be redone.
        history.record("c".to_owned(), None, "3");
        assert_eq!(history.names(), [Some("c"), None]);
    }

    #[test]
    fn a_drag_back_to_its_start_is_no_step() {
        let mut history = History::default();
        history.record("a 1".to_owned(), Some("a"), "0");
        history.record("a 0".to_owned(), Some("a"), "1");
        history.close("0");
        assert_eq!(history.names(), [None, None]);
        // One that changes something stays, and the oldest steps are dropped.
        (0..300).for_each(|step| history.record(step.to_string(), None, &step.to_string()));
        let count = std::iter::from_fn(|| history.undo("x")).count();
        assert_eq!(count, MAX_STEPS);
        // Long texts are bounded by their bytes.
        let long = "x".repeat(MAX_BYTES / 4);
        (0..9).for_each(|step| history.record(step.to_string(), None, &long));
        let names: Vec<String> = std::iter::from_fn(|| history.undo("x")).map(|(name, _)| name).collect();
        assert_eq!(names, ["8", "7", "6", "5"]);
    }
}
