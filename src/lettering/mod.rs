//! Text as pen strokes: the letters are lines without width, so that pictures, SVG and plotters draw the same.
//!
//! The letters are those of A. V. Hershey ("Roman simplex"); `letters.txt` contains them and describes their source and
//! format. The unit of length is the height of a capital letter. A character that the table lacks is taken from a font
//! of the machine ([`fonts`]), as a filled area. `unicode-bidi` orders text that runs to the left.

pub(crate) mod area;
mod fonts;
pub(crate) mod ink;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::LazyLock;

use fontdb::ID;
use glam::DVec2;
use unicode_bidi::{BidiClass, BidiInfo, bidi_class};

use self::area::Area;
use self::fonts::Fonts;

/// Height of capitals, in the units of the table.
const CAPITALS: f64 = 21.0;
/// Drawn in place of a character without a letter.
const REPLACEMENT: char = '?';
/// Drawn at the end of a text that is cut.
const ELLIPSIS: char = '…';

/// A letter, in heights of capitals, from the left end of its baseline; y goes up.
#[derive(Clone, Debug, Default, PartialEq)]
struct Letter {
    /// Distance to the start of the next letter.
    advance: f64,
    strokes: Vec<Vec<DVec2>>,
}

static LETTERS: LazyLock<BTreeMap<char, Letter>> = LazyLock::new(|| table(include_str!("letters.txt")));

/// Parses the table. Invalid lines are skipped; a test checks that there are none.
fn table(text: &str) -> BTreeMap<char, Letter> {
    text.lines().filter(|line| !line.starts_with('#')).filter_map(letter).collect()
}

fn letter(line: &str) -> Option<(char, Letter)> {
    let mut words = line.splitn(3, ' ');
    let code = u32::from_str_radix(words.next()?.strip_prefix("U+")?, 16).ok()?;
    let advance = words.next()?.parse::<f64>().ok()? / CAPITALS;
    let point = |text: &str| {
        let (x, y) = text.split_once(',')?;
        Some(DVec2::new(x.parse().ok()?, y.parse().ok()?) / CAPITALS)
    };
    let stroke = |text: &str| text.split(' ').map(point).collect::<Option<Vec<_>>>();
    let strokes = words.next().map_or(Some(Vec::new()), |strokes| strokes.split('|').map(stroke).collect())?;
    Some((char::from_u32(code)?, Letter { advance, strokes }))
}

/// Largest number of characters of a text with letters of fonts; more than that is cut.
const MAX_OF_FONTS: usize = 4096;
/// Width of the pen that hatches letters of fonts.
const HATCHING: f64 = 0.05;

/// A line of text.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Line {
    text: String,
    /// The letters from left to right.
    pieces: Vec<Piece>,
    /// Whether the text as a whole runs to the left.
    is_leftward: bool,
    /// Characters without a letter, each once, in the order of the text.
    pub replaced: Vec<char>,
}

/// A letter of a line.
#[derive(Clone, Debug, PartialEq)]
struct Piece {
    /// Byte offset of its characters in the text.
    begin: usize,
    advance: f64,
    shape: Shape,
}

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    Own(&'static Letter),
    /// The outlines of a letter of a font.
    Font(Vec<Vec<DVec2>>),
}

impl Piece {
    fn own(begin: usize, character: char) -> Option<Self> {
        let letter = LETTERS.get(&character)?;
        Some(Self { begin, advance: letter.advance, shape: Shape::Own(letter) })
    }
}

/// Returns whether a character is not seen itself, but changes others: joiners, selectors of variants, marks of
/// direction.
fn is_invisible(character: char) -> bool {
    matches!(character, '\u{ad}' | '\u{200b}'..='\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2060}'..='\u{206f}')
        || matches!(character, '\u{fe00}'..='\u{fe0f}' | '\u{feff}' | '\u{e0100}'..='\u{e01ef}')
}

impl Line {
    /// Creates a line: each run of white space becomes one blank, and each character without a letter a question mark.
    pub(crate) fn new(text: &str) -> Self {
        Self::with(text, Fonts::system)
    }

    /// Creates a line with letters of the given fonts, which are only looked at if the text needs them.
    fn with<'a>(text: &str, fonts: impl FnOnce() -> &'a Fonts) -> Self {
        let mut text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        if text.chars().all(|character| LETTERS.contains_key(&character)) {
            let pieces = text.char_indices().filter_map(|(at, character)| Piece::own(at, character)).collect();
            return Self { text, pieces, is_leftward: false, replaced: Vec::new() };
        }
        let is_foreign = |character: char| !LETTERS.contains_key(&character) && !is_invisible(character);
        let foreign: BTreeSet<char> = text.chars().filter(|character| is_foreign(*character)).collect();
        let fonts = fonts();
        let faces = fonts.faces(&foreign);
        let is_known = |character: char| !is_foreign(character) || faces.contains_key(&character);
        let mut seen = BTreeSet::new();
        let replaced = text.chars().filter(|it| !is_known(*it) && seen.insert(*it)).collect();
        if let Some((end, _)) = text.char_indices().nth(MAX_OF_FONTS) {
            text.truncate(end);
            text.push(ELLIPSIS);
        }
        let text: String = text.chars().map(|it| if is_known(it) { it } else { REPLACEMENT }).collect();
        let (pieces, is_leftward) = pieces(&text, fonts, &faces);
        Self { text, pieces, is_leftward, replaced }
    }

    /// Returns the text as it is drawn.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Returns the width, in heights of capitals.
    pub(crate) fn width(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.advance).sum()
    }

    /// Fits the line into a width of `room` units: at `height` if it fits, otherwise smaller, but not below `least`; a
    /// text that is still too long ends in an ellipsis. Returns the line with its height; it is empty if no letter
    /// fits.
    pub(crate) fn fitted(&self, room: f64, height: f64, least: f64) -> (Self, f64) {
        let width = self.width();
        let height = if width * height <= room { height } else { (room / width).clamp(least.min(height), height) };
        if width * height <= room * (1.0 + 1e-9) {
            return (self.clone(), height);
        }
        let empty = Self { text: String::new(), pieces: Vec::new(), ..self.clone() };
        // The longest beginning that leaves room for an ellipsis, without the blank that it may end with.
        let Some(ellipsis) = Piece::own(0, ELLIPSIS) else { return (empty, height) };
        let mut in_order: Vec<&Piece> = self.pieces.iter().collect();
        in_order.sort_by_key(|piece| piece.begin);
        let (mut width, mut kept) = (0.0, None);
        for piece in in_order {
            if (width + ellipsis.advance) * height > room {
                break;
            }
            kept = Some(piece.begin);
            width += piece.advance;
        }
        let Some(end) = kept else { return (empty, height) };
        let begin = self.text[..end].trim_end();
        let mut pieces: Vec<Piece> = self.pieces.iter().filter(|piece| piece.begin < begin.len()).cloned().collect();
        let ellipsis = Piece { begin: begin.len(), ..ellipsis };
        pieces.insert(if self.is_leftward { 0 } else { pieces.len() }, ellipsis);
        (Self { text: format!("{begin}{ELLIPSIS}"), pieces, ..empty }, height)
    }

    /// Returns the strokes of letters of `height`, starting at `at`, the left end of the baseline. y goes down, as in
    /// pixels. Letters of fonts are in [`Line::areas`].
    pub(crate) fn strokes(&self, at: DVec2, height: f64) -> Vec<Vec<DVec2>> {
        let of = |(piece, at): (&Piece, DVec2)| {
            let Shape::Own(letter) = piece.shape else { return Vec::new() };
            letter.strokes.iter().map(|stroke| placed(stroke, at, height)).collect()
        };
        self.places(at, height).flat_map(of).collect()
    }

    /// Returns the letters of fonts.
    pub(crate) fn areas(&self, at: DVec2, height: f64) -> Vec<Area> {
        let of = |(piece, at): (&Piece, DVec2)| {
            let Shape::Font(outlines) = &piece.shape else { return None };
            let outlines: Vec<Vec<DVec2>> = outlines.iter().map(|outline| placed(outline, at, height)).collect();
            (!outlines.is_empty()).then_some(Area { outlines, pen_px: HATCHING * height })
        };
        self.places(at, height).filter_map(of).collect()
    }

    /// Returns the letters with the left ends of their baselines.
    fn places(&self, at: DVec2, height: f64) -> impl Iterator<Item = (&Piece, DVec2)> {
        let mut x = 0.0;
        self.pieces.iter().map(move |piece| {
            let own = at + height * DVec2::new(x, 0.0);
            x += piece.advance;
            (piece, own)
        })
    }
}

fn placed(points: &[DVec2], at: DVec2, height: f64) -> Vec<DVec2> {
    points.iter().map(|point| at + height * DVec2::new(point.x, -point.y)).collect()
}

/// Returns the letters of a text from left to right, and whether it runs to the left as a whole.
fn pieces(text: &str, fonts: &Fonts, faces: &BTreeMap<char, ID>) -> (Vec<Piece>, bool) {
    let directions = BidiInfo::new(text, None);
    let Some(paragraph) = directions.paragraphs.first() else { return (Vec::new(), false) };
    let (levels, runs) = directions.visual_runs(paragraph, paragraph.range.clone());
    let mut pieces = Vec::new();
    for run in runs {
        let is_leftward = levels.get(run.start).is_some_and(|level| level.is_rtl());
        let mut parts = parts(&text[run.clone()], faces);
        if is_leftward {
            parts.reverse();
        }
        for (part, face) in parts {
            let begin = run.start + part.start;
            let part = &text[begin..run.start + part.end];
            let letters = || part.char_indices().filter_map(|(at, character)| Piece::own(begin + at, character));
            match face {
                Some(face) => pieces.extend(fonts.shaped(face, part, is_leftward).into_iter().map(|glyph| Piece {
                    begin: begin + glyph.begin,
                    advance: glyph.advance,
                    shape: Shape::Font(glyph.outlines),
                })),
                None if is_leftward => pieces.extend(letters().collect::<Vec<_>>().into_iter().rev()),
                None => pieces.extend(letters()),
            }
        }
    }
    (pieces, paragraph.level.is_rtl())
}

/// Splits a text into parts with letters of the table, or of one font. A combining mark takes the letter of the table
/// that it belongs to into its own font, and invisible characters stay with those before them.
fn parts(text: &str, faces: &BTreeMap<char, ID>) -> Vec<(Range<usize>, Option<ID>)> {
    let mut parts: Vec<(Range<usize>, Option<ID>)> = Vec::new();
    let mut before = 0;
    for (at, character) in text.char_indices() {
        let end = at + character.len_utf8();
        let face = faces.get(&character).copied();
        match parts.last_mut() {
            Some((part, own)) if *own == face || is_invisible(character) => part.end = end,
            Some((part, None)) if bidi_class(character) == BidiClass::NSM => {
                part.end = before;
                parts.push((before..end, face));
            }
            _ => parts.push((at..end, face)),
        }
        before = at;
    }
    parts.retain(|(part, _)| !part.is_empty());
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_the_table_is_a_letter() {
        let text = include_str!("letters.txt");
        let holds = |text: &str| table(text).len() == text.lines().filter(|line| !line.starts_with('#')).count();
        assert!(holds(text) && LETTERS.len() > 190);
        assert!(!holds(&text.replacen(",", ";", 1)) || text.find(',') < text.find("U+"), "planted: damage");
        assert!(!holds(&text.replace("U+0041 18 9,21", "U+0041 18 9;21")), "planted: damage");
        // ASCII and Latin-1 are complete, except for the soft hyphen, which is invisible.
        let latin = (0x20..0x7f).chain(0xa0..0x100).filter(|code| *code != 0xad).filter_map(char::from_u32);
        let missing: Vec<char> = latin.filter(|character| !LETTERS.contains_key(character)).collect();
        assert!(missing.is_empty(), "{missing:?}");
        // Letters are on the baseline, have plausible heights, and stay within their advance.
        let of = |character: char| LETTERS[&character].strokes.concat();
        let high = |points: &[DVec2]| points.iter().map(|point| point.y).fold(f64::MIN, f64::max);
        assert!((high(&of('H')) - 1.0).abs() < 1e-9 && high(&of('É')) > 1.2 && high(&of('x')) < 0.7);
        for (character, letter) in LETTERS.iter() {
            let inside = |point: &DVec2| point.x >= -0.01 && point.x <= letter.advance + 0.01 && point.y.abs() < 1.5;
            assert!(letter.strokes.concat().iter().all(inside), "{character}");
        }
    }

    #[test]
    fn characters_without_a_letter_are_replaced_and_reported_once() {
        let none = Fonts::of(fontdb::Database::new());
        let line = Line::with("  Mont\tBlanc \n 山 é 山 Ж", || &none);
        assert_eq!(line.text(), "Mont Blanc ? é ? ?");
        assert_eq!(line.replaced, ['山', 'Ж']);
        assert!(Line::new("Gruss aus Zürich – Säntis").replaced.is_empty());
    }

    #[test]
    fn long_texts_shrink_and_are_then_cut() {
        let line = Line::new("Grosser Aletschgletscher");
        let width = line.width();
        assert_eq!(line.fitted(4.0 * width, 3.0, 1.0), (line.clone(), 3.0));
        let (same, height) = line.fitted(2.0 * width, 3.0, 1.0);
        assert!(same == line && (height - 2.0).abs() < 1e-9);
        let (cut, height) = line.fitted(0.5 * width, 3.0, 1.0);
        assert!(cut.text().ends_with('…') && cut.text().starts_with("Grosser") && height == 1.0, "{}", cut.text());
        assert!(cut.width() <= 0.5 * width && cut.width() > 0.4 * width);
        assert_eq!(line.fitted(0.1, 3.0, 1.0).0.text(), "");
        // The result is the same as by trying each shorter text; a text of a megabyte is cut as fast as it is read.
        let words = Line::new("Am  Ende der Welt");
        for room in (0..60).map(|tenths| 0.1 * f64::from(tenths)) {
            let (cut, _) = words.fitted(room, 1.0, 1.0);
            let shorter = (0..words.text().chars().count()).rev().map(|count| {
                let begin: String = words.text().chars().take(count).collect();
                Line::new(&format!("{}…", begin.trim_end()))
            });
            let expected = shorter.clone().find(|line| line.width() <= room).map_or(String::new(), |line| line.text);
            assert_eq!(cut.text(), expected, "{room}");
        }
        let start = std::time::Instant::now();
        let long: String = (0..1 << 20).filter_map(|i| char::from_u32(0x4e00 + i % 60_000)).collect();
        let none = Fonts::of(fontdb::Database::new());
        let (cut, _) = Line::with(&long, || &none).fitted(1000.0, 3.0, 1.0);
        assert!(cut.text().ends_with('…') && start.elapsed().as_secs_f64() < 5.0, "{:?}", start.elapsed());
    }

    #[test]
    fn strokes_are_at_the_requested_positions() {
        let strokes = Line::new("H").strokes(DVec2::new(10.0, 100.0), 42.0);
        let points = strokes.concat();
        let [low, high] = [f64::min, f64::max].map(|pick| points.iter().map(|at| at.y).reduce(pick));
        assert_eq!([low, high], [Some(58.0), Some(100.0)]);
        assert!(points.iter().all(|at| at.x > 10.0 && at.x < 10.0 + 42.0 * Line::new("H").width()));
    }

    /// Fonts of the window's library, as those of a machine.
    #[cfg(feature = "window")]
    fn fonts() -> Fonts {
        let mut database = fontdb::Database::new();
        for font in egui::FontDefinitions::default().font_data.values() {
            database.load_font_data((*font.font).as_ref().to_vec());
        }
        Fonts::of(database)
    }

    #[cfg(feature = "window")]
    #[test]
    fn characters_that_the_table_lacks_come_from_fonts() {
        let fonts = fonts();
        let line = Line::with("Гора Elbrus, Łódź 山", || &fonts);
        assert_eq!((line.text(), line.replaced.as_slice()), ("Гора Elbrus, Łódź ?", &['山'][..]));
        let (areas, strokes) = (line.areas(DVec2::ZERO, 10.0), line.strokes(DVec2::ZERO, 10.0));
        // Four letters of the first word, and two that Latin-1 does not have.
        assert_eq!(areas.len(), 6);
        assert!(strokes.len() > 12 && line.width() > 10.0 && line.width() < 30.0, "{}", line.width());
        // Letters are on the baseline, as high as those of the table.
        let [top, bottom] = areas[0].high_px();
        assert!((top + 10.0).abs() < 0.5 && bottom.abs() < 0.2, "{top} {bottom}");
        // Where there is no font, all are replaced.
        let none = Fonts::of(fontdb::Database::new());
        assert_eq!(Line::with("Гора Elbrus", || &none).replaced, ['Г', 'о', 'р', 'а']);
        // A mark takes its letter along.
        let marked = Line::with("Ve\u{301}lo", || &fonts);
        assert!(marked.replaced.is_empty() && !marked.areas(DVec2::ZERO, 1.0).is_empty());
        // Text that is too long is cut.
        let (cut, _) = Line::with(&"Гора ".repeat(9000), || &fonts).fitted(100.0, 1.0, 1.0);
        assert!(cut.text().ends_with('…') && cut.width() <= 100.0 && cut.width() > 90.0, "{}", cut.width());
    }

    #[cfg(feature = "window")]
    #[test]
    fn text_that_runs_to_the_left_is_ordered() {
        let fonts = fonts();
        // Hebrew has no letters in these fonts, so its question marks show the order.
        let none = BTreeMap::new();
        let order =
            |text: &str| -> Vec<usize> { pieces(text, &fonts, &none).0.into_iter().map(|piece| piece.begin).collect() };
        assert_eq!(order("ab 12"), [0, 1, 2, 3, 4]);
        // A mark of direction makes the whole run to the left, except for the words and the number in it.
        assert_eq!(order("\u{200f}ab 12"), [3, 4, 5, 6, 7]);
        let (found, is_leftward) = pieces("\u{200f}! ab", &fonts, &none);
        assert!(is_leftward);
        let found: Vec<usize> = found.into_iter().map(|piece| piece.begin).collect();
        assert_eq!(found, [5, 6, 4, 3]);
    }
}
