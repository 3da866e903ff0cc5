//! Small buttons with drawn signs: the font of the panel has few.

use egui::{Button, Color32, Response, Stroke, Ui, pos2, vec2};

/// The icon of a button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Icon {
    /// An arrow up, to raise a layer.
    Up,
    /// An arrow down, to lower a layer.
    Down,
    /// Two sheets, to duplicate a layer.
    Copy,
    /// A cross, to remove a layer.
    Remove,
    /// An eye, to show or hide a layer.
    Eye,
    /// One of three bars, to draw a layer alone.
    Alone,
}

/// Size of a button in points.
const SIZE: egui::Vec2 = vec2(18.0, 16.0);

/// Adds a button with a sign.
pub(super) fn button(ui: &mut Ui, icon: Icon, is_enabled: bool, is_on: bool) -> Response {
    let response = ui.add_enabled(is_enabled, Button::new("").min_size(SIZE).selected(is_on));
    let color = match is_enabled {
        true => ui.style().interact(&response).text_color(),
        false => ui.visuals().weak_text_color().gamma_multiply(0.5),
    };
    paint(ui, icon, response.rect.center(), color, is_on);
    response
}

fn paint(ui: &Ui, icon: Icon, at: egui::Pos2, color: Color32, is_on: bool) {
    let painter = ui.painter();
    let stroke = Stroke::new(1.2, color);
    let line = |from: [f32; 2], to: [f32; 2]| {
        let [from, to] = [from, to].map(|[x, y]| pos2(at.x + x, at.y + y));
        painter.line_segment([from, to], stroke);
    };
    let arrow = |down: f32| {
        line([0.0, -4.0 * down], [0.0, 4.0 * down]);
        line([-3.0, down], [0.0, 4.0 * down]);
        line([3.0, down], [0.0, 4.0 * down]);
    };
    let sheet = |x: f32, y: f32| {
        let rect = egui::Rect::from_center_size(pos2(at.x + x, at.y + y), vec2(6.0, 7.0));
        painter.rect_stroke(rect, 0.0, stroke, egui::StrokeKind::Middle);
    };
    match icon {
        Icon::Up => arrow(-1.0),
        Icon::Down => arrow(1.0),
        Icon::Copy => {
            sheet(-1.5, -1.5);
            sheet(1.5, 1.5);
        }
        Icon::Remove => {
            line([-3.0, -3.0], [3.0, 3.0]);
            line([-3.0, 3.0], [3.0, -3.0]);
        }
        Icon::Eye => {
            painter.add(egui::epaint::EllipseShape::stroke(at, vec2(5.0, 3.2), stroke));
            painter.circle_filled(at, 1.5, color);
            if is_on {
                line([-5.0, 4.5], [5.0, -4.5]);
            }
        }
        Icon::Alone => {
            line([-4.0, -3.5], [4.0, -3.5]);
            line([-4.0, 3.5], [4.0, 3.5]);
            painter.rect_filled(egui::Rect::from_center_size(at, vec2(9.0, 3.0)), 0.0, color);
        }
    }
}
