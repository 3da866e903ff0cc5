//! Names of peaks in one row, at 45°: each rises to the right from the upper end of its leader.
//!
//! Names that rise in parallel overlap if their leaders are closer than the height of the right one, seen along the row;
//! their widths do not matter. So the heaviest selection is found exactly, by a dynamic programme over the last label of
//! the selection.

use std::f64::consts::SQRT_2;

use super::panorama::{Label, Rows};
use super::{Hold, usual};

/// Chooses the labels that are drawn at 45°. Their baselines begin at the leaders, `base_px` from the top of the picture.
/// The rows of `rows` are not used, only its margin, width and gaps. Labels that reach beyond the right or upper side
/// of the picture are left out, and so are summits above the baseline.
pub(crate) fn slanted(labels: &[Label], rows: &Rows, base_px: f64, holds: &[Hold]) -> Vec<bool> {
    let bond = 4.0 * labels.iter().filter(|label| label.is_valid()).map(|label| label.weight).sum::<f64>();
    let gain = |index: usize| holds.get(index).copied().unwrap_or_default().gain(0, labels[index].weight, bond);
    let mut sites: Vec<usize> =
        (0..labels.len()).filter(|index| is_inside(&labels[*index], rows, base_px) && gain(*index) > 0.0).collect();
    sites.sort_by(|a, b| {
        (labels[*a].x_px[0] + labels[*a].x_px[1]).total_cmp(&(labels[*b].x_px[0] + labels[*b].x_px[1]))
    });
    // For each site, the gain of the best selection that ends with it, and the site before it.
    let mut best: Vec<(f64, Option<usize>)> = Vec::with_capacity(sites.len());
    for index in &sites {
        let mut most = (0.0, None);
        for (from, (gain, _)) in best.iter().enumerate() {
            if *gain > most.0 && are_apart(&labels[sites[from]], &labels[*index], rows) {
                most = (*gain, Some(from));
            }
        }
        best.push((most.0 + gain(*index), most.1));
    }
    let mut is_drawn = vec![false; labels.len()];
    let mut at = (0..sites.len()).max_by(|a, b| best[*a].0.total_cmp(&best[*b].0));
    while let Some(site) = at {
        is_drawn[sites[site]] = true;
        at = best[site].1;
    }
    is_drawn
}

/// Returns whether a label is inside of the picture: its corners are at the lower end of its baseline, 45° up to the
/// right from it, and by its height up to the left from both.
fn is_inside(label: &Label, rows: &Rows, base_px: f64) -> bool {
    let [first, last] = [label.x_px[0].min(label.x_px[1]), label.x_px[0].max(label.x_px[1])];
    let top_px = base_px - (label.width_px + label.height_px) / SQRT_2;
    label.is_valid()
        && first - label.height_px / SQRT_2 >= rows.margin_px
        && last + label.width_px / SQRT_2 <= rows.width_px - rows.margin_px
        && top_px >= rows.margin_px
        && label.y_px >= base_px
}

/// Returns whether two labels, the left one first, do not overlap in either picture.
fn are_apart(left: &Label, right: &Label, rows: &Rows) -> bool {
    let distance_px = (right.x_px[0] - left.x_px[0]).min(right.x_px[1] - left.x_px[1]);
    distance_px >= 0.0 && distance_px / SQRT_2 >= right.height_px + usual(rows.gap_px)
}
