//! The divider between two styles: the current style is right of it, and another one, or the style before its edits, is
//! left of it.

use egui::{Align2, Color32, CursorIcon, Id, Key, Order, Rect, Response, RichText, Sense, Ui, pos2, vec2};

use super::settings::Styles;
use crate::studio::document::StyleDocument;

/// Width of the area in which the mouse grabs the divider, in points.
const GRAB: f32 = 16.0;
/// Radius of the handle in points.
const HANDLE: f32 = 11.0;
/// Distance of the names from the top of the picture, and from the divider, in points.
const MARGIN: f32 = 10.0;
/// Part of the width by which an arrow key moves the divider.
const STEP: f32 = 0.02;
/// The least part of the width on each side.
const LEAST: f32 = 0.02;

/// The style left of the divider.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Left {
    /// The current style without the edits that are not saved.
    Saved,
    /// A style of the list, by its index.
    Style(usize),
}

/// The divider, while it is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Divider {
    /// Position of the divider from the left, as a fraction of the window's width.
    pub at: f32,
    pub left: Left,
}

impl Divider {
    /// Creates a divider in the middle.
    pub(super) fn new(left: Left) -> Self {
        Self { at: 0.5, left }
    }

    /// Lays out the divider in a window whose part `free` no panel covers. `is_ready` says whether the left style is drawn.
    /// Returns whether the divider stays.
    pub(super) fn show(
        &mut self,
        context: &egui::Context,
        free: Rect,
        styles: &Styles,
        present: usize,
        is_ready: bool,
    ) -> bool {
        let window = context.content_rect();
        let x = (window.left() + self.at * window.width()).clamp(free.left(), free.right());
        let moved = line(context, free, x);
        if let Some(x) = moved {
            self.at = (x.clamp(free.left(), free.right()) - window.left()) / window.width().max(1.0);
        }
        self.at = self.at.clamp(LEAST, 1.0 - LEAST);
        let mut stays = true;
        let present_name = styles.list()[present].name.as_str();
        sign(context, "divider left", Align2::RIGHT_TOP, pos2(x - MARGIN, free.top() + MARGIN), |ui| {
            let is_edited = styles.document(present).is_some_and(StyleDocument::is_edited);
            let name = |left: Left| match left {
                Left::Saved if is_edited => format!("{present_name} (as saved)"),
                Left::Saved => present_name.to_owned(),
                Left::Style(style) => styles.list()[style].name.clone(),
            };
            let list = egui::ComboBox::from_id_salt("left of the divider").selected_text(name(self.left));
            let list = list.show_ui(ui, |ui| {
                // The current style can only be compared with its saved form.
                let others = (0..styles.list().len()).filter(|style| *style != present).map(Left::Style);
                let all = std::iter::once(Left::Saved).chain(others);
                for left in all {
                    ui.selectable_value(&mut self.left, left, name(left));
                }
            });
            named(&list.response, "Style left of the divider");
            if !is_ready {
                ui.label(RichText::new("is being prepared…").weak());
            }
        });
        sign(context, "divider right", Align2::LEFT_TOP, pos2(x + MARGIN, free.top() + MARGIN), |ui| {
            ui.label(present_name);
            let close = ui.small_button("×").on_hover_text("Show only this style (X)");
            named(&close, "Remove the divider");
            stays = !close.clicked();
        });
        stays
    }
}

/// Adds the line with its handle. Returns where it is moved to.
fn line(context: &egui::Context, free: Rect, x: f32) -> Option<f32> {
    let area = egui::Area::new(Id::unique("divider")).order(Order::Middle).movable(false);
    let area = area.fixed_pos(pos2(x - 0.5 * GRAB, free.top())).constrain(false);
    let line = area.show(context, |ui| {
        let (rect, line) = ui.allocate_exact_size(vec2(GRAB, free.height()), Sense::drag());
        let center = pos2(x, rect.center().y);
        let is_held = line.hovered() || line.dragged() || line.has_focus();
        let color = if is_held { Color32::WHITE } else { Color32::from_white_alpha(210) };
        let painter = ui.painter();
        painter.vline(x, rect.y_range(), (3.0, Color32::from_black_alpha(110)));
        painter.vline(x, rect.y_range(), (1.0, color));
        painter.circle(center, HANDLE, Color32::from_black_alpha(170), (1.5, color));
        for side in [-1.0, 1.0] {
            let corner = |right: f32, down: f32| center + vec2(side * right, down);
            let arrow = vec![corner(2.5, -4.0), corner(7.0, 0.0), corner(2.5, 4.0)];
            painter.add(egui::Shape::convex_polygon(arrow, color, egui::Stroke::NONE));
        }
        line.widget_info(|| {
            let part = f64::from((x - free.left()) / free.width().max(1.0));
            egui::WidgetInfo::slider(true, (100.0 * part).round(), "Divider between two styles")
        });
        line.on_hover_cursor(CursorIcon::ResizeHorizontal)
    });
    let line = line.inner;
    if line.dragged() || line.drag_stopped() {
        return line.ctx.pointer_latest_pos().map(|at| at.x);
    }
    if line.has_focus() {
        let keys =
            |key: Key| line.ctx.input_mut(|input| input.count_and_consume_key(egui::Modifiers::NONE, key)) as f32;
        let steps = keys(Key::ArrowRight) - keys(Key::ArrowLeft);
        line.ctx.memory_mut(|memory| {
            let arrows = egui::EventFilter { horizontal_arrows: true, ..Default::default() };
            memory.set_focus_lock_filter(line.id, arrows);
        });
        return (steps != 0.0).then(|| x + steps * STEP * line.ctx.content_rect().width());
    }
    None
}

/// Adds a sign at the top of one side.
fn sign(context: &egui::Context, id: &str, pivot: Align2, at: egui::Pos2, content: impl FnOnce(&mut Ui)) {
    let area = egui::Area::new(Id::unique(id)).order(Order::Middle).movable(false).pivot(pivot).fixed_pos(at);
    area.constrain(false).show(context, |ui| {
        egui::Frame::window(ui.style()).inner_margin(4).show(ui, |ui| ui.horizontal(content));
    });
}

/// Names a widget for a screen reader.
fn named(response: &Response, label: &str) {
    response.ctx.accesskit_node_builder(response.id, |node| node.set_label(label));
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use egui_kittest::Harness;
    use egui_kittest::kittest::{NodeT as _, Queryable as _};

    use super::*;

    fn harness<'a>() -> Harness<'a, (Divider, bool)> {
        of_styles(Styles::with("ink").unwrap())
    }

    fn of_styles<'a>((styles, present): (Styles, usize)) -> Harness<'a, (Divider, bool)> {
        let harness = Harness::builder().with_size(vec2(800.0, 600.0));
        harness.with_context_setup(crate::window::panel::set_up).build_ui_state(
            move |ui, (divider, stays): &mut (Divider, bool)| {
                let free = Rect::from_min_max(pos2(200.0, 0.0), pos2(800.0, 600.0));
                *stays &= divider.show(ui.ctx(), free, &styles, present, true);
            },
            (Divider::new(Left::Saved), true),
        )
    }

    #[test]
    fn the_divider_is_dragged_and_moved_by_keys_and_stays_beside_panels() {
        let mut harness = harness();
        harness.run();
        let drag = |harness: &mut Harness<'_, (Divider, bool)>, to: f32| {
            let from = harness.get_by_label("Divider between two styles").rect().center();
            harness.drag_at(from);
            harness.run();
            harness.drop_at(pos2(to, from.y));
            harness.run();
            harness.state().0.at
        };
        assert!((drag(&mut harness, 600.0) - 0.75).abs() < 0.01, "{}", harness.state().0.at);
        // Not under the panel on the left.
        assert!((drag(&mut harness, 20.0) - 0.25).abs() < 0.01, "{}", harness.state().0.at);
        harness.get_by_label("Divider between two styles").focus();
        harness.run();
        harness.key_press(Key::ArrowRight);
        harness.run();
        assert!((harness.state().0.at - 0.27).abs() < 0.005, "{}", harness.state().0.at);
    }

    #[test]
    fn only_an_edited_style_is_compared_as_it_is_saved() {
        let shown = |harness: &Harness<'_, (Divider, bool)>| {
            harness.get_by_label("Style left of the divider").accesskit_node().value()
        };
        let mut plain = harness();
        plain.run();
        assert_eq!(shown(&plain).as_deref(), Some("ink"));
        let (mut styles, present) = Styles::with("ink").unwrap();
        styles.open(present).unwrap();
        styles.document_mut(present).unwrap().set("tone.steps", 5_i64).unwrap();
        styles.refresh(present);
        let mut edited = of_styles((styles, present));
        edited.run();
        assert_eq!(shown(&edited).as_deref(), Some("ink (as saved)"));
    }

    #[test]
    fn the_left_style_is_chosen_and_the_divider_is_removed() {
        let mut harness = harness();
        harness.run();
        harness.get_by_label("Style left of the divider").click();
        harness.run();
        // The list is long, and shows its beginning.
        let (styles, present) = Styles::with("ink").unwrap();
        let other = if present == 2 { 3 } else { 2 };
        harness.get_by_label(&styles.list()[other].name).click();
        harness.run();
        assert_eq!(harness.state().0.left, Left::Style(other));
        assert!(harness.state().1);
        harness.get_by_label("Remove the divider").click();
        harness.run();
        assert!(!harness.state().1);
    }
}
