//! Removes short fragments: no piece of ink along a line, and no gap in it, is shorter than a pen would make it.
//!
//! Lines are also seen at grazing angles, where several texels along them are one pixel: faster changes would look
//! dotted there. So thresholds are smoothed along the rows first, and lines end long and thin.
//!
//! Where a line is about to appear its thresholds are nearly level, so the least unevenness lets a few texels appear
//! before the others. An opening of the ink by a segment along the line, and one of the paper (Serra 1982; on grey
//! values, so at all tones at once), removes them. Both are increasing operations, so tones stay nested.

use std::cmp::Ordering;

/// Shorter pieces and gaps are removed, in texels.
const SHORTEST_PX: usize = 7;
/// Half the width of each box by which thresholds are smoothed along a line.
const SMOOTH_PX: usize = 4;

/// Returns thresholds whose rows have no short pieces; rows are periodic.
pub(super) fn without_fragments(mut thresholds: Vec<f32>, side_px: usize) -> Vec<f32> {
    for row in thresholds.chunks_exact_mut(side_px) {
        // Ink is where a threshold is below the darkness, so its opening is the least, over all segments that contain
        // the texel, of the greatest.
        let reached = over_segments(row, Ordering::Greater, 0);
        let opened = over_segments(&reached, Ordering::Less, SHORTEST_PX - 1);
        let reached = over_segments(&opened, Ordering::Less, 0);
        row.copy_from_slice(&over_segments(&reached, Ordering::Greater, SHORTEST_PX - 1));
    }
    thresholds
}

/// Returns thresholds whose rows are smoothed by three boxes.
pub(super) fn smooth(mut thresholds: Vec<f32>, side_px: usize) -> Vec<f32> {
    const WIDTH: usize = 2 * SMOOTH_PX + 1;
    for row in thresholds.chunks_exact_mut(side_px) {
        for _ in 0..3 {
            let sum = |place: usize| (0..WIDTH).map(|i| row[(place + side_px + i - SMOOTH_PX) % side_px]).sum::<f32>();
            let means: Vec<f32> = (0..side_px).map(|place| sum(place) / WIDTH as f32).collect();
            row.copy_from_slice(&means);
        }
    }
    thresholds
}

/// Returns the greatest, or least, value of each segment that begins `before` texels before a place.
fn over_segments(row: &[f32], wanted: Ordering, before: usize) -> Vec<f32> {
    let count = row.len();
    let best = |place: usize| {
        let segment = (0..SHORTEST_PX).map(|i| row[(place + count - before + i) % count]);
        segment.fold(row[place], |best, value| if value.total_cmp(&best) == wanted { value } else { best })
    };
    (0..count).map(best).collect()
}
