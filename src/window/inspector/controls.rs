//! The five controls at the top of the inspector.

use egui::{Align, Color32, Layout, RichText, Slider, Ui};

use super::values::is_menu_click;
use super::{Edit, LABEL_WIDTH, named};
use crate::studio::document::StyleDocument;
use crate::style::controls::{Control, END};
use crate::window::panel::hint;

/// Width of a slider in points.
const SLIDER_WIDTH: f32 = 150.0;

/// Adds a slider for each control. A double click on its name, or Backspace, returns it to the middle.
pub(super) fn show(ui: &mut Ui, document: &StyleDocument, edits: &mut Vec<Edit>) {
    ui.separator();
    let heading = RichText::new("Whole style").strong();
    ui.label(heading).on_hover_text("Each of these changes several parameters of the style");
    for control in Control::ALL {
        ui.push_id(control.name(), |ui| ui.horizontal(|ui| slider(ui, document, control, edits)));
    }
    ui.separator();
}

fn slider(ui: &mut Ui, document: &StyleDocument, control: Control, edits: &mut Vec<Edit>) {
    let without_effect = control.without_effect(document.style());
    let before = document.control(control);
    let help = match without_effect {
        Some(why) => format!("{}\nWithout effect here: {why}", control.help()),
        None => format!(
            "{}\n−{END} to {END}; 0 is the style as it is saved. Backspace returns to 0.\nIt changes several parameters \
             below.",
            control.help()
        ),
    };
    let size = egui::vec2(LABEL_WIDTH, ui.spacing().interact_size.y);
    let text = RichText::new(control.name());
    let text = if before == 0 { text.weak() } else { text.color(Color32::WHITE) };
    let label = ui.allocate_ui_with_layout(size, Layout::left_to_right(Align::Center), |ui| {
        ui.set_min_width(LABEL_WIDTH);
        ui.add(egui::Label::new(text).sense(egui::Sense::click()))
    });
    ui.add_enabled_ui(without_effect.is_none(), |ui| {
        ui.spacing_mut().slider_width = SLIDER_WIDTH;
        let mut position = before;
        let widget = ui.add(Slider::new(&mut position, -END..=END).show_value(false));
        named(&widget, control.name());
        if widget.changed() && position != before && !is_menu_click(ui) {
            edits.push(Edit::Control(control, position));
        }
        let is_aimed_at = widget.hovered() || widget.has_focus() || label.inner.hovered();
        let restores =
            is_aimed_at && !ui.ctx().text_edit_focused() && ui.input(|input| input.key_pressed(egui::Key::Backspace));
        if (restores || label.inner.double_clicked()) && before != 0 && without_effect.is_none() {
            edits.push(Edit::Control(control, 0));
        }
        hint(widget, &help).on_disabled_hover_text(&help);
    });
    label.inner.on_hover_text(&help);
    let shown = if before == 0 { "0".to_owned() } else { format!("{before:+}").replace('-', "−") };
    ui.label(RichText::new(shown).monospace().weak());
}
