//! Messages over the picture: some expire, others stay as long as their cause.

use std::time::{Duration, Instant};

use egui::{Align, Layout, Pos2, Rect};

/// Largest number of passing messages; the oldest is dropped.
const MAX_PASSING: usize = 4;
/// Distance from the border of the window and from the panel, in points.
const MARGIN: f32 = 10.0;
/// Width in points at which a message is wrapped.
const WIDTH: f32 = 420.0;
/// Padding between a message and its frame, frame line included, in points.
const PADDING: f32 = 8.0;
/// Smallest width in which messages are readable, in points.
const NARROWEST: f32 = 120.0;

/// Subject of a message: a newer message replaces one on the same subject, except for files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum About {
    /// A style was chosen.
    Style,
    /// A style was edited, or could not be.
    Edit,
    /// Esc was pressed.
    Quitting,
    /// A file was written, or could not be written.
    File,
}

/// The messages, newest last.
#[derive(Debug, Default)]
pub(super) struct Toasts {
    passing: Vec<(About, String, Instant)>,
    /// Messages that stay as long as their cause: errors in files and shaders, and work that goes on.
    lasting: Vec<String>,
}

impl Toasts {
    /// Shows a message until a time. A message about a file does not replace one about another file.
    pub(super) fn say(&mut self, about: About, text: String, until: Instant) {
        self.passing.retain(|(known, said, _)| *known != about || (about == About::File && *said != text));
        self.passing.push((about, text, until));
        let surplus = self.passing.len().saturating_sub(MAX_PASSING);
        self.passing.drain(..surplus);
    }

    /// Sets the messages that stay until they are replaced. Returns whether they differ from the previous ones.
    pub(super) fn set_lasting(&mut self, texts: Vec<String>) -> bool {
        let is_new = self.lasting != texts;
        self.lasting = texts;
        is_new
    }

    /// Removes expired messages.
    pub(super) fn tidy(&mut self, now: Instant) {
        self.passing.retain(|(.., until)| *until > now);
    }

    /// Returns when the next message expires.
    pub(super) fn next_end(&self) -> Option<Instant> {
        self.passing.iter().map(|(.., until)| *until).min()
    }

    /// Returns all messages, from top to bottom.
    pub(super) fn texts(&self) -> impl DoubleEndedIterator<Item = &str> {
        self.lasting.iter().map(String::as_str).chain(self.passing.iter().map(|(_, text, _)| text.as_str()))
    }

    /// Returns whether there are no messages.
    pub(super) fn is_empty(&self) -> bool {
        self.lasting.is_empty() && self.passing.is_empty()
    }
}

/// Returns when a message shown now expires.
pub(super) fn until(how_long: Duration) -> Instant {
    Instant::now() + how_long
}

/// Returns the area for messages in a window, next to the panel: the largest area that is wide enough to be readable,
/// else the largest of all.
pub(super) fn place(window: Rect, panel: Option<Rect>) -> Rect {
    let window = window.shrink(MARGIN);
    let Some(panel) = panel.map(|panel| panel.expand(MARGIN)).filter(|panel| panel.intersects(window)) else {
        return window;
    };
    let of = |left: f32, top: f32, right: f32, bottom: f32| {
        Rect::from_min_max(Pos2::new(left, top), Pos2::new(right.max(left), bottom.max(top)))
    };
    let free_areas = [
        of(panel.right().max(window.left()), window.top(), window.right(), window.bottom()),
        of(window.left(), window.top(), panel.left().min(window.right()), window.bottom()),
        of(window.left(), panel.bottom().max(window.top()), window.right(), window.bottom()),
        of(window.left(), window.top(), window.right(), panel.top().min(window.bottom())),
    ];
    let rank = |place: &Rect| {
        let reads = place.width() >= NARROWEST && place.height() >= 24.0;
        (reads, place.area())
    };
    let better = |a: Rect, b: Rect| if rank(&b) > rank(&a) { b } else { a };
    free_areas.into_iter().reduce(better).unwrap_or(window)
}

/// Shows the messages next to the panel and to the left of the inspector, or in the whole window if they are hidden.
/// `bottom` is the upper border of a panel at the bottom, or that of the window, in points.
pub(super) fn show(
    context: &egui::Context,
    toasts: &Toasts,
    panel: Option<Rect>,
    inspector: Option<Rect>,
    bottom: f32,
) {
    if toasts.is_empty() {
        return;
    }
    let mut window = context.content_rect();
    window.max.y = bottom.min(window.bottom());
    if let Some(inspector) = inspector {
        window.max.x = inspector.left().max(window.left() + NARROWEST);
    }
    let place = place(window, panel);
    let area = egui::Area::new(egui::Id::unique("toasts")).order(egui::Order::Foreground).interactable(false);
    // Lay out from the bottom up, so that no message depends on the heights of the others in the previous frame.
    area.fixed_pos(place.min).constrain(false).show(context, |ui| {
        ui.allocate_ui_with_layout(place.size(), Layout::bottom_up(Align::Max), |ui| {
            for text in toasts.texts().rev() {
                egui::Frame::window(ui.style()).show(ui, |ui| {
                    ui.set_max_width((place.width() - 2.0 * PADDING).clamp(60.0, WIDTH));
                    ui.add(egui::Label::new(text).wrap().halign(Align::Min));
                });
            }
        });
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(toasts: &Toasts) -> Vec<&str> {
        toasts.texts().collect()
    }

    #[test]
    fn none_takes_the_place_of_another_unread() {
        let now = Instant::now();
        let after = |seconds| now + Duration::from_secs(seconds);
        let mut toasts = Toasts::default();
        toasts.say(About::File, "wrote a.png".to_owned(), after(5));
        toasts.say(About::Style, "ink".to_owned(), after(3));
        toasts.say(About::File, "wrote b.png".to_owned(), after(6));
        assert_eq!(texts(&toasts), ["wrote a.png", "ink", "wrote b.png"]);
        // Stepping through the styles does not fill the window.
        toasts.say(About::Style, "pen".to_owned(), after(4));
        assert_eq!(texts(&toasts), ["wrote a.png", "wrote b.png", "pen"]);
        // Each message expires by itself.
        assert_eq!(toasts.next_end(), Some(after(4)));
        toasts.tidy(after(5));
        assert_eq!(texts(&toasts), ["wrote b.png"]);
        // The newest messages stay if there are too many.
        (0..9).for_each(|number| toasts.say(About::File, number.to_string(), after(9)));
        assert_eq!(texts(&toasts), ["5", "6", "7", "8"]);
    }

    #[test]
    fn a_lasting_one_goes_when_its_cause_does() {
        let mut toasts = Toasts::default();
        assert!(toasts.set_lasting(vec!["lsa.wgsl: no".to_owned()]));
        toasts.tidy(Instant::now() + Duration::from_secs(3600));
        assert!(texts(&toasts) == ["lsa.wgsl: no"] && toasts.next_end().is_none() && !toasts.is_empty());
        assert!(!toasts.set_lasting(vec!["lsa.wgsl: no".to_owned()]) && toasts.set_lasting(Vec::new()));
        assert!(toasts.is_empty());
    }

    #[test]
    fn they_are_next_to_the_panel() {
        let rect = |left, top, right, bottom| Rect::from_min_max(Pos2::new(left, top), Pos2::new(right, bottom));
        let window = rect(0.0, 0.0, 1280.0, 720.0);
        assert_eq!(place(window, None), window.shrink(MARGIN));
        let panels = [
            rect(8.0, 8.0, 248.0, 700.0),
            // Collapsed, moved to the right, across the middle, below.
            rect(8.0, 8.0, 248.0, 30.0),
            rect(1000.0, 8.0, 1240.0, 700.0),
            rect(500.0, 300.0, 740.0, 500.0),
            rect(0.0, 600.0, 1280.0, 720.0),
        ];
        for panel in panels {
            let place = place(window, Some(panel));
            assert!(!place.intersects(panel) && window.contains_rect(place), "{panel:?}: {place:?}");
            assert!(place.width() >= NARROWEST && place.height() > 100.0, "{panel:?}: {place:?}");
        }
        // In a narrow window there is room below a collapsed panel.
        let narrow = rect(0.0, 0.0, 260.0, 300.0);
        let below = place(narrow, Some(rect(8.0, 8.0, 248.0, 30.0)));
        assert!(below.top() > 30.0 && below.width() > 200.0, "{below:?}");
    }

    #[test]
    fn messages_are_in_the_window_and_next_to_the_panel() {
        let window = Rect::from_min_size(Pos2::ZERO, egui::vec2(640.0, 420.0));
        let panel = Rect::from_min_max(egui::pos2(8.0, 8.0), egui::pos2(250.0, 380.0));
        let context = egui::Context::default();
        let mut toasts = Toasts::default();
        let long = "composite/composite.wgsl:85:24: no such thing; ".repeat(4);
        for (number, about) in [About::File, About::Style, About::File].into_iter().enumerate() {
            toasts.say(about, format!("{number} {long}"), until(Duration::from_secs(9)));
            // egui only measures in the first frame; all messages must be visible in the second.
            let mut texts = Vec::new();
            for _ in 0..2 {
                let input = egui::RawInput { screen_rect: Some(window), ..Default::default() };
                let output = context.run_ui(input, |ui| show(ui.ctx(), &toasts, Some(panel), None, 400.0));
                texts = output.shapes.into_iter().filter_map(|clipped| text_rect(&clipped.shape)).collect();
            }
            assert_eq!(texts.len(), number + 1);
            for rect in &texts {
                assert!(window.contains_rect(*rect) && !rect.intersects(panel) && rect.bottom() <= 400.0, "{rect:?}");
            }
            let overlap = |(i, a): (usize, &Rect)| texts[i + 1..].iter().any(|b| a.intersects(*b));
            assert!(!texts.iter().enumerate().any(overlap), "{texts:?}");
        }
    }

    fn text_rect(shape: &egui::Shape) -> Option<Rect> {
        match shape {
            egui::Shape::Text(text) => Some(text.visual_bounding_rect()),
            egui::Shape::Vec(shapes) => shapes.iter().find_map(text_rect),
            _ => None,
        }
    }
}
