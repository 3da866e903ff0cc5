//! The line at the bottom of the window: the place under the cursor, and the field for coordinates to go to.

use egui::{Align2, Key, RichText, Ui};

use super::place_picking::PlaceUnderCursor;
use super::places::{FORMS, Places, distance_text};

/// Distance from the border of the window, in points.
const MARGIN: f32 = 8.0;
/// Distance of the field from the border of the window, in points: the line is below it.
const LINE: f32 = 40.0;

/// The field for coordinates, while it is open.
#[derive(Debug, Default)]
pub(super) struct GoTo {
    text: Option<String>,
    /// The reason why the last coordinates were refused, if they were.
    error: Option<String>,
    /// Whether the field takes the keyboard in the next frame.
    takes_focus: bool,
}

impl GoTo {
    /// Opens the field.
    pub(super) fn open(&mut self) {
        self.text.get_or_insert_default();
        self.takes_focus = true;
    }

    /// Closes the field.
    pub(super) fn close(&mut self) {
        *self = Self::default();
    }

    /// Shows why coordinates were refused.
    pub(super) fn refuse(&mut self, error: String) {
        self.error = Some(error);
        self.takes_focus = true;
    }

    fn show(&mut self, ui: &mut Ui) -> Option<String> {
        let text = self.text.as_mut()?;
        let mut typed = None;
        let mut closes = false;
        ui.horizontal(|ui| {
            ui.label("Go to");
            let field = ui.add(egui::TextEdit::singleline(text).hint_text("46.5370,7.9622").desired_width(230.0));
            ui.ctx().accesskit_node_builder(field.id, |node| node.set_label("Coordinates to go to"));
            if std::mem::take(&mut self.takes_focus) {
                field.request_focus();
            }
            let has_enter = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            closes = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Escape));
            let field = field.on_hover_text(format!("Write {FORMS}."));
            if field.changed() {
                self.error = None;
            }
            if ui.button("Go").on_hover_text("Fly there (Enter)").clicked() || has_enter {
                typed = Some(text.clone());
            }
            closes |= ui.button("Close").on_hover_text("Close this field (Esc)").clicked();
        });
        if let Some(error) = &self.error {
            ui.add(egui::Label::new(RichText::new(error).color(super::panel::WARNING)).wrap());
        }
        if closes {
            self.close();
            // This frame still shows the field.
            ui.ctx().request_repaint();
            return None;
        }
        typed
    }
}

/// Returns the words of the line: coordinates, height and distance.
pub(super) fn words(place: &PlaceUnderCursor, places: &Places, exaggeration: f64) -> Vec<String> {
    let Some(place_m) = place.place_m else { return vec!["sky".to_owned()] };
    let mut words = places.texts(place_m.truncate());
    words.push(format!("height {:.0} m", place_m.z / exaggeration));
    words.push(format!("{} away", distance_text(place.distance_m)));
    words
}

/// Copies the coordinates of the line, which are the first of its words, if the user requests it while no text is
/// selected. Returns what was copied.
pub(super) fn copy(context: &egui::Context, words: &[String]) -> Option<String> {
    let is_asked = context.input(|input| input.events.iter().any(|event| matches!(event, egui::Event::Copy)));
    let has_selection = || context.plugin::<egui::text_selection::LabelSelectionState>().lock().has_selection();
    if !is_asked || context.text_edit_focused() || has_selection() {
        return None;
    }
    // The sky has no coordinates.
    let coordinates = words.first().filter(|_| words.len() > 1)?;
    context.copy_text(coordinates.clone());
    Some(coordinates.clone())
}

/// Shows the line, and the field if it is open. Returns the coordinates to which the user wants to go.
/// `free` is the part of the window that no panel covers.
pub(super) fn show(
    context: &egui::Context,
    free: egui::Rect,
    words: &[String],
    hint: Option<&str>,
    go_to: &mut GoTo,
) -> Option<String> {
    let at = |above: f32| free.left_bottom() + egui::vec2(MARGIN, -above);
    if words.is_empty() && go_to.text.is_none() {
        return None;
    }
    if !words.is_empty() {
        // The line is only read: clicks are for the picture below it.
        let area = egui::Area::new(egui::Id::unique("status")).order(egui::Order::Middle).interactable(false);
        area.pivot(Align2::LEFT_BOTTOM).fixed_pos(at(MARGIN)).show(context, |ui| {
            frame(ui).show(ui, |ui| {
                ui.set_max_width(widest(free));
                ui.horizontal_wrapped(|ui| {
                    ui.spacing_mut().item_spacing.x = 14.0;
                    words.iter().for_each(|word| _ = ui.label(RichText::new(word).monospace()));
                    hint.iter().for_each(|hint| _ = ui.label(RichText::new(*hint).weak()));
                });
            });
        });
    }
    go_to.text.as_ref()?;
    let mut typed = None;
    let area = egui::Area::new(egui::Id::unique("go to")).order(egui::Order::Foreground);
    area.pivot(Align2::LEFT_BOTTOM).fixed_pos(at(LINE)).show(context, |ui| {
        frame(ui).show(ui, |ui| {
            ui.set_max_width(widest(free));
            typed = go_to.show(ui);
        });
    });
    typed
}

fn frame(ui: &Ui) -> egui::Frame {
    egui::Frame::window(ui.style()).inner_margin(egui::Margin::symmetric(8, 4))
}

fn widest(free: egui::Rect) -> f32 {
    (free.width() - 4.0 * MARGIN).max(60.0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable as _;

    use super::*;

    #[derive(Default)]
    struct Bench {
        go_to: GoTo,
        typed: Vec<String>,
        copied: Vec<String>,
        is_over_sky: bool,
    }

    fn harness<'a>() -> Harness<'a, Bench> {
        let words = ["46.85230°, -121.76030°".to_owned(), "height 4390 m".to_owned()];
        let sky = ["sky".to_owned()];
        let harness = Harness::builder().with_size(egui::vec2(640.0, 360.0));
        let mut harness = harness.with_context_setup(crate::window::panel::set_up).build_ui_state(
            move |ui, bench: &mut Bench| {
                let typed = show(ui.ctx(), ui.ctx().content_rect(), &words, Some("EPSG:32610"), &mut bench.go_to);
                bench.typed.extend(typed);
                bench.copied.extend(copy(ui.ctx(), if bench.is_over_sky { &sky } else { &words }));
            },
            Bench::default(),
        );
        harness.run();
        harness
    }

    #[test]
    fn coordinates_are_shown_and_typed() {
        let mut harness = harness();
        assert!(harness.query_by_label("46.85230°, -121.76030°").is_some());
        assert!(harness.query_by_label("Coordinates to go to").is_none());
        harness.state_mut().go_to.open();
        harness.run();
        // The field has the keyboard at once.
        harness.get_by_label("Coordinates to go to").type_text("46.8,-121.7");
        harness.run();
        assert!(harness.state().typed.is_empty(), "it is not complete");
        harness.key_press(Key::Enter);
        harness.run();
        assert_eq!(harness.state().typed, ["46.8,-121.7"]);
        harness.state_mut().go_to.refuse("46.8,-121.7: outside of a.tif".to_owned());
        harness.run();
        assert!(harness.query_by_label("46.8,-121.7: outside of a.tif").is_some());
    }

    #[test]
    fn coordinates_are_copied() {
        let mut harness = harness();
        let copy = |harness: &mut Harness<'_, Bench>| {
            harness.event(egui::Event::Copy);
            harness.step();
            let commands = harness.output().platform_output.commands.iter();
            let texts = commands.filter_map(|command| match command {
                egui::OutputCommand::CopyText(text) => Some(text.clone()),
                _ => None,
            });
            texts.collect::<Vec<_>>()
        };
        assert_eq!(copy(&mut harness), ["46.85230°, -121.76030°"]);
        assert_eq!(harness.state().copied, ["46.85230°, -121.76030°"]);
        // Planted: there is nothing to copy in the sky, and a field copies its own text.
        harness.state_mut().is_over_sky = true;
        assert!(copy(&mut harness).is_empty());
        harness.state_mut().is_over_sky = false;
        harness.state_mut().go_to.open();
        harness.run();
        assert!(copy(&mut harness).is_empty());
        assert_eq!(harness.state().copied.len(), 1);
    }

    #[test]
    fn the_line_lets_clicks_through() {
        let harness = harness();
        let at = harness.get_by_label("height 4390 m").rect().center();
        let layer = harness.ctx.layer_id_at(at);
        assert!(layer.is_none_or(|layer| layer.order == egui::Order::Background), "{layer:?}");
    }
}
