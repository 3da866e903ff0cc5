//! Text as pen strokes, and as filled letters of a typeface ([`Typeface`]).
//!
//! The letters of strokes are lines without width, so that pictures, SVG and plotters draw the same: those of A. V.
//! Hershey ("Roman simplex"); `letters.txt` contains them and describes their source and format. The letters of
//! typefaces are filled outlines ([`fonts`]). The unit of length is the height of a capital letter. A character that a
//! typeface lacks is taken from the table, and one that the table lacks from a font of the machine. `unicode-bidi`
//! orders text that runs to the left.

pub(crate) mod area;
mod fonts;
pub(crate) mod ink;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::LazyLock;

use fontdb::ID;
use glam::DVec2;
use kurbo::{Affine, BezPath, Point, Vec2};
use unicode_bidi::{BidiClass, BidiInfo, bidi_class};

use self::area::Area;
use self::fonts::{Fonts, Own, is_thin};
use crate::file::svg::Text;
use crate::style::Typeface;

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
/// Distance that is added between letters: of a title of capitals of the typeface for them, of one in another typeface,
/// and of small letters, which are easier to read with a little more.
const SPACING_OF_CAPITALS: f64 = 0.22;
const SPACING_OF_TITLES: f64 = 0.12;
const SPACING_OF_SMALL: f64 = 0.03;

/// The font and the spacing of the letters of a text.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Setting {
    /// The typeface; `None` for strokes.
    font: Option<Own>,
    /// Distance that is added between letters of the typeface.
    spacing: f64,
}

/// Where a character of a text comes from, if not from the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Face {
    Own(Own),
    OfMachine(ID),
}

/// A line of text.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Line {
    text: String,
    /// The letters from left to right.
    pieces: Vec<Piece>,
    /// Whether the text as a whole runs to the left.
    is_leftward: bool,
    setting: Setting,
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
    /// The outlines of a letter of a font; y goes up.
    Font(BezPath),
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
    /// Creates a line of strokes: each run of white space becomes one blank, and each character without a letter a
    /// question mark.
    pub(crate) fn new(text: &str) -> Self {
        Self::with(text, Setting::default(), Fonts::system)
    }

    /// Creates a line of small letters of a typeface.
    pub(crate) fn small(text: &str, typeface: Typeface) -> Self {
        let font = match typeface {
            Typeface::Strokes => return Self::new(text),
            // Capitals are for large letters, since their thin lines are too thin in small ones.
            Typeface::Serif | Typeface::Capitals => Own::Serif,
            Typeface::Sans => Own::Sans,
        };
        Self::with(text, Setting { font: Some(font), spacing: SPACING_OF_SMALL }, Fonts::system)
    }

    /// Creates a line of large letters of a typeface. Capitals are spaced out.
    pub(crate) fn title(text: &str, typeface: Typeface) -> Self {
        let is_of_capitals = text.chars().any(char::is_uppercase) && !text.chars().any(char::is_lowercase);
        let spacing = if is_of_capitals { SPACING_OF_TITLES } else { 0.0 };
        let set = |font| Self::with(text, Setting { font: Some(font), spacing }, Fonts::system);
        match typeface {
            Typeface::Strokes => Self::new(text),
            Typeface::Serif => set(Own::Serif),
            Typeface::Sans => set(Own::Sans),
            Typeface::Capitals => {
                let setting = Setting { font: Some(Own::Capitals), spacing: SPACING_OF_CAPITALS };
                Self::with(&capitals(text), setting, Fonts::system)
            }
        }
    }

    /// Creates a line with letters of the given fonts, which are only looked at if the text needs them.
    fn with<'a>(text: &str, setting: Setting, fonts: impl FnOnce() -> &'a Fonts) -> Self {
        let words = text.split(|it: char| it.is_whitespace() && !is_thin(it)).filter(|word| !word.is_empty());
        let mut text = words.collect::<Vec<_>>().join(" ");
        let own = setting.font.map(|font| (font, font.known(text.chars())));
        let mut faces: BTreeMap<char, Face> = BTreeMap::new();
        if let Some((font, known)) = own {
            faces.extend(known.into_iter().map(|character| (character, Face::Own(font))));
        }
        let is_foreign = |character: char| !LETTERS.contains_key(&character) && !is_invisible(character);
        let foreign: BTreeSet<char> =
            text.chars().filter(|character| is_foreign(*character) && !faces.contains_key(character)).collect();
        if foreign.is_empty() && faces.is_empty() {
            let pieces = text.char_indices().filter_map(|(at, character)| Piece::own(at, character)).collect();
            return Self { text, pieces, is_leftward: false, setting, replaced: Vec::new() };
        }
        let fonts = (!foreign.is_empty()).then(fonts);
        let found = fonts.map(|fonts| fonts.faces(&foreign)).unwrap_or_default();
        faces.extend(found.into_iter().map(|(character, id)| (character, Face::OfMachine(id))));
        let is_known = |character: char| !is_foreign(character) || faces.contains_key(&character);
        let mut seen = BTreeSet::new();
        let replaced = text.chars().filter(|it| !is_known(*it) && seen.insert(*it)).collect();
        if let Some((end, _)) = text.char_indices().nth(MAX_OF_FONTS) {
            text.truncate(end);
            text.push(ELLIPSIS);
        }
        let text: String = text.chars().map(|it| if is_known(it) { it } else { REPLACEMENT }).collect();
        let (mut pieces, is_leftward) = pieces(&text, fonts, &faces, setting.spacing);
        if let Some(last) = pieces.iter_mut().rev().find(|piece| piece.advance > 0.0) {
            last.advance -= if matches!(last.shape, Shape::Font(_)) { setting.spacing.min(last.advance) } else { 0.0 };
        }
        Self { text, pieces, is_leftward, setting, replaced }
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
        let own = self.setting.font.and_then(|font| {
            let glyph = font.shaped("…", false, 0.0).into_iter().next()?;
            Some(Piece { begin: 0, advance: glyph.advance, shape: Shape::Font(glyph.outlines) })
        });
        let Some(ellipsis) = own.or_else(|| Piece::own(0, ELLIPSIS)) else { return (empty, height) };
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
            let Shape::Own(letter) = &piece.shape else { return Vec::new() };
            letter.strokes.iter().map(|stroke| placed(stroke, at, height)).collect()
        };
        self.places(at, height).flat_map(of).collect()
    }

    /// Returns the letters of fonts.
    pub(crate) fn areas(&self, at: DVec2, height: f64) -> Vec<Area> {
        let of = |(piece, at): (&Piece, DVec2)| {
            let Shape::Font(outlines) = &piece.shape else { return None };
            let place = Affine::new([height, 0.0, 0.0, -height, at.x, at.y]);
            (!outlines.is_empty()).then(|| Area::new(place * outlines.clone(), HATCHING * height))
        };
        self.places(at, height).filter_map(of).collect()
    }

    /// Returns the words of the line as its letters show them at `at`, the left end of the baseline; `None` if it is empty.
    pub(crate) fn words(&self, at: DVec2, height: f64) -> Option<Text> {
        let along = Vec2::new(self.width() * height, 0.0);
        let text = Text { words: self.text.clone(), begin: Point::new(at.x, at.y), along, height };
        (!self.text.is_empty()).then_some(text)
    }

    /// Returns the start of each letter and its width, from left to right, in heights of capitals.
    pub(crate) fn advances(&self) -> impl Iterator<Item = [f64; 2]> {
        let mut start = 0.0;
        self.pieces.iter().map(move |piece| {
            let own = [start, piece.advance];
            start += piece.advance;
            own
        })
    }

    /// Returns the strokes and the letters of fonts of a line whose letters have positions and directions of their own.
    /// `place` returns the left end of the baseline of the letter that starts at the given distance and has the given
    /// width, and its reading direction in radians, clockwise; both are in the unit of `height`.
    pub(crate) fn along(&self, height: f64, place: impl Fn(f64, f64) -> (DVec2, f64)) -> (Vec<Vec<DVec2>>, Vec<Area>) {
        let (mut strokes, mut areas) = (Vec::new(), Vec::new());
        for (piece, [start, advance]) in self.pieces.iter().zip(self.advances()) {
            let (left, angle) = place(height * start, height * advance);
            let along = DVec2::from_angle(angle);
            match &piece.shape {
                Shape::Own(letter) => {
                    let point = |own: &DVec2| left + height * (own.x * along - own.y * along.perp());
                    strokes.extend(letter.strokes.iter().map(|stroke| stroke.iter().map(point).collect()));
                }
                Shape::Font(outlines) if outlines.is_empty() => {}
                Shape::Font(outlines) => {
                    let [x, y] = [along, -along.perp()].map(|axis| height * axis);
                    let place = Affine::new([x.x, x.y, y.x, y.y, left.x, left.y]);
                    areas.push(Area::new(place * outlines.clone(), HATCHING * height));
                }
            }
        }
        (strokes, areas)
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

/// Returns a text in capitals. Greek capitals have no accents where all letters are capitals.
fn capitals(text: &str) -> String {
    let bare = |letter| match letter {
        'Ά' => 'Α',
        'Έ' => 'Ε',
        'Ή' => 'Η',
        'Ί' => 'Ι',
        'Ό' => 'Ο',
        'Ύ' => 'Υ',
        'Ώ' => 'Ω',
        letter => letter,
    };
    text.to_uppercase().chars().map(bare).collect()
}

/// Returns the letters of a text from left to right, and whether it runs to the left as a whole. Without fonts of the
/// machine no character is one of them.
fn pieces(text: &str, fonts: Option<&Fonts>, faces: &BTreeMap<char, Face>, spacing: f64) -> (Vec<Piece>, bool) {
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
            let glyphs = match face {
                Some(Face::Own(font)) => Some(font.shaped(part, is_leftward, spacing)),
                Some(Face::OfMachine(id)) => fonts.map(|fonts| fonts.shaped(id, part, is_leftward)),
                None => None,
            };
            match glyphs {
                Some(glyphs) => pieces.extend(glyphs.into_iter().map(|glyph| Piece {
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
fn parts(text: &str, faces: &BTreeMap<char, Face>) -> Vec<(Range<usize>, Option<Face>)> {
    let mut parts: Vec<(Range<usize>, Option<Face>)> = Vec::new();
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
mod tests;
