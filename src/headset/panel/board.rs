//! Pixels of a panel: filled rectangles and text.

use glam::DVec2;

use crate::lettering::Line;
use crate::lettering::area::cover_areas;
use crate::lettering::ink::{PenStroke, cover};

/// A colour in sRGB.
pub(super) type Tone = [u8; 3];

/// Colour of the panel's background.
pub(super) const PAPER: Tone = [26, 28, 33];
/// Colour of text.
pub(super) const INK: Tone = [238, 234, 224];
/// Colour of less important text.
pub(super) const DIM: Tone = [156, 160, 168];
/// The selected row, and the names of controls.
pub(super) const ACCENT: Tone = [246, 190, 92];
/// Lines and grooves.
pub(super) const GROOVE: Tone = [66, 70, 80];

/// Width of the pen that writes, as a fraction of the height of capitals.
const PEN: f64 = 0.125;
/// Smallest height of letters, as a fraction of the intended height; longer texts are cut.
const SMALLEST: f64 = 0.88;

/// A picture in memory.
pub(super) struct Board {
    size_px: [usize; 2],
    bytes: Vec<u8>,
}

impl Board {
    /// Creates an empty board.
    pub(super) fn new(size_px: [u32; 2]) -> Self {
        let size_px = size_px.map(|side| side as usize);
        let pixel = [PAPER[0], PAPER[1], PAPER[2], 255];
        Self { size_px, bytes: pixel.repeat(size_px[0] * size_px[1]) }
    }

    /// Draws a line along the border, which separates the panel from a dark picture behind it.
    pub(super) fn frame(&mut self) {
        let [width, height] = self.size_px.map(|side| side as f64);
        let pen = 4.0;
        for (from, to) in [
            ([0.0, 0.0], [width, pen]),
            ([0.0, height - pen], [width, height]),
            ([0.0, 0.0], [pen, height]),
            ([width - pen, 0.0], [width, height]),
        ] {
            self.fill(from, to, GROOVE);
        }
    }

    /// Fills a rectangle; partly covered pixels are filled as a whole or not at all.
    pub(super) fn fill(&mut self, from: [f64; 2], to: [f64; 2], tone: Tone) {
        let at = |value: f64, side: usize| (value.round().max(0.0) as usize).min(side);
        let [width, height] = self.size_px;
        let columns = at(from[0], width)..at(to[0], width);
        for row in at(from[1], height)..at(to[1], height) {
            for column in columns.clone() {
                self.blend(row, column, tone, 1.0);
            }
        }
    }

    /// Draws a line through points.
    pub(super) fn line(&mut self, points: &[[f64; 2]], tone: Tone) {
        let points = points.iter().map(|point| DVec2::from(*point)).collect();
        self.strokes(&[PenStroke { points, width_px: 4.0 }], tone);
    }

    /// Writes a text from the left end of its baseline, with capitals of `height`. A text that is wider than `room`
    /// becomes a little smaller, and is then cut.
    pub(super) fn text(&mut self, text: &str, at: DVec2, height: f64, room: f64, tone: Tone) {
        let (line, height) = Line::new(text).fitted(room, height, SMALLEST * height);
        let width_px = PEN * height;
        let strokes: Vec<PenStroke> =
            line.strokes(at, height).into_iter().map(|points| PenStroke { points, width_px }).collect();
        self.strokes(&strokes, tone);
        let areas = line.areas(at, height);
        let reach = areas.iter().map(|area| area.high_px()).fold([f64::MAX, f64::MIN], wider);
        self.rows(reach, tone, |row, covered| cover_areas(&areas, 0.0, row, covered));
    }

    /// Writes a text on lines that are `room` wide and `pitch` apart. Text that does not fit on the last of `most`
    /// lines is cut.
    pub(super) fn paragraph(&mut self, text: &str, at: DVec2, height: f64, (room, pitch): (f64, f64), most: usize) {
        let mut lines: Vec<String> = Vec::new();
        for word in text.split_whitespace() {
            let is_full = lines.len() == most;
            match lines.last_mut() {
                Some(line) if is_full || Line::new(&format!("{line} {word}")).width() * height <= room => {
                    line.extend([" ", word]);
                }
                _ => lines.push(word.to_owned()),
            }
        }
        for (i, line) in lines.iter().enumerate() {
            self.text(line, at + DVec2::new(0.0, pitch * i as f64), height, room, INK);
        }
    }

    fn strokes(&mut self, strokes: &[PenStroke], tone: Tone) {
        let points = || strokes.iter().flat_map(|stroke| &stroke.points).map(|point| [point.y - 8.0, point.y + 8.0]);
        let reach = points().fold([f64::MAX, f64::MIN], wider);
        self.rows(reach, tone, |row, covered| cover(strokes, 0.0, row, covered));
    }

    /// Draws on the rows between two heights.
    fn rows(&mut self, [top, bottom]: [f64; 2], tone: Tone, draw: impl Fn(f64, &mut [f32])) {
        let [width, height] = self.size_px;
        let mut covered = vec![0.0; width];
        let end = (bottom.ceil().max(0.0) as usize).min(height);
        for row in (top.floor().max(0.0) as usize)..end {
            covered.fill(0.0);
            draw(row as f64, &mut covered);
            for (column, part) in covered.iter().enumerate().filter(|(_, part)| **part > 0.0) {
                self.blend(row, column, tone, *part);
            }
        }
    }

    fn blend(&mut self, row: usize, column: usize, tone: Tone, part: f32) {
        let start = 4 * (row * self.size_px[0] + column);
        for (byte, tone) in self.bytes[start..start + 3].iter_mut().zip(tone) {
            let (from, to) = (f32::from(*byte), f32::from(tone));
            *byte = (from + (to - from) * part).round() as u8;
        }
    }

    /// Returns the pixels.
    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.bytes
    }
}

fn wider(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
}
