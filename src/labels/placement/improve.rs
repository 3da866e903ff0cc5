//! The choice between the exact dynamic programme of a panorama and an approximation that takes less time.
//!
//! The programme needs time proportional to the number of rows and the cube of the number of labels. If that is too
//! long, light labels among many heavier ones are left out, neighbours in a row have few other labels between them, and
//! afterwards each label that was left out is inserted where there is space.

use super::chain;
use super::panorama::{Problem, TOLERANCE_PX};
use super::settle;

/// Largest number of pairs of neighbours that the dynamic programme compares: for any number of rows, and for each row
/// more. With few rows, a pair takes longer and a smaller window suffices.
const MAX_PAIRS: [f64; 2] = [3e5, 4e4];
/// Number of heavier labels that may have leaders within the width of a label to its left and right, without rows.
/// Each row adds one.
const CROWD: usize = 8;

impl Problem {
    /// Returns the largest difference of the numbers of neighbours in a row that the dynamic programme has time for.
    pub(super) fn window(&self) -> usize {
        let count = self.sites.len() as f64;
        let tables = self.gains.len().saturating_sub(1) as f64;
        let most = MAX_PAIRS[0] + MAX_PAIRS[1] * self.gains.len() as f64;
        if tables * count * count * count / 6.0 <= most {
            return self.sites.len() + 1;
        }
        (2.0 * most / (tables * count)).sqrt() as usize
    }

    /// Returns the largest gain of a site in any row.
    fn gain(&self, site: usize) -> f64 {
        self.gains.iter().map(|row| row[site]).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns the sites by their gain, the largest one first.
    fn heaviest_first(&self) -> Vec<usize> {
        let mut sites: Vec<usize> = (0..self.sites.len()).collect();
        sites.sort_by(|a, b| self.gain(*b).total_cmp(&self.gain(*a)));
        sites
    }

    /// Returns the sites without those that have too many heavier ones close by, from left to right.
    fn thinned(&self) -> Vec<usize> {
        let most = CROWD + self.gains.len();
        let mut kept: Vec<usize> = Vec::new();
        for site in self.heaviest_first() {
            let at = kept.partition_point(|other| *other < site);
            let reach_px = self.sites[site].width_px;
            let left = kept[..at].iter().rev().take_while(|other| self.distance_px(**other, site) < reach_px);
            let right = kept[at..].iter().take_while(|other| self.distance_px(site, **other) < reach_px);
            if left.take(most).count() + right.take(most).count() < most {
                kept.insert(at, site);
            }
        }
        kept
    }

    /// Returns the problem for some of the sites.
    fn only(&self, sites: &[usize]) -> Self {
        let gains = self.gains.iter().map(|row| sites.iter().map(|site| row[*site]).collect()).collect();
        Self { sites: sites.iter().map(|site| self.sites[*site]).collect(), gains, ..*self }
    }
}

/// Returns the row of each site, or `None` for labels that are left out.
pub(super) fn solve(problem: &Problem) -> Vec<Option<usize>> {
    let count = problem.sites.len();
    let window = problem.window();
    if window > count {
        return chain::solve(problem, window);
    }
    let sites = problem.thinned();
    let less = problem.only(&sites);
    let mut rows_of = vec![None; count];
    for (site, row) in sites.iter().zip(chain::solve(&less, less.window())) {
        rows_of[*site] = row;
    }
    insert(problem, &mut rows_of);
    rows_of
}

/// Places labels that have been left out where there is space, the heaviest one first.
fn insert(problem: &Problem, rows_of: &mut [Option<usize>]) {
    let mut ranges = settle::ranges(problem, rows_of);
    for site in problem.heaviest_first() {
        if rows_of[site].is_some() {
            continue;
        }
        for row in (0..problem.gains.len()).rev() {
            if problem.gains[row][site] > 0.0 && may_fit(problem, rows_of, &ranges, [site, row]) {
                rows_of[site] = Some(row);
                let narrower = settle::ranges(problem, rows_of);
                if fits(problem, rows_of, &narrower, row) {
                    ranges = narrower;
                    break;
                }
                rows_of[site] = None;
            }
        }
    }
}

/// Returns whether the labels of a row and of those below it have space.
fn fits(problem: &Problem, rows_of: &[Option<usize>], ranges: &[[f64; 2]], row: usize) -> bool {
    (row..problem.gains.len()).all(|row| {
        let sites: Vec<usize> = (0..rows_of.len()).filter(|site| rows_of[*site] == Some(row)).collect();
        settle::is_possible(problem, &sites, ranges)
    })
}

/// Returns whether a label may have space in a row, by a look at the closest labels to the left and right. It is only
/// wrong if it returns `true`.
fn may_fit(problem: &Problem, rows_of: &[Option<usize>], ranges: &[[f64; 2]], [site, row]: [usize; 2]) -> bool {
    let [mut low_px, mut high_px] = problem.sites[site].range_px;
    let width_px = problem.sites[site].width_px;
    let mut blocked = false;
    // The closest labels of the same row and of the rows below: is there space for the label, and for its leader?
    let mut seen = vec![false; problem.gains.len()];
    for left in (0..site).rev() {
        let Some(other) = rows_of[left] else { continue };
        let distance_px = problem.distance_px(left, site);
        let first_px = ranges[left][0] + problem.sites[left].width_px;
        if other < row {
            low_px = low_px.max(problem.leader_gap_px - distance_px);
            break;
        }
        if !std::mem::replace(&mut seen[other], true) {
            blocked |= other > row && first_px > distance_px - problem.leader_gap_px + TOLERANCE_PX;
            low_px = if other == row { low_px.max(first_px + problem.gap_px - distance_px) } else { low_px };
        }
    }
    seen.fill(false);
    for (right, other) in rows_of.iter().enumerate().skip(site + 1) {
        let Some(other) = *other else { continue };
        let distance_px = problem.distance_px(site, right);
        let last_px = ranges[right][1] + distance_px;
        if other < row {
            high_px = high_px.min(distance_px - problem.leader_gap_px - width_px);
            break;
        }
        if !std::mem::replace(&mut seen[other], true) {
            blocked |= other > row && last_px < problem.leader_gap_px - TOLERANCE_PX;
            high_px = if other == row { high_px.min(last_px - problem.gap_px - width_px) } else { high_px };
        }
    }
    !blocked && low_px <= high_px + TOLERANCE_PX
}
