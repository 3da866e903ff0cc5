//! Shortens a tour through strokes by local changes (Croes 1958, Or 1976; with neighbour lists as in Bentley 1992).
//!
//! - **2-opt**: a stretch of the tour is reversed, and each of its strokes is drawn from its other end.
//! - **Or-opt**: one stroke is moved to another position in the tour, in either direction.
//!
//! Only changes that join two ends are tried, where one is among the nearest neighbours of the other. A change is made
//! if it shortens the tour. Rounds are repeated until one gains nothing, or until `MAX_MOVES` strokes were moved in
//! the list. This limit is a number of steps and not a time, so the same strokes always give the same tour.

use super::grid::{Grid, distance};

/// A stroke of the tour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stop {
    /// Points where the pen goes down and where it goes up.
    pub ends: [[f64; 2]; 2],
    /// Index of the stroke.
    pub stroke: usize,
    /// Whether the stroke is drawn in the direction opposite to the initial one.
    pub is_flipped: bool,
}

/// Number of neighbours of an end that are tried.
const NEIGHBOURS: usize = 8;
/// Largest number of rounds.
const MAX_ROUNDS: usize = 30;
/// Largest number of moves of strokes within the list, about one second of work.
const MAX_MOVES: usize = 200_000_000;
/// Smaller gains are rounding errors.
const MIN_GAIN: f64 = 1e-9;

/// Shortens the pen-up travel from `from` through all stops; never lengthens it.
pub(crate) fn improve(stops: &mut [Stop], from: [f64; 2]) {
    let count = stops.len();
    // In the initial order: ends 2i and 2i + 1 are where stop i began and ended then.
    let places: Vec<[f64; 2]> = stops.iter().flat_map(|stop| stop.ends).collect();
    let grid = Grid::new(&places);
    let near: Vec<Vec<u32>> = (0..places.len())
        .map(|end| grid.nearest(places[end], NEIGHBOURS, |other| other as usize / 2 != end / 2))
        .collect();
    // Current position of each initial stop.
    let mut at: Vec<usize> = (0..count).collect();
    let names: Vec<usize> = (0..count).collect();
    let mut way = Way { stops, names, from, moves: 0 };
    for _ in 0..MAX_ROUNDS {
        let mut gains = false;
        for (end, near) in near.iter().enumerate() {
            for &other in near {
                let (own, other) = (end, other as usize);
                if distance(places[own], places[other]) >= way.longest_gap(at[own / 2]) {
                    // All following neighbours are even farther away.
                    break;
                }
                let changed = way
                    .join_by_turning(at[own / 2], own % 2, at[other / 2], other % 2)
                    .or_else(|| way.join_by_moving(at[own / 2], own % 2, at[other / 2], other % 2));
                if let Some([first, last]) = changed {
                    (first..=last).for_each(|i| at[way.names[i]] = i);
                    gains = true;
                    break;
                }
            }
        }
        if !gains || way.moves > MAX_MOVES {
            break;
        }
    }
}

struct Way<'a> {
    stops: &'a mut [Stop],
    /// Initial index of each stop.
    names: Vec<usize>,
    from: [f64; 2],
    moves: usize,
}

impl Way<'_> {
    /// Returns where the pen is before stop `i`.
    fn before(&self, i: usize) -> [f64; 2] {
        if i == 0 { self.from } else { self.stops[i - 1].ends[1] }
    }

    /// Returns the distance from `place` to the start of stop `i`; 0 beyond the last stop.
    fn to(&self, place: [f64; 2], i: usize) -> f64 {
        self.stops.get(i).map_or(0.0, |stop| distance(place, stop.ends[0]))
    }

    /// Returns the longer of the pen-up moves to stop `i` and from it; infinite for the last stop, which any stop may
    /// follow.
    fn longest_gap(&self, i: usize) -> f64 {
        let after = if i + 1 == self.stops.len() { f64::INFINITY } else { self.to(self.stops[i].ends[1], i + 1) };
        self.to(self.before(i), i).max(after)
    }

    /// Returns whether stop `i` now begins at its end number `end`, as counted in the initial order.
    fn is_begin(&self, i: usize, end: usize) -> bool {
        (end == 0) != self.stops[i].is_flipped
    }

    /// Reverses a stretch so that two ends meet that are both beginnings, or both ends, of strokes. Returns the first
    /// and the last stop that changed.
    fn join_by_turning(&mut self, a: usize, a_end: usize, b: usize, b_end: usize) -> Option<[usize; 2]> {
        let is_begin = self.is_begin(a, a_end);
        if is_begin != self.is_begin(b, b_end) || a == b {
            return None;
        }
        // Two beginnings meet if the stretch from the first stop to the one before the second is reversed; two ends
        // meet if the stretch from after the first stop to the second is reversed.
        let [low, high] = [a.min(b), a.max(b)];
        let [first, last] = if is_begin { [low, high - 1] } else { [low + 1, high] };
        let (before, down, up) = (self.before(first), self.stops[first].ends[0], self.stops[last].ends[1]);
        let now = distance(before, down) + self.to(up, last + 1);
        let then = distance(before, up) + self.to(down, last + 1);
        if then > now - MIN_GAIN {
            return None;
        }
        self.stops[first..=last].reverse();
        self.names[first..=last].reverse();
        self.stops[first..=last].iter_mut().for_each(turn);
        self.moves += last + 1 - first;
        Some([first, last])
    }

    /// Moves stop `a` next to stop `b`, so that the two ends meet. Returns the first and the last stop that changed.
    fn join_by_moving(&mut self, a: usize, a_end: usize, b: usize, b_end: usize) -> Option<[usize; 2]> {
        let joins_begin = self.is_begin(b, b_end);
        // `a` goes before `b` if it joins the beginning of `b`, otherwise after it.
        let gap = if joins_begin { b } else { b + 1 };
        if a == b || gap == a || gap == a + 1 {
            return None;
        }
        let mut moved = self.stops[a];
        // The beginning of `b` must be joined by an end of `a`, and the end of `b` by a beginning.
        if self.is_begin(a, a_end) == joins_begin {
            turn(&mut moved);
        }
        let own = self.stops[a].ends;
        let out = self.to(self.before(a), a) + self.to(own[1], a + 1) - self.to(self.before(a), a + 1);
        let before = self.before(gap);
        let into = distance(before, moved.ends[0]) + self.to(moved.ends[1], gap) - self.to(before, gap);
        if into > out - MIN_GAIN {
            return None;
        }
        self.stops[a] = moved;
        let [first, last] = if gap > a { [a, gap - 1] } else { [gap, a] };
        if gap > a {
            self.stops[first..=last].rotate_left(1);
            self.names[first..=last].rotate_left(1);
        } else {
            self.stops[first..=last].rotate_right(1);
            self.names[first..=last].rotate_right(1);
        }
        self.moves += last + 1 - first;
        Some([first, last])
    }
}

fn turn(stop: &mut Stop) {
    stop.ends.reverse();
    stop.is_flipped = !stop.is_flipped;
}
