//! The welcome of the first start: three sentences and the keys.

use egui::{Align, Align2, Button, Key, Layout, RichText};

use super::keys;

const SENTENCES: [&str; 3] = [
    "hachure draws land as you fly over it: drag to look around, and press W A S D to fly.",
    "G shows all styles as pictures of this view; click a line of the drawing to edit the layer that drew it.",
    "F12 saves the picture, with all that it takes to draw it again.",
];
/// Width in points above which the list of keys has two columns.
const WIDE: f32 = 480.0;

/// Shows the sentences in the middle of the window. Returns whether they have been closed.
pub(super) fn show(context: &egui::Context) -> bool {
    let mut is_closed = false;
    let size = context.content_rect().size();
    let area = egui::Area::new(egui::Id::unique("welcome")).order(egui::Order::Foreground);
    area.anchor(Align2::CENTER_CENTER, [0.0, 0.0]).show(context, |ui| {
        egui::Frame::window(ui.style()).inner_margin(14).show(ui, |ui| {
            let width = (size.x - 60.0).clamp(120.0, 560.0);
            ui.set_width(width);
            ui.horizontal(|ui| {
                ui.label(RichText::new("Welcome to hachure").heading().strong());
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let button = ui.add(Button::new("Begin"));
                    // Enter reaches the panels only if a widget has the focus.
                    if ui.memory(|memory| memory.focused().is_none()) {
                        button.request_focus();
                    }
                    let has_key = ui.input(|input| input.key_pressed(Key::Escape) || input.key_pressed(Key::Enter));
                    let hint = "These sentences do not come again; F1 shows the keys (Enter, Esc)";
                    is_closed = button.on_hover_text(hint).clicked() || has_key;
                });
            });
            ui.separator();
            let tallest = (size.y - 100.0).max(40.0);
            egui::ScrollArea::vertical().max_height(tallest).show(ui, |ui| {
                SENTENCES.iter().for_each(|sentence| _ = ui.add(egui::Label::new(*sentence).wrap()));
                ui.add_space(6.0);
                let columns = if width > WIDE { 2 } else { 1 };
                egui::Grid::new("keys").num_columns(2 * columns).spacing([14.0, 2.0]).show(ui, |ui| {
                    let all: Vec<_> = keys::HELP.iter().flat_map(|group| group.keys).collect();
                    for row in all.chunks(columns) {
                        for (keys, what) in row {
                            ui.label(RichText::new(*keys).monospace().strong());
                            ui.label(*what);
                        }
                        ui.end_row();
                    }
                });
            });
        });
    });
    is_closed
}

#[cfg(test)]
mod tests {
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable as _;

    #[test]
    fn three_sentences_and_the_keys_fit_and_close() {
        for size in [egui::vec2(1280.0, 800.0), egui::vec2(960.0, 540.0), egui::vec2(320.0, 200.0)] {
            let harness = Harness::builder().with_size(size).with_context_setup(crate::window::panel::set_up);
            let mut harness = harness.build_ui_state(|ui, closed: &mut bool| *closed |= super::show(ui.ctx()), false);
            harness.run();
            let button = harness.get_by_label("Begin").rect();
            let window = egui::Rect::from_min_size(egui::Pos2::ZERO, size);
            assert!(window.contains_rect(button), "{size}: {button}");
            assert!(harness.get_by_label("Begin").is_focused(), "Enter does not close it");
            assert!(harness.query_by_label("gallery of styles").is_some());
            assert!(!*harness.state());
            harness.get_by_label("Begin").click();
            harness.run();
            assert!(*harness.state());
        }
    }
}
