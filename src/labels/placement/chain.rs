//! The dynamic programme over rows and leaders of [`super::panorama`].
//!
//! Sites have numbers from 1 on. 0 is the left side of the picture, and the last number its right side; both act as
//! leaders that are infinitely far away.

use super::panorama::{Problem, TOLERANCE_PX};

/// Largest number of selections per label that are continued, without and with limits to what is compared. More have not
/// been seen to matter.
const MAX_SELECTIONS: [usize; 2] = [16, 5];
/// No earlier selection.
const NONE: u32 = u32::MAX;

/// For each pair of leaders, the largest gain of labels between them, in the rows below.
pub(super) struct Table {
    /// Largest difference of the numbers of two leaders.
    band: usize,
    /// For each right leader, the gains from the left leaders before it, the closest one first. `band` zeros, which
    /// serve all right leaders, if there are no rows below.
    gains: Vec<f64>,
    /// Number of gains from one right leader to the next.
    stride: usize,
}

impl Table {
    /// Returns the gains from the leaders before a leader, the closest one first.
    fn gains(&self, to: usize) -> &[f64] {
        &self.gains[to * self.stride..][..self.band]
    }

    /// Returns the gain between two leaders; negative infinity if it is not known.
    fn gain(&self, from: usize, to: usize) -> f64 {
        self.gains(to).get(to - from - 1).copied().unwrap_or(f64::NEG_INFINITY)
    }
}

/// Labels of a row from a leader on, of which the last is known.
#[derive(Clone, Copy)]
struct Selection {
    /// Gain of the labels of the row and of all rows below.
    gain: f64,
    /// Where the last label ends, from its leader to the right, in pixels.
    end_px: f64,
    /// Number of the last label.
    site: u32,
    /// Index of the selection without the last label.
    before: u32,
    /// Whether no label is there, and the lower rows are divided nevertheless.
    is_wall: bool,
}

/// Solves a problem exactly among the layouts in which neighbours in a row have less than `window` sites between them.
/// Returns the row of each site.
pub(super) fn solve(problem: &Problem, window: usize) -> Vec<Option<usize>> {
    let count = problem.sites.len();
    let mut rows_of = vec![None; count];
    let band = window.clamp(1, count + 1);
    let mut tables = vec![Table { band, gains: vec![0.0; band], stride: 0 }];
    let outside = [[f64::NEG_INFINITY; 2], [f64::INFINITY; 2]];
    let mut x_px = vec![outside[0]];
    x_px.extend(problem.sites.iter().map(|site| site.x_px).chain([outside[1]]));
    let mut chain = Chain {
        problem,
        x_px,
        selections: Vec::new(),
        begins: Vec::new(),
        most: Vec::new(),
        found: Vec::new(),
        near: Vec::new(),
        most_selections: MAX_SELECTIONS[usize::from(band <= count)],
    };
    let narrowest_px = problem.sites.iter().map(|site| site.width_px).fold(f64::INFINITY, f64::min);
    for row in (1..problem.gains.len()).rev() {
        let mut gains = vec![0.0; (count + 2) * band];
        let Some(below) = tables.last() else { break };
        for from in 0..=count {
            let last = (from + band).min(count + 1);
            let is_narrow = chain.distance_px(from, last) < narrowest_px + 2.0 * problem.leader_gap_px;
            if is_narrow {
                continue;
            }
            chain.extend(row, below, from, last - 1, false);
            for to in from + 1..=last {
                gains[to * band + to - from - 1] = chain.best(below, from, to).0;
            }
        }
        tables.push(Table { band, gains, stride: band });
    }
    if !problem.gains.is_empty() {
        chain.trace(&tables, 0, [0, count + 1], &mut rows_of);
    }
    rows_of
}

/// A label to the left of another one, which it may push to the right.
struct Near {
    /// What is added to the end of the left label to get the offset of the right one.
    shift_px: f64,
    /// Gain of the rows below between the two.
    below: f64,
    /// Largest gain of the selections of the left label.
    most: f64,
    /// Indices of the selections that push.
    range: [u32; 2],
}

/// The dynamic programme along one row, from a leader to the right.
struct Chain<'a> {
    problem: &'a Problem,
    /// Positions of all leaders in both pictures, with those of the sides.
    x_px: Vec<[f64; 2]>,
    selections: Vec<Selection>,
    /// Index of the first selection of each site, from the leader on, and of the end.
    begins: Vec<u32>,
    /// The largest gain of the selections of each site, from the leader on.
    most: Vec<f64>,
    /// Selections that the label of one site may continue.
    found: Vec<Selection>,
    /// Labels that may push it.
    near: Vec<Near>,
    /// Largest number of selections of a site.
    most_selections: usize,
}

impl Chain<'_> {
    /// Returns the distance of two leaders.
    fn distance_px(&self, from: usize, to: usize) -> f64 {
        let [from, to] = [self.x_px[from], self.x_px[to]];
        (to[0] - from[0]).min(to[1] - from[1])
    }

    /// Returns the selections of a site, and the index of the first one.
    fn of(&self, site: usize) -> (u32, &[Selection]) {
        let [begin, end] = [self.begins[site], self.begins[site + 1]];
        (begin, &self.selections[begin as usize..end as usize])
    }

    /// Finds the selections that end with each site from a leader of a higher row to `last`. With `has_walls`, the
    /// lower rows may be divided without a label: so that leaders can be further apart than the band of the table.
    fn extend(&mut self, row: usize, below: &Table, from: usize, last: usize, has_walls: bool) {
        let [gap_px, leader_gap_px] = [self.problem.gap_px, self.problem.leader_gap_px];
        self.selections.clear();
        self.begins.clear();
        self.begins.resize(2, 0);
        self.most.clear();
        self.most.push(f64::NEG_INFINITY);
        for to in from + 1..=last {
            let begin = self.selections.len();
            if has_walls {
                // A wall has no label, so it needs no gap. It ends at its leader, before any label.
                self.find(below, [from, to], [0.0; 2], 0.0);
                self.selections.extend(self.found.iter().map(|found| Selection { is_wall: true, ..*found }));
            }
            let site = &self.problem.sites[to - 1];
            let gain = self.problem.gains[row][to - 1];
            let low_px = site.range_px[0].max(leader_gap_px - self.distance_px(from, to));
            if gain > 0.0 && low_px <= site.range_px[1] {
                self.find(below, [from, to], [low_px, site.range_px[1]], gap_px);
                for found in &self.found {
                    let [gain, end_px] = [found.gain + gain, found.end_px + site.width_px];
                    if self.selections[begin..].last().is_none_or(|last| gain > last.gain) {
                        self.selections.push(Selection { gain, end_px, ..*found });
                    }
                }
            }
            self.limit(begin);
            self.begins.push(self.selections.len() as u32);
            let last = self.selections[begin..].last();
            self.most.push(last.map_or(f64::NEG_INFINITY, |last| last.gain));
        }
    }

    /// Finds the selections that a label or wall at site `to` may continue, with the offset of the label as their end.
    /// The result has no dominated ones: it is in the order of ends, and of gains.
    fn find(&mut self, below: &Table, [from, to]: [usize; 2], [low_px, high_px]: [f64; 2], gap_px: f64) {
        let site = to as u32;
        let none = Selection { gain: f64::NEG_INFINITY, end_px: low_px, site, before: NONE, is_wall: false };
        // The best one that does not push the label to the right.
        let mut free = Selection { gain: below.gain(from, to), ..none };
        let first = (from + 1).max(to.saturating_sub(below.band));
        let gains = &below.gains(to)[..to - first];
        let most = &self.most[first - from..to - from];
        let mut nears = std::mem::take(&mut self.near);
        nears.clear();
        for (left, (below, most)) in (first..to).rev().zip(gains.iter().zip(most.iter().rev())) {
            if below + most <= free.gain {
                continue;
            }
            let shift_px = gap_px - self.distance_px(left, to);
            let (begin, selections) = self.of(left - from);
            let Some(ends_px) = selections.first().zip(selections.last()).map(|(a, b)| [a.end_px, b.end_px]) else {
                continue;
            };
            if ends_px[0] + shift_px > high_px + TOLERANCE_PX {
                continue;
            }
            let mut fitting = selections.len();
            if ends_px[1] + shift_px > low_px {
                fitting = selections.partition_point(|selection| selection.end_px + shift_px <= low_px);
                let end = begin + selections.len() as u32;
                nears.push(Near { shift_px, below: *below, most: *most, range: [begin + fitting as u32, end] });
            }
            let gain = fitting.checked_sub(1).map_or(f64::NEG_INFINITY, |last| selections[last].gain + below);
            if gain > free.gain {
                free = Selection { gain, before: begin + fitting as u32 - 1, ..none };
            }
        }
        self.found.clear();
        if free.gain > f64::NEG_INFINITY {
            self.found.push(free);
        }
        for near in nears.iter().filter(|near| near.below + near.most > free.gain) {
            let [begin, end] = near.range;
            for (before, selection) in (begin..).zip(&self.selections[begin as usize..end as usize]) {
                let [gain, end_px] = [selection.gain + near.below, selection.end_px + near.shift_px];
                if end_px > high_px + TOLERANCE_PX {
                    break;
                }
                if gain > free.gain {
                    offer(&mut self.found, Selection { gain, end_px, before, ..none });
                }
            }
        }
        self.near = nears;
    }

    /// Removes selections from index `begin` on, if there are too many.
    fn limit(&mut self, begin: usize) {
        while self.selections.len() - begin > self.most_selections {
            // The one that gains least over the one before.
            let step = |i: &usize| self.selections[*i].gain - self.selections[i - 1].gain;
            let least = (begin + 1..self.selections.len() - 1).min_by(|a, b| step(a).total_cmp(&step(b)));
            let Some(least) = least else { break };
            self.selections.remove(least);
        }
    }

    /// Returns the largest gain between two leaders of higher rows, and the selection that has it.
    fn best(&self, below: &Table, from: usize, to: usize) -> (f64, u32) {
        let mut best = (below.gain(from, to), NONE);
        let first = (from + 1).max(to.saturating_sub(below.band));
        let gains = &below.gains(to)[..to - first];
        let most = &self.most[first - from..to - from];
        for (left, (below, most)) in (first..to).rev().zip(gains.iter().zip(most.iter().rev())) {
            if below + most <= best.0 {
                continue;
            }
            let (begin, selections) = self.of(left - from);
            let space_px = self.distance_px(left, to) - self.problem.leader_gap_px + TOLERANCE_PX;
            let fitting = selections.partition_point(|selection| selection.end_px <= space_px);
            let gain = fitting.checked_sub(1).map_or(f64::NEG_INFINITY, |last| selections[last].gain + below);
            if gain > best.0 {
                best = (gain, begin + fitting as u32 - 1);
            }
        }
        best
    }

    /// Writes the rows of the best layout between two leaders, in a row and all rows below.
    fn trace(&mut self, tables: &[Table], row: usize, [from, to]: [usize; 2], rows_of: &mut [Option<usize>]) {
        let Some(below) = tables.len().checked_sub(row + 1).and_then(|index| tables.get(index)) else { return };
        if to - from < 2 {
            return;
        }
        self.extend(row, below, from, to - 1, to - from > below.band);
        let (_, mut at) = self.best(below, from, to);
        let mut leaders = vec![to];
        while let Some(selection) = self.selections.get(at as usize) {
            let site = selection.site as usize;
            if !selection.is_wall {
                rows_of[site - 1] = Some(row);
            }
            leaders.push(site);
            at = selection.before;
        }
        leaders.push(from);
        if row + 1 < self.problem.gains.len() {
            leaders.windows(2).for_each(|pair| self.trace(tables, row + 1, [pair[1], pair[0]], rows_of));
        }
    }
}

/// Inserts a selection into a list in the order of ends and gains, unless it is dominated, and removes those that it
/// dominates.
fn offer(found: &mut Vec<Selection>, new: Selection) {
    let at = found.iter().rposition(|other| other.end_px <= new.end_px).map_or(0, |last| last + 1);
    if at > 0 && found[at - 1].gain >= new.gain {
        return;
    }
    let equal = usize::from(at > 0 && found[at - 1].end_px >= new.end_px);
    let dominated = found[at..].iter().take_while(|other| other.gain <= new.gain).count();
    let [from, to] = [at - equal, at + dominated];
    if from == to {
        found.insert(at, new);
    } else {
        found[from] = new;
        found.drain(from + 1..to);
    }
}
