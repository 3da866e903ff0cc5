//! Moves the five controls of a style: a position of a control becomes values of parameters in the text.

use std::collections::BTreeMap;

use super::document::StyleDocument;
use super::rows::{Section, sections};
use crate::style::controls::{Amount, Control, Driven, bare, moved, position, rules};
use crate::style::parameters::set_all;
use crate::style::{Style, StyleError};

/// The controls of a document.
#[derive(Clone, Debug, Default)]
pub(super) struct Controls {
    /// The saved style: at the position 0 of a control, each parameter has its value in it.
    saved: Option<Saved>,
    /// The position of each control.
    positions: [i8; 5],
    /// The drag of a control that has not ended.
    grip: Option<Grip>,
}

/// The style that is saved.
#[derive(Clone, Debug)]
struct Saved {
    text: String,
    style: Style,
    /// The values of its parameters by their keys.
    amounts: BTreeMap<String, Amount>,
}

/// The start of a drag. All positions of a drag are applied to the text at its start, so that a drag back to the start
/// changes nothing, even where values were clamped.
#[derive(Clone, Debug)]
struct Grip {
    control: Control,
    from: i8,
    text: String,
    driven: Vec<Driven>,
}

impl Controls {
    /// Ends a drag.
    pub(super) fn release(&mut self) {
        self.grip = None;
    }
}

impl StyleDocument {
    /// Returns the position of a control, from −100 to 100; 0 is the style as it is saved.
    pub(crate) fn control(&self, control: Control) -> i8 {
        self.controls.positions[control as usize]
    }

    /// Moves a control. While the mouse is held, further positions of the same control belong to the same step.
    ///
    /// # Errors
    /// The style would not be valid; then nothing changes.
    pub(crate) fn set_control(&mut self, control: Control, to: i8) -> Result<(), StyleError> {
        self.read_saved();
        let held = self.controls.grip.take().filter(|grip| grip.control == control);
        let grip = held.unwrap_or_else(|| Grip {
            control,
            from: self.control(control),
            text: self.text().to_owned(),
            driven: self.driven(control),
        });
        let changes = moved(&grip.driven, grip.from, to);
        let mut text = set_all::<Style>(self.name(), &grip.text, changes)?;
        if let Some(saved) = &self.controls.saved
            && text != saved.text
            && self.parsed_edit(&text)? == saved.style
        {
            // Keys that only the control has added disappear again.
            text.clone_from(&saved.text);
        }
        if text != self.text() {
            self.controls.positions[control as usize] = to;
            self.change(text, Some(control.name()), |document| {
                format!("{}: {:+}", control.name(), document.control(control))
            })?;
        }
        self.controls.grip = Some(grip);
        Ok(())
    }

    /// Finds the positions of all controls again, because the style has changed.
    pub(super) fn find_positions(&mut self) {
        self.controls.grip = None;
        self.read_saved();
        for control in Control::ALL {
            let expected = self.control(control);
            self.controls.positions[control as usize] = position(&self.driven(control), expected);
        }
    }

    /// Reads what is saved, if it has changed.
    fn read_saved(&mut self) {
        let saved = self.saved_text();
        if self.controls.saved.as_ref().is_some_and(|known| known.text == saved) {
            return;
        }
        let text = saved.to_owned();
        // The saved style is valid, unless a recipe has disappeared since; then there is no position 0.
        self.controls.saved = self.parsed_edit(&text).ok().map(|style| {
            let amounts = amounts(&sections(&style)).collect();
            Saved { text, style, amounts }
        });
    }

    /// Returns the parameters that follow a control.
    fn driven(&self, control: Control) -> Vec<Driven> {
        let mut all = Vec::new();
        for rule in rules(control, self.style()) {
            for row in self.sections().iter().flat_map(|section| &section.rows) {
                if row.without_effect.is_some() || bare(&row.key) != rule.key {
                    continue;
                }
                let Some(now) = row.value.as_ref().and_then(Amount::of) else { continue };
                let base = self.controls.saved.as_ref().and_then(|saved| saved.amounts.get(&row.key)).cloned();
                let (key, definition) = (row.key.clone(), row.definition.clone());
                all.push(Driven { key, rule, definition, base, now });
            }
        }
        all
    }
}

/// Returns the values of the parameters that may follow a control, by their keys.
fn amounts(sections: &[Section]) -> impl Iterator<Item = (String, Amount)> {
    let rows = sections.iter().flat_map(|section| &section.rows);
    rows.filter_map(|row| Some((row.key.clone(), Amount::of(row.value.as_ref()?)?)))
}
