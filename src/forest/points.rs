//! The points at which trees can grow: evenly spread over a square that tiles seamlessly, in an order of which each
//! prefix is evenly spread as well.
//!
//! Sample elimination (Yuksel 2015, sections 3 and 4): starting with five times as many random points, the most crowded
//! point is removed until the requested number is left. Continuing to a half, a quarter and so on gives the order: the
//! points removed last come first.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::{BLOCKS, LEVELS_OF_TILE, POINTS};

/// A candidate point of a tile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    /// Position in the tile, whose side is 1.
    pub at: [f64; 2],
    /// Index in the progressive order, and number of its tree in the tile.
    pub number: u32,
}

impl Point {
    /// Returns the rank, 0 to 1: the tree exists where the density is above it.
    pub(crate) fn rank(&self) -> f64 {
        (f64::from(self.number) + 0.5) / f64::from(POINTS)
    }
}

/// The points of a tile, sorted by blocks: level 0 has all points, each further level the quarter of lowest rank.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Points {
    /// Points, level by level and block by block; by rank within a block.
    pub points: Vec<Point>,
    /// For each level, the start of each block's points, row by row, and the end.
    pub starts: [Vec<u32>; LEVELS_OF_TILE as usize],
}

impl Points {
    /// Generates the points, the same on every machine.
    pub(crate) fn new() -> Self {
        let order = progressive(&random(5 * POINTS as usize), POINTS as usize);
        let ordered = order.iter().zip(0..).map(|(at, number)| Point { at: *at, number });
        let ordered: Vec<Point> = ordered.collect();
        let mut points = Vec::new();
        let starts = std::array::from_fn(|level| {
            let side = BLOCKS >> level;
            let first = points.len() as u32;
            let mut own = ordered[..POINTS as usize >> (2 * level)].to_vec();
            // The sort is stable, so points stay sorted by rank within a block.
            own.sort_by_key(|point| block_of(point.at, side));
            let mut starts = vec![0; (side * side + 1) as usize];
            own.iter().for_each(|point| starts[block_of(point.at, side) as usize + 1] += 1);
            starts[0] = first;
            (1..starts.len()).for_each(|block| starts[block] += starts[block - 1]);
            points.append(&mut own);
            starts
        });
        Self { points, starts }
    }

    /// Returns the points of a block of a tile.
    pub(crate) fn of_block(&self, level: u32, number: u32) -> &[Point] {
        let starts = &self.starts[level as usize];
        &self.points[starts[number as usize] as usize..starts[number as usize + 1] as usize]
    }
}

impl Default for Points {
    fn default() -> Self {
        Self::new()
    }
}

fn block_of(at: [f64; 2], side: u32) -> u32 {
    let [x, y] = at.map(|along| ((along * f64::from(side)) as u32).min(side - 1));
    y * side + x
}

/// Returns the distance between two points of a square that repeats.
pub(crate) fn apart(a: [f64; 2], b: [f64; 2]) -> f64 {
    let along = |i: usize| {
        let d = (a[i] - b[i]).abs();
        d.min(1.0 - d)
    };
    along(0).hypot(along(1))
}

/// Returns random points from SplitMix64 (Steele, Lea, Flood 2014).
fn random(count: usize) -> Vec<[f64; 2]> {
    let mut state = 0x7ee5_u64;
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    };
    (0..count).map(|_| [next(), next()]).collect()
}

/// Returns the best `count` of the points, in an order of which each prefix is evenly spread.
fn progressive(points: &[[f64; 2]], count: usize) -> Vec<[f64; 2]> {
    let (mut kept, _) = eliminate(points, count);
    let mut order = Vec::with_capacity(count);
    // The order is built from its end to its beginning.
    while kept.len() > 1 {
        let (fewer, gone) = eliminate(&kept, kept.len() / 2);
        order.extend(gone);
        kept = fewer;
    }
    order.extend(kept);
    order.reverse();
    order
}

/// The crowding of a point when it was last updated, and its index. Crowding only decreases.
struct Crowded(f64, usize);

impl PartialEq for Crowded {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Crowded {}

impl PartialOrd for Crowded {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Crowded {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0).then(other.1.cmp(&self.1))
    }
}

/// Removes the most crowded points until `left` remain. Returns those that remain, and the removed ones in order.
fn eliminate(points: &[[f64; 2]], left: usize) -> (Vec<[f64; 2]>, Vec<[f64; 2]>) {
    // Twice the largest radius of this many discs (section 3.2).
    let reach = 2.0 * (1.0 / (2.0 * 3.0_f64.sqrt() * left as f64)).sqrt();
    let neighbours = neighbours(points, reach);
    let weight = |d: f64| (1.0 - d / reach).powi(8);
    let mut crowd: Vec<f64> = neighbours.iter().map(|near| near.iter().map(|(_, d)| weight(*d)).sum()).collect();
    let mut heap: BinaryHeap<Crowded> = crowd.iter().enumerate().map(|(i, crowd)| Crowded(*crowd, i)).collect();
    let mut is_gone = vec![false; points.len()];
    let mut gone = Vec::with_capacity(points.len() - left);
    while gone.len() < points.len() - left {
        let Some(Crowded(before, i)) = heap.pop() else { break };
        if before > crowd[i] {
            heap.push(Crowded(crowd[i], i));
            continue;
        }
        is_gone[i] = true;
        gone.push(points[i]);
        for (near, d) in neighbours[i].iter().filter(|(near, _)| !is_gone[*near]) {
            crowd[*near] -= weight(*d);
        }
    }
    let kept = points.iter().zip(&is_gone).filter(|(_, is_gone)| !**is_gone).map(|(point, _)| *point).collect();
    (kept, gone)
}

/// Returns for each point the others within `reach`, with their distances.
fn neighbours(points: &[[f64; 2]], reach: f64) -> Vec<Vec<(usize, f64)>> {
    let side = ((1.0 / reach).floor() as usize).clamp(1, 256);
    let place = |at: f64| ((at * side as f64) as usize).min(side - 1);
    let mut boxes = vec![Vec::new(); side * side];
    for (i, [x, y]) in points.iter().enumerate() {
        boxes[place(*y) * side + place(*x)].push(i);
    }
    let around = |at: usize| {
        // With fewer than three boxes, a box is its own neighbour.
        let mut all: Vec<usize> = [side - 1, 0, 1].map(|by| (at + by) % side).to_vec();
        all.sort_unstable();
        all.dedup();
        all
    };
    let of = |(i, point): (usize, &[f64; 2])| {
        let (rows, columns, boxes) = (around(place(point[1])), around(place(point[0])), &boxes);
        let near = rows.iter().flat_map(|row| columns.iter().flat_map(move |column| &boxes[row * side + column]));
        near.filter(|j| **j != i).map(|j| (*j, apart(*point, points[*j]))).filter(|(_, d)| *d < reach).collect()
    };
    points.iter().enumerate().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smallest distance of points with rank below `density`, relative to the largest that this many points could have.
    fn evenness(points: &[Point], density: f64) -> f64 {
        let some: Vec<[f64; 2]> = points.iter().filter(|point| point.rank() < density).map(|point| point.at).collect();
        let most = 2.0 * (1.0 / (2.0 * 3.0_f64.sqrt() * some.len() as f64)).sqrt();
        let near = neighbours(&some, most);
        near.iter().flatten().map(|(_, d)| d / most).fold(1.0, f64::min)
    }

    #[test]
    fn points_lie_evenly_at_every_density_and_across_borders() {
        let points = Points::new();
        assert_eq!(points, Points::new(), "they are the same each time");
        let all = &points.points[..POINTS as usize];
        for density in [1.0, 0.7, 0.5, 0.3, 0.25, 0.1, 0.05] {
            let even = evenness(all, density);
            assert!(even > 0.6, "{density}: {even}");
        }
        // Planted: random points, and points whose opposite borders do not match.
        let at_random: Vec<Point> = random(POINTS as usize).into_iter().map(|at| Point { at, number: 0 }).collect();
        assert!(evenness(&at_random, 1.0) < 0.1);
        let shrunk = |point: &Point| Point { at: point.at.map(|along| 0.5 * along), ..*point };
        let shrunk: Vec<Point> = all.iter().map(shrunk).collect();
        assert!(evenness(&shrunk, 1.0) < 0.5);
    }

    #[test]
    fn blocks_have_their_points() {
        let points = Points::new();
        for level in 0..LEVELS_OF_TILE {
            let side = BLOCKS >> level;
            let mut numbers = Vec::new();
            for block in 0..side * side {
                let own = points.of_block(level, block);
                assert!(own.iter().all(|point| block_of(point.at, side) == block));
                assert!(own.is_sorted_by(|a, b| a.number < b.number));
                // Evenly spread: no block is empty or crowded.
                assert!((40..90).contains(&own.len()), "{level}: {}", own.len());
                numbers.extend(own.iter().map(|point| point.number));
            }
            numbers.sort_unstable();
            assert!(numbers.into_iter().eq(0..POINTS >> (2 * level)));
        }
    }
}
