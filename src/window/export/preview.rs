//! A small drawing of the page of an export: its paper, the picture, the window's view in it, and the cuts of sheets.

use egui::{Color32, Pos2, Rect, Sense, Shape, Stroke, StrokeKind, Ui, pos2, vec2};

use crate::studio::export::Page;

/// Height of the drawing in points.
const HEIGHT: f32 = 150.0;
const PAPER: Color32 = Color32::from_gray(240);
const PICTURE: Color32 = Color32::from_gray(205);
const VIEW: Color32 = Color32::from_rgb(40, 110, 190);
const CUT: Color32 = Color32::from_rgb(200, 70, 50);

/// Draws a page. `window_px` is the size of the window's picture, whose frame is drawn if the picture `has_view`: it has
/// the window's camera.
pub(super) fn show(ui: &mut Ui, page: &Page, width: f32, window_px: [u32; 2], has_view: bool) {
    let (area, response) = ui.allocate_exact_size(vec2(width, HEIGHT), Sense::hover());
    let hint = match has_view {
        true => "The page: grey is the picture, the blue frame is what the window shows, red are cuts",
        false => "The page: grey is the map",
    };
    response.on_hover_text(hint);
    let painter = ui.painter_at(area);
    let place = Placed::new(page, area.shrink(4.0));
    painter.rect_filled(place.rect([0.0, 0.0, page.size[0], page.size[1]]), 1.0, PAPER);
    painter.rect_filled(place.rect(page.picture), 0.0, PICTURE);
    if has_view {
        let [left, top, width, height] = view_in(page.picture, window_px);
        let frame = place.rect([left, top, width, height]);
        painter.rect_stroke(frame.shrink(1.0), 0.0, Stroke::new(1.0, VIEW), StrokeKind::Middle);
        // A ridge, so that the picture looks like one.
        let at = |x: f32, y: f32| pos2(frame.left() + x * frame.width(), frame.top() + y * frame.height());
        let ridge = [(0.05, 0.75), (0.3, 0.5), (0.42, 0.6), (0.6, 0.3), (0.8, 0.62), (0.95, 0.55)];
        let points: Vec<Pos2> = ridge.iter().map(|(x, y)| at(*x, *y)).collect();
        painter.add(Shape::line(points, Stroke::new(1.0, VIEW.gamma_multiply(0.6))));
    }
    for cut in &page.cuts {
        painter.rect_stroke(place.rect(*cut), 0.0, Stroke::new(0.7, CUT), StrokeKind::Middle);
    }
}

/// Returns where the window's view is in a picture: it has the same height, because the field of view is vertical. A wider
/// view is cut off at the picture's sides.
fn view_in([left, top, width, height]: [f64; 4], window_px: [u32; 2]) -> [f64; 4] {
    let [window_width, window_height] = window_px.map(|side| f64::from(side.max(1)));
    let shown = (height * window_width / window_height).min(width);
    [left + 0.5 * (width - shown), top, shown, height]
}

/// The mapping of a page to the window.
struct Placed {
    origin: Pos2,
    points_per_unit: f32,
}

impl Placed {
    fn new(page: &Page, area: Rect) -> Self {
        let [width, height] = page.size.map(|side| side as f32);
        let points_per_unit = (area.width() / width).min(area.height() / height);
        let size = points_per_unit * vec2(width, height);
        Self { origin: area.center() - 0.5 * size, points_per_unit }
    }

    fn rect(&self, [left, top, width, height]: [f64; 4]) -> Rect {
        let scaled = |x: f64, y: f64| self.points_per_unit * vec2(x as f32, y as f32);
        Rect::from_min_size(self.origin + scaled(left, top), scaled(width, height))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_view_keeps_its_height() {
        // A page in portrait cuts the sides of the view off; a wide one shows more.
        assert_eq!(view_in([0.0, 0.0, 200.0, 300.0], [1600, 900]), [0.0, 0.0, 200.0, 300.0]);
        assert_eq!(view_in([10.0, 5.0, 800.0, 90.0], [1600, 900]), [330.0, 5.0, 160.0, 90.0]);
    }

    #[test]
    fn a_page_is_as_large_as_its_area_allows() {
        let page =
            Page { size: [420.0, 297.0], picture: [0.0; 4], sheets: None, cuts: Vec::new(), words: String::new() };
        let area = Rect::from_min_size(pos2(10.0, 20.0), vec2(240.0, 140.0));
        let whole = Placed::new(&page, area).rect([0.0, 0.0, 420.0, 297.0]);
        assert!(area.expand(0.01).contains_rect(whole), "{whole:?}");
        assert!((whole.height() - area.height()).abs() < 0.01 && (whole.center() - area.center()).length() < 0.01);
    }
}
