//! Input of the controllers: the OpenXR actions, and what they mean for the flight and for the panel.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use glam::DVec2;
use openxr as xr;

use super::controllers::{CONTROLLERS, Controller, FlightAction};
use super::error::{During, HeadsetError};
use super::menu::{LongPress, MenuInput};
use super::travel::HandInput;

/// Deflection of a stick that counts as a push.
const PUSH: f64 = 0.5;
/// Interval at which the runtime is queried for the controllers in use.
const ASK: Duration = Duration::from_secs(1);

/// The OpenXR actions of both hands.
pub(super) struct Hands {
    set: xr::ActionSet,
    sticks: BTreeMap<FlightAction, xr::Action<xr::Vector2f>>,
    buttons: BTreeMap<FlightAction, xr::Action<bool>>,
    /// Buttons with two meanings.
    long: [LongPress; 3],
    hands: [xr::Path; 2],
    controller: &'static Controller,
    asked: Option<Instant>,
}

impl Hands {
    /// Creates the actions, suggests bindings for them, and attaches them to the session permanently.
    ///
    /// # Errors
    /// Returns the error of the runtime.
    pub(super) fn new(instance: &xr::Instance, session: &xr::Session<xr::Vulkan>) -> Result<Self, HeadsetError> {
        let set = instance.create_action_set("flight", "Flight", 0).during("xrCreateActionSet")?;
        let (mut sticks, mut buttons) = (BTreeMap::new(), BTreeMap::new());
        for action in FlightAction::ALL {
            let [name, description] = action.names();
            if action.is_stick() {
                sticks.insert(action, set.create_action(name, description, &[]).during("xrCreateAction")?);
            } else {
                buttons.insert(action, set.create_action(name, description, &[]).during("xrCreateAction")?);
            }
        }
        let path = |text| instance.string_to_path(text).during("xrStringToPath");
        let hands = Self {
            set,
            sticks,
            buttons,
            long: [LongPress::default(); 3],
            hands: [path("/user/hand/right")?, path("/user/hand/left")?],
            controller: Controller::of(None),
            asked: None,
        };
        for controller in &CONTROLLERS {
            if let Err(error) = hands.suggest(instance, controller) {
                let profile = controller.profile;
                tracing::warn!("the OpenXR runtime does not accept the bindings of {profile}: {error}");
            }
        }
        session.attach_action_sets(&[&hands.set]).during("xrAttachSessionActionSets")?;
        Ok(hands)
    }

    fn suggest(&self, instance: &xr::Instance, controller: &Controller) -> xr::Result<()> {
        let mut bindings = Vec::with_capacity(controller.controls.len());
        for (action, control, _) in controller.controls {
            let path = instance.string_to_path(control)?;
            bindings.extend(self.sticks.get(action).map(|action| xr::Binding::new(action, path)));
            bindings.extend(self.buttons.get(action).map(|action| xr::Binding::new(action, path)));
        }
        instance.suggest_interaction_profile_bindings(instance.string_to_path(controller.profile)?, &bindings)
    }

    /// Returns the controller in use, or the most common one if the runtime does not say. The runtime is queried once
    /// in a while.
    ///
    /// # Errors
    /// Returns the error of the runtime.
    pub(super) fn controller(
        &mut self,
        instance: &xr::Instance,
        session: &xr::Session<xr::Vulkan>,
    ) -> Result<&'static Controller, HeadsetError> {
        if self.asked.is_some_and(|asked| asked.elapsed() < ASK) {
            return Ok(self.controller);
        }
        self.asked = Some(Instant::now());
        for hand in self.hands {
            let profile = session.current_interaction_profile(hand).during("xrGetCurrentInteractionProfile")?;
            if profile != xr::Path::NULL {
                let profile = instance.path_to_string(profile).during("xrPathToString")?;
                self.controller = Controller::of(Some(&profile));
                break;
            }
        }
        Ok(self.controller)
    }

    /// Returns the current input for the flight and for the panel. `step_s` is the time since the last call. A session
    /// without focus receives none.
    ///
    /// # Errors
    /// Returns the error of the runtime.
    pub(super) fn read(
        &mut self,
        session: &xr::Session<xr::Vulkan>,
        step_s: f64,
    ) -> Result<(HandInput, MenuInput), HeadsetError> {
        session.sync_actions(&[(&self.set).into()]).during("xrSyncActions")?;
        let stick = |action: FlightAction| {
            let Some(action) = self.sticks.get(&action) else { return Ok(DVec2::ZERO) };
            let state = action.state(session, xr::Path::NULL).during("xrGetActionStateVector2f")?;
            let push = DVec2::new(state.current_state.x.into(), state.current_state.y.into());
            Ok::<_, HeadsetError>(if state.is_active && push.is_finite() { push } else { DVec2::ZERO })
        };
        let mut presses = BTreeMap::new();
        for (action, of_runtime) in &self.buttons {
            let state = of_runtime.state(session, xr::Path::NULL).during("xrGetActionStateBoolean")?;
            let is_down = state.is_active && state.current_state;
            presses.insert(*action, (is_down, is_down && state.changed_since_last_sync));
        }
        let is_held = |action| presses.get(&action).is_some_and(|(is_held, _)| *is_held);
        let is_pressed = |action| presses.get(&action).is_some_and(|(_, is_pressed)| *is_pressed);
        let double = [FlightAction::NextOrStyles, FlightAction::ScaleOrAdjust, FlightAction::ResetOrHelp];
        let mut presses_of = [(false, false, false); 3];
        for ((long, action), press) in self.long.iter_mut().zip(double).zip(&mut presses_of) {
            *press = long.advance(is_held(action), step_s);
        }
        let [(next, styles, _), (scale, adjust, _), (reset, _, help)] = presses_of;
        let [fly, turn] = [stick(FlightAction::Fly)?, stick(FlightAction::Turn)?];
        let ahead = if is_held(FlightAction::Ahead) { DVec2::Y } else { DVec2::ZERO };
        let flight = HandInput {
            left_stick: (fly + ahead).clamp(DVec2::NEG_ONE, DVec2::ONE),
            right_stick: turn,
            fast: is_held(FlightAction::Fast),
            next_style: is_pressed(FlightAction::NextStyle) || next,
            switch_scale: is_pressed(FlightAction::Scale) || scale,
            reset: is_pressed(FlightAction::Reset) || reset,
        };
        let is_any_pressed = presses.iter().any(|(action, (_, is_new))| *is_new && *action != FlightAction::Help);
        let menu = MenuInput {
            styles: is_held(FlightAction::Styles) || styles,
            adjust: is_held(FlightAction::Adjust) || adjust,
            help: is_pressed(FlightAction::Help) || help,
            any: is_any_pressed || fly.length().max(turn.length()) > PUSH,
            stick: (fly + turn).clamp(DVec2::NEG_ONE, DVec2::ONE),
            picks: [is_pressed(FlightAction::Ahead), is_pressed(FlightAction::ResetOrHelp)],
        };
        Ok((flight, menu))
    }
}
