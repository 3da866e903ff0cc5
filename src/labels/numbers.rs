//! Numbers on contour lines.
//!
//! A number interrupts its line, and is in the middle of the gap: straight where the line is nearly straight, otherwise
//! along an arc of a circle. [`place`] chooses the positions; the GPU interrupts the lines
//! ([`crate::frame::LineGap`]).
//!
//! 1. Each line is sampled at every half letter height ([`course`]). Prefix sums of the directions give, for a window
//!    of the width of the text, the arc that fits best and the roughness around it, in constant time.
//! 2. The best windows are fitted to the line ([`stretch`]) and compared with the page ([`judge`]): lines that pass
//!    under the digits, the direction of uphill, the border. Everything that a reader dislikes has a cost; what a map must not have excludes the window.
//! 3. Ladders ([`ladder`]): from the best window in each cell of a coarse grid, a slope line is followed up and down
//!    to the next contour lines, and numbers are placed near it. The ladders with the most and the best numbers win.
//! 4. Single numbers fill the rest, in the order of their costs, and each is the seed of a further ladder ([`choose`]).
//! 5. Each number is moved along its line as long as that improves it or its place in a ladder.
//!
//! Tops of digits point uphill, as in Maplex for ArcGIS and on Swiss maps; the bend of at most 45° for each letter is
//! MapLibre's. Everything is deterministic. The unit of length is the pixel, or any other; y goes down.

mod choose;
mod course;
mod frame;
mod grid;
mod judge;
mod ladder;
mod paths;
mod ranks;
mod stretch;
mod taken;
#[cfg(test)]
mod tests;

use glam::DVec2;

use self::frame::Frame;

/// A contour line.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contour<'a> {
    /// Points in pixels. Points that are not finite, and repeated points, are skipped.
    pub points: &'a [DVec2],
    pub is_closed: bool,
    /// Height in metres, or depth in metres of a line under water.
    pub level_m: f64,
    /// Whether this is an index contour, which is drawn with a stronger line.
    pub is_index: bool,
    /// Whether this is a line of equal depth. Depths and heights have separate ladders.
    pub is_depth: bool,
    /// The number as it is written. A line with an empty text has no number.
    pub text: &'a str,
}

/// The page, and what is known of it.
#[derive(Clone, Copy)]
pub(crate) struct Page<'a> {
    /// Lower and upper corner of the page, in pixels.
    pub corners_px: [DVec2; 2],
    /// Lower and upper corners of boxes that numbers must not touch, in pixels.
    pub obstacles_px: &'a [[DVec2; 2]],
    /// Height of the digits, in pixels.
    pub letter_px: f64,
    /// Returns the width of a text, in pixels.
    pub width_px: &'a dyn Fn(&str) -> f64,
    /// Returns the direction of uphill at a point of the page, of any length, or `None` if it is unknown.
    pub uphill: &'a dyn Fn(DVec2) -> Option<DVec2>,
}

/// Which contour lines have numbers.
#[cfg_attr(not(test), expect(dead_code, reason = "no style chooses one of the others yet"))]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Every {
    /// Index contours.
    Index,
    /// All contour lines.
    All,
    /// Index contours, and others where there are no lines and no numbers nearby.
    #[default]
    Auto,
}

/// Which way up the digits are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Tops {
    /// Tops of digits point uphill. Positions where this turns a number upside down are avoided.
    #[default]
    Uphill,
    /// Numbers are never upside down.
    Upright,
}

/// Rules for [`place`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rules {
    pub every: Every,
    pub tops: Tops,
    /// Smallest distance of two numbers on the same line, in pixels; numbers of the same level on different lines are
    /// at least half as far apart. Numbers are usually a little farther apart than this.
    pub spacing_px: f64,
}

impl Default for Rules {
    fn default() -> Self {
        Self { every: Every::default(), tops: Tops::default(), spacing_px: 250.0 }
    }
}

/// A number on a contour line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Number {
    /// Index of the contour line.
    pub line: usize,
    pub text: String,
    /// Begin and end of the gap, as arc lengths of the line in pixels. On a closed line the gap may reach over the first
    /// point: its end is then greater than the length of the line.
    pub gap_px: [f64; 2],
    /// Centre of the text, in pixels.
    pub centre_px: DVec2,
    /// Reading direction at the centre, in radians; 0 is to the right, and positive angles are clockwise.
    pub angle: f64,
    /// Change of the reading direction along the text, in radians per pixel; 0 for a straight number.
    pub bend: f64,
    /// Width of the text and height of its digits, in pixels.
    pub size_px: DVec2,
}

/// Position of a letter: the left end of its baseline in pixels, and its reading direction in radians, clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Letter {
    pub left_px: DVec2,
    pub angle: f64,
}

impl Number {
    fn frame(&self) -> Frame {
        Frame { centre: self.centre_px, along: DVec2::from_angle(self.angle), bend: self.bend }
    }

    /// Returns whether the whole text is on a straight line.
    pub(crate) fn is_straight(&self) -> bool {
        self.bend == 0.0
    }

    /// Returns the position of a letter of width `advance_px` that begins at `from_px` along the text. The middle of
    /// the letter is on the arc, and the letter has the direction of the arc there.
    pub(crate) fn letter(&self, from_px: f64, advance_px: f64) -> Letter {
        let u = from_px + 0.5 * (advance_px - self.size_px.x);
        let angle = self.angle + self.bend * u;
        let along = DVec2::from_angle(angle);
        let middle = self.frame().point(u, 0.0);
        Letter { left_px: middle - 0.5 * advance_px * along + 0.5 * self.size_px.y * along.perp(), angle }
    }
}

/// Largest side of a page, in letter heights.
const MAX_LETTERS: f64 = 2e4;

/// Places numbers on contour lines. Returns them ordered by line and position; none if a length of the page or of the
/// rules is not positive, or if the page is more than 20 000 letters high or wide.
pub(crate) fn place(contours: &[Contour<'_>], page: &Page<'_>, rules: &Rules) -> Vec<Number> {
    let size_px = page.corners_px[1] - page.corners_px[0];
    let is_valid = |length_px: f64| length_px.is_finite() && length_px > 0.0;
    if ![page.letter_px, rules.spacing_px, size_px.x, size_px.y].into_iter().all(is_valid) {
        return Vec::new();
    }
    // Such a page has no letters that anyone could read, and would need too many cells.
    if size_px.max_element() > MAX_LETTERS * page.letter_px {
        return Vec::new();
    }
    choose::numbers(&judge::Map::new(contours, page, rules))
}

/// Returns the text of a level: whole metres, or one decimal for levels between them. Depths have no sign.
pub(crate) fn metres(level_m: f64, is_depth: bool) -> String {
    let tenths = (level_m * 10.0).round();
    let tenths = if is_depth { tenths.abs() } else { tenths };
    let sign = if tenths < 0.0 { "−" } else { "" };
    let decimals = usize::from(tenths % 10.0 != 0.0);
    format!("{sign}{:.decimals$}", tenths.abs() / 10.0)
}
