//! How steady a drawing is from frame to frame, whatever its lines are made of.
//!
//! Two frames that follow each other are held against each other in both directions. The world stands still, so where
//! a pixel of one frame lies in the other is known exactly (`follow`); what is not seen in both is masked. A **line
//! pixel** has ink of at least [`LINE_INK`]; the line goes on where the other frame has a line pixel within
//! [`REACH_PX`] of its place. From this come
//!
//! - *flicker*: the share of line pixels that do not go on, of those that are not masked; births are seen from the
//!   later frame, deaths from the earlier one. In the ink-weighted form a pixel counts with the ink that the other
//!   frame lacks within the same reach, and needs no threshold;
//! - *births and deaths of strokes*: strokes of which less than half goes on;
//! - *change of identity*: line pixels that go on as strokes of other identities, and not as their own;
//! - *slip*: how far the parameter along a stroke (what a texture is laid by) moved under a place (`parameter`);
//! - *E_warp*: the mean squared difference between the later picture and the earlier one, bilinearly fetched from where
//!   each pixel was.
//!
//! All of them are cheap for an empty page: line coverage stands beside them ([`TemporalTotals::metrics`]).
//!
//! E_warp is the warping error of Lai et al. 2018 (Learning Blind Video Temporal Consistency, section 4) with exact
//! motion in the place of an estimate. Paper grain is fixed to the sheet and not to the world: E_warp counts it as a
//! change, since eyes do.
//!
//! Why: `docs/decisions/temporal-steadiness.md`.

pub(super) mod follow;
pub(super) mod lines;
mod parameter;
mod read;
mod read_strokes;
mod totals;

use glam::DVec3;
use rayon::prelude::*;

use self::follow::{Follower, SurfaceOfFrame, Whose};
use self::lines::Fates;
pub use self::read::read_drawn;
pub use self::read_strokes::{count_strokes, read_stroke_pictures, strokes_left_out};
pub use self::totals::TemporalTotals;
use crate::scene::view::View;

/// A pixel with at least this much ink is a line pixel: faint strokes of the far distance have 0.15.
pub const LINE_INK: f32 = 0.1;
/// A line goes on if the other frame has one within this distance.
pub const REACH_PX: f64 = 1.5;
/// Of a stroke that goes on, at least this share of its line pixels does.
pub const HELD_SHARE: f64 = 0.5;

/// What a frame drew, read back. All pictures are row by row, of `view.part.size_px`.
#[derive(Clone, Debug)]
pub struct DrawnFrame {
    /// The eye.
    pub view: View,
    /// What positions count from in the world: the origin of the rig that the eye belongs to.
    pub origin_m: DVec3,
    /// Metres from the origin (east, north, up); the fourth is the distance along the view axis, and 0 is the sky.
    pub position: Vec<[f32; 4]>,
    /// Ink of lines and strokes, 0 to 1; none where a style draws no lines.
    pub ink: Option<Vec<f32>>,
    /// Of a style with strokes.
    pub strokes: Option<StrokePictures>,
    /// The middles of strokes, of an eye of a pair.
    pub centres: Option<StrokePictures>,
    /// Ink of marks, of hatching and of rows, 0 to 1; none where a style has neither.
    pub marks: Option<Vec<f32>>,
    /// sRGB-encoded luminance of the final picture: 0 black to 1 white.
    pub luma: Vec<f32>,
}

/// Which strokes lie where. Row by row, as the frame's other pictures.
#[derive(Clone, Debug)]
pub struct StrokePictures {
    /// A stroke's identity; 0 is none.
    pub id: Vec<u32>,
    /// Its parameter in pixels at the pixel's centre; NaN where there is none.
    pub along_px: Vec<f32>,
    /// Its half width at full pressure; NaN where there is none.
    pub half_width_px: Vec<f32>,
    /// Its distance along the view axis; NaN where there is none.
    pub depth_m: Vec<f32>,
    /// Whether an identity means the same stroke in the next frame. If not, changes of identity are not measured.
    pub identities_last: bool,
    /// The frame made its strokes anew (an update); else it moved those of the frame before.
    pub made_anew: bool,
}

/// A part of a whole: a number that can be summed over frames before it becomes a share.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Share {
    /// How much of it.
    pub part: f64,
    /// All of it.
    pub whole: f64,
}

impl Share {
    /// The quotient; none of nothing.
    pub fn value(self) -> Option<f64> {
        (self.whole > 0.0).then(|| self.part / self.whole)
    }
}

impl std::ops::AddAssign for Share {
    fn add_assign(&mut self, other: Self) {
        self.part += other.part;
        self.whole += other.whole;
    }
}

/// What became of line pixels in the other frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LineChange {
    /// Line pixels that cannot be followed, of all line pixels.
    pub masked: Share,
    /// Line pixels that do not go on, of those that can be followed.
    pub lone: Share,
    /// Ink that the other frame lacks, of all ink that can be followed.
    pub lone_ink: Share,
}

/// Lines of two frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LineMeasures {
    /// Line pixels, of all pixels of the later frame.
    pub coverage: Share,
    /// From the later frame to the earlier one.
    pub births: LineChange,
    /// From the earlier frame to the later one.
    pub deaths: LineChange,
}

/// Strokes of two frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StrokeMeasures {
    /// Strokes that were not there before, of the later frame's strokes that can be followed.
    pub born: Share,
    /// Strokes that are there no more, of the earlier frame's strokes that can be followed.
    pub died: Share,
    /// Line pixels that were of other strokes only, of those that go on; none where identities do not last.
    pub identity_change: Option<Share>,
    /// Of each line pixel that was of the same stroke before: how far the parameter moved, in pixels.
    pub slips_px: Vec<f32>,
    /// The later frame made its strokes anew.
    pub made_anew: bool,
}

/// What two frames tell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PairMeasures {
    /// None where one of them has no lines.
    pub lines: Option<LineMeasures>,
    /// None where one of them has no strokes.
    pub strokes: Option<StrokeMeasures>,
    /// The sum of squared differences of luma, and the pixels of the later frame that can be followed.
    pub e_warp: Share,
}

/// Why two frames cannot be held against each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TemporalError {
    /// Pictures of different sizes, or pixels that do not fill them.
    #[error("the pictures of two frames have different sizes")]
    Size,
}

/// Holds two frames that follow each other against each other.
///
/// # Errors
/// [`TemporalError::Size`] when the pictures do not have the pixels of one size.
pub fn compare(before: &DrawnFrame, now: &DrawnFrame) -> Result<PairMeasures, TemporalError> {
    if before.view.part.size_px != now.view.part.size_px || !before.is_whole() || !now.is_whole() {
        return Err(TemporalError::Size);
    }
    let (seen_before, seen_now) = (SurfaceOfFrame::new(before), SurfaceOfFrame::new(now));
    let back = Follower { from: &seen_now, to: &seen_before };
    let on = Follower { from: &seen_before, to: &seen_now };
    let mut measures = PairMeasures { e_warp: e_warp(&back, before, now), ..PairMeasures::default() };
    let (Some(ink_before), Some(ink_now)) = (&before.ink, &now.ink) else { return Ok(measures) };
    let born = Fates::of(&back, ink_now, ink_before, REACH_PX, None);
    let died = Fates::of(&on, ink_before, ink_now, REACH_PX, None);
    measures.lines = Some(LineMeasures {
        coverage: Share { part: born.line_pixels() as f64, whole: ink_now.len() as f64 },
        births: born.change(),
        deaths: died.change(),
    });
    if let (Some(strokes_before), Some(strokes_now)) = (&before.strokes, &now.strokes) {
        let identities_last = strokes_before.identities_last && strokes_now.identities_last;
        let followed = parameter::follow(&born, strokes_now, strokes_before, ink_before, &seen_before);
        measures.strokes = Some(StrokeMeasures {
            born: born.lone_strokes(&strokes_now.id),
            died: died.lone_strokes(&strokes_before.id),
            identity_change: identities_last.then_some(followed.changed),
            slips_px: followed.slips_px,
            made_anew: strokes_now.made_anew,
        });
    }
    Ok(measures)
}

impl DrawnFrame {
    /// Whether all pictures have the pixels of one size.
    pub(super) fn is_whole(&self) -> bool {
        let [width, height] = self.view.part.size_px.map(|side| side as usize);
        let pixels = width * height;
        let of_strokes = self.strokes.iter().chain(&self.centres);
        let of_strokes =
            of_strokes.flat_map(|of| [of.id.len(), of.along_px.len(), of.half_width_px.len(), of.depth_m.len()]);
        let lengths = [self.position.len(), self.luma.len()];
        let mut lengths = lengths.into_iter().chain(self.ink.iter().chain(&self.marks).map(Vec::len)).chain(of_strokes);
        pixels > 0 && lengths.all(|length| length == pixels)
    }
}

/// See [`PairMeasures::e_warp`].
fn e_warp(back: &Follower<'_>, before: &DrawnFrame, now: &DrawnFrame) -> Share {
    let squared = |pixel: usize| {
        // The ink beside an edge moves with what it outlines.
        let has_ink = now.ink.as_ref().is_some_and(|ink| ink[pixel] >= LINE_INK);
        let place = back.place(pixel, if has_ink { Whose::Line } else { Whose::Surface })?;
        let difference = f64::from(now.luma[pixel]) - back.to.bilinear(&before.luma, place);
        Some(difference * difference)
    };
    let width = back.from.width();
    let rows = (0..now.luma.len() / width).into_par_iter().map(|row| {
        let mut share = Share::default();
        for squared in (row * width..(row + 1) * width).filter_map(squared) {
            share += Share { part: squared, whole: 1.0 };
        }
        share
    });
    // In order, so that the sum does not depend on the threads.
    let rows: Vec<Share> = rows.collect();
    let mut sum = Share::default();
    rows.into_iter().for_each(|row| sum += row);
    sum
}
