//! Clipboard for X11, Windows and macOS. egui-winit handles Wayland's clipboard itself; its support for the others
//! depends on image decoders, which a panel of numbers does not need.

use winit::event::{ElementState, KeyEvent, MouseButton, WindowEvent};
use winit::keyboard::{Key, KeyCode, NamedKey, PhysicalKey};
use winit::raw_window_handle::{HasDisplayHandle, RawDisplayHandle};
use winit::window::Window;

/// The clipboard of a system for which egui-winit has none.
pub(super) struct Clipboard(Option<arboard::Clipboard>);

impl Clipboard {
    /// Opens the clipboard of the window's system.
    pub(super) fn of(window: &Window) -> Self {
        let is_wayland =
            window.display_handle().is_ok_and(|display| matches!(display.as_raw(), RawDisplayHandle::Wayland(_)));
        if is_wayland {
            return Self(None);
        }
        let opened = arboard::Clipboard::new();
        Self(opened.inspect_err(|error| tracing::warn!("cannot open the clipboard: {error}")).ok())
    }

    /// Returns the text of the clipboard; `None` on Wayland, and if it has no text.
    pub(super) fn text(&mut self) -> Option<String> {
        self.0.as_mut()?.get_text().ok()
    }

    /// Prepares a paste: gives egui the clipboard's text before it sees an event that may paste.
    pub(super) fn before(&mut self, event: &WindowEvent, state: &mut egui_winit::State) {
        let WindowEvent::KeyboardInput { event: key, .. } = event else { return };
        if !may_paste(key) {
            return;
        }
        // If the clipboard has no text, nothing is pasted, not even an earlier text.
        if let Some(clipboard) = &mut self.0 {
            state.set_clipboard_text(clipboard.get_text().unwrap_or_default());
        }
    }

    /// Handles a click of the middle button, after egui has seen it: pastes what is selected elsewhere.
    pub(super) fn after(&mut self, event: &WindowEvent, context: &egui::Context, state: &mut egui_winit::State) {
        let WindowEvent::MouseInput { state: ElementState::Pressed, button: MouseButton::Middle, .. } = event else {
            return;
        };
        let Some(pos) = context.input(|input| input.pointer.latest_pos()) else { return };
        if let Some(text) = self.selected().filter(|text| !text.is_empty()) {
            state.egui_input_mut().events.push(egui::Event::MiddleClickPaste { pos, text });
        }
    }

    /// Stores text that egui has copied or selected.
    pub(super) fn take(&mut self, commands: &[egui::OutputCommand]) {
        for command in commands {
            match command {
                egui::OutputCommand::CopyText(text) => {
                    let Some(clipboard) = &mut self.0 else { continue };
                    if let Err(error) = clipboard.set_text(text.as_str()) {
                        tracing::warn!("cannot copy to the clipboard: {error}");
                    }
                }
                egui::OutputCommand::TextSelectionSettled(text) => self.select(text),
                _ => {}
            }
        }
    }

    #[cfg(target_os = "linux")]
    fn selected(&mut self) -> Option<String> {
        use arboard::{GetExtLinux, LinuxClipboardKind};
        self.0.as_mut()?.get().clipboard(LinuxClipboardKind::Primary).text().ok()
    }

    #[cfg(target_os = "linux")]
    fn select(&mut self, text: &str) {
        use arboard::{LinuxClipboardKind, SetExtLinux};
        let Some(clipboard) = &mut self.0 else { return };
        if let Err(error) = clipboard.set().clipboard(LinuxClipboardKind::Primary).text(text) {
            tracing::debug!("cannot set the primary selection: {error}");
        }
    }

    /// Returns `None`: systems other than Linux have no selection that a click pastes.
    #[cfg(not(target_os = "linux"))]
    fn selected(&mut self) -> Option<String> {
        None
    }

    #[cfg(not(target_os = "linux"))]
    fn select(&mut self, _text: &str) {}
}

/// Returns whether a key, alone or with others, may paste: a superset of what egui-winit takes as a paste.
fn may_paste(key: &KeyEvent) -> bool {
    let logical = match &key.logical_key {
        Key::Named(NamedKey::Paste | NamedKey::Insert) => true,
        Key::Character(text) => text.eq_ignore_ascii_case("v"),
        _ => false,
    };
    let physical = matches!(key.physical_key, PhysicalKey::Code(KeyCode::KeyV | KeyCode::Paste));
    key.state == ElementState::Pressed && (logical || physical)
}
