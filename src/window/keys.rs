//! What the keys mean.

use std::collections::HashSet;

use winit::keyboard::KeyCode;

use super::fly_camera::FlyInput;

/// What a key does when it goes down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Another style: so many further in the list.
    StepStyle(i32),
    /// The style at this place of the list.
    ChooseStyle(usize),
    /// A picture into a file.
    Screenshot,
    /// Show or hide the panel.
    TogglePanel,
    /// Back to the start.
    Restart,
    /// The whole screen, or a window again.
    FullScreen,
    /// Multiply the field of view.
    Zoom(f64),
    /// A coarser or finer picture.
    StepScale(i32),
    /// Let the mouse go, or quit.
    Escape,
}

/// The keys, for the panel.
pub const HELP: &[(&str, &str)] = &[
    ("W A S D", "fly"),
    ("Q E", "down, up"),
    ("Shift", "faster"),
    ("wheel", "speed"),
    ("right drag, click", "look around"),
    ("[ ]", "field of view"),
    ("Tab 1–9", "style"),
    ("− +", "render scale"),
    ("F12 P", "picture to a file"),
    ("F11", "full screen"),
    ("R", "back to the start"),
    ("H", "hide this panel"),
    ("Esc Esc", "quit"),
];

/// What `code` does as it goes down; keys that fly do nothing here.
pub fn action(code: KeyCode, shift: bool) -> Option<Action> {
    use KeyCode as Key;
    const DIGITS: [KeyCode; 9] = [
        Key::Digit1,
        Key::Digit2,
        Key::Digit3,
        Key::Digit4,
        Key::Digit5,
        Key::Digit6,
        Key::Digit7,
        Key::Digit8,
        Key::Digit9,
    ];
    Some(match code {
        Key::Tab => Action::StepStyle(if shift { -1 } else { 1 }),
        Key::F12 | Key::KeyP => Action::Screenshot,
        Key::KeyH => Action::TogglePanel,
        Key::KeyR => Action::Restart,
        Key::F11 => Action::FullScreen,
        Key::BracketLeft => Action::Zoom(1.0 / 1.1),
        Key::BracketRight => Action::Zoom(1.1),
        Key::Minus | Key::NumpadSubtract => Action::StepScale(-1),
        Key::Equal | Key::NumpadAdd => Action::StepScale(1),
        Key::Escape => Action::Escape,
        _ => Action::ChooseStyle(DIGITS.iter().position(|digit| *digit == code)?),
    })
}

/// The keys that are down.
#[derive(Debug, Default)]
pub struct KeysDown {
    down: HashSet<KeyCode>,
}

impl KeysDown {
    /// A key went down or up. Says whether it flies.
    pub fn set(&mut self, code: KeyCode, down: bool) -> bool {
        if down {
            self.down.insert(code)
        } else {
            self.down.remove(&code)
        };
        !FlyInput::is_still(&Self { down: HashSet::from([code]) }.input())
    }

    /// All are up: the window is no longer told.
    pub fn clear(&mut self) {
        self.down.clear();
    }

    /// Whether a Shift is down.
    pub fn shift(&self) -> bool {
        self.any(&[KeyCode::ShiftLeft, KeyCode::ShiftRight])
    }

    /// Whether a Ctrl is down.
    pub fn control(&self) -> bool {
        self.any(&[KeyCode::ControlLeft, KeyCode::ControlRight])
    }

    /// What they ask of the camera.
    pub fn input(&self) -> FlyInput {
        use KeyCode as Key;
        let axis =
            |plus: &[KeyCode], minus: &[KeyCode]| f64::from(i8::from(self.any(plus)) - i8::from(self.any(minus)));
        FlyInput {
            forward: axis(&[Key::KeyW, Key::ArrowUp], &[Key::KeyS, Key::ArrowDown]),
            right: axis(&[Key::KeyD, Key::ArrowRight], &[Key::KeyA, Key::ArrowLeft]),
            up: axis(&[Key::KeyE, Key::Space], &[Key::KeyQ, Key::ControlLeft, Key::ControlRight]),
            fast: self.shift(),
            ..FlyInput::default()
        }
    }

    fn any(&self, codes: &[KeyCode]) -> bool {
        codes.iter().any(|code| self.down.contains(code))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opposite_keys_cancel() {
        let mut keys = KeysDown::default();
        assert!(keys.set(KeyCode::KeyW, true));
        assert!(keys.set(KeyCode::KeyE, true));
        assert!(!keys.set(KeyCode::ShiftLeft, true));
        let input = keys.input();
        assert_eq!((input.forward, input.up, input.fast), (1.0, 1.0, true));
        keys.set(KeyCode::KeyS, true);
        keys.set(KeyCode::Space, true);
        assert_eq!(keys.input().forward, 0.0);
        keys.clear();
        assert!(keys.input().is_still());
    }

    #[test]
    fn keys_that_fly_do_nothing_else() {
        for code in [KeyCode::KeyW, KeyCode::KeyA, KeyCode::KeyS, KeyCode::KeyD, KeyCode::KeyQ, KeyCode::KeyE] {
            assert_eq!(action(code, false), None);
        }
        assert_eq!(action(KeyCode::Tab, true), Some(Action::StepStyle(-1)));
        assert_eq!(action(KeyCode::Digit3, false), Some(Action::ChooseStyle(2)));
    }
}
