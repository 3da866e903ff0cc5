//! Steadiness of a drawing from frame to frame, for any kind of lines.
//!
//! Two consecutive frames are compared in both directions. The world does not move, so the place of a pixel of one
//! frame in the other is known exactly (`follow`); pixels that are not visible in both are masked. A **line pixel** has
//! ink of at least [`LINE_INK`]; the line continues where the other frame has a line pixel within [`REACH_PX`] of its
//! place. The measures are
//!
//! - *flicker*: the share of line pixels that do not continue, of those that are not masked; births are measured from
//!   the later frame, deaths from the earlier one. In the ink-weighted form a pixel counts with the ink that the other
//!   frame lacks within the same reach, and no threshold is needed;
//! - *births and deaths of strokes*: strokes of which less than half continues;
//! - *change of identity*: line pixels that continue as strokes of other identities, and not as their own;
//! - *slip*: how far the parameter along a stroke (by which a texture is mapped) moved at a fixed point (`parameter`);
//! - *E_warp*: the mean squared difference between the later picture and the earlier one, read bilinearly from where
//!   each pixel was.
//!
//! An empty page scores well in all of them, so line coverage is reported with them ([`TemporalTotals::metrics`]).
//!
//! E_warp is the warping error of Lai et al. 2018 (Learning Blind Video Temporal Consistency, section 4) with exact
//! motion instead of an estimate. Paper grain is fixed to the page and not to the world: E_warp counts it as a change,
//! as a viewer sees it.
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
pub(crate) use self::read_strokes::{count_strokes, read_stroke_pictures, strokes_left_out};
pub use self::totals::TemporalTotals;
use crate::scene::view::View;

/// Least ink of a line pixel: faint strokes in the far distance have 0.15.
pub(crate) const LINE_INK: f32 = 0.1;
/// A line continues if the other frame has one within this distance.
pub(crate) const REACH_PX: f64 = 1.5;
/// Least share of a stroke's line pixels that continue if the stroke continues.
pub(crate) const HELD_SHARE: f64 = 0.5;

/// The pictures and strokes of a frame, read back. All pictures are stored row by row, with `view.part.size_px` pixels.
#[derive(Clone, Debug)]
pub struct DrawnFrame {
    /// View of the eye.
    pub view: View,
    /// Origin of positions in the world: that of the rig.
    pub origin_m: DVec3,
    /// Metres from the origin (east, north, up), and the distance along the view axis, which is 0 for the sky.
    pub position: Vec<[f32; 4]>,
    /// Ink of lines and strokes, 0 to 1; `None` if the style draws no lines.
    pub ink: Option<Vec<f32>>,
    /// Strokes at each pixel, in styles with strokes.
    pub strokes: Option<StrokePictures>,
    /// Centre lines of strokes, for an eye of a stereo pair.
    pub centres: Option<StrokePictures>,
    /// Ink of marks of hatching and of rows, 0 to 1; `None` if the style has neither.
    pub marks: Option<Vec<f32>>,
    /// sRGB-encoded luminance of the final picture, 0 black to 1 white.
    pub luma: Vec<f32>,
    /// Colours of the final picture: red, green and blue, sRGB-encoded, 0 to 255.
    pub colors: Vec<[u8; 3]>,
}

/// The stroke at each pixel, row by row like the frame's other pictures.
#[derive(Clone, Debug)]
pub struct StrokePictures {
    /// Identity of the stroke; 0 is none.
    pub id: Vec<u32>,
    /// Parameter along the stroke at the pixel's centre, in pixels; NaN if there is none.
    pub along_px: Vec<f32>,
    /// Half width of the stroke at full pressure; NaN if there is none.
    pub half_width_px: Vec<f32>,
    /// Distance along the view axis; NaN if there is none.
    pub depth_m: Vec<f32>,
    /// Whether an identity means the same stroke in the next frame. If not, changes of identity are not measured.
    pub identities_last: bool,
    /// Whether the frame rebuilt its strokes (an update); otherwise it moved those of the previous frame.
    pub rebuilt: bool,
}

/// Part and whole of a share, kept apart so that shares can be summed over frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Share {
    pub part: f64,
    pub whole: f64,
}

impl Share {
    /// Returns part / whole; `None` if the whole is 0.
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

/// The changes of line pixels from one frame to another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LineChange {
    /// Line pixels that cannot be followed, of all line pixels.
    pub masked: Share,
    /// Line pixels that do not continue, of those that can be followed.
    pub lone: Share,
    /// Ink that the other frame lacks, of all ink that can be followed.
    pub lone_ink: Share,
}

/// Measurements of the lines of two frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LineMeasures {
    /// Line pixels, of all pixels of the later frame.
    pub coverage: Share,
    /// Changes from the later frame to the earlier one.
    pub births: LineChange,
    /// Changes from the earlier frame to the later one.
    pub deaths: LineChange,
}

/// Measurements of the strokes of two frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StrokeMeasures {
    /// Strokes that did not exist before, of the later frame's strokes that can be followed.
    pub born: Share,
    /// Strokes that no longer exist, of the earlier frame's strokes that can be followed.
    pub died: Share,
    /// Line pixels that belonged only to other strokes, of those that continue; `None` if identities do not persist.
    pub identity_change: Option<Share>,
    /// For each line pixel that belonged to the same stroke before, how far the parameter moved, in pixels.
    pub slips_px: Vec<f32>,
    /// Whether the later frame rebuilt its strokes.
    pub rebuilt: bool,
}

/// Measurements of two consecutive frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PairMeasures {
    /// Lines; `None` if one of the frames has none.
    pub lines: Option<LineMeasures>,
    /// Strokes; `None` if one of the frames has none.
    pub strokes: Option<StrokeMeasures>,
    /// Sum of squared differences of luma, and number of pixels of the later frame that can be followed.
    pub e_warp: Share,
}

/// Why two frames cannot be compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TemporalError {
    /// The pictures have different sizes, or pixels that do not fill them.
    #[error("the pictures of two frames have different sizes")]
    Size,
}

/// Compares two consecutive frames.
///
/// # Errors
/// [`TemporalError::Size`] if the pictures have different sizes, or pixels that do not fill them.
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
            rebuilt: strokes_now.rebuilt,
        });
    }
    Ok(measures)
}

impl DrawnFrame {
    /// Whether all pictures have the same number of pixels, that of the view.
    pub(super) fn is_whole(&self) -> bool {
        let [width, height] = self.view.part.size_px.map(|side| side as usize);
        let pixels = width * height;
        let of_strokes = self.strokes.iter().chain(&self.centres);
        let of_strokes =
            of_strokes.flat_map(|of| [of.id.len(), of.along_px.len(), of.half_width_px.len(), of.depth_m.len()]);
        let lengths = [self.position.len(), self.luma.len(), self.colors.len()];
        let mut lengths = lengths.into_iter().chain(self.ink.iter().chain(&self.marks).map(Vec::len)).chain(of_strokes);
        pixels > 0 && lengths.all(|length| length == pixels)
    }
}

/// Returns the sum of squared differences of luma along the motion, over the number of pixels
/// ([`PairMeasures::e_warp`]).
fn e_warp(back: &Follower<'_>, before: &DrawnFrame, now: &DrawnFrame) -> Share {
    let squared = |pixel: usize| {
        // Ink next to an edge moves with what it outlines.
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
