//! Positions of labels along their rows, after it has been decided which label is in which row.
//!
//! Each label is as close to its preferred position as its neighbours allow: isotonic regression by pooling adjacent
//! violators (Ayer and others 1955), limited to the range in which each label touches its leader and crosses no other.
//! The positions depend continuously on those of the summits, so labels do not jump while the camera moves.

use super::panorama::{Problem, TOLERANCE_PX};

/// A label in its row.
#[derive(Clone, Copy)]
struct Member {
    site: usize,
    /// The offset that the label would have if its left neighbour touched it, the left neighbour of that one too, and
    /// so on. Without these, labels in a row only need to be in order.
    shift_px: f64,
    low_px: f64,
    high_px: f64,
}

/// Returns the range of offsets of each site that has a row, as far as the picture and the leaders of higher rows limit
/// it.
pub(super) fn ranges(problem: &Problem, rows_of: &[Option<usize>]) -> Vec<[f64; 2]> {
    let mut ranges: Vec<[f64; 2]> = problem.sites.iter().map(|site| site.range_px).collect();
    // The last leader of each row.
    let mut last: Vec<Option<usize>> = vec![None; problem.gains.len()];
    for (site, row) in rows_of.iter().enumerate() {
        let Some(row) = *row else { continue };
        if let Some(left) = last[..row].iter().flatten().max() {
            let low_px = problem.leader_gap_px - problem.distance_px(*left, site);
            ranges[site][0] = ranges[site][0].max(low_px);
        }
        last[row] = Some(site);
    }
    last.fill(None);
    for (site, row) in rows_of.iter().enumerate().rev() {
        let Some(row) = *row else { continue };
        if let Some(right) = last[..row].iter().flatten().min() {
            let end_px = problem.distance_px(site, *right) - problem.leader_gap_px;
            ranges[site][1] = ranges[site][1].min(end_px - problem.sites[site].width_px);
        }
        last[row] = Some(site);
    }
    ranges
}

/// Returns the offsets of all sites that have a row: close to the preferred ones, and without overlaps. A site for which
/// the sites to its left leave no space gets `None`.
pub(super) fn offsets(problem: &Problem, rows_of: &[Option<usize>], preferred_px: &[f64]) -> Vec<Option<f64>> {
    let ranges = ranges(problem, rows_of);
    let mut offsets = vec![None; rows_of.len()];
    for row in 0..problem.gains.len() {
        let mut members = members(problem, (0..rows_of.len()).filter(|site| rows_of[*site] == Some(row)), &ranges);
        let mut highest_px = f64::INFINITY;
        for member in members.iter_mut().rev() {
            highest_px = highest_px.min(member.high_px);
            // The lower limit wins over rounding.
            member.high_px = highest_px.max(member.low_px);
        }
        let wanted: Vec<f64> = members.iter().map(|member| preferred_px[member.site] - member.shift_px).collect();
        for (member, pooled_px) in members.iter().zip(pooled(&wanted)) {
            let at_px = pooled_px.max(member.low_px).min(member.high_px) + member.shift_px;
            let [low_px, high_px] = ranges[member.site];
            offsets[member.site] = Some(at_px.min(high_px).max(low_px));
        }
    }
    offsets
}

/// Returns whether all sites of a row have space.
pub(super) fn is_possible(problem: &Problem, sites: &[usize], ranges: &[[f64; 2]]) -> bool {
    members(problem, sites.iter().copied(), ranges).len() == sites.len()
}

/// Returns the sites of a row, from left to right, without those that have no space.
fn members(problem: &Problem, sites: impl Iterator<Item = usize>, ranges: &[[f64; 2]]) -> Vec<Member> {
    let mut members: Vec<Member> = Vec::new();
    for site in sites {
        let (mut shift_px, mut low_px) = (0.0, f64::NEG_INFINITY);
        if let Some(left) = members.last() {
            let apart_px = problem.sites[left.site].width_px + problem.gap_px;
            shift_px = left.shift_px + apart_px - problem.distance_px(left.site, site);
            low_px = left.low_px;
        }
        let low_px = low_px.max(ranges[site][0] - shift_px);
        let high_px = ranges[site][1] - shift_px;
        if low_px <= high_px + TOLERANCE_PX {
            members.push(Member { site, shift_px, low_px, high_px });
        }
    }
    members
}

/// Returns the sequence that never falls and is closest to some numbers in the sense of least squares.
fn pooled(wanted: &[f64]) -> Vec<f64> {
    let mut pools: Vec<(f64, usize)> = Vec::new();
    for number in wanted {
        let mut pool = (*number, 1);
        while let Some((mean, count)) = pools.pop_if(|(mean, _)| *mean > pool.0) {
            let all = count + pool.1;
            pool = ((mean * count as f64 + pool.0 * pool.1 as f64) / all as f64, all);
        }
        pools.push(pool);
    }
    pools.into_iter().flat_map(|(mean, count)| std::iter::repeat_n(mean, count)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pools_are_in_order() {
        assert_eq!(pooled(&[1.0, 3.0, 2.0, 5.0]), [1.0, 2.5, 2.5, 5.0]);
        assert_eq!(pooled(&[3.0, 2.0, 1.0]), [2.0; 3]);
        assert_eq!(pooled(&[]), [0.0; 0]);
    }
}
