//! Slip: how far the parameter along strokes moves at a fixed point of the world, and where strokes change identity.
//!
//! The parameter is known at pixel centres, and a pixel's place in the other frame is between them. So the nearest line
//! pixel's parameter is extrapolated to that place with its gradient: a least-squares plane through the pixels of the
//! same stroke around it. A line is thin and often straight, so its pixels do not determine the gradient across the
//! line; a small weight on the gradient's length makes it 0 there.
//!
//! Where strokes are close together, the nearest line pixel may belong to another one. So a stroke is searched for by
//! its identity, within reach of the place. If it is not found, the pixel has no slip and counts as a change of
//! identity. A stroke may also pass a place more than once (a fold, or one stroke that became two parallel ones): of
//! its passes within reach, the one with the closest parameter counts.

use glam::{DMat2, DVec2};

use super::follow::SurfaceOfFrame;
use super::lines::Fates;
use super::{LINE_INK, REACH_PX, Share, StrokePictures};

/// Pixels within this distance determine the gradient.
const AROUND_PX: f64 = 2.5;
/// Pixels of one pass differ in their parameter by at most this many times their distance.
const STEEPEST: f64 = 2.0;
/// Weight of the gradient's length, in square pixels: far below the weights of a few neighbours.
const TOWARD_ZERO: f64 = 0.01;

/// The changes of the line pixels of strokes from one frame to another.
#[derive(Debug, Default)]
pub(super) struct Followed {
    /// For each pixel that continues as the same stroke, the absolute change of its parameter in pixels.
    pub slips_px: Vec<f32>,
    /// Pixels that continue only as other strokes, of all that continue.
    pub changed: Share,
}

/// Follows the line pixels of strokes to the previous frame.
pub(super) fn follow(
    fates: &Fates,
    own: &StrokePictures,
    before: &StrokePictures,
    ink_before: &[f32],
    seen_before: &SurfaceOfFrame<'_>,
) -> Followed {
    let is_stroke = |at: usize| ink_before[at] >= LINE_INK && before.id[at] != 0 && before.along_px[at].is_finite();
    let identities_last = own.identities_last && before.identities_last;
    let mut followed = Followed::default();
    for fate in fates.0.iter().filter(|fate| fate.is_line()) {
        let (id, along_px) = (own.id[fate.pixel], f64::from(own.along_px[fate.pixel]));
        let Some(there) = fate.there.as_ref().filter(|_| id != 0 && along_px.is_finite()) else { continue };
        let mut near: Vec<_> = seen_before.within(there.place, REACH_PX).filter(|(at, _)| is_stroke(*at)).collect();
        near.sort_by(|a, b| a.1.total_cmp(&b.1));
        let Some((nearest, _)) = near.first() else { continue };
        // If identities do not persist, the nearest stroke is taken to be the same one.
        let same = if identities_last { id } else { before.id[*nearest] };
        let near = near.into_iter().map(|(at, _)| at).filter(|at| before.id[*at] == same);
        let slip_px = turns(before, near, seen_before)
            .into_iter()
            .map(|at| {
                let offset = there.place - seen_before.centre(at);
                let there_px = f64::from(before.along_px[at]) + gradient(before, at, seen_before).dot(offset);
                (along_px - there_px).abs()
            })
            .min_by(f64::total_cmp);
        followed.changed += Share { part: f64::from(u8::from(slip_px.is_none())), whole: 1.0 };
        followed.slips_px.extend(slip_px.map(|slip_px| slip_px as f32));
    }
    followed
}

/// Returns the nearest pixel of each pass, of pixels of one stroke sorted from near to far.
fn turns(strokes: &StrokePictures, pixels: impl Iterator<Item = usize>, seen: &SurfaceOfFrame<'_>) -> Vec<usize> {
    let mut turns: Vec<usize> = Vec::new();
    for pixel in pixels {
        if !turns.iter().any(|turn| is_one_turn(strokes, [*turn, pixel], seen)) {
            turns.push(pixel);
        }
    }
    turns
}

/// Whether two pixels of a stroke belong to one pass: their parameters differ by little more than their distance.
fn is_one_turn(strokes: &StrokePictures, [a, b]: [usize; 2], seen: &SurfaceOfFrame<'_>) -> bool {
    let difference_px = f64::from(strokes.along_px[a]) - f64::from(strokes.along_px[b]);
    // Comparisons with NaN fail, so a pixel without a parameter is left out.
    difference_px.abs() <= STEEPEST * (seen.centre(a) - seen.centre(b)).length()
}

/// Returns the gradient of the parameter at a pixel of a stroke, per pixel.
fn gradient(strokes: &StrokePictures, pixel: usize, seen: &SurfaceOfFrame<'_>) -> DVec2 {
    let (centre, own_px) = (seen.centre(pixel), f64::from(strokes.along_px[pixel]));
    let (mut squares, mut products) = (DMat2::from_diagonal(DVec2::splat(TOWARD_ZERO)), DVec2::ZERO);
    for (at, _) in seen.within(centre, AROUND_PX).filter(|(at, _)| strokes.id[*at] == strokes.id[pixel]) {
        if is_one_turn(strokes, [pixel, at], seen) {
            let (way, difference_px) = (seen.centre(at) - centre, f64::from(strokes.along_px[at]) - own_px);
            squares += DMat2::from_cols(way * way.x, way * way.y);
            products += way * difference_px;
        }
    }
    squares.inverse() * products
}
