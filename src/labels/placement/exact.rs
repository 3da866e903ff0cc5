//! The heaviest layout of a panorama by branch and bound, for the few labels for which that is possible.

use super::panorama::{Label, Rows};

/// Returns the largest total weight of labels that can be placed.
pub(super) fn largest_weight(labels: &[Label], rows: &Rows) -> f64 {
    let mut order: Vec<usize> = (0..labels.len()).collect();
    order.sort_by(|a, b| labels[*b].weight.total_cmp(&labels[*a].weight));
    let mut search = Search { labels, rows, order, placed: Vec::new(), best: 0.0 };
    search.branch(0, 0.0);
    search.best
}

/// Returns the largest total weight of labels in one row of one picture, whose weights are integers: the
/// pseudo-polynomial programme of Gemsa, Haunert and Nöllenburg.
pub(super) fn largest_in_one_row(labels: &[Label], rows: &Rows) -> f64 {
    let mut order: Vec<&Label> = labels.iter().collect();
    order.sort_by(|a, b| a.x_px[0].total_cmp(&b.x_px[0]));
    let all: usize = labels.iter().map(|label| label.weight as usize).sum();
    // Where the row ends, including a gap, if labels of a total weight are as far left as possible.
    let mut ends_px = vec![f64::INFINITY; all + 1];
    ends_px[0] = rows.margin_px;
    for label in order {
        let weight = label.weight as usize;
        for total in (weight..=all).rev() {
            let left_px = ends_px[total - weight].max(label.x_px[0] - label.width_px);
            let is_inside = left_px + label.width_px <= rows.width_px - rows.margin_px + 1e-9;
            if is_inside && left_px <= label.x_px[0] + 1e-9 {
                ends_px[total] = ends_px[total].min(left_px + label.width_px + rows.gap_px);
            }
        }
    }
    (0..=all).rev().find(|total| ends_px[*total].is_finite()).unwrap_or(0) as f64
}

struct Search<'a> {
    labels: &'a [Label],
    rows: &'a Rows,
    order: Vec<usize>,
    /// Labels and their rows.
    placed: Vec<(usize, usize)>,
    best: f64,
}

impl Search<'_> {
    /// Tries all rows of the labels from `depth` on.
    fn branch(&mut self, depth: usize, weight: f64) {
        self.best = self.best.max(weight);
        let rest: f64 = self.order[depth..].iter().map(|i| self.labels[*i].weight).sum();
        if depth == self.order.len() || weight + rest <= self.best {
            return;
        }
        let label = self.order[depth];
        for row in 0..self.rows.tops_px.len() {
            self.placed.push((label, row));
            // Fewer labels never need more space, so nothing can follow what is impossible.
            if self.is_possible() {
                self.branch(depth + 1, weight + self.labels[label].weight);
            }
            self.placed.pop();
        }
        self.branch(depth + 1, weight);
    }

    /// Returns whether the labels that are placed have space, row by row from left to right.
    fn is_possible(&self) -> bool {
        (0..self.rows.tops_px.len()).all(|row| {
            let mut of_row: Vec<&Label> =
                self.placed.iter().filter(|(_, other)| *other == row).map(|(i, _)| &self.labels[*i]).collect();
            of_row.sort_by(|a, b| a.x_px[0].total_cmp(&b.x_px[0]));
            let mut end_px = f64::NEG_INFINITY;
            let mut x_of_end = [0.0; 2];
            of_row.iter().all(|label| {
                let apart = self.apart(label.x_px, x_of_end);
                let Some(offset) = self.first_offset(label, row, end_px - apart) else { return false };
                end_px = offset + label.width_px + self.rows.gap_px;
                x_of_end = label.x_px;
                true
            })
        })
    }

    /// Returns the smaller distance of two summits, right one first, in both pictures.
    fn apart(&self, right: [f64; 2], left: [f64; 2]) -> f64 {
        (right[0] - left[0]).min(right[1] - left[1])
    }

    /// Returns the least offset of at least `least_px` with which a label is in the picture and crosses no leader.
    fn first_offset(&self, label: &Label, row: usize, least_px: f64) -> Option<f64> {
        let first = label.x_px[0].min(label.x_px[1]);
        let last = label.x_px[0].max(label.x_px[1]);
        let low = least_px.max(-label.width_px).max(self.rows.margin_px - first);
        let high = (self.rows.width_px - self.rows.margin_px - last - label.width_px).min(0.0);
        let higher = self.placed.iter().filter(|(_, other)| *other < row).map(|(i, _)| self.labels[*i].x_px);
        let (mut from, mut to) = (low, high);
        let gap = self.rows.leader_gap_px;
        for leader in higher {
            let right = self.apart(leader, label.x_px);
            let left = self.apart(label.x_px, leader);
            // The label contains its own leader, so the other one is on the same side of the label as of that leader.
            if right >= 0.0 && right >= left {
                to = to.min(right - gap - label.width_px);
            } else if left >= 0.0 {
                from = from.max(gap - left);
            } else {
                return None;
            }
            if right.abs() < gap && left.abs() < gap && gap > 0.0 {
                // Closer than the gap on either side.
                let fits_left = right - gap - label.width_px >= -label.width_px;
                let fits_right = gap - left <= 0.0;
                if !fits_left && !fits_right {
                    return None;
                }
            }
        }
        let is_above = self.rows.tops_px[row] + label.height_px <= label.y_px;
        (from <= to + 1e-9 && is_above).then_some(from)
    }
}
