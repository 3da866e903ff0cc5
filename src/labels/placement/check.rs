//! Checks of layouts that share no code with them.

use super::panorama::{Label, Place, Rows};

/// Tolerance in pixels.
const TOLERANCE_PX: f64 = 1e-6;

/// What is wrong with a layout. Numbers are indices of labels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Violation {
    /// Two labels of a row are closer than the gap.
    Overlap(usize, usize),
    /// The leader of the first label is closer than the gap to the box of the second one.
    Crossing(usize, usize),
    /// A label is not inside of the picture.
    Outside(usize),
    /// A label does not touch its leader.
    Detached(usize),
    /// A label is not above its summit, or reaches the next row.
    TooLow(usize),
    /// There is no such row.
    NoRow(usize),
}

/// Returns the violations in a layout, in both pictures of a pair.
pub(crate) fn check(labels: &[Label], rows: &Rows, places: &[Option<Place>]) -> Vec<Violation> {
    let mut found = Vec::new();
    let placed: Vec<(usize, Label, Place)> =
        (0..labels.len()).filter_map(|i| Some((i, labels[i], places.get(i).copied().flatten()?))).collect();
    for (i, label, place) in &placed {
        let Some(top_px) = rows.tops_px.get(place.row) else {
            found.push(Violation::NoRow(*i));
            continue;
        };
        let bottom_px = top_px + label.height_px;
        let next_px = rows.tops_px.get(place.row + 1).copied().unwrap_or(f64::INFINITY);
        if !(bottom_px <= label.y_px + TOLERANCE_PX && bottom_px <= next_px + TOLERANCE_PX) {
            found.push(Violation::TooLow(*i));
        }
        for x_px in label.x_px {
            let [left, right] = [x_px + place.offset_px, x_px + place.offset_px + label.width_px];
            let [first, last] = [rows.margin_px - TOLERANCE_PX, rows.width_px - rows.margin_px + TOLERANCE_PX];
            if !(left >= first && right <= last) {
                found.push(Violation::Outside(*i));
            }
            if !(left <= x_px + TOLERANCE_PX && right >= x_px - TOLERANCE_PX) {
                found.push(Violation::Detached(*i));
            }
        }
        for (j, other, beside) in &placed {
            for eye in 0..2 {
                let left = label.x_px[eye] + place.offset_px;
                let right = left + label.width_px;
                let from = other.x_px[eye] + beside.offset_px;
                let to = from + other.width_px;
                let gap_px = rows.gap_px - TOLERANCE_PX;
                if i < j && place.row == beside.row && left < to + gap_px && from < right + gap_px {
                    found.push(Violation::Overlap(*i, *j));
                }
                let reach_px = rows.leader_gap_px - TOLERANCE_PX;
                let x_px = label.x_px[eye];
                if place.row < beside.row && x_px > from - reach_px && x_px < to + reach_px {
                    found.push(Violation::Crossing(*i, *j));
                }
            }
        }
    }
    found.dedup();
    found
}
