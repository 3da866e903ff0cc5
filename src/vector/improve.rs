//! A way through strokes is made shorter by local changes (Croes 1958, Or 1976; with lists of neighbours as Bentley
//! 1992 has them).
//!
//! - **2-opt**: a stretch of the way is drawn backwards, each of its strokes from its other end.
//! - **Or-opt**: one stroke is drawn elsewhere, either way round.
//!
//! Only changes that bring two ends together that are among the nearest of each other are looked at. A change is made
//! when it is a gain; rounds go on until one gains nothing, or until `MOST_MOVES` strokes were moved in the list. That
//! is a number of steps and not a time, so the same strokes always give the same way.

use super::grid::{Grid, distance};

/// A stroke on the way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stop {
    /// Where the pen comes down, and where it goes up.
    pub ends: [[f64; 2]; 2],
    /// Whose.
    pub stroke: usize,
    /// Whether it is drawn the other way round than at first.
    pub is_flipped: bool,
}

/// Neighbours of an end that are looked at.
const NEIGHBOURS: usize = 8;
/// Rounds, at most.
const MOST_ROUNDS: usize = 30;
/// Strokes that change their places in the list, at most, counted each time: about a second.
const MOST_MOVES: usize = 200_000_000;
/// Less is rounding.
const LEAST_GAIN: f64 = 1e-9;

/// Makes the pen's way from `from` through all stops shorter, or leaves it.
pub fn improve(stops: &mut [Stop], from: [f64; 2]) {
    let count = stops.len();
    // By their first order: ends 2i and 2i + 1 are where stop i began and ended then.
    let places: Vec<[f64; 2]> = stops.iter().flat_map(|stop| stop.ends).collect();
    let grid = Grid::new(&places);
    let near: Vec<Vec<u32>> = (0..places.len())
        .map(|end| grid.nearest(places[end], NEIGHBOURS, |other| other as usize / 2 != end / 2))
        .collect();
    // Where each is now.
    let mut at: Vec<usize> = (0..count).collect();
    let names: Vec<usize> = (0..count).collect();
    let mut way = Way { stops, names, from, moves: 0 };
    for _ in 0..MOST_ROUNDS {
        let mut gains = false;
        for (end, near) in near.iter().enumerate() {
            for &other in near {
                let (own, other) = (end, other as usize);
                if distance(places[own], places[other]) >= way.longest_gap(at[own / 2]) {
                    // Farther neighbours are farther still.
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
        if !gains || way.moves > MOST_MOVES {
            break;
        }
    }
}

struct Way<'a> {
    stops: &'a mut [Stop],
    /// Which stop of the first order each is.
    names: Vec<usize>,
    from: [f64; 2],
    moves: usize,
}

impl Way<'_> {
    /// Where the pen is before stop `i`.
    fn before(&self, i: usize) -> [f64; 2] {
        if i == 0 { self.from } else { self.stops[i - 1].ends[1] }
    }

    /// From `place` to stop `i`; nothing beyond the last.
    fn to(&self, place: [f64; 2], i: usize) -> f64 {
        self.stops.get(i).map_or(0.0, |stop| distance(place, stop.ends[0]))
    }

    /// The longer of the ways in the air to stop `i` and from it. The last leads nowhere, so anything may follow it.
    fn longest_gap(&self, i: usize) -> f64 {
        let after = if i + 1 == self.stops.len() { f64::INFINITY } else { self.to(self.stops[i].ends[1], i + 1) };
        self.to(self.before(i), i).max(after)
    }

    /// Whether the end with this number among the two of the first order is where stop `i` begins now.
    fn is_begin(&self, i: usize, end: usize) -> bool {
        (end == 0) != self.stops[i].is_flipped
    }

    /// Turns a stretch so that two ends meet that both begin strokes, or both end them. Tells which stops changed.
    fn join_by_turning(&mut self, a: usize, a_end: usize, b: usize, b_end: usize) -> Option<[usize; 2]> {
        let is_begin = self.is_begin(a, a_end);
        if is_begin != self.is_begin(b, b_end) || a == b {
            return None;
        }
        // Two that begin meet when what lies from the first to before the second is turned; two that end meet when
        // what lies behind the first up to the second is.
        let [low, high] = [a.min(b), a.max(b)];
        let [first, last] = if is_begin { [low, high - 1] } else { [low + 1, high] };
        let (before, down, up) = (self.before(first), self.stops[first].ends[0], self.stops[last].ends[1]);
        let now = distance(before, down) + self.to(up, last + 1);
        let then = distance(before, up) + self.to(down, last + 1);
        if then > now - LEAST_GAIN {
            return None;
        }
        self.stops[first..=last].reverse();
        self.names[first..=last].reverse();
        self.stops[first..=last].iter_mut().for_each(turn);
        self.moves += last + 1 - first;
        Some([first, last])
    }

    /// Draws stop `a` beside stop `b`, so that the two ends meet. Tells which stops changed.
    fn join_by_moving(&mut self, a: usize, a_end: usize, b: usize, b_end: usize) -> Option<[usize; 2]> {
        let joins_begin = self.is_begin(b, b_end);
        // Before b it goes if b begins there, else behind it.
        let gap = if joins_begin { b } else { b + 1 };
        if a == b || gap == a || gap == a + 1 {
            return None;
        }
        let mut moved = self.stops[a];
        // What meets b's beginning must be an end, and the other way round.
        if self.is_begin(a, a_end) == joins_begin {
            turn(&mut moved);
        }
        let own = self.stops[a].ends;
        let out = self.to(self.before(a), a) + self.to(own[1], a + 1) - self.to(self.before(a), a + 1);
        let before = self.before(gap);
        let into = distance(before, moved.ends[0]) + self.to(moved.ends[1], gap) - self.to(before, gap);
        if into > out - LEAST_GAIN {
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
