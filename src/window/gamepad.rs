//! The gamepad: the left stick flies, the right one looks around, the triggers move down and up.

use gilrs::{Axis, Button, Gamepad, Gilrs};

use super::fly_camera::FlyInput;

/// Dead zone: deflections of a stick up to this count as 0.
const DEAD: f64 = 0.15;
/// Turning rate at full deflection.
const TURN_DEG_S: f64 = 90.0;

/// The gamepads of the machine; `None` if the system does not support them.
pub(super) struct Gamepads {
    gilrs: Option<Gilrs>,
}

impl Gamepads {
    /// Starts listening to gamepads.
    pub(super) fn new() -> Self {
        let gilrs = match Gilrs::new() {
            Ok(gilrs) => Some(gilrs),
            Err(error) => {
                tracing::info!("gamepads are not available: {error}");
                None
            }
        };
        Self { gilrs }
    }

    /// Returns whether a gamepad is connected.
    pub(super) fn any(&self) -> bool {
        self.gilrs.as_ref().is_some_and(|gilrs| gilrs.gamepads().next().is_some())
    }

    /// Returns whether a gamepad can be connected.
    pub(super) fn may_come(&self) -> bool {
        self.gilrs.is_some()
    }

    /// Returns the current input of all gamepads together.
    pub(super) fn poll(&mut self) -> FlyInput {
        let Some(gilrs) = &mut self.gilrs else { return FlyInput::default() };
        while let Some(event) = gilrs.next_event() {
            if matches!(event.event, gilrs::EventType::Connected) {
                tracing::info!("gamepad: {}", gilrs.gamepad(event.id).name());
            }
        }
        gilrs.gamepads().fold(FlyInput::default(), |input, (_, gamepad)| input.plus(input_of(&gamepad)))
    }
}

fn input_of(gamepad: &Gamepad<'_>) -> FlyInput {
    let stick = |x: Axis, y: Axis| dead_zone([gamepad.value(x), gamepad.value(y)].map(f64::from));
    let trigger = |button: Button| {
        let value = gamepad.button_data(button).map_or(0.0, |data| f64::from(data.value()));
        dead_zone([value, 0.0])[0]
    };
    let [right, forward] = stick(Axis::LeftStickX, Axis::LeftStickY);
    // Squared: fine near the centre, fast at full deflection.
    let turn_deg_s = stick(Axis::RightStickX, Axis::RightStickY).map(|part| part * part.abs() * TURN_DEG_S);
    let fast = gamepad.is_pressed(Button::LeftThumb) || gamepad.is_pressed(Button::RightTrigger);
    let up = trigger(Button::RightTrigger2) - trigger(Button::LeftTrigger2);
    FlyInput { forward, right, up, fast, look_deg: [0.0; 2], turn_deg_s }
}

/// Removes the dead zone and rescales the rest to a length of 0 to 1, in any direction.
fn dead_zone([x, y]: [f64; 2]) -> [f64; 2] {
    let length = x.hypot(y);
    if length <= DEAD {
        return [0.0; 2];
    }
    let scale = ((length - DEAD) / (1.0 - DEAD)).min(1.0) / length;
    [x * scale, y * scale]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_middle_is_dead_and_the_rim_is_full() {
        assert_eq!(dead_zone([0.1, -0.1]), [0.0, 0.0]);
        assert_eq!(dead_zone([0.0, 0.0]), [0.0, 0.0]);
        assert_eq!(dead_zone([-1.0, 0.0]), [-1.0, 0.0]);
        let [x, y] = dead_zone([1.0, 1.0]);
        assert!((x.hypot(y) - 1.0).abs() < 1e-12);
        // The response is continuous at the edge of the dead zone.
        assert!(dead_zone([DEAD + 1e-6, 0.0])[0] < 1e-5);
    }
}
