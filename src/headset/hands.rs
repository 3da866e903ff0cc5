//! Input of the controllers: the OpenXR actions, and the suggested bindings of each controller.

use glam::DVec2;
use openxr as xr;

use super::error::{During, HeadsetError};
use super::travel::HandInput;

/// An action of the flight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FlightAction {
    Fly,
    Turn,
    Ahead,
    Fast,
    NextStyle,
    Scale,
    Reset,
}

/// Suggested bindings by interaction profile. A runtime that does not know one of them still accepts the others.
const CONTROLLERS: [(&str, &[(FlightAction, &str)]); 5] = [
    (
        "/interaction_profiles/khr/simple_controller",
        &[
            (FlightAction::Ahead, "/user/hand/left/input/select/click"),
            (FlightAction::Reset, "/user/hand/left/input/menu/click"),
            (FlightAction::NextStyle, "/user/hand/right/input/select/click"),
            (FlightAction::Scale, "/user/hand/right/input/menu/click"),
        ],
    ),
    (
        "/interaction_profiles/oculus/touch_controller",
        &[
            (FlightAction::Fly, "/user/hand/left/input/thumbstick"),
            (FlightAction::Turn, "/user/hand/right/input/thumbstick"),
            (FlightAction::Fast, "/user/hand/left/input/squeeze/value"),
            (FlightAction::Reset, "/user/hand/left/input/x/click"),
            (FlightAction::Scale, "/user/hand/right/input/a/click"),
            (FlightAction::NextStyle, "/user/hand/right/input/b/click"),
        ],
    ),
    (
        "/interaction_profiles/valve/index_controller",
        &[
            (FlightAction::Fly, "/user/hand/left/input/thumbstick"),
            (FlightAction::Turn, "/user/hand/right/input/thumbstick"),
            (FlightAction::Fast, "/user/hand/left/input/squeeze/value"),
            (FlightAction::Reset, "/user/hand/left/input/a/click"),
            (FlightAction::Scale, "/user/hand/right/input/a/click"),
            (FlightAction::NextStyle, "/user/hand/right/input/b/click"),
        ],
    ),
    (
        "/interaction_profiles/microsoft/motion_controller",
        &[
            (FlightAction::Fly, "/user/hand/left/input/thumbstick"),
            (FlightAction::Turn, "/user/hand/right/input/thumbstick"),
            (FlightAction::Fast, "/user/hand/left/input/squeeze/click"),
            (FlightAction::Reset, "/user/hand/left/input/menu/click"),
            (FlightAction::Scale, "/user/hand/right/input/squeeze/click"),
            (FlightAction::NextStyle, "/user/hand/right/input/menu/click"),
        ],
    ),
    (
        "/interaction_profiles/htc/vive_controller",
        &[
            (FlightAction::Fly, "/user/hand/left/input/trackpad"),
            (FlightAction::Turn, "/user/hand/right/input/trackpad"),
            (FlightAction::Fast, "/user/hand/left/input/squeeze/click"),
            (FlightAction::Reset, "/user/hand/left/input/menu/click"),
            (FlightAction::Scale, "/user/hand/right/input/squeeze/click"),
            (FlightAction::NextStyle, "/user/hand/right/input/menu/click"),
        ],
    ),
];

/// The OpenXR actions of both hands.
pub(super) struct Hands {
    set: xr::ActionSet,
    fly: xr::Action<xr::Vector2f>,
    turn: xr::Action<xr::Vector2f>,
    ahead: xr::Action<bool>,
    fast: xr::Action<bool>,
    next_style: xr::Action<bool>,
    scale: xr::Action<bool>,
    reset: xr::Action<bool>,
}

impl Hands {
    /// Creates the actions, suggests bindings for them, and attaches them to the session permanently.
    ///
    /// # Errors
    /// Returns the error of the runtime.
    pub(super) fn new(instance: &xr::Instance, session: &xr::Session<xr::Vulkan>) -> Result<Self, HeadsetError> {
        let set = instance.create_action_set("flight", "Flight", 0).during("xrCreateActionSet")?;
        let stick = |name: &str, description: &str| set.create_action(name, description, &[]).during("xrCreateAction");
        let button = |name: &str, description: &str| set.create_action(name, description, &[]).during("xrCreateAction");
        let hands = Self {
            fly: stick("fly", "Fly forward and sideways")?,
            turn: stick("turn_and_lift", "Turn, move up and down")?,
            ahead: button("ahead", "Fly forward")?,
            fast: button("fast", "Fly faster")?,
            next_style: button("next_style", "Next style")?,
            scale: button("scale", "Switch between giant and person")?,
            reset: button("reset", "Return to the start")?,
            set: set.clone(),
        };
        for (profile, controls) in CONTROLLERS {
            if let Err(error) = hands.suggest(instance, profile, controls) {
                tracing::warn!("the OpenXR runtime does not accept the bindings of {profile}: {error}");
            }
        }
        session.attach_action_sets(&[&hands.set]).during("xrAttachSessionActionSets")?;
        Ok(hands)
    }

    fn suggest(&self, instance: &xr::Instance, profile: &str, controls: &[(FlightAction, &str)]) -> xr::Result<()> {
        let mut bindings = Vec::with_capacity(controls.len());
        for (action, control) in controls {
            let path = instance.string_to_path(control)?;
            bindings.push(match action {
                FlightAction::Fly => xr::Binding::new(&self.fly, path),
                FlightAction::Turn => xr::Binding::new(&self.turn, path),
                FlightAction::Ahead => xr::Binding::new(&self.ahead, path),
                FlightAction::Fast => xr::Binding::new(&self.fast, path),
                FlightAction::NextStyle => xr::Binding::new(&self.next_style, path),
                FlightAction::Scale => xr::Binding::new(&self.scale, path),
                FlightAction::Reset => xr::Binding::new(&self.reset, path),
            });
        }
        instance.suggest_interaction_profile_bindings(instance.string_to_path(profile)?, &bindings)
    }

    /// Returns the present input. A session without focus receives none.
    ///
    /// # Errors
    /// Returns the error of the runtime.
    pub(super) fn read(&self, session: &xr::Session<xr::Vulkan>) -> Result<HandInput, HeadsetError> {
        session.sync_actions(&[(&self.set).into()]).during("xrSyncActions")?;
        let stick = |action: &xr::Action<xr::Vector2f>| {
            let state = action.state(session, xr::Path::NULL).during("xrGetActionStateVector2f")?;
            let push = DVec2::new(state.current_state.x.into(), state.current_state.y.into());
            Ok::<_, HeadsetError>(if state.is_active && push.is_finite() { push } else { DVec2::ZERO })
        };
        let button = |action: &xr::Action<bool>| {
            let state = action.state(session, xr::Path::NULL).during("xrGetActionStateBoolean")?;
            let is_down = state.is_active && state.current_state;
            // Whether the button is held, and whether it was pressed in this frame.
            Ok::<_, HeadsetError>((is_down, is_down && state.changed_since_last_sync))
        };
        let ahead = if button(&self.ahead)?.0 { DVec2::Y } else { DVec2::ZERO };
        Ok(HandInput {
            left_stick: (stick(&self.fly)? + ahead).clamp(DVec2::NEG_ONE, DVec2::ONE),
            right_stick: stick(&self.turn)?,
            fast: button(&self.fast)?.0,
            next_style: button(&self.next_style)?.1,
            switch_scale: button(&self.scale)?.1,
            reset: button(&self.reset)?.1,
        })
    }
}
