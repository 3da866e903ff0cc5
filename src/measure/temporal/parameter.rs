//! How far the parameter along strokes moves under a place of the world.
//!
//! The parameter is known at the centres of pixels, and a pixel's place in the other frame lies between them. So the
//! nearest line pixel's parameter is carried to that place by its gradient: a plane laid through the same stroke's
//! pixels around, by least squares. A line is thin and often straight, and says nothing of its parameter across itself;
//! a small weight on the gradient's length makes it 0 there.

use glam::{DMat2, DVec2};

use super::follow::SurfaceOfFrame;
use super::lines::Fates;
use super::{LINE_INK, REACH_PX, StrokePictures};

/// Pixels within this tell the gradient.
const AROUND_PX: f64 = 2.5;
/// Neighbours on a stroke differ by their distance; those that differ by so much more are of another turn of it.
const STEEPEST: f64 = 2.0;
/// Weight of the gradient's length, in squares of pixels: far below those of a few neighbours.
const TOWARD_ZERO: f64 = 0.01;

/// Of each line pixel of a stroke that was near a line pixel of a stroke before: |its parameter − that at its place|,
/// in pixels.
pub(super) fn slips_px(
    fates: &Fates,
    own: &StrokePictures,
    before: &StrokePictures,
    ink_before: &[f32],
    seen_before: &SurfaceOfFrame<'_>,
) -> Vec<f32> {
    let is_stroke = |at: usize| ink_before[at] >= LINE_INK && before.id[at] != 0 && before.along_px[at].is_finite();
    let slip = |pixel: usize, place: DVec2| {
        let along_px = f64::from(own.along_px[pixel]);
        if own.id[pixel] == 0 || !along_px.is_finite() {
            return None;
        }
        let near = seen_before.within(place, REACH_PX).filter(|(at, _)| is_stroke(*at));
        let nearest = near.min_by(|a, b| a.1.total_cmp(&b.1))?.0;
        let offset = place - seen_before.centre(nearest);
        let there_px = f64::from(before.along_px[nearest]) + gradient(before, nearest, seen_before).dot(offset);
        Some((along_px - there_px).abs() as f32)
    };
    let lines = fates.0.iter().filter(|fate| fate.is_line());
    lines.filter_map(|fate| slip(fate.pixel, fate.there.as_ref()?.place)).collect()
}

/// Of the parameter at a pixel of a stroke, per pixel.
fn gradient(strokes: &StrokePictures, pixel: usize, seen: &SurfaceOfFrame<'_>) -> DVec2 {
    let (centre, own_px) = (seen.centre(pixel), f64::from(strokes.along_px[pixel]));
    let (mut squares, mut products) = (DMat2::from_diagonal(DVec2::splat(TOWARD_ZERO)), DVec2::ZERO);
    for (at, squared) in seen.within(centre, AROUND_PX).filter(|(at, _)| strokes.id[*at] == strokes.id[pixel]) {
        let difference_px = f64::from(strokes.along_px[at]) - own_px;
        // Comparisons with NaN fail: a pixel without a parameter is left out.
        if difference_px.abs() <= STEEPEST * squared.sqrt() {
            let way = seen.centre(at) - centre;
            squares += DMat2::from_cols(way * way.x, way * way.y);
            products += way * difference_px;
        }
    }
    squares.inverse() * products
}
