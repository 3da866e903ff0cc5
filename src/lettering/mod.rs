//! Text as pen strokes: the letters are lines without width, so that pictures, SVG and plotters draw the same.
//!
//! The letters are those of A. V. Hershey ("Roman simplex"); `letters.txt` contains them and describes their source and
//! format. The unit of length is the height of a capital letter.

pub(crate) mod ink;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use glam::DVec2;

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

/// A line of text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Line {
    text: String,
    /// Characters without a letter, each once, in the order of the text.
    pub replaced: Vec<char>,
}

impl Line {
    /// Creates a line: each run of white space becomes one blank, and each character without a letter a question mark.
    pub(crate) fn new(text: &str) -> Self {
        let (mut replaced, mut seen) = (Vec::new(), BTreeSet::new());
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        let known = |character: char| {
            if LETTERS.contains_key(&character) {
                return character;
            }
            if seen.insert(character) {
                replaced.push(character);
            }
            REPLACEMENT
        };
        Self { text: text.chars().map(known).collect(), replaced }
    }

    /// Returns the text as it is drawn.
    pub(crate) fn text(&self) -> &str {
        &self.text
    }

    /// Returns the width, in heights of capitals.
    pub(crate) fn width(&self) -> f64 {
        self.letters().map(|letter| letter.advance).sum()
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
        // The longest beginning that leaves room for an ellipsis, without the blank that it may end with.
        let ellipsis = LETTERS.get(&ELLIPSIS).map_or(0.0, |letter| letter.advance);
        let (mut width, mut kept) = (0.0, None);
        for (at, character) in self.text.char_indices() {
            if (width + ellipsis) * height > room {
                break;
            }
            kept = Some(at);
            width += LETTERS.get(&character).map_or(0.0, |letter| letter.advance);
        }
        let text = kept.map_or_else(String::new, |end| format!("{}{ELLIPSIS}", self.text[..end].trim_end()));
        (Self { text, replaced: self.replaced.clone() }, height)
    }

    /// Returns the strokes of letters of `height`, starting at `at`, the left end of the baseline. y goes down, as in
    /// pixels.
    pub(crate) fn strokes(&self, at: DVec2, height: f64) -> Vec<Vec<DVec2>> {
        let mut strokes = Vec::new();
        let mut x = 0.0;
        for letter in self.letters() {
            let place = |point: &DVec2| at + height * DVec2::new(x + point.x, -point.y);
            strokes.extend(letter.strokes.iter().map(|stroke| stroke.iter().map(place).collect::<Vec<_>>()));
            x += letter.advance;
        }
        strokes
    }

    fn letters(&self) -> impl Iterator<Item = &'static Letter> {
        self.text.chars().filter_map(|character| LETTERS.get(&character))
    }
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
        let line = Line::new("  Mont\tBlanc \n 山 é 山 Ж");
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
        // As by trying each shorter text; a text of a megabyte is cut as fast as it is read.
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
        let (cut, _) = Line::new(&long).fitted(1000.0, 3.0, 1.0);
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
}
