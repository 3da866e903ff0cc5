//! The time line: seconds, key frames as diamonds, and the playhead.

use egui::{Align2, Color32, EventFilter, FontId, Key, Pos2, Rect, Sense, Shape, Stroke, Ui, pos2, vec2};

use super::{PathEdit, PathRequest, PathState};

/// Height in points: above are the seconds, below the keys.
const HEIGHT: f32 = 38.0;
/// Height of the seconds in points.
const TICKS: f32 = 15.0;
/// Distance of the first and the last second from the border in points.
const SIDE: f32 = 12.0;
/// Half of the diagonal of a diamond in points.
const DIAMOND: f32 = 6.0;
/// Least distance between two numbers in points.
const LABELS: f32 = 52.0;
/// More keys than this are drawn as lines, and are selected in the list.
const MOST_DIAMONDS: usize = 500;
/// Step of the playhead for an arrow key, in seconds.
const STEP_S: f64 = 0.1;

/// The state of the time line.
#[derive(Debug, Default)]
pub(super) struct Timeline {
    drag: Option<Drag>,
}

/// A key that is being dragged.
#[derive(Clone, Copy, Debug)]
struct Drag {
    index: usize,
    /// From the mouse to the key, in points.
    offset: f32,
    /// The range of the time line, which stays during a drag.
    range_s: [f64; 2],
}

/// Maps times to points.
#[derive(Clone, Copy, Debug)]
struct Scale {
    rect: Rect,
    range_s: [f64; 2],
}

impl Scale {
    fn x(&self, time_s: f64) -> f32 {
        let [from_s, to_s] = self.range_s;
        let part = ((time_s - from_s) / (to_s - from_s)).clamp(-1.0, 2.0) as f32;
        self.rect.left() + SIDE + part * (self.rect.width() - 2.0 * SIDE)
    }

    fn time_s(&self, x: f32) -> f64 {
        let part = f64::from((x - self.rect.left() - SIDE) / (self.rect.width() - 2.0 * SIDE).max(1.0));
        let [from_s, to_s] = self.range_s;
        // Hundredths are finer than a pixel in most paths, and short.
        ((from_s + part * (to_s - from_s)) * 100.0).round() / 100.0
    }
}

impl Timeline {
    /// Adds the time line. Returns the key that was selected.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        shown: &PathState<'_>,
        selected: Option<usize>,
        requests: &mut Vec<PathRequest>,
    ) -> Option<usize> {
        let width = ui.available_width().max(4.0 * SIDE);
        let (id, rect) = ui.allocate_space(vec2(width, HEIGHT));
        let range_s = self.drag.map_or_else(|| range_s(shown.document.span_s()), |drag| drag.range_s);
        let scale = Scale { rect, range_s };
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 2.0, Color32::from_white_alpha(12));
        ticks(ui, &scale);
        track(ui, id, &scale, shown, requests);
        let picked = self.keys(ui, id, &scale, shown, selected, requests);
        let x = scale.x(shown.player.playhead_s);
        let color = Color32::from_rgb(250, 210, 90);
        painter.vline(x, rect.y_range(), (1.5, color));
        let top = rect.top();
        let triangle = vec![pos2(x - 5.0, top), pos2(x + 5.0, top), pos2(x, top + 7.0)];
        painter.add(Shape::convex_polygon(triangle, color, Stroke::NONE));
        picked
    }

    fn keys(
        &mut self,
        ui: &Ui,
        id: egui::Id,
        scale: &Scale,
        shown: &PathState<'_>,
        selected: Option<usize>,
        requests: &mut Vec<PathRequest>,
    ) -> Option<usize> {
        let keys = shown.document.keys();
        let painter = ui.painter_at(scale.rect);
        let y = 0.5 * (scale.rect.top() + TICKS + scale.rect.bottom());
        painter.hline(
            scale.x(shown.document.span_s()[0])..=scale.x(shown.document.span_s()[1]),
            y,
            (1.0, Color32::from_white_alpha(60)),
        );
        if keys.len() > MOST_DIAMONDS {
            let mut last = f32::NEG_INFINITY;
            for x in keys.iter().map(|key| scale.x(key.time_s)) {
                if x - last >= 1.0 {
                    painter.vline(x, y - 4.0..=y + 4.0, (1.0, Color32::from_gray(190)));
                    last = x;
                }
            }
            return None;
        }
        let mut picked = None;
        for (index, key) in keys.iter().enumerate() {
            let at = pos2(scale.x(key.time_s), y);
            let area = Rect::from_center_size(at, vec2(2.0 * DIAMOND, scale.rect.height() - TICKS));
            // The list is for the keyboard.
            let response = ui.interact(area, id.with(index), Sense::CLICK | Sense::DRAG);
            let label = format!("Key {} at {} s", index + 1, key.time_s);
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &label));
            if response.drag_started()
                && let Some(pressed) = ui.input(|input| input.pointer.press_origin())
            {
                self.drag = Some(Drag { index, offset: at.x - pressed.x, range_s: scale.range_s });
            }
            if response.clicked() || response.drag_started() {
                picked = Some(index);
                requests.push(PathRequest::Seek(key.time_s));
            }
            if let (Some(drag), Some(pointer)) = (self.drag, response.interact_pointer_pos())
                && drag.index == index
                && response.dragged()
            {
                requests.push(PathRequest::Edit(PathEdit::Move(index, scale.time_s(pointer.x + drag.offset))));
            }
            if response.drag_stopped() {
                self.drag = None;
                requests.push(PathRequest::Edit(PathEdit::Release));
            }
            let color = match (selected == Some(index), response.hovered()) {
                (true, _) => ui.visuals().selection.stroke.color,
                (false, true) => Color32::WHITE,
                (false, false) => Color32::from_gray(190),
            };
            diamond(&painter, at, color, key.ease as f32, selected == Some(index));
            response.on_hover_text(label);
        }
        picked
    }
}

/// Paints a key; the more the camera slows down there, the emptier it is.
fn diamond(painter: &egui::Painter, at: Pos2, color: Color32, ease: f32, is_selected: bool) {
    let size = if is_selected { DIAMOND + 1.5 } else { DIAMOND };
    let corners = [(0.0, -size), (size, 0.0), (0.0, size), (-size, 0.0)];
    let corners = corners.into_iter().map(|(x, y)| at + vec2(x, y)).collect();
    painter.add(Shape::convex_polygon(corners, color.gamma_multiply(1.0 - 0.85 * ease), Stroke::new(1.3, color)));
}

/// Adds the area in which the playhead is dragged.
fn track(ui: &Ui, id: egui::Id, scale: &Scale, shown: &PathState<'_>, requests: &mut Vec<PathRequest>) {
    let [first_s, last_s] = shown.document.span_s();
    let playhead_s = shown.player.playhead_s;
    let response = ui.interact(scale.rect, id.with("track"), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::slider(true, playhead_s, "Time line of the camera path"));
    ui.ctx().accesskit_node_builder(response.id, |node| {
        use egui::accesskit::Action;
        node.set_min_numeric_value(first_s);
        node.set_max_numeric_value(last_s);
        node.set_numeric_value_step(STEP_S);
        [Action::SetValue, Action::Increment, Action::Decrement].into_iter().for_each(|action| node.add_action(action));
    });
    if shown.document.keys().is_empty() {
        return;
    }
    if response.is_pointer_button_down_on()
        && let Some(at) = response.interact_pointer_pos()
    {
        let time_s = scale.time_s(at.x).clamp(first_s, last_s);
        if time_s != playhead_s || shown.player.is_playing() {
            requests.push(PathRequest::Seek(time_s));
        }
    } else if response.clicked() && ui.input(|input| input.key_pressed(Key::Space) || input.key_pressed(Key::Enter)) {
        requests.push(PathRequest::Play(!shown.player.is_playing()));
    }
    if response.has_focus() {
        let filter = EventFilter { horizontal_arrows: true, ..EventFilter::default() };
        ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
        let painter = ui.painter_at(scale.rect);
        painter.rect_stroke(scale.rect, 2.0, ui.visuals().selection.stroke, egui::StrokeKind::Inside);
    }
    let asked_s = asked_s(ui, &response, playhead_s, [first_s, last_s]);
    requests.extend(asked_s.map(|time_s| PathRequest::Seek(time_s.clamp(first_s, last_s))));
}

/// Returns the time that the keyboard or a screen reader requests.
fn asked_s(ui: &Ui, response: &egui::Response, playhead_s: f64, [first_s, last_s]: [f64; 2]) -> Option<f64> {
    use egui::accesskit::{Action, ActionData};
    let has_focus = response.has_focus();
    ui.input(|input| {
        let count = |action: Action, key: Key| {
            let pressed = if has_focus { input.num_presses(key) } else { 0 };
            (pressed + input.num_accesskit_action_requests(response.id, action)) as f64
        };
        let steps = count(Action::Increment, Key::ArrowRight) - count(Action::Decrement, Key::ArrowLeft);
        let set =
            input.accesskit_action_requests(response.id, Action::SetValue).filter_map(|request| match request.data {
                Some(ActionData::NumericValue(value)) if value.is_finite() => Some(value),
                _ => None,
            });
        let end_s = match has_focus {
            true if input.key_pressed(Key::Home) => Some(first_s),
            true if input.key_pressed(Key::End) => Some(last_s),
            _ => None,
        };
        let stepped_s = ((playhead_s + steps * STEP_S) * 1000.0).round() / 1000.0;
        set.last().or(end_s).or((steps != 0.0).then_some(stepped_s))
    })
}

/// Returns the times at both ends of the time line: there is room behind the last key, to which it may be dragged.
fn range_s([first_s, last_s]: [f64; 2]) -> [f64; 2] {
    let duration_s = last_s - first_s;
    let from_s = if first_s > 0.0 { (first_s - duration_s.max(1.0)).max(0.0) } else { first_s };
    let room_s = if duration_s > 0.0 { (0.15 * duration_s).max(2.0) } else { 10.0 };
    [from_s, last_s + room_s]
}

/// Returns the distance between two numbers, in seconds.
fn tick_step_s(seconds_of_labels: f64) -> f64 {
    const STEPS_S: [f64; 16] =
        [0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 30.0, 60.0, 120.0, 300.0, 600.0, 1800.0, 3600.0, 7200.0];
    let step = STEPS_S.into_iter().find(|step| *step >= seconds_of_labels);
    step.unwrap_or_else(|| 14_400.0 * (seconds_of_labels / 14_400.0).ceil())
}

/// Returns a time as the time line has it.
fn tick_words(time_s: f64, step_s: f64) -> String {
    if step_s < 1.0 {
        return format!("{time_s:.1}");
    }
    let sign = if time_s < 0.0 { "−" } else { "" };
    let seconds = time_s.abs().round() as u64;
    match seconds {
        0..60 => format!("{sign}{seconds} s"),
        60..3600 => format!("{sign}{}:{:02}", seconds / 60, seconds % 60),
        _ => format!("{sign}{}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60),
    }
}

fn ticks(ui: &Ui, scale: &Scale) {
    let [from_s, to_s] = scale.range_s;
    let width = f64::from((scale.rect.width() - 2.0 * SIDE).max(1.0));
    let step_s = tick_step_s((to_s - from_s) * f64::from(LABELS) / width);
    let painter = ui.painter_at(scale.rect);
    let (top, color) = (scale.rect.top(), Color32::from_white_alpha(110));
    let first = (from_s / step_s).ceil() as i64;
    let last = (to_s / step_s).floor() as i64;
    for number in first..=last {
        let time_s = number as f64 * step_s;
        let x = scale.x(time_s);
        painter.vline(x, top..=top + 5.0, (1.0, color));
        let words = tick_words(time_s, step_s);
        painter.text(pos2(x + 3.0, top + 1.0), Align2::LEFT_TOP, words, FontId::proportional(9.0), color);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_and_points_agree() {
        let rect = Rect::from_min_size(pos2(10.0, 0.0), vec2(600.0, HEIGHT));
        for span_s in [[0.0, 0.0], [0.0, 20.0], [3.0, 20.0], [100.0, 101.0], [-5.0, 90_000.0]] {
            let scale = Scale { rect, range_s: range_s(span_s) };
            assert!(scale.range_s[0] <= span_s[0] && scale.range_s[1] >= span_s[1] + 2.0, "{span_s:?}");
            for time_s in span_s {
                let x = scale.x(time_s);
                assert!(rect.x_range().contains(x));
                assert!((scale.time_s(x) - time_s).abs() <= 0.01 + 2e-6 * span_s[1], "{time_s}");
            }
        }
    }

    #[test]
    fn numbers_have_room() {
        assert_eq!([0.03, 0.7, 5.0, 25.0, 61.0].map(tick_step_s), [0.1, 1.0, 5.0, 30.0, 120.0]);
        assert_eq!(tick_step_s(20_000.0), 28_800.0);
        assert_eq!(tick_words(0.5, 0.1), "0.5");
        assert_eq!(
            [12.0, 75.0, 3700.0, -4.0].map(|time_s| tick_words(time_s, 1.0)),
            ["12 s", "1:15", "1:01:40", "−4 s"]
        );
    }
}
