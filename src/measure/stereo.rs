//! Agreement of the drawings of two eyes.
//!
//! Both eyes see the same world at the same time, so the place of a pixel of one eye in the other is known exactly; it
//! is computed as between two frames ([`super::temporal`]). Surfaces that only one eye sees are ignored. The measures
//! are
//!
//! - *orphans*: ink of lines that the other eye lacks within [`REACH_PX`], of all ink. Each pixel counts with its ink,
//!   so no threshold is needed;
//! - *correlation of ink*, of lines and of marks: Pearson's correlation of the ink at a pixel and at its place in the
//!   other eye. For lines, pixels count where either eye has a line; for marks, all pixels of surfaces. Places are
//!   between pixels, and interpolation blurs thin lines, so the ink of both eyes is first spread over 3 × 3 pixels
//!   (1 2 1 in each direction);
//! - *identity* and *width* of strokes: of pixels along the centre lines of strokes that continue in the other eye,
//!   those that do not continue as the same stroke within [`REACH_PX`]; and of the others, those with another width
//!   there (by more than [`SAME_WIDTH`]);
//! - *coverage*: line pixels of each eye, for comparison with a single eye.

use super::report::Metrics;
use super::temporal::follow::{Follower, SurfaceOfFrame, Whose};
use super::temporal::lines::Fates;
use super::temporal::{DrawnFrame, LINE_INK, Share, TemporalError};

/// A line has a counterpart if the other eye has ink within this distance.
pub(crate) const REACH_PX: f64 = 2.0;
/// Two widths are equal if they differ by no more than this share.
pub(crate) const SAME_WIDTH: f32 = 0.05;

/// Sums over pairs of values, for their correlation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Correlation {
    count: f64,
    sums: [f64; 2],
    squares: [f64; 2],
    products: f64,
}

impl Correlation {
    pub(crate) fn add(&mut self, a: f64, b: f64) {
        self.count += 1.0;
        self.sums = [self.sums[0] + a, self.sums[1] + b];
        self.squares = [self.squares[0] + a * a, self.squares[1] + b * b];
        self.products += a * b;
    }

    /// Returns Pearson's correlation; `None` if either side does not vary.
    pub(crate) fn value(&self) -> Option<f64> {
        let spread = |i: usize| self.count * self.squares[i] - self.sums[i] * self.sums[i];
        let both = (spread(0) * spread(1)).sqrt();
        (both > 1e-9).then(|| (self.count * self.products - self.sums[0] * self.sums[1]) / both)
    }
}

/// Sums over pairs of pictures of two eyes.
#[derive(Clone, Debug, Default)]
pub struct StereoTotals {
    pairs: u64,
    has_lines: bool,
    has_strokes: bool,
    /// For the left eye and for the right one.
    orphans: [Share; 2],
    coverage: Share,
    masked: Share,
    other_identity: Share,
    other_width: Share,
    lines: Correlation,
    marks: Correlation,
    luma: Correlation,
}

impl StereoTotals {
    /// Compares the pictures of two eyes and adds the result.
    ///
    /// # Errors
    /// [`TemporalError::Size`] if the pictures have different sizes, or pixels that do not fill them.
    pub fn add(&mut self, left: &DrawnFrame, right: &DrawnFrame) -> Result<(), TemporalError> {
        if left.view.part.size_px != right.view.part.size_px || !left.is_whole() || !right.is_whole() {
            return Err(TemporalError::Size);
        }
        self.pairs += 1;
        let seen = [SurfaceOfFrame::new(left), SurfaceOfFrame::new(right)];
        for (own, other, eye) in [(left, right, 0), (right, left, 1)] {
            let follower = Follower { from: &seen[eye], to: &seen[1 - eye] };
            self.add_lines(&follower, own, other, eye);
            if let (Some(own), Some(other)) = (&own.marks, &other.marks) {
                correlate(&mut self.marks, &follower, own, other);
            }
            correlate(&mut self.luma, &follower, &own.luma, &other.luma);
        }
        Ok(())
    }

    fn add_lines(&mut self, follower: &Follower<'_>, own: &DrawnFrame, other: &DrawnFrame, eye: usize) {
        let (Some(ink), Some(ink_there)) = (&own.ink, &other.ink) else { return };
        self.has_lines = true;
        let fates = Fates::of(follower, ink, ink_there, REACH_PX, own.strokes.as_ref());
        let change = fates.change();
        self.orphans[eye] += change.lone_ink;
        self.masked += change.masked;
        self.coverage += Share { part: fates.line_pixels() as f64, whole: ink.len() as f64 };
        let (soft, soft_there) = (spread(ink, follower.from.width()), spread(ink_there, follower.to.width()));
        for fate in &fates.0 {
            let Some(there) = fate.there.as_ref().filter(|there| fate.ink.max(there.ink) >= LINE_INK) else { continue };
            self.lines.add(soft[fate.pixel].into(), follower.to.bilinear(&soft_there, there.place));
        }
        let (Some(strokes), Some(strokes_there)) = (&own.centres, &other.centres) else { return };
        self.has_strokes = true;
        for (fate, there) in fates.0.iter().filter_map(|fate| Some((fate, fate.there.as_ref()?))) {
            let id = strokes.id[fate.pixel];
            if !fate.is_line() || id == 0 || there.line.is_none() {
                continue;
            }
            // Lines are close to each other: look for the stroke itself, not for the nearest one.
            let around = follower.to.within(there.place, REACH_PX).map(|(at, _)| at);
            let mut same = around.filter(|at| strokes_there.id[*at] == id && ink_there[*at] > 0.0).peekable();
            self.other_identity += Share { part: f64::from(u8::from(same.peek().is_none())), whole: 1.0 };
            let own_px = strokes.half_width_px[fate.pixel];
            let differs = |at: usize| (strokes_there.half_width_px[at] - own_px).abs() > SAME_WIDTH * own_px;
            if same.peek().is_some() {
                self.other_width += Share { part: f64::from(u8::from(same.all(differs))), whole: 1.0 };
            }
        }
    }

    /// Returns the numbers for a report; `None` before the first pair. Values that could not be measured are null:
    ///
    /// | name | |
    /// | --- | --- |
    /// | `pairs` | number of pairs of pictures |
    /// | `orphans_left`, `orphans_right`, `orphans` | ink of lines that the other eye should have and lacks, of all ink that both could have; and the mean |
    /// | `line_coverage` | line pixels, of all pixels |
    /// | `line_masked` | line pixels that the other eye does not see, of all line pixels: they count for nothing else |
    /// | `line_correlation`, `mark_correlation` | correlation of the ink of both eyes |
    /// | `picture_correlation` | correlation of the luma of both eyes, where both see a surface |
    /// | `other_identity`, `other_width` | line pixels of strokes that are other strokes in the other eye; and those of the same stroke with another width |
    pub fn metrics(&self) -> Option<Metrics> {
        let [left, right] = self.orphans.map(Share::value);
        let metrics = [
            ("pairs", Some(self.pairs as f64)),
            ("orphans_left", left),
            ("orphans_right", right),
            ("orphans", left.zip(right).map(|(left, right)| 0.5 * (left + right))),
            ("line_coverage", self.coverage.value().filter(|_| self.has_lines)),
            ("line_masked", self.masked.value()),
            ("line_correlation", self.lines.value()),
            ("mark_correlation", self.marks.value()),
            ("picture_correlation", self.luma.value()),
            ("other_identity", self.other_identity.value().filter(|_| self.has_strokes)),
            ("other_width", self.other_width.value().filter(|_| self.has_strokes)),
        ];
        (self.pairs > 0).then(|| metrics.into_iter().map(|(name, value)| (name.to_owned(), value)).collect())
    }
}

/// Returns the ink of lines that an eye has and the other one lacks, pixel by pixel; `None` if either has no lines.
#[cfg(test)]
pub(crate) fn orphans(own: &DrawnFrame, other: &DrawnFrame) -> Option<Vec<f32>> {
    let (ink, ink_there) = own.ink.as_ref().zip(other.ink.as_ref())?;
    let seen = [SurfaceOfFrame::new(own), SurfaceOfFrame::new(other)];
    let fates = Fates::of(&Follower { from: &seen[0], to: &seen[1] }, ink, ink_there, REACH_PX, own.strokes.as_ref());
    let mut lacking = vec![0.0; ink.len()];
    for (fate, there) in fates.0.iter().filter_map(|fate| Some((fate, fate.there.as_ref()?))) {
        lacking[fate.pixel] = (fate.ink - there.ink).max(0.0);
    }
    Some(lacking)
}

/// Adds both eyes' values on surfaces that both see.
fn correlate(sums: &mut Correlation, follower: &Follower<'_>, own: &[f32], other: &[f32]) {
    let (soft, soft_there) = (spread(own, follower.from.width()), spread(other, follower.to.width()));
    for (pixel, value) in soft.iter().enumerate().filter(|(pixel, _)| follower.from.is_surface(*pixel)) {
        if let Some(place) = follower.place(pixel, Whose::Surface) {
            sums.add((*value).into(), follower.to.bilinear(&soft_there, place));
        }
    }
}

/// Spreads each pixel over 3 × 3 by 1 2 1 in each direction; beyond the border the outermost pixels continue.
fn spread(picture: &[f32], width: usize) -> Vec<f32> {
    let height = picture.len() / width;
    let rows: Vec<f32> = (0..picture.len())
        .map(|pixel| {
            let (row, x) = (pixel - pixel % width, pixel % width);
            let (before, after) = (picture[row + x.saturating_sub(1)], picture[row + (x + 1).min(width - 1)]);
            0.25 * (before + 2.0 * picture[pixel] + after)
        })
        .collect();
    (0..picture.len())
        .map(|pixel| {
            let (y, x) = (pixel / width, pixel % width);
            let (before, after) = (rows[y.saturating_sub(1) * width + x], rows[(y + 1).min(height - 1) * width + x]);
            0.25 * (before + 2.0 * rows[pixel] + after)
        })
        .collect()
}
