//! Turns events of the window into actions: fly, look around, keys. Events for the panel are passed to the panel.

use std::time::Instant;

use winit::event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent};
use winit::keyboard::{KeyCode, PhysicalKey};
use winit::window::{CursorGrabMode, Window};

use super::fly_camera::FlyInput;
use super::gamepad::Gamepads;
use super::keys::{self, Action, KeysDown};
use super::overlay::Overlay;

/// Pixels of scrolling on a touchpad that count as one notch of a wheel.
const NOTCH_PX: f64 = 40.0;

/// The reaction to an event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Reaction {
    /// No reaction: the event is for nobody.
    Nothing,
    /// A repaint of the panel only.
    Panel,
    /// A frame: the camera may move.
    Fly,
    /// A change of speed, in notches of the wheel.
    Wheel(f64),
    /// The action of a key.
    Do(Action),
}

/// Why the mouse looks around.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Look {
    /// The right button is down.
    Held,
    /// The mouse is captured until Esc.
    Captured,
}

/// State of keys, mouse and gamepads.
pub(super) struct Input {
    keys: KeysDown,
    gamepads: Gamepads,
    look: Option<Look>,
    moved_px: [f64; 2],
}

impl Input {
    /// Creates the state in which nothing is pressed.
    pub(super) fn new() -> Self {
        Self { keys: KeysDown::default(), gamepads: Gamepads::new(), look: None, moved_px: [0.0; 2] }
    }

    /// Returns the gamepads.
    pub(super) fn gamepads(&self) -> &Gamepads {
        &self.gamepads
    }

    /// Returns the input for a step of `step_s` that ends `now`; `deg_per_px` is the angle of a pixel in the middle of
    /// the window.
    pub(super) fn take(&mut self, deg_per_px: f64, now: Instant, step_s: f64) -> FlyInput {
        let [right_px, down_px] = std::mem::take(&mut self.moved_px);
        let look_deg = [right_px * deg_per_px, -down_px * deg_per_px];
        FlyInput { look_deg, ..self.keys.take(now, step_s) }.plus(self.gamepads.poll())
    }

    /// Returns whether a key that flies is down.
    pub(super) fn flies(&self) -> bool {
        self.keys.fly()
    }

    /// Returns the present input of the gamepads.
    pub(super) fn poll_gamepads(&mut self) -> FlyInput {
        self.gamepads.poll()
    }

    /// Handles a motion of the mouse; returns whether the view follows it.
    pub(super) fn on_mouse_motion(&mut self, (right_px, down_px): (f64, f64)) -> bool {
        if self.look.is_some() {
            self.moved_px[0] += right_px;
            self.moved_px[1] += down_px;
        }
        self.look.is_some()
    }

    /// Releases the mouse; returns whether it was captured.
    pub(super) fn release_mouse(&mut self, window: &Window) -> bool {
        let held = self.look.take().is_some();
        if held {
            self.moved_px = [0.0; 2];
            grab(window, false);
        }
        held
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
            WindowEvent::MouseWheel { delta, .. } if self.look.is_some() || !overlay.wants_pointer() => {
                Reaction::Wheel(match delta {
                    MouseScrollDelta::LineDelta(_, lines) => f64::from(*lines),
                    MouseScrollDelta::PixelDelta(by) => by.y / NOTCH_PX,
                })
            }
            WindowEvent::CursorMoved { .. } if self.look.is_some() => Reaction::Nothing,
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
        let copies = code == KeyCode::KeyC && self.keys.control();
        // Backspace restores the default of the parameter under the mouse, and Esc closes a list before it leaves.
        let closes = code == KeyCode::Escape && self.look.is_none() && overlay.has_popup();
        if copies || closes || code == KeyCode::Backspace {
            return forward(window, overlay, event);
        }
        if down && self.keys.control() {
            let action = keys::action_with_control(key.logical_key.to_text(), self.keys.shift());
            return action.filter(|_| !key.repeat).map_or(Reaction::Nothing, Reaction::Do);
        }
        let flies = self.keys.set(code, down, Instant::now());
        match keys::action(code, key.logical_key.to_text(), self.keys.shift()) {
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
        let down = state == ElementState::Pressed;
        match (self.look, button) {
            (Some(Look::Held), MouseButton::Right) if !down => {
                self.release_mouse(window);
                Reaction::Fly
            }
            (Some(_), _) => Reaction::Nothing,
            // A click next to an open list closes the list.
            (None, MouseButton::Left | MouseButton::Right) if down && !overlay.wants_click() => {
                self.look = Some(if button == MouseButton::Right { Look::Held } else { Look::Captured });
                overlay.stop_typing();
                grab(window, true);
                Reaction::Panel
            }
            _ => forward(window, overlay, event),
        }
    }
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
