//! The title block below a picture: the title and, in small letters, details of the view; for a map also a scale bar,
//! the representative fraction and a north arrow. All of it consists of pen strokes and of letters of the paper's
//! typeface, for raster and vector output.
//!
//! The block is on the blank paper of the style's `foot_px`, below the picture and as wide. Lengths here are pixels of
//! the style, which are scaled with the dots per inch.

use glam::DVec2;

use super::Band;
use super::legend::{LegendPlace, ROW};
use crate::file::svg::Text;
use crate::lettering::Line;
use crate::lettering::area::{Area, cover_areas};
use crate::lettering::ink::{PenStroke, cover};
use crate::lines::strokes::polylines::{Polyline, PolylinePoint};
use crate::style::{Color, Paper, Typeface};
use crate::vector::{Group, GroupKind, InkKind};

/// Height of the block below a picture, and of the line of credits in it.
const HEIGHT: f64 = 72.0;
const CREDITS_HEIGHT: f64 = 13.0;
/// Height of what is above and below the rows of a legend.
pub(crate) const LEGEND_HEIGHT: f64 = 10.0;
/// Distance from the paper's edge to the text, if the style has no margin.
const SIDE: f64 = 16.0;
/// Height of capitals of the title, and its minimum.
const TITLE: [f64; 2] = [20.0, 10.0];
/// Height of capitals of small text, and its minimum; of credits, and of the representative fraction.
pub(super) const SMALL: [f64; 2] = [7.5, 5.5];
const CREDITS: [f64; 2] = [6.0, 5.0];
const FRACTION: f64 = 9.0;
/// Baselines of the title, of the small text below it and without a title, and of the credits below either.
const TITLE_LINE: f64 = 37.0;
const SMALL_LINES: [f64; 2] = [57.5, 41.0];
const CREDITS_BELOW: f64 = 14.0;
/// Baselines of the representative fraction and of the lengths of the scale bar, and the middle of the bar.
const FRACTION_LINE: f64 = 25.0;
const LENGTHS_LINE: f64 = 42.0;
const BAR_LINE: f64 = 50.0;
/// Width of the pen for capitals of height 1, and its minimum. A finer line would look grey, which makes small letters
/// hard to read.
pub(super) const PEN: f64 = 0.1;
pub(super) const MIN_PEN: f64 = 1.15;
/// The most that the minimum may be for capitals of height 1: wider lines would close the smallest letters.
pub(super) const MAX_PEN: f64 = 0.155;
/// Width of the line under the picture, if it has no border.
const RULE: f64 = 1.0;
/// Power of the coverage of filled letters at their edges. Light is mixed linearly, which makes dark letters on light paper
/// look thinner than they are.
const EDGE_POWER: f32 = 0.7;
/// Gap between the text and the scale bar or arrow to its right.
const GAP: f64 = 20.0;
/// Width and length of the north arrow, the distance from its tip to its letter, and the height of its middle below
/// the picture. It has room in every direction.
const ARROW: [f64; 2] = [12.0, 28.0];
const LETTER_GAP: f64 = 3.0;
const ARROW_MIDDLE: f64 = 39.0;
/// Largest length of a scale bar, also as a fraction of the available width, and the least length at which it is drawn.
const BAR: f64 = 200.0;
const BAR_PART: f64 = 0.3;
const MIN_BAR: f64 = 36.0;

/// The contents of a title block.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Words {
    /// Title in large letters; may be empty.
    pub title: String,
    /// Text in small letters below the title.
    pub below: String,
    /// Sources of the data and names of makers, in smaller letters; may be empty.
    pub credits: String,
    /// Scale of a map; `None` for other views.
    pub scale: Option<MapScale>,
    /// Number of rows for which the legend has space; 0 if there is none.
    pub legend_rows: usize,
}

/// The scale of a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MapScale {
    /// Metres in the world per pixel.
    pub m_per_px: f64,
    /// Millimetres on paper per pixel, if the paper has a size.
    pub mm_per_px: Option<f64>,
    /// The number N of the scale 1 : N that was given for the map, which is stated as it is.
    pub denominator: Option<f64>,
    /// Direction of true north at the middle of the map, in radians clockwise from the top of the sheet; `None` if it
    /// is unknown, so that the arrow shows the north of the grid.
    pub true_north_rad: Option<f64>,
}

/// A title block, ready to be drawn.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Block {
    /// Strokes in pixels of the picture.
    pub strokes: Vec<PenStroke>,
    /// Letters of fonts, in pixels of the picture.
    pub areas: Vec<Area>,
    /// The words of the letters, in pixels of the picture.
    pub texts: Vec<Text>,
    /// Colour of all strokes.
    pub ink: Color,
    /// Opacity from 0 to 1.
    pub opacity: f32,
    /// Characters of the text that neither the lettering nor a font of the machine has.
    pub replaced: Vec<char>,
    /// Where the legend is, if there is one.
    pub legend: Option<LegendPlace>,
}

/// Returns the width of the pen for letters of a height. `px` is the number of pixels per pixel of the style.
pub(super) fn pen_px(height_px: f64, px: f64) -> f64 {
    (PEN * height_px).max((MIN_PEN * px).min(MAX_PEN * height_px))
}

/// Returns the height of a title block in pixels of the style, without and with its legend.
fn heights(has_credits: bool, legend_rows: usize) -> [f64; 2] {
    let height = HEIGHT + if has_credits { CREDITS_HEIGHT } else { 0.0 };
    let of_legend = if legend_rows > 0 { LEGEND_HEIGHT + ROW * legend_rows as f64 } else { 0.0 };
    [height, height + of_legend]
}

/// Returns the height of blank paper below a picture, in addition to the margin, that a title block needs on `paper`.
/// `px` is the number of pixels per pixel of the style, and `legend_rows` the number of rows of a legend.
pub(crate) fn foot_px(paper: &Paper, has_credits: bool, legend_rows: usize, px: f64) -> f32 {
    let needed = (heights(has_credits, legend_rows)[1] * px).ceil() as f32 - paper.margin_px.floor();
    needed.max(paper.foot_px).max(0.0)
}

/// Returns the largest round length that is at most `max_m`: 1, 2 or 5 times a power of ten, in metres.
pub(crate) fn round_m(max_m: f64) -> f64 {
    let power = 10.0_f64.powf(max_m.log10().floor());
    [5.0, 2.0, 1.0]
        .into_iter()
        .map(|digit| digit * power)
        .find(|length| *length <= max_m * (1.0 + 1e-9))
        .unwrap_or(power)
}

/// Formats a length: `500 m`, `2 km`.
fn length(metres: f64) -> String {
    if metres >= 1000.0 { format!("{} km", grouped(metres / 1000.0)) } else { format!("{metres} m") }
}

/// A blank between groups of digits.
const THIN_BLANK: char = '\u{2009}';

/// Formats a whole number with a thin blank before each group of three digits: `12 500`.
pub(crate) fn grouped(number: f64) -> String {
    let digits = format!("{:.0}", number.abs());
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(THIN_BLANK);
        }
        text.push(digit);
    }
    if number <= -0.5 { format!("−{text}") } else { text }
}

/// Formats the representative fraction, `1 : 50 000`: as it was given, otherwise to three significant digits.
fn fraction(scale: &MapScale) -> Option<String> {
    let written = |number: String| format!("1{THIN_BLANK}:{THIN_BLANK}{number}");
    if let Some(given) = scale.denominator {
        return Some(written(if given.fract() == 0.0 { grouped(given) } else { given.to_string() }));
    }
    let exact = 1000.0 * scale.m_per_px / scale.mm_per_px?;
    let step = 10.0_f64.powf(exact.log10().floor() - 2.0).max(1.0);
    (exact.is_finite() && exact >= 1.0).then(|| written(grouped((exact / step).round() * step)))
}

/// Lays out the title block of a picture of `size_px`. Foot and margin of `paper` must have room for it ([`foot_px`]).
/// `px` is the number of pixels per pixel of the style.
pub(crate) fn block(words: &Words, size_px: [u32; 2], paper: &Paper, ink: Color, px: f64) -> Block {
    let mut page = Page {
        typeface: paper.typeface,
        strokes: Vec::new(),
        areas: Vec::new(),
        texts: Vec::new(),
        replaced: Vec::new(),
    };
    let [width, height] = size_px.map(f64::from);
    let [margin, foot] = [paper.margin_px, paper.foot_px].map(f64::from);
    let side = if margin > 0.0 { margin } else { SIDE * px };
    let picture_bottom = height - margin - foot;
    if paper.border_px == 0.0 {
        let rule = RULE * px;
        let y = picture_bottom + 0.5 * rule;
        page.strokes.push(PenStroke::line(DVec2::new(margin, y), DVec2::new(width - margin, y), rule));
    }
    // On a large foot the block still stays close to the picture.
    let [own, all] = heights(!words.credits.is_empty(), words.legend_rows);
    let spare = 0.5 * (margin + foot - all * px);
    let top = picture_bottom + spare.clamp(0.0, 12.0 * px);
    let (left, mut right) = (side, width - side);
    let at = |x: f64, y: f64| DVec2::new(x, top + y * px);
    if let Some(scale) = &words.scale {
        right = page.scale(scale, right - left, right, at, px);
    }
    let room = (right - left).max(0.0);
    let title = Line::title(&words.title, paper.typeface);
    let has_title = !title.text().is_empty();
    if has_title {
        page.fitted(&title, room, TITLE, at(left, TITLE_LINE), px);
    }
    let small_line = SMALL_LINES[usize::from(!has_title)];
    page.fitted(&Line::small(&words.below, paper.typeface), room, SMALL, at(left, small_line), px);
    if !words.credits.is_empty() {
        let credits = Line::small(&words.credits, paper.typeface);
        page.fitted(&credits, room, CREDITS, at(left, small_line + CREDITS_BELOW), px);
    }
    let legend = (words.legend_rows > 0).then(|| {
        let (room_px, rows, typeface) = (width - 2.0 * side, words.legend_rows, paper.typeface);
        LegendPlace { at: at(side, own), room_px, rows, px, typeface, ink }
    });
    let mut replaced = page.replaced;
    replaced.sort_unstable();
    replaced.dedup();
    Block { strokes: page.strokes, areas: page.areas, texts: page.texts, ink, opacity: 1.0, replaced, legend }
}

struct Page {
    typeface: Typeface,
    strokes: Vec<PenStroke>,
    areas: Vec<Area>,
    texts: Vec<Text>,
    replaced: Vec<char>,
}

impl Page {
    fn fitted(&mut self, line: &Line, room: f64, [height, least]: [f64; 2], at: DVec2, px: f64) {
        self.replaced.extend(&line.replaced);
        let (line, height) = line.fitted(room, height * px, least * px);
        self.write(&line, at, height, px);
    }

    fn write(&mut self, line: &Line, at: DVec2, height: f64, px: f64) {
        let width_px = pen_px(height, px);
        self.strokes.extend(line.strokes(at, height).into_iter().map(|points| PenStroke { points, width_px }));
        self.areas.extend(line.areas(at, height));
        self.texts.extend(line.words(at, height));
    }

    /// Writes a text of which `part_left` is to the left of a point.
    fn small(&mut self, text: &str, height: f64, at: DVec2, px: f64, part_left: f64) {
        let line = Line::small(text, self.typeface);
        let height = height * px;
        self.write(&line, at - DVec2::new(part_left * line.width() * height, 0.0), height, px);
    }

    /// Draws the arrow, the bar and the fraction from the right end, and returns where the text must end.
    fn scale(&mut self, scale: &MapScale, width: f64, right: f64, at: impl Fn(f64, f64) -> DVec2, px: f64) -> f64 {
        let line = |from: DVec2, to: DVec2, width: f64| PenStroke::line(from, to, width * px);
        if width < 6.0 * ARROW[0] * px {
            return right;
        }
        let [arrow_width, arrow_height] = ARROW;
        let half_length = 0.5 * arrow_height;
        // The letters may be wider than the arrow, and a turned arrow needs more room to its sides.
        let name = if scale.true_north_rad.is_some() { "N" } else { "GN" };
        let arrow_width = arrow_width.max(SMALL[0] * Line::small(name, self.typeface).width());
        let (sine, cosine) = scale.true_north_rad.unwrap_or(0.0).sin_cos();
        let arrow_width = (2.0 * (half_length + LETTER_GAP + SMALL[0]) * sine.abs()).max(arrow_width);
        let middle = right - 0.5 * arrow_width * px;
        let centre = at(middle, ARROW_MIDDLE);
        let turned = |x: f64, y: f64| centre + px * DVec2::new(cosine * x - sine * y, sine * x + cosine * y);
        let tip = turned(0.0, -half_length);
        self.strokes.push(line(turned(0.0, half_length), tip, 1.2));
        for way in [-1.0, 1.0] {
            self.strokes.push(line(tip, turned(0.42 * way * ARROW[0], 11.0 - half_length), 1.2));
        }
        // The letter is upright, with its middle in the arrow's direction.
        let letter = turned(0.0, -half_length - LETTER_GAP - 0.5 * SMALL[0]) + DVec2::new(0.0, 0.5 * SMALL[0] * px);
        self.small(name, SMALL[0], letter, px, 0.5);
        let mut left = right - arrow_width * px - GAP * px;
        let most = (BAR * px).min(BAR_PART * width);
        let bar_m = round_m(most * scale.m_per_px);
        let bar = bar_m / scale.m_per_px;
        if bar >= MIN_BAR * px {
            let name = length(bar_m);
            let overhang = 0.5 * SMALL[0] * px * Line::small(&name, self.typeface).width();
            let end = left - overhang;
            let begin = end - bar;
            // A bar of 1 has four quarters, of 2 four halves, of 5 five ones; every second section is heavy.
            let parts = if (bar_m / 10.0_f64.powf(bar_m.log10().floor() + 1e-9) - 5.0).abs() < 0.1 { 5 } else { 4 };
            let tick = |part: f64| begin + bar * part;
            self.strokes.push(line(at(begin, BAR_LINE), at(end, BAR_LINE), 1.0));
            for i in 0..parts {
                let [from, to] = [i, i + 1].map(|i| tick(f64::from(i) / f64::from(parts)));
                if i % 2 == 0 {
                    // Round ends would lengthen the section.
                    let half = 0.5 * 3.2 * px;
                    self.strokes.push(line(at(from + half, BAR_LINE), at(to - half, BAR_LINE), 3.2));
                }
            }
            for part in [0.0, 1.0] {
                self.strokes.push(line(at(tick(part), BAR_LINE - 4.0), at(tick(part), BAR_LINE + 4.0), 1.0));
            }
            self.small("0", SMALL[0], at(begin, LENGTHS_LINE), px, 0.5);
            self.small(&name, SMALL[0], at(end, LENGTHS_LINE), px, 0.5);
            if let Some(text) = fraction(scale) {
                self.small(&text, FRACTION, at(0.5 * (begin + end), FRACTION_LINE), px, 0.5);
            }
            left = begin - 0.5 * SMALL[0] * px;
        } else if let Some(text) = fraction(scale) {
            let long = FRACTION * px * Line::small(&text, self.typeface).width();
            // A picture that is too narrow has no fraction.
            if left - long >= right - width {
                self.small(&text, FRACTION, at(left, ARROW_MIDDLE), px, 1.0);
                left -= long;
            }
        }
        left - GAP * px
    }
}

impl Block {
    /// Returns a block without content.
    pub(crate) fn empty(ink: Color) -> Self {
        Self {
            strokes: Vec::new(),
            areas: Vec::new(),
            texts: Vec::new(),
            ink,
            opacity: 1.0,
            replaced: Vec::new(),
            legend: None,
        }
    }

    /// Draws the block into a band of a picture that is `width` pixels wide.
    pub(crate) fn draw(&self, band: &mut Band, width: usize) {
        let ink = self.ink.linear();
        let ends = self.strokes.iter().flat_map(|stroke| &stroke.points).map(|at| [at.y; 2]);
        let [highest, lowest] = ends
            .chain(self.areas.iter().map(Area::high_px))
            .fold([f64::MAX, f64::MIN], |[highest, lowest], [top, bottom]| [highest.min(top), lowest.max(bottom)]);
        let reach = self.strokes.iter().map(|stroke| 0.5 * stroke.width_px + 2.0).fold(2.0, f64::max);
        for (i, row) in band.picture.chunks_exact_mut(width.max(1)).enumerate() {
            let y = f64::from(band.first_row) + i as f64;
            if y < highest - reach || y > lowest + reach {
                continue;
            }
            let mut covered = vec![0.0; width];
            cover_areas(&self.areas, 0.0, y, &mut covered);
            covered.iter_mut().filter(|part| **part > 0.0).for_each(|part| *part = part.powf(EDGE_POWER));
            cover(&self.strokes, 0.0, y, &mut covered);
            for (texel, part) in row.iter_mut().zip(&covered).filter(|(_, part)| **part > 0.0) {
                (0..3).for_each(|k| texel[k] += (ink[k] - texel[k]) * part * self.opacity);
            }
        }
    }

    /// Adds the block to the lines and areas of a drawing. For pens, letters of fonts are hatched.
    pub(crate) fn group(&self, (id, label): (&str, &str), is_for_pens: bool) -> Group {
        let polyline = |stroke: &PenStroke| {
            let half_width_px = 0.5 * stroke.width_px as f32;
            let point = |at: &DVec2| PolylinePoint { px: [at.x as f32, at.y as f32], half_width_px, ink: 1.0 };
            Polyline { points: stroke.points.iter().map(point).collect(), ..Polyline::default() }
        };
        let hatched = || self.areas.iter().flat_map(Area::hatching).collect::<Vec<PenStroke>>();
        let hatching = if is_for_pens { hatched() } else { Vec::new() };
        let filled = self.areas.iter().filter(|_| !is_for_pens);
        Group {
            id: id.to_owned(),
            label: label.to_owned(),
            ink: self.ink,
            kind: GroupKind::Ink(InkKind::Mark),
            lines: self.strokes.iter().chain(&hatching).map(polyline).collect(),
            fills: filled.map(|area| area.curves.clone()).collect(),
            texts: self.texts.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    fn paper(margin_px: f32) -> Paper {
        let plain = crate::style::Style::load("plain").unwrap().paper;
        let bare = Paper { margin_px, border_px: 0.0, foot_px: 0.0, ..plain };
        Paper { foot_px: foot_px(&bare, false, 0, 1.0), ..bare }
    }

    #[test]
    fn lengths_are_round() {
        let lengths = [0.9, 1.0, 1.9, 4.99, 5.0, 999.0, 25_000.0].map(round_m);
        assert_eq!(lengths, [0.5, 1.0, 1.0, 2.0, 5.0, 500.0, 20_000.0]);
        assert_eq!([length(0.5), length(500.0), length(20_000.0)], ["0.5 m", "500 m", "20 km"]);
        assert_eq!(
            [grouped(50_000.0), grouped(999.6), grouped(-1234.0)],
            ["50\u{2009}000", "1\u{2009}000", "−1\u{2009}234"]
        );
        let scale =
            |m_per_px, mm_per_px| fraction(&MapScale { m_per_px, mm_per_px, denominator: None, true_north_rad: None });
        let given = |number| {
            fraction(&MapScale { m_per_px: 5.0, mm_per_px: None, denominator: Some(number), true_north_rad: None })
        };
        assert_eq!(given(63_360.0), Some("1\u{2009}:\u{2009}63\u{2009}360".to_owned()));
        assert_eq!(given(12.5), Some("1\u{2009}:\u{2009}12.5".to_owned()));
        assert_eq!(scale(5.0, Some(0.1)), Some("1\u{2009}:\u{2009}50\u{2009}000".to_owned()));
        assert_eq!(scale(4.9876, Some(0.1)), Some("1\u{2009}:\u{2009}49\u{2009}900".to_owned()));
        assert_eq!(scale(5.0, None), None);
    }

    /// Returns the length of the bar between its end ticks, in pixels.
    fn bar_px(block: &Block) -> f64 {
        let is_tick = |stroke: &&PenStroke| {
            stroke.points.len() == 2 && stroke.points[0].x == stroke.points[1].x && (stroke.width_px - 1.0).abs() < 1e-9
        };
        let ticks: Vec<f64> = block.strokes.iter().filter(is_tick).map(|stroke| stroke.points[0].x).collect();
        assert_eq!(ticks.len(), 2);
        (ticks[1] - ticks[0]).abs()
    }

    #[test]
    fn a_scale_bar_has_its_length() {
        for (m_per_px, bar_m) in [(1.0, 100.0), (7.3, 1000.0), (0.011, 2.0), (1300.0, 200_000.0)] {
            let scale = Some(MapScale { m_per_px, mm_per_px: None, denominator: None, true_north_rad: Some(0.3) });
            let words = Words { title: "A map".into(), below: "ink".into(), scale, ..Words::default() };
            let found_m = bar_px(&block(&words, [640, 400], &paper(0.0), Color::default(), 1.0)) * m_per_px;
            assert!((found_m / bar_m - 1.0).abs() < 1e-6, "{m_per_px} m: {found_m} m and not {bar_m}");
            // Planted: another scale.
            let scale = scale.map(|scale| MapScale { m_per_px: 1.1 * m_per_px, ..scale });
            let other = Words { scale, ..words };
            let other_m = bar_px(&block(&other, [640, 400], &paper(0.0), Color::default(), 1.0)) * m_per_px;
            assert!((other_m / bar_m - 1.0).abs() > 0.05);
        }
    }

    #[test]
    fn a_block_stays_on_bare_paper() {
        let long = "A title that is much too long for the room that there is below a picture as narrow as this one";
        for (size, margin) in
            [([640, 400], 0.0), ([640, 400], 30.0), ([200, 300], 0.0), ([90, 200], 5.0), ([900, 700], 120.0)]
        {
            let scale = |turn: f64| MapScale {
                m_per_px: 12.0,
                mm_per_px: Some(0.1),
                denominator: None,
                true_north_rad: (turn < 8.0).then_some(turn * std::f64::consts::FRAC_PI_4),
            };
            for scale in (0..9).map(|turn| Some(scale(f64::from(turn)))).chain([None]) {
                let words = Words { title: long.into(), below: long.into(), scale, ..Words::default() };
                let paper = paper(margin);
                let found = block(&words, size, &paper, Color::default(), 1.0);
                let of_strokes = Paper { typeface: Typeface::Strokes, ..paper.clone() };
                let found_strokes = block(&words, size, &of_strokes, Color::default(), 1.0);
                let top = f64::from(size[1]) - f64::from(paper.margin_px + paper.foot_px);
                for area in &found.areas {
                    let around = kurbo::Shape::bounding_box(&area.curves);
                    let [right, bottom] = size.map(f64::from);
                    assert!(around.x0 >= 0.0 && around.x1 <= right, "{size:?}, margin {margin}: {around:?}");
                    assert!(around.y0 >= top && around.y1 <= bottom - 1.0, "{size:?}, margin {margin}: {around:?}");
                }
                for stroke in found.strokes.iter().chain(&found_strokes.strokes) {
                    let half = 0.5 * stroke.width_px - 1e-6;
                    let holds = |at: &DVec2| {
                        at.y - half >= top
                            && at.y + half <= f64::from(size[1]) - 1.0
                            && at.x >= 0.0
                            && at.x <= f64::from(size[0])
                    };
                    assert!(stroke.points.iter().all(holds), "{size:?}, margin {margin}: {stroke:?}");
                }
            }
        }
        // No font has letters for code points that are not assigned.
        let words = Words { title: "\u{530}".into(), below: "\u{530} \u{378}".into(), ..Words::default() };
        assert_eq!(block(&words, [640, 400], &paper(0.0), Color::default(), 1.0).replaced, ['\u{378}', '\u{530}']);
    }
}
