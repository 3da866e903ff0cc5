//! The surface that fills a hole: a thin plate under tension that matches the heights and the slopes around it.
//!
//! The heights of a hole are those that minimise the sum of the squared second differences along rows, columns and
//! diagonals (a thin plate: Briggs 1974, *Machine contouring using minimum curvature*), plus [`TENSION`] times the sum
//! of the squared first differences (Smith and Wessel 1990, *Gridding with continuous curvature splines in tension*).
//! The plate makes slopes meet at the rim; the tension turns it into a membrane farther inside, so that the steep or
//! noisy rim of a hole in radar data does not cause hills and wells. The two samples around the hole are given.
//! Differences that would need other samples without heights are left out.
//!
//! The equations are solved by conjugate gradients (Hestenes and Stiefel 1952). The initial guess grows from the rim
//! inwards by layers of means, in an order and with numbers that depend on the hole alone.

use std::cell::Cell;

use super::holes::Hole;
use crate::source::reader::Window;

/// Number of samples around a hole on which its surface depends.
pub(super) const RING: u32 = 2;

/// Weight of the membrane against the plate: it dominates beyond the square root of the reciprocal, 24 samples from the
/// rim.
const TENSION: f64 = 1.0 / 576.0;

/// Residual, relative to the initial one, at which the equations count as solved.
const TOLERANCE: f64 = 1e-7;
/// Largest number of iterations; a hole of the largest width needs fewer.
const MAX_STEPS: u32 = 3000;

/// Offsets in columns and rows from a sample to those that share a second difference with it.
const OFFSETS: [[i32; 2]; 13] =
    [[0, 0], [-1, 0], [1, 0], [0, -1], [0, 1], [-1, -1], [1, -1], [-1, 1], [1, 1], [-2, 0], [2, 0], [0, -2], [0, 2]];

/// Offsets from a sample, with the factor of each.
type Stencil = &'static [([i32; 2], f64)];

/// Differences that are minimised: samples with factors, and the weight of the square.
const DIFFERENCES: [(Stencil, f64); 5] = [
    (&[([0, 0], 1.0), ([1, 0], -2.0), ([2, 0], 1.0)], 1.0),
    (&[([0, 0], 1.0), ([0, 1], -2.0), ([0, 2], 1.0)], 1.0),
    (&[([0, 0], 1.0), ([1, 0], -1.0), ([0, 1], -1.0), ([1, 1], 1.0)], 2.0),
    (&[([0, 0], 1.0), ([1, 0], -1.0)], TENSION),
    (&[([0, 0], 1.0), ([0, 1], -1.0)], TENSION),
];

/// The role of a sample in or around a hole.
#[derive(Clone, Copy)]
enum Place {
    /// The sample is outside the grid or has no valid height.
    Absent,
    /// The sample's height is given, in metres relative to the mean of all given heights.
    Given(f64),
    /// The height is an unknown with this number.
    Unknown(u32),
}

/// Returns the heights in metres of a hole's samples, with their indices in the window.
pub(super) fn fill(heights_m: &[f32], spikes: &[u32], window: Window, hole: &Hole) -> Vec<(u32, f32)> {
    let box_width = (hole.width + 2 * RING) as usize;
    let mut places = vec![Place::Absent; box_width * (hole.height + 2 * RING) as usize];
    let place_of = |sample: u32| {
        let (x, y) = (sample % window.width + RING - hole.left, sample / window.width + RING - hole.top);
        y as usize * box_width + x as usize
    };
    for (number, &sample) in hole.samples.iter().enumerate() {
        places[place_of(sample)] = Place::Unknown(number as u32);
    }
    let (mut sum_m, mut count) = (0.0, 0.0);
    let right = (hole.left + hole.width + RING).min(window.width);
    let bottom = (hole.top + hole.height + RING).min(window.height);
    for y in hole.top.saturating_sub(RING)..bottom {
        for x in hole.left.saturating_sub(RING)..right {
            let index = y * window.width + x;
            let (height_m, at) = (heights_m[index as usize], place_of(index));
            let is_free = matches!(places[at], Place::Absent) && spikes.binary_search(&index).is_err();
            if is_free && height_m.is_finite() {
                places[at] = Place::Given(height_m.into());
                (sum_m, count) = (sum_m + f64::from(height_m), count + 1.0);
            }
        }
    }
    let mean_m = sum_m / count;
    for place in &mut places {
        if let Place::Given(height_m) = place {
            *height_m -= mean_m;
        }
    }
    let cells: Vec<usize> = hole.samples.iter().map(|&sample| place_of(sample)).collect();
    let start = layers(&places, box_width, &cells);
    let solved = Equations::new(&places, box_width, &cells).solve(start);
    hole.samples.iter().zip(solved).map(|(&sample, over_m)| (sample, (mean_m + over_m) as f32)).collect()
}

/// Returns an initial guess: layer by layer from the rim, each sample is the mean of its neighbours that have a height.
fn layers(places: &[Place], width: usize, cells: &[usize]) -> Vec<f64> {
    let known: Vec<Cell<Option<f64>>> = places
        .iter()
        .map(|place| Cell::new(if let Place::Given(height_m) = place { Some(*height_m) } else { None }))
        .collect();
    let mut left: Vec<usize> = cells.to_vec();
    while !left.is_empty() {
        let mut layer = Vec::new();
        left.retain(|&cell| {
            let around = OFFSETS[1..9].iter().filter_map(|offset| known[moved(cell, *offset, width)].get());
            let (sum, count) = around.fold((0.0, 0.0), |(sum, count), height| (sum + height, count + 1.0));
            if count > 0.0 {
                layer.push((cell, sum / count));
            }
            count == 0.0
        });
        if layer.is_empty() {
            break;
        }
        layer.into_iter().for_each(|(cell, height)| known[cell].set(Some(height)));
    }
    cells.iter().map(|&cell| known[cell].get().unwrap_or(0.0)).collect()
}

/// Returns the cell at an offset, which [`RING`] keeps inside.
fn moved(cell: usize, [x, y]: [i32; 2], width: usize) -> usize {
    (cell as isize + y as isize * width as isize + x as isize) as usize
}

/// The normal equations: for each unknown, the numbers of its neighbours (its own number where there is none) and their
/// factors.
struct Equations {
    neighbours: Vec<[u32; OFFSETS.len()]>,
    factors: Vec<[f64; OFFSETS.len()]>,
    right: Vec<f64>,
}

impl Equations {
    fn new(places: &[Place], width: usize, cells: &[usize]) -> Self {
        let mut factors = vec![[0.0; OFFSETS.len()]; cells.len()];
        let mut right = vec![0.0; cells.len()];
        for (number, &cell) in cells.iter().enumerate() {
            for (samples, weight) in DIFFERENCES {
                // The loop visits every difference that contains this sample.
                for (own, own_factor) in samples {
                    let place = |at: [i32; 2]| places[moved(cell, [at[0] - own[0], at[1] - own[1]], width)];
                    if samples.iter().any(|(at, _)| matches!(place(*at), Place::Absent)) {
                        continue;
                    }
                    for (at, factor) in samples {
                        let product = weight * own_factor * factor;
                        match place(*at) {
                            Place::Given(height) => right[number] -= product * height,
                            _ => {
                                let offset = [at[0] - own[0], at[1] - own[1]];
                                let slot = OFFSETS.iter().position(|known| *known == offset).unwrap_or(0);
                                factors[number][slot] += product;
                            }
                        }
                    }
                }
            }
        }
        let neighbours = cells.iter().enumerate().map(|(number, &cell)| {
            OFFSETS.map(|offset| match places[moved(cell, offset, width)] {
                Place::Unknown(there) => there,
                _ => number as u32,
            })
        });
        Self { neighbours: neighbours.collect(), factors, right }
    }

    fn times(&self, heights: &[f64], into: &mut [f64]) {
        for ((into, neighbours), factors) in into.iter_mut().zip(&self.neighbours).zip(&self.factors) {
            *into = neighbours.iter().zip(factors).map(|(&there, factor)| factor * heights[there as usize]).sum();
        }
    }

    /// Solves the equations by conjugate gradients from an initial guess.
    fn solve(&self, mut heights: Vec<f64>) -> Vec<f64> {
        let dot = |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| a * b).sum() };
        let mut product = vec![0.0; heights.len()];
        self.times(&heights, &mut product);
        let mut residual: Vec<f64> = self.right.iter().zip(&product).map(|(right, left)| right - left).collect();
        let mut direction = residual.clone();
        let mut square = dot(&residual, &residual);
        let enough = square * TOLERANCE * TOLERANCE;
        for _ in 0..MAX_STEPS {
            if square <= enough {
                break;
            }
            self.times(&direction, &mut product);
            let curvature = dot(&direction, &product);
            if curvature <= 0.0 {
                break;
            }
            let step = square / curvature;
            heights.iter_mut().zip(&direction).for_each(|(height, direction)| *height += step * direction);
            residual.iter_mut().zip(&product).for_each(|(residual, product)| *residual -= step * product);
            let next = dot(&residual, &residual);
            let turn = next / square;
            direction
                .iter_mut()
                .zip(&residual)
                .for_each(|(direction, residual)| *direction = residual + turn * *direction);
            square = next;
        }
        heights
    }
}
