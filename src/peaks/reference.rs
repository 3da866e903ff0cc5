//! What the tests compare with: floods from each summit, and searches of all samples.

use std::collections::{BTreeSet, BinaryHeap};

use super::sample::{Sample, ordered};
use super::spacing::Metric;
use super::{Heights, Higher, Isolation, Peak, Rules, Saddle};

/// Steps to eight neighbours; the first four share an edge with the sample.
pub(super) const EIGHT: [[i64; 2]; 8] = [[1, 0], [0, 1], [-1, 0], [0, -1], [1, 1], [-1, 1], [-1, -1], [1, -1]];

/// Heights in memory.
#[derive(Clone)]
pub(super) struct Land {
    pub size: [usize; 2],
    pub heights_m: Vec<f32>,
}

impl Heights for Land {
    type Error = std::convert::Infallible;

    fn size(&self) -> [usize; 2] {
        self.size
    }

    fn read(&mut self, first: [usize; 2], size: [usize; 2], into: &mut Vec<f32>) -> Result<(), Self::Error> {
        into.clear();
        for row in first[1]..first[1] + size[1] {
            into.extend_from_slice(&self.heights_m[row * self.size[0] + first[0]..][..size[0]]);
        }
        Ok(())
    }
}

/// The slow computation on a land, with the neighbours of a sample as a parameter so that errors can be planted.
pub(super) struct Reference<'a> {
    pub land: &'a Land,
    pub rules: &'a Rules,
    pub around: &'a [[i64; 2]],
}

impl Reference<'_> {
    /// Returns the peaks of the land, most prominent first.
    pub(super) fn peaks(&self) -> Vec<Peak> {
        let mut peaks: Vec<Peak> = self.summits().into_iter().filter_map(|summit| self.peak(summit)).collect();
        let order =
            |peak: &Peak| (peak.prominence_m, peak.height_m, -((peak.row * self.land.size[0] + peak.column) as f64));
        peaks.sort_by(|a, b| order(b).partial_cmp(&order(a)).unwrap());
        peaks.truncate(self.rules.most);
        peaks
    }

    fn wraps(&self) -> bool {
        self.rules.wraps && self.land.size[0] > 2
    }

    fn height_m(&self, at: usize) -> f32 {
        // The result has +0 for −0.
        self.land.heights_m[at] + 0.0
    }

    fn is_land(&self, at: usize) -> bool {
        self.land.heights_m[at].is_finite()
    }

    fn sample(&self, at: usize) -> Sample {
        Sample::new(ordered(self.land.heights_m[at]), at as u64)
    }

    fn place(&self, at: usize) -> [usize; 2] {
        [at % self.land.size[0], at / self.land.size[0]]
    }

    /// Returns the neighbours on the DEM, and whether that is all of them.
    fn neighbours(&self, at: usize) -> (Vec<usize>, bool) {
        let [columns, rows] = self.land.size.map(|side| side as i64);
        let [x, y] = self.place(at).map(|place| place as i64);
        let steps = self.around.iter().map(|[dx, dy]| [x + dx, y + dy]);
        let steps = steps.map(|[x, y]| [if self.wraps() { x.rem_euclid(columns) } else { x }, y]);
        let inside = steps.filter(|[x, y]| (0..columns).contains(x) && (0..rows).contains(y));
        let inside: Vec<usize> = inside.map(|[x, y]| (y * columns + x) as usize).collect();
        let is_all = inside.len() == self.around.len();
        (inside, is_all)
    }

    /// Returns whether land may continue beyond a sample.
    fn is_open(&self, at: usize) -> bool {
        let [_, row] = self.place(at);
        let [column, _] = self.place(at);
        let is_at_border = row == 0
            || row + 1 == self.land.size[1]
            || !self.wraps() && (column == 0 || column + 1 == self.land.size[0]);
        let (neighbours, _) = self.neighbours(at);
        is_at_border || self.rules.has_open_gaps && neighbours.iter().any(|other| !self.is_land(*other))
    }

    /// Returns the first samples of all plateaus without higher neighbours.
    fn summits(&self) -> Vec<usize> {
        let mut known = BTreeSet::new();
        let mut summits = Vec::new();
        for first in (0..self.land.heights_m.len()).filter(|at| self.is_land(*at)) {
            if known.contains(&first) {
                continue;
            }
            let (mut is_summit, mut rest) = (true, vec![first]);
            known.insert(first);
            while let Some(at) = rest.pop() {
                for other in self.neighbours(at).0 {
                    is_summit &= !(self.height_m(other) > self.height_m(first) && self.is_land(other));
                    if self.height_m(other) == self.height_m(first) && known.insert(other) {
                        rest.push(other);
                    }
                }
            }
            summits.extend(is_summit.then_some(first));
        }
        summits
    }

    /// Floods the land from a summit, always on from the highest sample reached, until something higher is met.
    fn peak(&self, summit: usize) -> Option<Peak> {
        let peak = self.sample(summit);
        let mut reached = BTreeSet::from([summit]);
        let mut queue = BinaryHeap::from([(peak, summit)]);
        let (mut lowest, mut runoff, mut saddle) = (peak, None, None);
        while let Some((sample, at)) = queue.pop() {
            if sample > peak {
                saddle = Some(lowest);
                break;
            }
            lowest = lowest.min(sample);
            if runoff.is_none() && self.is_open(at) {
                runoff = Some(lowest.height_m());
            }
            let land = self.neighbours(at).0.into_iter().filter(|other| self.is_land(*other));
            queue.extend(land.filter(|other| reached.insert(*other)).map(|other| (self.sample(other), other)));
        }
        let (height_m, rules) = (self.height_m(summit), self.rules);
        let base_m = match (saddle, rules.sea_level_m) {
            (Some(saddle), _) => saddle.height_m(),
            (None, Some(sea_level_m)) if runoff.is_none() && height_m > sea_level_m => sea_level_m,
            (None, _) => lowest.height_m(),
        };
        let prominence_m = height_m - base_m;
        let [column, row] = self.place(summit);
        let is_kept = prominence_m > 0.0 && f64::from(prominence_m) >= rules.least_prominence_m;
        is_kept.then(|| Peak {
            column,
            row,
            height_m,
            prominence_m,
            certain_prominence_m: runoff.map_or(prominence_m, |runoff_m| prominence_m.min(height_m - runoff_m)),
            key_saddle: saddle.map(|saddle| {
                let [column, row] = saddle.place(self.land.size[0]);
                Saddle { column, row, height_m: saddle.height_m() }
            }),
            isolation: self.isolation(summit, |_| true),
        })
    }

    /// Searches the samples of which `takes` returns true for the nearest higher one.
    pub(super) fn isolation(&self, summit: usize, takes: impl Fn(usize) -> bool) -> Isolation {
        let metric = Metric::new(self.rules.spacing, self.land.size[0], self.wraps());
        let origin = { metric.origin((summit % self.land.size[0]) as i64, (summit / self.land.size[0]) as i64) };
        let nearness = |column: i64, row: i64| origin.nearness(origin.row_terms(row), origin.columns_to(column));
        let higher = (0..self.land.heights_m.len())
            .filter(|at| self.is_land(*at) && self.height_m(*at) > self.height_m(summit) && takes(*at));
        let keyed = higher.map(|at| {
            let [column, row] = self.place(at).map(|place| place as i64);
            (nearness(column, row), row, origin.columns_to(column), column, at)
        });
        let nearest = keyed.min_by(|a, b| a.partial_cmp(b).unwrap());
        let [columns, rows] = self.land.size.map(|side| side as i64);
        let mut outside = Vec::new();
        if !self.wraps() {
            outside.extend((0..rows).flat_map(|row| [[-1, row], [columns, row]]));
        }
        let beyond = [-1, rows].into_iter().filter(|row| metric.has_row(*row));
        outside.extend(beyond.flat_map(|row| (0..columns).map(move |column| [column, row])));
        let keyed = outside.into_iter().map(|[column, row]| (nearness(column, row), row));
        let outside = keyed.min_by(|a, b| a.partial_cmp(b).unwrap());
        let outside = outside.filter(|(outside, _)| nearest.is_none_or(|nearest| *outside < nearest.0));
        Isolation {
            higher: nearest.map(|(nearness, row, _, column, at)| Higher {
                column: column as usize,
                row: row as usize,
                height_m: self.height_m(at),
                distance_m: origin.distance_m(row, nearness),
            }),
            outside_m: outside.map(|(nearness, row)| origin.distance_m(row, nearness)),
        }
    }
}
