//! Turns events of the window into actions: fly, look around, keys. Events for the panel are passed to the panel.

use std::time::{Duration, Instant};

use glam::DVec2;
use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::keyboard::{KeyCode, PhysicalKey};
use winit::window::{CursorGrabMode, Window};

use super::fly_camera::FlyInput;
use super::gamepad::Gamepads;
use super::keys::{self, Action, KeysDown};
use super::overlay::Overlay;

/// Pixels of scrolling on a touchpad that count as one notch of a wheel.
const NOTCH_PX: f64 = 40.0;
/// A button that is released within this distance of where it was pressed is a click, not a drag, in pixels.
const CLICK_PX: f64 = 4.0;
/// Longest time between the clicks of a double click.
pub(super) const DOUBLE_CLICK: Duration = Duration::from_millis(450);

/// The reaction to an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reaction {
    /// No reaction: the event concerns neither the flight nor a panel.
    Nothing,
    /// A repaint of the panel only.
    Panel,
    /// A frame: the camera may move.
    Fly,
    /// A zoom toward the place under the cursor, in notches of the wheel.
    Zoom(f64),
    /// A change of speed, in notches of the wheel.
    Speed(f64),
    /// A click at a position in the window, in pixels.
    Click(DVec2),
    /// A double click at a position in the window, in pixels.
    LookAt(DVec2),
    /// The action of a key.
    Do(Action),
}

/// The motion that a drag of the mouse causes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DragKind {
    /// The camera turns on the spot.
    Look,
    /// The camera turns about the place under the cursor.
    Orbit,
    /// The place under the cursor moves with it.
    Pan,
}

/// A button of the mouse that is down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Drag {
    pub kind: DragKind,
    button: MouseButton,
    /// Position at which the button was pressed, in pixels of the window.
    pub from_px: DVec2,
    /// Whether the mouse has moved far enough to be no click.
    pub moves: bool,
}

/// State of keys, mouse and gamepads.
pub(super) struct Input {
    keys: KeysDown,
    gamepads: Gamepads,
    drag: Option<Drag>,
    /// Motion of the mouse while it looks around, in pixels.
    looked_px: [f64; 2],
    /// Motion of the mouse since a button was pressed, until the press is known to be a drag, in pixels.
    pressed_px: [f64; 2],
    /// Motion of the cursor while it orbits, in pixels.
    dragged_px: DVec2,
    /// Position of the cursor in the window, in pixels.
    cursor_px: Option<DVec2>,
    last_click: Option<(Instant, DVec2)>,
}

impl Input {
    /// Creates the state in which nothing is pressed.
    pub(super) fn new() -> Self {
        Self {
            keys: KeysDown::default(),
            gamepads: Gamepads::new(),
            drag: None,
            looked_px: [0.0; 2],
            pressed_px: [0.0; 2],
            dragged_px: DVec2::ZERO,
            cursor_px: None,
            last_click: None,
        }
    }

    /// Returns where the cursor is in the window, in pixels; `None` outside.
    pub(super) fn cursor_px(&self) -> Option<DVec2> {
        self.cursor_px
    }

    /// Returns the drag, if a button is down.
    pub(super) fn drag(&self) -> Option<&Drag> {
        self.drag.as_ref()
    }

    /// Returns by how much the cursor has been dragged since the last call, in pixels.
    pub(super) fn take_dragged_px(&mut self) -> DVec2 {
        std::mem::take(&mut self.dragged_px)
    }

    /// Returns the gamepads.
    pub(super) fn gamepads(&self) -> &Gamepads {
        &self.gamepads
    }

    /// Returns the input for a step of `step_s` that ends `now`; `deg_per_px` is the angle of a pixel in the middle of
    /// the window.
    pub(super) fn take(&mut self, deg_per_px: f64, now: Instant, step_s: f64) -> FlyInput {
        let [right_px, down_px] = std::mem::take(&mut self.looked_px);
        let look_deg = [right_px * deg_per_px, -down_px * deg_per_px];
        FlyInput { look_deg, ..self.keys.take(now, step_s) }.plus(self.gamepads.poll())
    }

    /// Returns whether a key that flies is down.
    pub(super) fn flies(&self) -> bool {
        self.keys.fly()
    }

    /// Returns whether the key that compares with the style before is down.
    pub(super) fn compares(&self) -> bool {
        self.keys.compares()
    }

    /// Returns the current input of the gamepads.
    pub(super) fn poll_gamepads(&mut self) -> FlyInput {
        self.gamepads.poll()
    }

    /// Handles a motion of the mouse; returns whether the view follows it.
    pub(super) fn on_mouse_motion(&mut self, (right_px, down_px): (f64, f64)) -> bool {
        let looks = self.looks();
        let sum_px = if looks { &mut self.looked_px } else { &mut self.pressed_px };
        if self.drag.is_some_and(|drag| drag.kind == DragKind::Look) {
            sum_px[0] += right_px;
            sum_px[1] += down_px;
        }
        looks
    }

    /// Returns whether the mouse looks around.
    fn looks(&self) -> bool {
        self.drag.is_some_and(|drag| drag.kind == DragKind::Look && drag.moves)
    }

    /// Ends a drag; returns whether there was one that moved.
    pub(super) fn release_mouse(&mut self, window: &Window) -> bool {
        let looked = self.looks();
        let moved = self.drag.take().is_some_and(|drag| drag.moves);
        // What was looked around since the last frame still counts: a whole drag may happen between two slow frames.
        if looked {
            grab(window, false);
        }
        moved
    }

    /// Forgets all keys and releases the mouse, because another window has the focus now.
    pub(super) fn lose_focus(&mut self, window: &Window) {
        self.keys.clear();
        self.release_mouse(window);
    }

    /// Handles an event of keyboard or mouse, or passes it to the panel.
    pub(super) fn on_event(&mut self, window: &Window, overlay: &mut Overlay, event: &WindowEvent) -> Reaction {
        match event {
            WindowEvent::KeyboardInput { event: key, is_synthetic, .. } => {
                if *is_synthetic && key.state == ElementState::Pressed {
                    // The key was pressed while another window had the focus.
                    return Reaction::Nothing;
                }
                self.on_key(window, overlay, event, key)
            }
            WindowEvent::MouseInput { state, button, .. } => self.on_button(window, overlay, event, *state, *button),
            WindowEvent::MouseWheel { delta, .. } if self.drag.is_some() || !overlay.wants_click() => {
                let notches = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(*lines),
                    MouseScrollDelta::PixelDelta(by) => by.y / NOTCH_PX,
                };
                let is_speed = self.looks() || self.keys.control();
                if is_speed { Reaction::Speed(notches) } else { Reaction::Zoom(notches) }
            }
            WindowEvent::CursorMoved { position, .. } => {
                self.on_cursor(window, overlay, event, DVec2::new(position.x, position.y))
            }
            WindowEvent::CursorLeft { .. } => {
                self.cursor_px = None;
                forward(window, overlay, event)
            }
            event => forward(window, overlay, event),
        }
    }

    fn on_key(&mut self, window: &Window, overlay: &mut Overlay, event: &WindowEvent, key: &KeyEvent) -> Reaction {
        let PhysicalKey::Code(code) = key.physical_key else { return Reaction::Nothing };
        let down = key.state == ElementState::Pressed;
        // A key that is released is always handled here: if it was pressed before typing began, it would otherwise stay
        // down.
        if overlay.is_typing() {
            if !down {
                self.keys.set(code, false, Instant::now());
            }
            return forward(window, overlay, event);
        }
        if let Some(action) = keys::action_with_alt(code).filter(|_| self.keys.alt() && down) {
            return if key.repeat { Reaction::Nothing } else { Reaction::Do(action) };
        }
        // Tab moves the focus through the panels, as everywhere else; then the keys that operate a widget are for it.
        let operates = matches!(
            code,
            KeyCode::Space
                | KeyCode::Enter
                | KeyCode::NumpadEnter
                | KeyCode::ArrowUp
                | KeyCode::ArrowDown
                | KeyCode::ArrowLeft
                | KeyCode::ArrowRight
                | KeyCode::Home
                | KeyCode::End
                | KeyCode::Escape
        );
        if code == KeyCode::Tab || operates && overlay.has_focus() && self.drag.is_none() {
            if !down {
                self.keys.set(code, false, Instant::now());
            }
            return forward(window, overlay, event);
        }
        let copies = code == KeyCode::KeyC && self.keys.control();
        // Backspace restores the default of the parameter under the mouse, Delete removes the selected key frame, and Esc
        // closes a list before it leaves.
        let closes = code == KeyCode::Escape && self.drag.is_none() && overlay.has_popup();
        if copies || closes || matches!(code, KeyCode::Backspace | KeyCode::Delete) {
            return forward(window, overlay, event);
        }
        // Shift may be pressed after Ctrl.
        let is_modifier =
            matches!(code, KeyCode::ShiftLeft | KeyCode::ShiftRight | KeyCode::AltLeft | KeyCode::AltRight);
        if down && self.keys.control() && !is_modifier {
            let action = keys::action_with_control(key.logical_key.to_text(), self.keys.shift());
            return action.filter(|_| !key.repeat).map_or(Reaction::Nothing, Reaction::Do);
        }
        // A key whose press was for something else, such as Alt and an arrow, flies only when it is pressed again.
        if key.repeat && !self.keys.is_down(code) {
            return Reaction::Nothing;
        }
        let flies = self.keys.set(code, down, Instant::now());
        if code == keys::COMPARE {
            return Reaction::Fly;
        }
        match keys::action(code, key.logical_key.to_text()) {
            Some(Action::Zoom(factor)) if down => Reaction::Do(Action::Zoom(factor)),
            Some(action) if down && !key.repeat => Reaction::Do(action),
            _ if flies && !key.repeat => Reaction::Fly,
            _ => Reaction::Nothing,
        }
    }

    fn on_button(
        &mut self,
        window: &Window,
        overlay: &mut Overlay,
        event: &WindowEvent,
        state: ElementState,
        button: MouseButton,
    ) -> Reaction {
        let is_down = state == ElementState::Pressed;
        if let Some(drag) = self.drag {
            if drag.button != button || is_down {
                return Reaction::Nothing;
            }
            self.release_mouse(window);
            return if drag.moves { Reaction::Fly } else { self.on_click(drag) };
        }
        // A click next to an open list closes the list.
        let Some(from_px) = self.cursor_px.filter(|_| is_down && !overlay.wants_click()) else {
            return forward(window, overlay, event);
        };
        let Some(kind) = drag_kind(button, &self.keys) else { return forward(window, overlay, event) };
        overlay.stop_typing();
        self.drag = Some(Drag { kind, button, from_px, moves: false });
        self.dragged_px = DVec2::ZERO;
        self.pressed_px = [0.0; 2];
        Reaction::Panel
    }

    /// Handles the end of a press that did not move.
    fn on_click(&mut self, drag: Drag) -> Reaction {
        if drag.button != MouseButton::Left {
            return Reaction::Nothing;
        }
        let now = Instant::now();
        let is_second = self.last_click.take().is_some_and(|(at, px)| {
            now.saturating_duration_since(at) <= DOUBLE_CLICK && px.distance(drag.from_px) <= CLICK_PX
        });
        if is_second {
            return Reaction::LookAt(drag.from_px);
        }
        self.last_click = Some((now, drag.from_px));
        Reaction::Click(drag.from_px)
    }

    fn on_cursor(&mut self, window: &Window, overlay: &mut Overlay, event: &WindowEvent, at_px: DVec2) -> Reaction {
        let before_px = self.cursor_px.replace(at_px);
        let Some(drag) = self.drag else { return forward(window, overlay, event) };
        match drag.kind {
            kind if self.turns_into_drag(at_px) => {
                if kind == DragKind::Look {
                    grab(window, true);
                }
                Reaction::Fly
            }
            DragKind::Orbit | DragKind::Pan if drag.moves => {
                self.dragged_px += at_px - before_px.unwrap_or(at_px);
                Reaction::Fly
            }
            _ => Reaction::Nothing,
        }
    }

    /// Returns whether a motion of the cursor turns a press into a drag. What has moved since the press counts.
    fn turns_into_drag(&mut self, at_px: DVec2) -> bool {
        let Some(drag) = self.drag.as_mut().filter(|drag| !drag.moves && at_px.distance(drag.from_px) > CLICK_PX)
        else {
            return false;
        };
        drag.moves = true;
        if drag.kind == DragKind::Look {
            let pressed_px = std::mem::take(&mut self.pressed_px);
            (0..2).for_each(|axis| self.looked_px[axis] += pressed_px[axis]);
        } else {
            self.dragged_px = at_px - drag.from_px;
        }
        true
    }
}

/// Returns what a drag with a button does.
fn drag_kind(button: MouseButton, keys: &KeysDown) -> Option<DragKind> {
    Some(match button {
        MouseButton::Middle if keys.shift() => DragKind::Pan,
        MouseButton::Left if keys.alt() && keys.shift() => DragKind::Pan,
        MouseButton::Middle => DragKind::Orbit,
        MouseButton::Left if keys.alt() => DragKind::Orbit,
        MouseButton::Left | MouseButton::Right => DragKind::Look,
        _ => return None,
    })
}

fn forward(window: &Window, overlay: &mut Overlay, event: &WindowEvent) -> Reaction {
    if overlay.on_event(window, event).repaint { Reaction::Panel } else { Reaction::Nothing }
}

/// Hides the cursor and confines it to the window, or releases it.
fn grab(window: &Window, grabbed: bool) {
    if grabbed {
        // Not every system supports both modes. Without either, motion still arrives while the cursor is in the window.
        let kept = window
            .set_cursor_grab(CursorGrabMode::Locked)
            .or_else(|_| window.set_cursor_grab(CursorGrabMode::Confined));
        if let Err(error) = kept {
            tracing::info!("cannot confine the cursor to the window: {error}");
        }
    } else if let Err(error) = window.set_cursor_grab(CursorGrabMode::None) {
        tracing::info!("cannot release the cursor: {error}");
    }
    window.set_cursor_visible(!grabbed);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pressed() -> Input {
        let mut input = Input::new();
        let (kind, button) = (DragKind::Look, MouseButton::Left);
        input.drag = Some(Drag { kind, button, from_px: DVec2::new(100.0, 100.0), moves: false });
        input
    }

    fn look_deg(input: &mut Input) -> [f64; 2] {
        input.take(0.5, Instant::now(), 0.1).look_deg
    }

    #[test]
    fn the_motion_that_turns_a_press_into_a_drag_counts() {
        // The system reports the motion of the mouse before or after that of the cursor.
        for mouse_is_first in [true, false] {
            let mut input = pressed();
            if mouse_is_first {
                assert!(!input.on_mouse_motion((40.0, -20.0)));
            }
            assert!(input.turns_into_drag(DVec2::new(140.0, 80.0)));
            if !mouse_is_first {
                assert!(input.on_mouse_motion((40.0, -20.0)));
            }
            assert_eq!(look_deg(&mut input), [20.0, 10.0]);
            assert_eq!(look_deg(&mut input), [0.0, 0.0]);
            input.on_mouse_motion((2.0, 0.0));
            assert!(!input.turns_into_drag(DVec2::new(142.0, 80.0)));
            assert_eq!(look_deg(&mut input), [1.0, 0.0]);
        }
    }

    #[test]
    fn a_click_does_not_look_around() {
        let mut input = pressed();
        assert!(!input.on_mouse_motion((2.0, 1.0)) && !input.turns_into_drag(DVec2::new(102.0, 101.0)));
        assert_eq!(look_deg(&mut input), [0.0, 0.0]);
    }
}
