//! Exactness of a drawing: how far a picture is from a converged reference of the same view at rest.
//!
//! The reference has more samples and exact options, so it shows what the faster drawing approximates. The measures are
//!
//! - *line recall*: the share of the reference's line pixels near which the drawing has a line, within [`REACH_PX`];
//! - *line precision*: the share of the drawing's line pixels near which the reference has a line;
//! - *tone error*: the mean difference of luma over squares of [`CELL_PX`] pixels, as the eye sees marks from a
//!   distance. A mark that moves within its square is not an error;
//! - *picture error*: the root of the mean squared difference of luma of single pixels;
//! - *FLIP*: the mean of the perceptual difference of Andersson and others (2020, "FLIP: A Difference Evaluator for
//!   Alternating Images"), at [`PIXELS_PER_DEGREE`];
//! - *surface error*: the largest distance in pixels between the drawn land and the heights of the file.
//!
//! Pictures of another size, as a lower render scale has them, are compared at the size of the reference: each of its
//! pixels reads the drawing at its own place, luma bilinearly.

use super::report::Metrics;
use super::temporal::{DrawnFrame, LINE_INK, REACH_PX, Share, TemporalError};

/// Side of the squares over which tones are compared.
pub(crate) const CELL_PX: usize = 8;

/// Resolution at which the pictures are viewed, for FLIP: a monitor of 0.7 m width and 3840 pixels from 0.7 m.
const PIXELS_PER_DEGREE: f32 = nv_flip::DEFAULT_PIXELS_PER_DEGREE;

/// Sums over the views at which a drawing was compared with its reference.
#[derive(Clone, Debug, Default)]
pub(crate) struct ExactnessTotals {
    views: u64,
    /// Line pixels of the reference that the drawing has, of all line pixels of the reference.
    found: Share,
    /// Line pixels of the drawing that the reference has, of all line pixels of the drawing.
    right: Share,
    tone: Share,
    luma: Share,
    flip: Share,
    surface_px: Option<f64>,
}

impl ExactnessTotals {
    /// Adds a view: what was drawn, the reference, and the largest surface error in pixels if it was measured.
    ///
    /// # Errors
    /// [`TemporalError::Size`] if the pictures have pixels that do not fill them.
    pub(crate) fn add(
        &mut self,
        drawn: &DrawnFrame,
        reference: &DrawnFrame,
        surface_px: Option<f64>,
    ) -> Result<(), TemporalError> {
        if !drawn.is_whole() || !reference.is_whole() {
            return Err(TemporalError::Size);
        }
        self.views += 1;
        let size = size_of(reference);
        // An error of a pixel of a smaller picture is an error of several pixels of the reference.
        let surface_px = surface_px.map(|error_px| error_px * size[1] as f64 / size_of(drawn)[1] as f64);
        self.surface_px = self.surface_px.into_iter().chain(surface_px).reduce(f64::max);
        let luma = resized(&drawn.luma, size_of(drawn), size, Filter::Bilinear);
        for (drawn, reference) in luma.iter().zip(&reference.luma) {
            self.luma += Share { part: f64::from(drawn - reference).powi(2), whole: 1.0 };
        }
        self.flip += Share { part: flip(drawn, reference), whole: 1.0 };
        for (drawn, reference) in cells(&luma, size[0]).into_iter().zip(cells(&reference.luma, size[0])) {
            self.tone += Share { part: (drawn - reference).abs(), whole: 1.0 };
        }
        if let (Some(drawn_ink), Some(ink)) = (&drawn.ink, &reference.ink) {
            let drawn_ink = resized(drawn_ink, size_of(drawn), size, Filter::Most);
            let [lines, drawn_lines] = [ink, &drawn_ink].map(|ink| Lines::of(ink, size[0]));
            self.found += lines.near(&drawn_lines);
            self.right += drawn_lines.near(&lines);
        }
        Ok(())
    }

    /// Returns the numbers for a report; `None` before the first view. Values that could not be measured are null:
    ///
    /// | name | |
    /// | --- | --- |
    /// | `views` | number of views |
    /// | `line_recall` | line pixels of the reference that the drawing has |
    /// | `line_precision` | line pixels of the drawing that the reference has |
    /// | `tone_error` | mean difference of luma of squares, 0 to 1 |
    /// | `picture_error` | root of the mean squared difference of luma, 0 to 1 |
    /// | `flip` | mean FLIP, 0 to 1 |
    /// | `surface_error_px` | largest distance of the drawn land from the heights |
    pub(crate) fn metrics(&self) -> Option<Metrics> {
        let metrics = [
            ("views", Some(self.views as f64)),
            ("line_recall", self.found.value()),
            ("line_precision", self.right.value()),
            ("tone_error", self.tone.value()),
            ("picture_error", self.luma.value().map(f64::sqrt)),
            ("flip", self.flip.value()),
            ("surface_error_px", self.surface_px),
        ];
        (self.views > 0).then(|| metrics.into_iter().map(|(name, value)| (name.to_owned(), value)).collect())
    }
}

fn size_of(frame: &DrawnFrame) -> [usize; 2] {
    frame.view.part.size_px.map(|side| side as usize)
}

/// Returns the mean FLIP of a drawing.
fn flip(drawn: &DrawnFrame, reference: &DrawnFrame) -> f64 {
    let [from, to] = [drawn, reference].map(size_of);
    let channel = |channel: usize| {
        let values: Vec<f32> = drawn.colors.iter().map(|color| color[channel].into()).collect();
        resized(&values, from, to, Filter::Bilinear)
    };
    let [red, green, blue] = [0, 1, 2].map(channel);
    let values = red.iter().zip(&green).zip(&blue).flat_map(|((red, green), blue)| [*red, *green, *blue]);
    let drawn: Vec<u8> = values.map(|value| value.round() as u8).collect();
    let [width, height] = to.map(|side| side as u32);
    let image = |bytes: &[u8]| nv_flip::FlipImageRgb8::with_data(width, height, bytes);
    let map = nv_flip::flip(image(reference.colors.as_flattened()), image(&drawn), PIXELS_PER_DEGREE);
    let errors = map.to_vec();
    errors.iter().map(|error| f64::from(*error)).sum::<f64>() / errors.len().max(1) as f64
}

/// How a picture is read between its pixels.
#[derive(Clone, Copy)]
enum Filter {
    /// The largest value of all pixels that a pixel covers: a line of a larger picture is not lost.
    Most,
    Bilinear,
}

/// Returns a picture of another size, whose pixels read `picture` at their own places.
fn resized(picture: &[f32], from: [usize; 2], to: [usize; 2], filter: Filter) -> Vec<f32> {
    if from == to {
        return picture.to_vec();
    }
    let [width, height] = from;
    let pixel = |x: usize, y: usize| picture[y.min(height - 1) * width + x.min(width - 1)];
    let covered = |index: usize, side: usize| {
        let first = index * from[side] / to[side];
        first..((index + 1) * from[side]).div_ceil(to[side]).max(first + 1)
    };
    let place = |index: usize, side: usize| (index as f64 + 0.5) * from[side] as f64 / to[side] as f64;
    let mut resized = Vec::with_capacity(to[0] * to[1]);
    for y in 0..to[1] {
        for x in 0..to[0] {
            let [at_x, at_y] = [place(x, 0), place(y, 1)];
            resized.push(match filter {
                Filter::Most => {
                    let [columns, rows] = [covered(x, 0), covered(y, 1)];
                    let all = rows.flat_map(|row| columns.clone().map(move |column| (column, row)));
                    all.map(|(column, row)| pixel(column, row)).fold(0.0, f32::max)
                }
                Filter::Bilinear => {
                    let [left, top] = [at_x - 0.5, at_y - 0.5].map(|at| at.max(0.0));
                    let [column, row] = [left as usize, top as usize];
                    let [along, down] = [(left - left.floor()) as f32, (top - top.floor()) as f32];
                    let of_row = |row| pixel(column, row) * (1.0 - along) + pixel(column + 1, row) * along;
                    of_row(row) * (1.0 - down) + of_row(row + 1) * down
                }
            });
        }
    }
    resized
}

/// Returns the mean of each square of [`CELL_PX`] pixels; those at the right and lower border may be smaller.
fn cells(picture: &[f32], width: usize) -> Vec<f64> {
    let height = picture.len() / width;
    let mut cells = Vec::new();
    for top in (0..height).step_by(CELL_PX) {
        for left in (0..width).step_by(CELL_PX) {
            let rows = top..(top + CELL_PX).min(height);
            let columns = left..(left + CELL_PX).min(width);
            let count = (rows.len() * columns.len()) as f64;
            let sum: f64 = rows
                .map(|y| &picture[y * width..])
                .flat_map(|row| &row[columns.clone()])
                .map(|it| f64::from(*it))
                .sum();
            cells.push(sum / count);
        }
    }
    cells
}

/// The line pixels of a picture.
struct Lines {
    is_line: Vec<bool>,
    width: usize,
}

impl Lines {
    fn of(ink: &[f32], width: usize) -> Self {
        Self { is_line: ink.iter().map(|ink| *ink >= LINE_INK).collect(), width }
    }

    /// Returns these line pixels that have a line pixel of `other` within reach, of all of these line pixels.
    fn near(&self, other: &Self) -> Share {
        let reach = REACH_PX.floor() as isize;
        let around: Vec<[isize; 2]> = (-reach..=reach)
            .flat_map(|y| (-reach..=reach).map(move |x| [x, y]))
            .filter(|[x, y]| ((x * x + y * y) as f64).sqrt() <= REACH_PX)
            .collect();
        let height = self.is_line.len() / self.width;
        let has = |x: usize, y: usize, [right, down]: [isize; 2]| {
            let (Some(x), Some(y)) = (x.checked_add_signed(right), y.checked_add_signed(down)) else { return false };
            x < self.width && y < height && other.is_line[y * self.width + x]
        };
        let mut share = Share::default();
        for pixel in (0..self.is_line.len()).filter(|pixel| self.is_line[*pixel]) {
            let (x, y) = (pixel % self.width, pixel / self.width);
            let is_near = around.iter().any(|offset| has(x, y, *offset));
            share += Share { part: f64::from(u8::from(is_near)), whole: 1.0 };
        }
        share
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may panic")]

    use glam::DVec3;

    use super::*;
    use crate::scene::view::{Pose, View};

    const SIZE_PX: [u32; 2] = [64, 48];

    /// Returns a frame whose ink and luma are functions of the pixel.
    fn frame(size_px: [u32; 2], ink: impl Fn(u32, u32) -> f32) -> DrawnFrame {
        let [position_m, forward, right, up] = [DVec3::ZERO, DVec3::Y, DVec3::X, DVec3::Z];
        let pose = Pose { position_m, forward, right, up, fov_rad: 1.0 };
        let view = View::whole(pose, pose, size_px);
        let pixels = || (0..size_px[1]).flat_map(|y| (0..size_px[0]).map(move |x| (x, y)));
        let ink: Vec<f32> = pixels().map(|(x, y)| ink(x, y)).collect();
        DrawnFrame {
            view,
            origin_m: DVec3::ZERO,
            position: vec![[0.0; 4]; ink.len()],
            luma: ink.iter().map(|ink| 1.0 - ink).collect(),
            colors: ink.iter().map(|ink| [(255.0 * (1.0 - ink)).round() as u8; 3]).collect(),
            ink: Some(ink),
            strokes: None,
            centres: None,
            marks: None,
        }
    }

    fn of(drawn: &DrawnFrame, reference: &DrawnFrame) -> impl Fn(&str) -> f64 + use<> {
        let mut totals = ExactnessTotals::default();
        assert!(totals.metrics().is_none());
        totals.add(drawn, reference, None).unwrap();
        let metrics = totals.metrics().unwrap();
        move |name| metrics[name].unwrap()
    }

    fn column(at: u32) -> impl Fn(u32, u32) -> f32 {
        move |x, _| if x == at { 1.0 } else { 0.0 }
    }

    #[test]
    fn a_drawing_is_exact_if_it_is_its_reference() {
        let reference = frame(SIZE_PX, column(20));
        let same = of(&reference, &reference);
        assert_eq!(["line_recall", "line_precision", "tone_error", "picture_error"].map(same), [1.0, 1.0, 0.0, 0.0]);
    }

    #[test]
    fn lost_and_added_lines_are_told_apart() {
        let reference = frame(SIZE_PX, |x, _| if x == 20 || x == 40 { 1.0 } else { 0.0 });
        let lost = of(&frame(SIZE_PX, column(20)), &reference);
        assert_eq!([lost("line_recall"), lost("line_precision")], [0.5, 1.0]);
        let added = of(&reference, &frame(SIZE_PX, column(20)));
        assert_eq!([added("line_recall"), added("line_precision")], [1.0, 0.5]);
        // A line that is moved by a pixel is still there, and one that is moved by two is not.
        let [near, far] = [41, 42].map(|at| {
            let moved = frame(SIZE_PX, |x, _| if x == 20 || x == at { 1.0 } else { 0.0 });
            of(&moved, &reference)("line_recall")
        });
        assert_eq!([near, far], [1.0, 0.5]);
    }

    #[test]
    fn a_tone_is_compared_over_squares() {
        // A dot in each square, in its first or in its third column: other pixels, but the same tone.
        let dots = |first: u32| frame(SIZE_PX, move |x, y| if x % 8 == first && y % 8 == 4 { 1.0 } else { 0.0 });
        let moved = of(&dots(2), &dots(0));
        assert!(moved("tone_error") < 1e-6 && moved("picture_error") > 0.1);
        // Planted: a picture that is darker everywhere.
        let dark = of(&frame(SIZE_PX, |_, _| 0.25), &frame(SIZE_PX, |_, _| 0.0));
        assert!((dark("tone_error") - 0.25).abs() < 1e-6 && (dark("picture_error") - 0.25).abs() < 1e-6);
    }

    #[test]
    fn a_smaller_picture_is_compared_at_the_size_of_the_reference() {
        let wide = |x: u32, width: u32| if x * 2 / width == 1 { 0.5 } else { 0.0 };
        let reference = frame(SIZE_PX, |x, _| wide(x, SIZE_PX[0]));
        let half = frame([32, 24], |x, _| wide(x, 32));
        let same = of(&half, &reference);
        assert_eq!([same("line_recall"), same("line_precision")], [1.0, 1.0]);
        assert!(same("tone_error") < 0.01, "{}", same("tone_error"));
        // Planted: the other side is dark.
        let other = frame([32, 24], |x, _| wide(31 - x, 32));
        assert!(of(&other, &reference)("line_recall") < 0.1);
        // The land of a picture of half the size is as far from the heights as twice as many pixels of the reference.
        let mut totals = ExactnessTotals::default();
        totals.add(&half, &reference, Some(0.5)).unwrap();
        assert_eq!(totals.metrics().unwrap()["surface_error_px"], Some(1.0));
        // A line of one pixel in a picture of twice the size is there, in an even column and in an odd one.
        for at in [40, 41] {
            let twice = frame([128, 96], column(at));
            let line = of(&twice, &frame(SIZE_PX, column(20)));
            assert_eq!([line("line_recall"), line("line_precision")], [1.0, 1.0], "{at}");
        }
        let mut broken = half;
        broken.luma.pop();
        assert_eq!(ExactnessTotals::default().add(&broken, &reference, None), Err(TemporalError::Size));
    }

    #[test]
    fn what_an_eye_notices_more_is_a_larger_flip() {
        let line_at = |column: u32| frame(SIZE_PX, move |x, _| if x % 16 == column { 1.0 } else { 0.0 });
        let of = |drawn: &DrawnFrame| flip(drawn, &line_at(4));
        let [same, moved, missing] = [line_at(4), line_at(5), frame(SIZE_PX, |_, _| 0.0)].map(|drawn| of(&drawn));
        let black = of(&frame(SIZE_PX, |_, _| 1.0));
        assert!(same == 0.0 && moved > 0.01 && missing > moved && black > missing, "{same} {moved} {missing} {black}");
        // A smaller picture of the same lines, two pixels of it for each one of theirs.
        let half = frame(SIZE_PX.map(|side| side / 2), |x, _| if x % 8 == 2 { 0.5 } else { 0.0 });
        assert!(of(&half) < missing, "{}", of(&half));
    }
}
