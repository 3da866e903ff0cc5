//! The window that lists all keys by group; `F1` opens it.

use egui::{Align2, Grid, Key, RichText, Ui, vec2};

use super::keys;

/// Distance from the border of the window in points.
const MARGIN: f32 = 16.0;
/// Width of a column in points.
const COLUMN: f32 = 330.0;

/// The window of keys.
#[derive(Debug, Default)]
pub(super) struct KeysWindow {
    is_open: bool,
}

impl KeysWindow {
    /// Opens the window, or closes it.
    pub(super) fn toggle(&mut self) {
        self.is_open = !self.is_open;
    }

    /// Returns whether the window is open.
    pub(super) fn is_open(&self) -> bool {
        self.is_open
    }

    /// Lays out the window, if it is open.
    pub(super) fn show(&mut self, context: &egui::Context) {
        if !self.is_open {
            return;
        }
        let mut is_closed = context.input(|input| input.key_pressed(Key::Escape));
        let free = context.content_rect().shrink(MARGIN);
        let columns = ((free.width() / COLUMN) as usize).clamp(1, 2);
        let window = egui::Window::new("Keys").id(egui::Id::unique("keys window")).collapsible(false).resizable(false);
        let window = window.anchor(Align2::CENTER_CENTER, [0.0, 0.0]).order(egui::Order::Foreground).title_bar(false);
        let size = vec2((columns as f32 * COLUMN).min(free.width()), free.height());
        window.fixed_size(size).fade_in(false).fade_out(false).show(context, |ui| {
            ui.set_width(size.x);
            ui.horizontal(|ui| {
                ui.label(RichText::new("Keys").heading().strong());
                let button = ui.button("Close").on_hover_text("Close this window (Esc, F1)");
                // Tabs of panels have buttons of the same name.
                context.accesskit_node_builder(button.id, |node| node.set_label("Close the keys"));
                is_closed |= button.clicked();
            });
            ui.separator();
            let tallest = (free.height() - 60.0).max(60.0);
            egui::ScrollArea::vertical().max_height(tallest).auto_shrink([false, true]).show(ui, |ui| {
                ui.horizontal_top(|ui| {
                    for part in keys::HELP.chunks(keys::HELP.len().div_ceil(columns)) {
                        ui.vertical(|ui| {
                            ui.set_width(size.x / columns as f32 - 2.0 * MARGIN);
                            part.iter().for_each(|group| add_group(ui, group));
                        });
                    }
                });
            });
        });
        if is_closed {
            self.is_open = false;
            context.request_repaint();
        }
    }
}

/// Adds the keys of a group below its heading.
fn add_group(ui: &mut Ui, group: &keys::Group) {
    ui.label(RichText::new(group.heading).strong());
    Grid::new(group.heading).num_columns(2).min_col_width(140.0).spacing([12.0, 2.0]).show(ui, |ui| {
        for (keys, action) in group.keys {
            ui.label(RichText::new(*keys).monospace());
            ui.label(*action);
            ui.end_row();
        }
    });
    ui.add_space(6.0);
}

#[cfg(test)]
mod tests {
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable as _;

    use super::*;
    use crate::window::screen_reader::tests::{repeated, unnamed};

    fn open(size: egui::Vec2) -> Harness<'static, KeysWindow> {
        let harness = Harness::builder().with_size(size).with_context_setup(crate::window::panel::set_up);
        let mut harness =
            harness.build_ui_state(|ui, keys: &mut KeysWindow| keys.show(ui.ctx()), KeysWindow::default());
        harness.run();
        assert!(harness.query_by_label("Close the keys").is_none(), "the window is closed at first");
        harness.state_mut().toggle();
        harness.run();
        harness
    }

    #[test]
    fn all_keys_are_listed_by_group() {
        let harness = open(vec2(960.0, 720.0));
        let mut count = 0;
        for group in keys::HELP {
            assert!(harness.query_by_label(group.heading).is_some(), "{}", group.heading);
            for (key, action) in group.keys {
                assert!(harness.query_all_by_label(key).next().is_some(), "{key}");
                assert!(harness.query_all_by_label(action).next().is_some(), "{action}");
                count += 1;
            }
        }
        assert!(count > 35, "{count} keys");
        assert!(unnamed(&harness).is_empty() && repeated(&harness).is_empty());
        // Planted: a key that does not exist is not listed.
        assert!(harness.query_by_label("F13").is_none());
    }

    #[test]
    fn the_window_fits_and_closes() {
        for size in [vec2(1280.0, 800.0), vec2(640.0, 360.0), vec2(320.0, 200.0)] {
            let mut harness = open(size);
            let window = egui::Rect::from_min_size(egui::Pos2::ZERO, size);
            let button = harness.get_by_label("Close the keys").rect();
            assert!(window.contains_rect(button), "{size}: {button}");
            harness.get_by_label("Close the keys").click();
            harness.run();
            assert!(!harness.state().is_open() && harness.query_by_label("Close the keys").is_none());
            harness.state_mut().toggle();
            harness.run();
            harness.key_press(Key::Escape);
            harness.run();
            assert!(!harness.state().is_open(), "Esc does not close it");
        }
    }
}
