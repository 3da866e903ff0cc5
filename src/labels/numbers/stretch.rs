//! Fits a number to the part of a line that it replaces.

use glam::DVec2;

use super::course::is_sharp;
use super::frame::Frame;
use super::paths::Path;

/// Samples for each letter height.
const PER_LETTER: usize = 4;
/// Numbers that turn by less than this in total are straight, in radians.
const STRAIGHT: f64 = 0.15;

/// The part of a line around a window, sampled at every quarter of a letter.
pub(super) struct Stretch {
    points: Vec<DVec2>,
    from_px: f64,
    step_px: f64,
}

impl Stretch {
    pub(super) fn new(path: &Path<'_>, middle_px: f64, half_px: f64, letter_px: f64) -> Self {
        let step_px = letter_px / PER_LETTER as f64;
        let half = (half_px / step_px).ceil();
        let from_px = middle_px - half * step_px;
        let mut points = Vec::with_capacity(2 * half as usize + 1);
        path.sample(from_px, step_px, 2 * half as usize + 1, &mut points);
        Self { points, from_px, step_px }
    }

    /// Moves an arc to the middle of the line, and makes it straight if it is nearly so. Returns it with the mean and
    /// the largest distance of the line from it under the text.
    pub(super) fn fitted(&self, mut frame: Frame, width_px: f64) -> Option<(Frame, [f64; 2])> {
        if (frame.bend * width_px).abs() < STRAIGHT {
            frame.bend = 0.0;
        }
        let mut off_px = [0.0; 2];
        // After the first pass the arc is in its place; the second one measures.
        for _ in 0..2 {
            let points = self.points.iter().map(|point| frame.local(*point));
            let under: Vec<DVec2> = points.filter(|local| local.x.abs() <= 0.5 * width_px + self.step_px).collect();
            let count = under.len() as f64;
            if under.len() < PER_LETTER {
                return None;
            }
            let mean = under.iter().map(|local| local.y).sum::<f64>() / count;
            let square = under.iter().map(|local| (local.y - mean).powi(2)).sum::<f64>() / count;
            let largest = under.iter().map(|local| (local.y - mean).abs()).fold(0.0, f64::max);
            frame.centre += mean * frame.direction(0.0).perp();
            off_px = [square.sqrt(), largest];
        }
        Some((frame, off_px))
    }

    /// Returns the arc lengths at which the line, followed from the middle, is `half_px` away along the arc.
    pub(super) fn gap(&self, frame: &Frame, half_px: f64) -> Option<[f64; 2]> {
        let middle = self.points.len() / 2;
        let u = |i: usize| frame.local(self.points[i]).x;
        let direction = u(middle + 1) - u(middle - 1);
        let sign = if direction < 0.0 { -1.0 } else { 1.0 };
        let along_px = |i: f64| self.from_px + i * self.step_px;
        let part = |inner: usize, outer: usize, side: f64| {
            let [inner, outer] = [inner, outer].map(|i| side * sign * u(i));
            (inner < half_px && outer >= half_px).then(|| (half_px - inner) / (outer - inner))
        };
        let end = (middle..self.points.len() - 1).find_map(|i| Some(i as f64 + part(i, i + 1, 1.0)?))?;
        let begin = (0..middle).rev().find_map(|i| Some((i + 1) as f64 - part(i + 1, i, -1.0)?))?;
        Some([along_px(begin), along_px(end)])
    }

    /// Returns whether the line turns too sharply from one letter to the next within a gap.
    pub(super) fn is_sharp(&self, gap_px: [f64; 2], letter_px: f64) -> bool {
        let [first, last] = gap_px.map(|along_px| (along_px - self.from_px) / self.step_px);
        let inside = (first.floor().max(0.0) as usize).max(PER_LETTER)..=last.ceil().max(0.0) as usize;
        inside.filter(|i| i + PER_LETTER < self.points.len()).any(|i| {
            let [before, after] =
                [self.points[i] - self.points[i - PER_LETTER], self.points[i + PER_LETTER] - self.points[i]];
            let is_long = before.length().min(after.length()) > 0.3 * letter_px;
            is_long && is_sharp(before, after)
        })
    }
}
