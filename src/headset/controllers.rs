//! The functions of the controls of each kind of controller: one table for the suggested bindings and for the page that
//! explains them.

/// An action of the flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum FlightAction {
    Fly,
    Turn,
    Ahead,
    Fast,
    Styles,
    Adjust,
    Scale,
    NextStyle,
    Reset,
    Help,
    /// A press and a hold of the same button, for controllers with few buttons.
    NextOrStyles,
    ScaleOrAdjust,
    ResetOrHelp,
}

impl FlightAction {
    pub(super) const ALL: [Self; 13] = [
        Self::Fly,
        Self::Turn,
        Self::Ahead,
        Self::Fast,
        Self::Styles,
        Self::Adjust,
        Self::Scale,
        Self::NextStyle,
        Self::Reset,
        Self::Help,
        Self::NextOrStyles,
        Self::ScaleOrAdjust,
        Self::ResetOrHelp,
    ];

    /// Returns whether the action has two axes; all others are buttons.
    pub(super) fn is_stick(self) -> bool {
        matches!(self, Self::Fly | Self::Turn)
    }

    /// Returns the name of the action for the runtime, and the one that it may show to people.
    pub(super) fn names(self) -> [&'static str; 2] {
        match self {
            Self::Fly => ["fly", "Fly forward and sideways"],
            Self::Turn => ["turn_and_lift", "Turn, move up and down"],
            Self::Ahead => ["ahead", "Fly forward"],
            Self::Fast => ["fast", "Fly faster"],
            Self::Styles => ["styles", "Choose a style while held"],
            Self::Adjust => ["adjust", "Adjust the style while held"],
            Self::Scale => ["scale", "Switch between giant and person"],
            Self::NextStyle => ["next_style", "Next style"],
            Self::Reset => ["reset", "Return to the start"],
            Self::Help => ["help", "Show or hide the controls"],
            Self::NextOrStyles => ["next_or_styles", "Next style; choose a style while held"],
            Self::ScaleOrAdjust => ["scale_or_adjust", "Switch the scale; adjust the style while held"],
            Self::ResetOrHelp => ["reset_or_help", "Return to the start; show the controls if held"],
        }
    }

    /// Returns the description of the action, for the panel.
    pub(super) fn does(self) -> &'static str {
        match self {
            Self::Fly | Self::Ahead => "Fly where you look",
            Self::Turn => "Turn, rise and sink",
            Self::Fast => "Fly faster",
            Self::Styles => "Hold: choose a style",
            Self::Adjust => "Hold: adjust the style",
            Self::Scale => "Giant or person",
            Self::NextStyle => "Next style",
            Self::Reset => "Back to the start",
            Self::Help => "Show or hide this",
            Self::NextOrStyles => "Next style; hold: list",
            Self::ScaleOrAdjust => "Giant; hold: adjust",
            Self::ResetOrHelp => "To start; hold: this",
        }
    }
}

/// A kind of controller.
#[derive(Clone, Copy, Debug)]
pub(super) struct Controller {
    /// The interaction profile of OpenXR.
    pub profile: &'static str,
    /// Action, path of the control, and the name that people know.
    pub controls: &'static [(FlightAction, &'static str, &'static str)],
}

impl Controller {
    /// Returns the controller with an interaction profile. An unknown profile, or `None`, gives the most common
    /// controller.
    pub(super) fn of(profile: Option<&str>) -> &'static Self {
        CONTROLLERS.iter().find(|known| Some(known.profile) == profile).unwrap_or(&CONTROLLERS[0])
    }

    /// Returns whether the controller has sticks or trackpads.
    pub(super) fn has_sticks(&self) -> bool {
        self.controls.iter().any(|(action, ..)| action.is_stick())
    }

    /// Returns the controls with their actions.
    pub(super) fn rows(&self) -> Vec<[String; 2]> {
        self.controls.iter().map(|(action, _, name)| [(*name).to_owned(), action.does().to_owned()]).collect()
    }
}

use FlightAction as A;

/// All controllers. A runtime that does not know one of them still accepts the others.
pub(super) const CONTROLLERS: [Controller; 5] = [
    Controller {
        profile: "/interaction_profiles/oculus/touch_controller",
        controls: &[
            (A::Fly, "/user/hand/left/input/thumbstick", "Left stick"),
            (A::Turn, "/user/hand/right/input/thumbstick", "Right stick"),
            (A::Fast, "/user/hand/left/input/squeeze/value", "Left grip"),
            (A::Styles, "/user/hand/right/input/trigger/value", "Right trigger"),
            (A::Adjust, "/user/hand/left/input/trigger/value", "Left trigger"),
            (A::Scale, "/user/hand/right/input/a/click", "A"),
            (A::NextStyle, "/user/hand/right/input/b/click", "B"),
            (A::Reset, "/user/hand/left/input/x/click", "X"),
            (A::Help, "/user/hand/left/input/y/click", "Y"),
        ],
    },
    Controller {
        profile: "/interaction_profiles/valve/index_controller",
        controls: &[
            (A::Fly, "/user/hand/left/input/thumbstick", "Left stick"),
            (A::Turn, "/user/hand/right/input/thumbstick", "Right stick"),
            (A::Fast, "/user/hand/left/input/squeeze/value", "Left grip"),
            (A::Styles, "/user/hand/right/input/trigger/value", "Right trigger"),
            (A::Adjust, "/user/hand/left/input/trigger/value", "Left trigger"),
            (A::Scale, "/user/hand/right/input/a/click", "Right A"),
            (A::NextStyle, "/user/hand/right/input/b/click", "Right B"),
            (A::Reset, "/user/hand/left/input/a/click", "Left A"),
            (A::Help, "/user/hand/left/input/b/click", "Left B"),
        ],
    },
    Controller {
        profile: "/interaction_profiles/microsoft/motion_controller",
        controls: &[
            (A::Fly, "/user/hand/left/input/thumbstick", "Left stick"),
            (A::Turn, "/user/hand/right/input/thumbstick", "Right stick"),
            (A::Fast, "/user/hand/left/input/squeeze/click", "Left grip"),
            (A::Styles, "/user/hand/right/input/trigger/value", "Right trigger"),
            (A::Adjust, "/user/hand/left/input/trigger/value", "Left trigger"),
            (A::Scale, "/user/hand/right/input/squeeze/click", "Right grip"),
            (A::NextStyle, "/user/hand/right/input/menu/click", "Right menu"),
            (A::Reset, "/user/hand/left/input/menu/click", "Left menu"),
            (A::Help, "/user/hand/left/input/trackpad/click", "Left trackpad"),
        ],
    },
    Controller {
        profile: "/interaction_profiles/htc/vive_controller",
        controls: &[
            (A::Fly, "/user/hand/left/input/trackpad", "Left pad"),
            (A::Turn, "/user/hand/right/input/trackpad", "Right pad"),
            (A::Fast, "/user/hand/left/input/squeeze/click", "Left grip"),
            (A::Styles, "/user/hand/right/input/trigger/value", "Right trigger"),
            (A::Adjust, "/user/hand/left/input/trigger/value", "Left trigger"),
            (A::Scale, "/user/hand/right/input/squeeze/click", "Right grip"),
            (A::NextStyle, "/user/hand/right/input/menu/click", "Right menu"),
            (A::Reset, "/user/hand/left/input/menu/click", "Left menu"),
            (A::Help, "/user/hand/left/input/trackpad/click", "Press left pad"),
        ],
    },
    Controller {
        profile: "/interaction_profiles/khr/simple_controller",
        controls: &[
            (A::Ahead, "/user/hand/left/input/select/click", "Left select"),
            (A::NextOrStyles, "/user/hand/right/input/select/click", "Right select"),
            (A::ScaleOrAdjust, "/user/hand/right/input/menu/click", "Right menu"),
            (A::ResetOrHelp, "/user/hand/left/input/menu/click", "Left menu"),
        ],
    },
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_controller_does_everything() {
        for controller in CONTROLLERS {
            let has = |any: &[A]| any.iter().any(|it| controller.controls.iter().any(|(action, ..)| action == it));
            for any in [
                &[A::Fly, A::Ahead][..],
                &[A::Styles, A::NextOrStyles],
                &[A::Adjust, A::ScaleOrAdjust],
                &[A::Help, A::ResetOrHelp],
                &[A::NextStyle, A::NextOrStyles],
                &[A::Scale, A::ScaleOrAdjust],
                &[A::Reset, A::ResetOrHelp],
            ] {
                assert!(has(any), "{}: {any:?}", controller.profile);
            }
            // No control has two meanings, and no name is used twice.
            for (i, (_, path, name)) in controller.controls.iter().enumerate() {
                let others = &controller.controls[i + 1..];
                assert!(others.iter().all(|(_, other, known)| other != path && known != name), "{path}");
                let hand = path.split('/').nth(3).unwrap_or_default();
                let is_of_other = if hand == "left" { "right" } else { "left" };
                assert!(!name.to_lowercase().contains(is_of_other), "{path} is not {name}");
            }
            assert_eq!(Controller::of(Some(controller.profile)).profile, controller.profile);
            assert!(controller.rows().len() <= crate::headset::panel::ROWS);
        }
        assert_eq!(Controller::of(None).profile, CONTROLLERS[0].profile);
    }
}
