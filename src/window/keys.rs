//! The meaning of keys.

use std::collections::HashMap;
use std::time::{Duration, Instant};

use winit::keyboard::KeyCode;

use super::camera_history::ViewStep;
use super::dock::Pane;
use super::fly_camera::FlyInput;

/// Action of a key when it is pressed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Action {
    /// Go this many styles forward in the list.
    StepStyle(i32),
    /// Choose the favourite style of this digit, counted from 0.
    Favourite(usize),
    /// Open or close the gallery of styles.
    ToggleGallery,
    /// Show or remove the divider between two styles.
    ToggleDivider,
    /// Show or hide the labels of summits.
    ToggleLabels,
    /// Write a picture to a file.
    Screenshot,
    /// Show or hide a panel.
    Toggle(Pane),
    /// Return to the start.
    Restart,
    /// Return to the previous view, or go forward again.
    View(ViewStep),
    /// Toggle full screen.
    FullScreen,
    /// Multiply the field of view.
    Zoom(f64),
    /// Render a coarser (−1) or finer (1) picture.
    StepScale(i32),
    /// Release the mouse, or quit.
    Escape,
    /// Undo the last change of the style or of the scene.
    Undo,
    /// Repeat the change that was undone last.
    Redo,
    /// Write the file of the style.
    Save,
    /// Ask for the name of a new file for the style.
    SaveAs,
    /// Look straight down at the place under the cursor.
    TopView,
    /// Show all of the land.
    FrameAll,
    /// Ask for coordinates to go to.
    GoTo,
    /// Open or close the dialog that opens files.
    Open,
    /// Open or close the dialog that exports.
    Export,
    /// Add a key frame to the camera path.
    AddKey,
    /// Remember the current view.
    AddView,
    /// Play the camera path, or pause it.
    Play,
    /// Open or close the window of keys.
    ToggleKeys,
}

/// Keys for one purpose, each with its action.
#[derive(Debug)]
pub(super) struct Group {
    pub heading: &'static str,
    /// Keys and actions.
    pub keys: &'static [(&'static str, &'static str)],
}

/// All keys by group, for the window of keys, the panel and the welcome.
pub(super) const HELP: &[Group] = &[
    Group {
        heading: "Fly",
        keys: &[
            ("W A S D, arrows", "fly"),
            ("Q, E or Space", "down, up"),
            ("Shift", "faster"),
            ("drag", "look around"),
            ("wheel", "zoom to the cursor"),
            ("Ctrl wheel", "speed"),
            ("middle drag, Alt drag", "orbit"),
            ("Shift middle drag, Alt Shift drag", "pan"),
            ("[ ]", "field of view"),
        ],
    },
    Group {
        heading: "Places",
        keys: &[
            ("double click", "look at"),
            ("T", "top view"),
            ("F", "frame all"),
            ("L", "go to coordinates"),
            ("U", "labels of summits"),
            ("Ctrl C", "copy coordinates"),
            ("R", "return to start"),
            ("Alt Left, Alt Right", "previous view, next view"),
        ],
    },
    Group {
        heading: "Camera path",
        keys: &[
            ("V", "camera path and views"),
            ("N", "add key frame to the path"),
            ("Del", "delete the key frame"),
            ("J", "play, pause the path"),
            ("M", "remember this view"),
        ],
    },
    Group {
        heading: "Styles",
        keys: &[
            ("click", "edit what drew there"),
            ("I", "edit the style"),
            ("G", "gallery of styles"),
            ("PgDn PgUp", "next style, previous"),
            ("1–9", "favourite styles"),
            ("B", "hold: style before"),
            ("X", "compare two styles"),
            ("Backspace", "default of a parameter"),
            ("Ctrl S", "save the style"),
            ("Ctrl Shift S", "save it under a name"),
        ],
    },
    Group { heading: "Edit", keys: &[("Ctrl Z", "undo, scene or style"), ("Ctrl Y", "redo")] },
    Group { heading: "Files", keys: &[("Ctrl O", "open a file"), ("Ctrl E", "export"), ("F12 P", "save picture")] },
    Group {
        heading: "Window",
        keys: &[
            ("F1 ?", "all keys"),
            ("H", "panel of the flight"),
            ("K", "look inside the frame"),
            ("C", "cost of the frame"),
            ("Tab", "next control of a panel"),
            ("− +", "resolution"),
            ("F11", "full screen"),
            ("Esc Esc", "quit"),
        ],
    },
];

/// Returns the action of a key. Keys named by a character are recognised by the character of the keyboard layout,
/// others by their position. Keys that fly have no action.
pub(super) fn action(code: KeyCode, sign: Option<&str>) -> Option<Action> {
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
    match sign {
        Some("-" | "−") => return Some(Action::StepScale(-1)),
        // Both characters are on one key of many keyboards, and one of them needs Shift.
        Some("+" | "=") => return Some(Action::StepScale(1)),
        Some("?") => return Some(Action::ToggleKeys),
        _ => {}
    }
    Some(match code {
        Key::PageDown => Action::StepStyle(1),
        Key::PageUp => Action::StepStyle(-1),
        Key::F1 => Action::ToggleKeys,
        Key::F12 | Key::KeyP => Action::Screenshot,
        Key::KeyG => Action::ToggleGallery,
        Key::KeyX => Action::ToggleDivider,
        Key::KeyH => Action::Toggle(Pane::Flight),
        Key::KeyI => Action::Toggle(Pane::Style),
        Key::KeyK => Action::Toggle(Pane::Inside),
        Key::KeyC => Action::Toggle(Pane::Cost),
        Key::KeyV => Action::Toggle(Pane::Path),
        Key::KeyN => Action::AddKey,
        Key::KeyM => Action::AddView,
        Key::KeyJ => Action::Play,
        Key::KeyR => Action::Restart,
        Key::KeyT => Action::TopView,
        Key::KeyF => Action::FrameAll,
        Key::KeyL => Action::GoTo,
        Key::KeyU => Action::ToggleLabels,
        Key::F11 => Action::FullScreen,
        Key::BracketLeft => Action::Zoom(1.0 / 1.1),
        Key::BracketRight => Action::Zoom(1.1),
        Key::Escape => Action::Escape,
        _ => Action::Favourite(DIGITS.iter().position(|digit| *digit == code)?),
    })
}

/// Returns the action of a key that is pressed while Ctrl is down, by its character on the keyboard layout.
pub(super) fn action_with_control(sign: Option<&str>, shift: bool) -> Option<Action> {
    Some(match sign?.to_lowercase().as_str() {
        "z" if shift => Action::Redo,
        "z" => Action::Undo,
        "y" => Action::Redo,
        "s" if shift => Action::SaveAs,
        "s" => Action::Save,
        "o" => Action::Open,
        "e" => Action::Export,
        _ => return None,
    })
}

/// Returns the action of a key that is pressed while Alt is down.
pub(super) fn action_with_alt(code: KeyCode) -> Option<Action> {
    match code {
        KeyCode::ArrowLeft => Some(Action::View(ViewStep::Back)),
        KeyCode::ArrowRight => Some(Action::View(ViewStep::Forward)),
        _ => None,
    }
}

/// The key that shows the style before while it is held.
pub(super) const COMPARE: KeyCode = KeyCode::KeyB;

/// Assumed duration of a key that is pressed and released between two frames, since the system reports no times.
const TAP: Duration = Duration::from_millis(16);

/// The keys that are down, and for how long they were down since the last frame.
#[derive(Debug, Default)]
pub(super) struct KeysDown {
    /// Start of the press, or time of the last frame; and whether a frame has already included it.
    down: HashMap<KeyCode, (Instant, bool)>,
    /// Durations of keys that were released since the last frame.
    held: HashMap<KeyCode, Duration>,
}

impl KeysDown {
    /// Records that a key was pressed or released. Returns whether it is a key that flies.
    pub(super) fn set(&mut self, code: KeyCode, down: bool, now: Instant) -> bool {
        if down {
            self.down.entry(code).or_insert((now, false));
        } else if let Some((since, is_seen)) = self.down.remove(&code) {
            let held = now.saturating_duration_since(since);
            *self.held.entry(code).or_default() += if is_seen { held } else { held.max(TAP) };
        }
        let alone = Self { down: HashMap::from([(code, (now, false))]), ..Self::default() };
        alone.fly()
    }

    /// Returns whether the keys that are down move the camera; opposite keys cancel.
    pub(super) fn fly(&self) -> bool {
        !self.input(|codes| f64::from(i8::from(self.any(codes)))).is_still()
    }

    /// Releases all keys, because the window no longer receives their events.
    pub(super) fn clear(&mut self) {
        self.down.clear();
        self.held.clear();
    }

    /// Returns whether a key is down.
    pub(super) fn is_down(&self, code: KeyCode) -> bool {
        self.down.contains_key(&code)
    }

    /// Returns whether Shift is down.
    pub(super) fn shift(&self) -> bool {
        self.any(&[KeyCode::ShiftLeft, KeyCode::ShiftRight])
    }

    /// Returns whether the key that compares with the style before is down.
    pub(super) fn compares(&self) -> bool {
        self.any(&[COMPARE])
    }

    /// Returns whether Ctrl is down.
    pub(super) fn control(&self) -> bool {
        self.any(&[KeyCode::ControlLeft, KeyCode::ControlRight])
    }

    /// Returns whether Alt is down.
    pub(super) fn alt(&self) -> bool {
        self.any(&[KeyCode::AltLeft, KeyCode::AltRight])
    }

    /// Returns the input for a step of `step_s` that ends `now`; a key that was down for part of the step counts for
    /// that part.
    pub(super) fn take(&mut self, now: Instant, step_s: f64) -> FlyInput {
        let mut held = std::mem::take(&mut self.held);
        for (code, (since, is_seen)) in &mut self.down {
            *held.entry(*code).or_default() += now.saturating_duration_since(*since);
            (*since, *is_seen) = (now, true);
        }
        let held_s = |code: &KeyCode| held.get(code).map_or(0.0, Duration::as_secs_f64);
        self.input(|codes| (codes.iter().map(held_s).fold(0.0, f64::max) / step_s.max(1e-6)).min(1.0))
    }

    fn input(&self, part: impl Fn(&[KeyCode]) -> f64) -> FlyInput {
        use KeyCode as Key;
        let axis = |plus: &[KeyCode], minus: &[KeyCode]| part(plus) - part(minus);
        FlyInput {
            forward: axis(&[Key::KeyW, Key::ArrowUp], &[Key::KeyS, Key::ArrowDown]),
            right: axis(&[Key::KeyD, Key::ArrowRight], &[Key::KeyA, Key::ArrowLeft]),
            up: axis(&[Key::KeyE, Key::Space], &[Key::KeyQ]),
            fast: self.shift(),
            ..FlyInput::default()
        }
    }

    fn any(&self, codes: &[KeyCode]) -> bool {
        codes.iter().any(|code| self.down.contains_key(code))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::scene::camera::Camera;
    use crate::window::fly_camera::FlyCamera;

    #[test]
    fn opposite_keys_cancel() {
        let now = Instant::now();
        let then = now + Duration::from_millis(100);
        let mut keys = KeysDown::default();
        assert!(keys.set(KeyCode::KeyW, true, now));
        assert!(keys.set(KeyCode::KeyE, true, now));
        assert!(!keys.set(KeyCode::ShiftLeft, true, now));
        assert!(keys.fly());
        let input = keys.take(then, 0.1);
        assert_eq!((input.forward, input.up, input.fast), (1.0, 1.0, true));
        keys.set(KeyCode::KeyS, true, then);
        keys.set(KeyCode::Space, true, then);
        let input = keys.take(then + Duration::from_millis(100), 0.1);
        assert_eq!((input.forward, input.up), (0.0, 1.0));
        keys.clear();
        assert!(keys.take(then, 0.1).is_still() && !keys.fly());
    }

    /// Returns how far the camera flies at frames of `frame_ms`, in seconds at full speed, if a key is down in this
    /// interval.
    fn flown_m(frame_ms: u64, down_ms: std::ops::Range<u64>) -> f64 {
        let at = |begun: Instant, ms| begun + Duration::from_millis(ms);
        let begun = Instant::now();
        let start =
            Camera { position_m: DVec3::ZERO, height_above_ground: false, yaw_deg: 0.0, pitch_deg: 0.0, fov_deg: 45.0 };
        let mut camera = FlyCamera::new(&start, |_| -1000.0, [30_000.0, 30_000.0]);
        let mut keys = KeysDown::default();
        let mut is_down = false;
        for end_ms in (frame_ms..5000).step_by(frame_ms as usize) {
            for ms in end_ms - frame_ms..end_ms {
                if down_ms.contains(&ms) != is_down {
                    is_down = !is_down;
                    keys.set(KeyCode::KeyW, is_down, at(begun, ms));
                }
            }
            let step_s = frame_ms as f64 / 1000.0;
            camera.advance(&keys.take(at(begun, end_ms), step_s), step_s, |_| -1000.0);
        }
        assert!(camera.is_still());
        camera.position_m.length() / camera.speed_m_s()
    }

    #[test]
    fn a_key_moves_by_the_time_that_it_is_down() {
        for down_ms in [10..70, 35..295, 100..1234, 20..1020] {
            let held_s = (down_ms.end - down_ms.start) as f64 / 1000.0;
            for frame_ms in [10, 16, 100, 500] {
                let flown_s = flown_m(frame_ms, down_ms.clone());
                // Tolerance for the remaining speed when the camera stops.
                assert!((flown_s - held_s).abs() < 2e-3, "{down_ms:?} at {frame_ms} ms: {flown_s} s of {held_s} s");
            }
        }
        // A tap is not lost, however slow the frames are, and does not count as a whole slow frame.
        let tap_s = flown_m(500, 120..121);
        assert!((tap_s - TAP.as_secs_f64()).abs() < 2e-3, "{tap_s}");
    }

    #[test]
    fn signs_are_those_of_the_layout() {
        // Where an English keyboard has the minus, a German one has ß; where the English one has the slash, it has the
        // minus.
        assert_eq!(action(KeyCode::Minus, Some("ß")), None);
        assert_eq!(action(KeyCode::Slash, Some("-")), Some(Action::StepScale(-1)));
        assert_eq!(action(KeyCode::BracketRight, Some("+")), Some(Action::StepScale(1)));
        assert_eq!(action(KeyCode::Equal, Some("=")), Some(Action::StepScale(1)));
        assert_eq!(action(KeyCode::NumpadAdd, Some("+")), Some(Action::StepScale(1)));
        assert_eq!(action(KeyCode::BracketRight, Some("]")), Some(Action::Zoom(1.1)));
        // The question mark is on the slash of an English keyboard, and on the ß of a German one.
        for code in [KeyCode::Slash, KeyCode::Minus] {
            assert_eq!(action(code, Some("?")), Some(Action::ToggleKeys));
        }
        assert_eq!(action(KeyCode::Slash, Some("/")), None);
    }

    #[test]
    fn keys_that_fly_do_nothing_else() {
        for code in [KeyCode::KeyW, KeyCode::KeyA, KeyCode::KeyS, KeyCode::KeyD, KeyCode::KeyQ, KeyCode::KeyE] {
            assert_eq!(action(code, Some("w")), None);
        }
        assert_eq!(action(KeyCode::PageUp, None), Some(Action::StepStyle(-1)));
        assert_eq!(action(KeyCode::Tab, Some("\t")), None, "Tab moves the focus");
        assert_eq!(action(KeyCode::Digit3, Some("3")), Some(Action::Favourite(2)));
    }

    #[test]
    fn arrows_fly_but_not_with_alt() {
        let mut keys = KeysDown::default();
        assert!(keys.set(KeyCode::ArrowLeft, true, Instant::now()) && keys.is_down(KeyCode::ArrowLeft));
        assert_eq!(action(KeyCode::ArrowLeft, None), None);
        assert_eq!(action_with_alt(KeyCode::ArrowLeft), Some(Action::View(ViewStep::Back)));
        assert_eq!(action_with_alt(KeyCode::ArrowRight), Some(Action::View(ViewStep::Forward)));
        assert_eq!(action_with_alt(KeyCode::ArrowUp), None);
    }
}
