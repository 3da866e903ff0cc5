//! The work of a governor during a flight, for a report.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// A flight whose frames had a budget.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct GovernedRun {
    /// Time that a frame may take.
    pub budget_ms: f64,
    /// Share of the frames after the first second that were within it; null if there were none.
    pub held: Option<f64>,
    /// Changes of the setting, in the order of time.
    pub changes: Vec<SettingChange>,
    /// The settings, from the cheapest to the most expensive.
    pub steps: Vec<GovernedStep>,
}

/// A change of the setting.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct SettingChange {
    /// Time on the camera path.
    pub t_s: f64,
    /// Index of the setting before.
    pub from: usize,
    /// Index of the setting after.
    pub to: usize,
    /// `panic` (frames were over the budget, or about to be), `close` (their mean was close to it) or `room` (there was
    /// room for the next setting).
    pub reason: String,
}

/// A setting, and how many frames had it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct GovernedStep {
    /// The values of the setting by their keys; none for the style as it is.
    pub set: BTreeMap<String, String>,
    pub frames: u64,
}

impl GovernedRun {
    /// Returns a sentence about the run.
    pub(crate) fn text(&self) -> String {
        let budget_ms = self.budget_ms;
        let held = self.held.map_or_else(
            || "the flight ended within the first second, of which no frame counts".to_owned(),
            |held| format!("{:.1} % of the frames within {budget_ms} ms after the first second", 100.0 * held),
        );
        let used: Vec<String> = self
            .steps
            .iter()
            .filter(|step| step.frames > 0)
            .map(|step| {
                let set: Vec<String> = step.set.iter().map(|(key, value)| format!("{key}={value}")).collect();
                let set = if set.is_empty() { "as it is".to_owned() } else { set.join(" ") };
                format!("{} frames with {set}", step.frames)
            })
            .collect();
        let changes = match self.changes.len() {
            1 => "1 change".to_owned(),
            count => format!("{count} changes"),
        };
        format!("{held}, {changes}: {}", used.join(", "))
    }
}
