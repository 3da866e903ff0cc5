//! The panel inside the headset: its content, drawn as pixels with hachure's own letters.
//!
//! A [`Page`] is the content of a panel; [`Page::pixels`] draws it. Where the panel is in the room, and which page it
//! has, is decided elsewhere ([`super::quad`], [`super::menu`]). This module depends on neither OpenXR nor GPUs.

mod board;

use glam::DVec2;

use self::board::{ACCENT, Board, DIM, GROOVE, INK, PAPER};

/// Size of the panel's picture.
pub(super) const SIZE_PX: [u32; 2] = [1024, 768];
/// Size of the panel in the room. At [`DISTANCE_M`] it covers 58° × 45°, with 18 pixels for each degree.
pub(super) const SIZE_M: [f32; 2] = [2.2, 1.65];
/// Distance of the panel from the eyes when it is opened: far enough for relaxed eyes.
pub(super) const DISTANCE_M: f64 = 2.0;

/// Height of a capital letter, in pixels: 1.7° in the middle of the panel, and 1.5° at its left and right edges.
const LETTER: f64 = 28.0;
/// Height of a capital letter of the title.
const TITLE: f64 = 38.0;
/// Distance between two rows.
const PITCH: f64 = 55.0;
/// Distance of text from the border of the panel.
const MARGIN: f64 = 44.0;
/// Where the second column of a row with two texts begins.
const SECOND: f64 = 384.0;
/// Baselines of the title, of the first row and of the last line.
const BASELINES: [f64; 3] = [84.0, 166.0, 732.0];
/// Largest number of rows.
pub(super) const ROWS: usize = 10;

/// The contents of a panel.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Page {
    pub title: String,
    pub body: Body,
    /// The line at the lower edge.
    pub footer: String,
    /// Progress of the work that the footer names, 0 to 1, drawn as a bar above it.
    pub done: Option<f32>,
}

/// The part of a panel between its title and its last line.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Body {
    /// Rows of two texts: a control and its effect.
    Controls(Vec<[String; 2]>),
    /// Two columns of choices.
    Columns([Column; 2]),
    /// Rows of sliders, and the effect of the selected one.
    Sliders(Vec<Slider>, String),
    /// Text in sentences.
    Text(String),
}

impl Default for Body {
    fn default() -> Self {
        Self::Controls(Vec::new())
    }
}

/// A column of choices.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Column {
    pub heading: String,
    /// The choices, and whether each is in use.
    pub choices: Vec<(String, bool)>,
    /// The index of the selected choice, if it is in this column.
    pub selected: Option<usize>,
}

/// A control of a style.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Slider {
    pub name: String,
    /// −100 to 100.
    pub position: i8,
    pub is_selected: bool,
    /// Whether the control has an effect in this style.
    pub has_effect: bool,
}

impl Page {
    /// Draws the page. Returns the rows from top to bottom: four bytes for each pixel, red, green, blue and opacity, in
    /// sRGB.
    pub(super) fn pixels(&self) -> Vec<u8> {
        let [width, height] = SIZE_PX.map(f64::from);
        let mut board = Board::new(SIZE_PX);
        board.frame();
        let [title, first, last] = BASELINES;
        let room = width - 2.0 * MARGIN;
        board.text(&self.title, DVec2::new(MARGIN, title), TITLE, room, INK);
        board.fill([MARGIN, title + 24.0], [width - MARGIN, title + 27.0], GROOVE);
        match &self.body {
            Body::Controls(rows) => {
                for ([control, action], row) in rows.iter().zip(0..ROWS) {
                    let y = first + PITCH * row as f64;
                    board.text(control, DVec2::new(MARGIN, y), LETTER, SECOND - MARGIN - 20.0, ACCENT);
                    board.text(action, DVec2::new(SECOND, y), LETTER, width - SECOND - MARGIN, INK);
                }
            }
            Body::Columns(columns) => {
                let each = 0.5 * (room - 30.0);
                for (column, left) in columns.iter().zip([MARGIN, MARGIN + each + 30.0]) {
                    column.draw(&mut board, left, each, first);
                }
            }
            Body::Sliders(sliders, help) => {
                for (slider, row) in sliders.iter().zip(0..ROWS) {
                    slider.draw(&mut board, first + 14.0 + 1.4 * PITCH * row as f64);
                }
                board.paragraph(help, DVec2::new(MARGIN, first + 430.0), LETTER, (room, PITCH), 2);
            }
            Body::Text(text) => board.paragraph(text, DVec2::new(MARGIN, first), LETTER, (room, PITCH), ROWS),
        }
        if let Some(done) = self.done {
            let (top, bottom) = (last - 62.0, last - 52.0);
            board.fill([MARGIN, top], [width - MARGIN, bottom], GROOVE);
            let end = MARGIN + room * f64::from(done.clamp(0.0, 1.0));
            board.fill([MARGIN, top], [end, bottom], ACCENT);
        }
        debug_assert!(last < height);
        board.text(&self.footer, DVec2::new(MARGIN, last), LETTER, room, DIM);
        board.into_bytes()
    }
}

impl Column {
    /// Draws the column: its heading, and as many choices as there is room for, around the selected one.
    fn draw(&self, board: &mut Board, left: f64, width: f64, first: f64) {
        board.text(&self.heading, DVec2::new(left + 16.0, first), LETTER, width - 32.0, DIM);
        let room = ROWS - 1;
        let last_start = self.choices.len().saturating_sub(room);
        let is_used = |(_, is_used): &(String, bool)| *is_used;
        let middle = self.selected.or_else(|| self.choices.iter().position(is_used)).unwrap_or(0);
        let start = middle.saturating_sub(room / 2).min(last_start);
        for (row, (name, is_used)) in self.choices.iter().enumerate().skip(start).take(room) {
            let y = first + PITCH * (row - start + 1) as f64;
            let is_selected = self.selected == Some(row);
            if is_selected {
                board.fill([left, y - LETTER - 12.0], [left + width, y + 14.0], ACCENT);
            }
            let tone = match (is_selected, is_used) {
                (true, _) => PAPER,
                (false, true) => ACCENT,
                (false, false) => INK,
            };
            board.text(name, DVec2::new(left + 16.0, y), LETTER, width - 32.0, tone);
        }
        // Arrowheads if there are more choices above or below the shown part.
        let tip = left + width - 26.0;
        if start > 0 {
            board.line(&[[tip - 12.0, first - 4.0], [tip, first - 20.0], [tip + 12.0, first - 4.0]], DIM);
        }
        if start < last_start {
            let y = first + PITCH * room as f64 + 24.0;
            board.line(&[[tip - 12.0, y], [tip, y + 16.0], [tip + 12.0, y]], DIM);
        }
    }
}

impl Slider {
    fn draw(&self, board: &mut Board, y: f64) {
        let width = f64::from(SIZE_PX[0]);
        let ink = if self.has_effect { INK } else { DIM };
        if self.is_selected {
            board.fill([MARGIN - 16.0, y - LETTER - 22.0], [width - MARGIN + 16.0, y + 24.0], GROOVE);
        }
        let tone = if self.is_selected && self.has_effect { ACCENT } else { ink };
        board.text(&self.name, DVec2::new(MARGIN, y), LETTER, 270.0, tone);
        if !self.has_effect {
            board.text("no effect here", DVec2::new(330.0, y), LETTER, width - 330.0 - MARGIN, DIM);
            return;
        }
        let (from, to, level) = (330.0, 830.0, y - 0.5 * LETTER);
        let middle = 0.5 * (from + to);
        let at = middle + 0.5 * (to - from) * f64::from(self.position) / 100.0;
        let groove = if self.is_selected { PAPER } else { GROOVE };
        board.fill([from, level - 4.0], [to, level + 4.0], groove);
        board.fill([middle - 2.0, level - 14.0], [middle + 2.0, level + 14.0], DIM);
        board.fill([at.min(middle), level - 4.0], [at.max(middle), level + 4.0], tone);
        board.fill([at - 9.0, level - 18.0], [at + 9.0, level + 18.0], tone);
        let position = if self.position == 0 { "0".to_owned() } else { format!("{:+}", self.position) };
        board.text(&position, DVec2::new(856.0, y), LETTER, width - 856.0 - MARGIN + 8.0, tone);
    }
}

#[cfg(test)]
pub(super) mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use super::board::Tone;
    use super::*;

    /// Writes a page as a PNG into the folder that `HACHURE_PANELS` names, for inspection.
    pub(in crate::headset) fn look(name: &str, page: &Page) {
        let Some(folder) = std::env::var_os("HACHURE_PANELS") else { return };
        let path = std::path::Path::new(&folder).join(format!("{name}.png"));
        crate::file::png::write_rgba8(&path, SIZE_PX[0], SIZE_PX[1], &page.pixels()).unwrap();
    }

    /// Returns the part of the pixels in a rectangle that are nearly those of a tone.
    fn part(pixels: &[u8], [left, top]: [usize; 2], [right, bottom]: [usize; 2], tone: Tone) -> f64 {
        let width = SIZE_PX[0] as usize;
        let is_tone = |at: usize| (0..3).all(|i| pixels[4 * at + i].abs_diff(tone[i]) < 24);
        let all = (top..bottom).flat_map(|y| (left..right).map(move |x| y * width + x));
        let count = all.clone().count();
        all.filter(|at| is_tone(*at)).count() as f64 / count as f64
    }

    #[test]
    fn text_is_where_it_belongs_and_nothing_else_changes() {
        let page = Page {
            title: "Controls".to_owned(),
            body: Body::Controls(vec![["Left stick".to_owned(), "Fly where you look".to_owned()]]),
            footer: "Press a button to begin".to_owned(),
            done: None,
        };
        let pixels = page.pixels();
        // Left column, right column, title, footer.
        for (from, to, tone) in [
            ([44, 130], [364, 172], ACCENT),
            ([384, 130], [800, 172], INK),
            ([44, 40], [300, 88], INK),
            ([44, 700], [600, 736], DIM),
        ] {
            let found = part(&pixels, from, to, tone);
            assert!((0.02..0.4).contains(&found), "{from:?}: {found}");
        }
        // Outside of the rows nothing is drawn.
        assert_eq!(part(&pixels, [44, 240], [980, 660], PAPER), 1.0);
        // Planted: a page without texts has none.
        let blank = Page::default().pixels();
        assert!(part(&blank, [44, 130], [980, 172], PAPER) == 1.0 && part(&blank, [44, 40], [300, 88], INK) == 0.0);
        assert!(pixels.chunks_exact(4).all(|pixel| pixel[3] == 255));
    }

    #[test]
    fn long_texts_are_wrapped_and_end_with_the_panel() {
        let text = "a style that cannot be read: ".repeat(30);
        let lines = |page: &Page| {
            let pixels = page.pixels();
            (0..ROWS).filter(|row| part(&pixels, [44, 130 + 55 * row], [980, 172 + 55 * row], INK) > 0.02).count()
        };
        assert_eq!(lines(&Page { body: Body::Text(text), ..Page::default() }), ROWS);
        assert_eq!(lines(&Page { body: Body::Text("one line".to_owned()), ..Page::default() }), 1);
    }

    #[test]
    fn a_bar_shows_how_much_is_done() {
        let bar = |done| part(&Page { done: Some(done), ..Page::default() }.pixels(), [44, 672], [980, 678], ACCENT);
        for done in [0.0, 0.25, 1.0, 7.0] {
            assert!((bar(done) - f64::from(done.min(1.0))).abs() < 0.01, "{done}: {}", bar(done));
        }
    }

    #[test]
    fn long_columns_scroll_to_the_selected_choice() {
        let choices: Vec<_> = (0..30).map(|i| (format!("style {i}"), i == 3)).collect();
        for selected in [0, 3, 15, 29] {
            let column = Column { heading: "Presets".to_owned(), choices: choices.clone(), selected: Some(selected) };
            let page = Page { body: Body::Columns([Column::default(), column]), ..Page::default() };
            let pixels = page.pixels();
            // The bar behind the selected choice is in the right column, and whole.
            let found = part(&pixels, [512, 110], [1000, 720], ACCENT);
            assert!(found > 0.06, "{selected}: {found}");
            assert!(part(&pixels, [20, 110], [500, 720], ACCENT) == 0.0);
        }
    }
}
