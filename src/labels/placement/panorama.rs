//! Names of peaks in rows above the land, with vertical leaders down to the summits.
//!
//! Gemsa, Haunert and Nöllenburg 2011, "Boundary-labeling algorithms for panorama images", and 2015, "Multirow
//! boundary-labeling algorithms for panorama images": labels slide along their row as long as they touch their leader,
//! and no leader crosses a label. The layout has the largest total weight of labels that are drawn.
//!
//! A leader divides all lower rows. So between the leaders of two neighbours in a row, the lower rows are a problem of
//! their own, and a dynamic programme solves it for all pairs of leaders, from the lowest row up ([`super::chain`]).
//! Within a row, a selection that is heavier but reaches further right is neither better nor worse than a lighter one:
//! both are continued. The papers round weights to integers and have one entry for each sum; here, each label has the
//! list of selections that are not dominated.
//!
//! What differs from the papers:
//! - A pair of stereo pictures has one layout. The distance of two leaders is the smaller one of both pictures, and the
//!   same dynamic programme applies, because these distances add up to no more than the distance of the outer leaders.
//! - With many labels and rows, neighbours in a row have at most [`Problem::window`] other summits between them, and
//!   light labels among many heavier ones are not considered at first ([`super::improve`]).
//! - Labels keep a gap from each other and from leaders, have different heights, and are above their summits.

use super::{Hold, improve, settle, usual};

/// The part of its weight that a label loses for each row that its leader is longer, so that of two layouts that show
/// the same labels the one with shorter leaders is chosen.
const LEADER_LOSS: f64 = 1e-4;
/// Tolerance of comparisons, for rounding, in pixels.
pub(super) const TOLERANCE_PX: f64 = 1e-9;

/// A label of a summit. A label whose numbers are not finite is never placed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Label {
    /// Position of the summit from the left in the left and right picture of a stereo pair, in pixels; the same number
    /// twice in a single picture.
    pub x_px: [f64; 2],
    /// Position of the summit from the top, in pixels.
    pub y_px: f64,
    /// Width of the label's box in pixels, more than 0.
    pub width_px: f64,
    /// Height of the label's box in pixels.
    pub height_px: f64,
    /// Importance, more than 0, such as the summit's prominence.
    pub weight: f64,
}

impl Label {
    /// Returns whether the label can be placed at all.
    pub(super) fn is_valid(&self) -> bool {
        let all = [self.x_px[0], self.x_px[1], self.y_px, self.width_px, self.height_px, self.weight];
        // More would lose the precision of positions.
        let is_usual = all.iter().all(|number| number.is_finite() && number.abs() < 1e9);
        is_usual && self.width_px > 0.0 && self.height_px >= 0.0 && self.weight > 0.0
    }
}

/// The rows of a panorama.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rows {
    /// Upper side of the labels of each row in pixels from the top, top row first. A row that is not finite has no
    /// labels, and neither has a row that is too close to the next one for their height.
    pub tops_px: Vec<f64>,
    /// Width of the picture in pixels.
    pub width_px: f64,
    /// Least distance of labels from the left and right side of the picture, in pixels.
    pub margin_px: f64,
    /// Least distance of neighbours in a row, in pixels.
    pub gap_px: f64,
    /// Least distance of a label from the leaders of other labels, in pixels.
    pub leader_gap_px: f64,
    /// The part of a label that is to the left of its leader if nothing is in its way: 0 to 1, 0.5 for centred names.
    pub align: f64,
}

/// Where a label is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// Index of the row, from the top.
    pub row: usize,
    /// Position of the label's left side from its summit in pixels, 0 or less. It is the same in both pictures of a
    /// pair, so that a name appears at the distance of its summit.
    pub offset_px: f64,
}

/// Chooses the labels that are drawn, and places them. `holds` is what the last layout requires of each label; labels
/// for which it has no element are free. Returns a place for each label, or `None` for a label that is left out.
pub(crate) fn panorama(labels: &[Label], rows: &Rows, holds: &[Hold]) -> Vec<Option<Place>> {
    let problem = Problem::new(labels, rows, holds);
    let rows_of = problem.solved();
    problem.places(labels.len(), &rows_of, &problem.homes(rows.align))
}

/// A label as the layout sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Site {
    /// Index of the label in the caller's list.
    pub index: usize,
    /// Position of the leader in both pictures.
    pub x_px: [f64; 2],
    /// Width of the label.
    pub width_px: f64,
    /// Lowest and highest offset with which the label touches its leader and is inside of the picture.
    pub range_px: [f64; 2],
}

/// Labels in the order of their leaders, from left to right.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Problem {
    /// The labels that have a place in some row.
    pub sites: Vec<Site>,
    /// For each row, top row first, what each site is worth there; negative infinity where it may not be.
    pub gains: Vec<Vec<f64>>,
    /// Least distance of neighbours in a row.
    pub gap_px: f64,
    /// Least distance of a label from the leaders of others.
    pub leader_gap_px: f64,
}

impl Problem {
    /// Creates the problem of placing labels in rows.
    pub(super) fn new(labels: &[Label], rows: &Rows, holds: &[Hold]) -> Self {
        let bond = 4.0 * labels.iter().filter(|label| label.is_valid()).map(|label| label.weight).sum::<f64>();
        let count = rows.tops_px.len();
        let gain = |site: &Site, row: usize| {
            let label = &labels[site.index];
            let top_px = rows.tops_px[row];
            let floor_px = rows.tops_px.get(row + 1).map_or(label.y_px, |next| next.min(label.y_px));
            // A row that is NaN is not above anything.
            let is_above = top_px.is_finite() && top_px + label.height_px <= floor_px + TOLERANCE_PX;
            let hold = holds.get(site.index).copied().unwrap_or_default();
            let gain = hold.gain(row, label.weight, bond);
            let loss = LEADER_LOSS * label.weight * (count - 1 - row) as f64 / count as f64;
            if is_above { gain - loss } else { f64::NEG_INFINITY }
        };
        let mut sites: Vec<Site> =
            (0..labels.len()).filter_map(|index| Site::new(index, &labels[index], rows)).collect();
        sites.retain(|site| (0..count).any(|row| gain(site, row) > 0.0));
        sites.sort_by(|a, b| (a.x_px[0] + a.x_px[1]).total_cmp(&(b.x_px[0] + b.x_px[1])));
        let gains = (0..count).map(|row| sites.iter().map(|site| gain(site, row)).collect()).collect();
        Self { sites, gains, gap_px: usual(rows.gap_px), leader_gap_px: usual(rows.leader_gap_px) }
    }

    /// Returns the row of each site. Rows in which no label may be cost no time.
    fn solved(&self) -> Vec<Option<usize>> {
        let is_used = |row: &usize| self.gains[*row].iter().any(|gain| *gain > f64::NEG_INFINITY);
        let used: Vec<usize> = (0..self.gains.len()).filter(is_used).collect();
        let gains = used.iter().map(|row| self.gains[*row].clone()).collect();
        let rows_of = improve::solve(&Self { sites: self.sites.clone(), gains, ..*self });
        rows_of.into_iter().map(|row| row.map(|row| used[row])).collect()
    }

    /// Returns the distance from a leader to another one to its right; the smaller one of both pictures.
    pub(super) fn distance_px(&self, from: usize, to: usize) -> f64 {
        let [from, to] = [self.sites[from].x_px, self.sites[to].x_px];
        (to[0] - from[0]).min(to[1] - from[1])
    }

    /// Returns the offset of each site if nothing is in its way.
    pub(super) fn homes(&self, align: f64) -> Vec<f64> {
        let align = if align.is_finite() { align.clamp(0.0, 1.0) } else { 0.5 };
        self.sites.iter().map(|site| -align * site.width_px).collect()
    }

    /// Returns the places of all labels of the caller's list, of which there are `count`: as close to the preferred
    /// offsets as the other labels allow.
    pub(super) fn places(&self, count: usize, rows_of: &[Option<usize>], preferred_px: &[f64]) -> Vec<Option<Place>> {
        let mut places = vec![None; count];
        let offsets = settle::offsets(self, rows_of, preferred_px);
        for ((site, row), offset_px) in self.sites.iter().zip(rows_of).zip(offsets) {
            places[site.index] = row.zip(offset_px).map(|(row, offset_px)| Place { row, offset_px });
        }
        places
    }
}

impl Site {
    fn new(index: usize, label: &Label, rows: &Rows) -> Option<Self> {
        let width_px = label.width_px;
        let [first, last] = [label.x_px[0].min(label.x_px[1]), label.x_px[0].max(label.x_px[1])];
        let low_px = (rows.margin_px - first).max(-width_px);
        let high_px = (rows.width_px - rows.margin_px - last - width_px).min(0.0);
        let is_inside = label.is_valid() && first >= 0.0 && last <= rows.width_px && low_px <= high_px;
        let is_usual = low_px.is_finite() && high_px.is_finite();
        // `max` and `min` ignore NaN.
        let has_bounds = rows.margin_px.is_finite() && rows.width_px.is_finite();
        let site = Self { index, x_px: label.x_px, width_px, range_px: [low_px, high_px] };
        (is_inside && is_usual && has_bounds).then_some(site)
    }
}
