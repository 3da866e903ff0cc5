//! The measured error of every mesh patch: how far its triangles are from the data.
//!
//! A patch of stride 1 is held against the surface between its own samples, at quarter steps in each valid cell;
//! a patch of stride 2^j, j ≥ 1, against the full-resolution heights under it. Each quad is split along the diagonal
//! from its first sample to the one opposite. Vertices are the original heights; void ones have the filled height
//! that tiles serve.

use rayon::prelude::*;

use super::fill::is_void;
use super::levels::LevelSize;
use super::statistics::{PatchStatistics, Range, patch_counts, patch_levels, raise_to_children, rounded_up};
use super::{PATCH_QUADS, bicubic};

/// The steps per sample at which a cell is compared with its two triangles.
const STEPS: usize = 4;

/// The statistics of all patches, by stride and then row-major. `heights_m` is the grid (NaN for voids), `served` its
/// level 0 as tiles serve it.
pub fn patch_statistics(heights_m: &[f32], served: &[f32], finest: LevelSize) -> Vec<Vec<PatchStatistics>> {
    let mut all: Vec<Vec<PatchStatistics>> = vec![finest_patches(served, finest)];
    for j in 1..patch_levels(finest) {
        let children = &all[j as usize - 1];
        let (count, child_count) = (patch_counts(finest, j), patch_counts(finest, j - 1));
        let mut errors_m = coarse_errors_m(heights_m, served, finest, j);
        let child_errors_m: Vec<f32> = children.iter().map(|child| child.mesh_error_m).collect();
        raise_to_children(&mut errors_m, count, &child_errors_m, child_count);
        let patches = errors_m.into_iter().enumerate().map(|(i, mesh_error_m)| {
            let (x, y) = (i as u32 % count.0, i as u32 / count.0);
            let mut patch: Option<PatchStatistics> = None;
            for child_y in 2 * y..(2 * y + 2).min(child_count.1) {
                for child_x in 2 * x..(2 * x + 2).min(child_count.0) {
                    let child = children[child_y as usize * child_count.0 as usize + child_x as usize];
                    patch = Some(patch.map_or(child, |patch| PatchStatistics {
                        min_m: patch.min_m.min(child.min_m),
                        max_m: patch.max_m.max(child.max_m),
                        voids: patch.voids.union(child.voids),
                        ..patch
                    }));
                }
            }
            let patch = patch.expect("a patch exists only over a child, by the rounding up of both counts");
            PatchStatistics { mesh_error_m, ..patch }
        });
        all.push(patches.collect());
    }
    all
}

/// The patches of stride 1.
fn finest_patches(served: &[f32], finest: LevelSize) -> Vec<PatchStatistics> {
    let (count_x, count_y) = patch_counts(finest, 0);
    let width = finest.width as usize;
    let steps = Steps::new();
    (0..count_x * count_y)
        .into_par_iter()
        .map(|patch| {
            let (x0, y0) = (patch % count_x * PATCH_QUADS, patch / count_x * PATCH_QUADS);
            let (x1, y1) = ((x0 + PATCH_QUADS).min(finest.width - 1), (y0 + PATCH_QUADS).min(finest.height - 1));
            let mut range = Range::EMPTY;
            for row in y0..=y1 {
                let start = row as usize * width;
                range.add(&served[start + x0 as usize..=start + x1 as usize]);
            }
            let mut worst = 0.0_f32;
            for row in y0..y1 {
                for column in x0..x1 {
                    let corner = row as usize * width + column as usize;
                    let corners = [corner, corner + 1, corner + width, corner + width + 1];
                    if corners.iter().all(|&corner| !is_void(served[corner])) {
                        worst = worst.max(cell_error_m(served, finest, column, row, &steps));
                    }
                }
            }
            PatchStatistics { min_m: range.min_m, max_m: range.max_m, mesh_error_m: worst, voids: range.voids() }
        })
        .collect()
}

/// The quarter steps across a cell, five of them, in as many lanes as vector units like: the others repeat the first.
const LANES: usize = 8;

/// The weights of the four samples along an axis at the quarter steps; their f32 values are exact.
pub(super) struct Steps {
    /// By step.
    down: [[f32; 4]; STEPS + 1],
    /// By sample, then by lane.
    across: [[f32; LANES]; 4],
    /// The fraction of each lane.
    u: [f32; LANES],
}

impl Steps {
    pub(super) fn new() -> Self {
        let weights = |step: usize| bicubic::weights(step as f64 / STEPS as f64).map(|weight| weight as f32);
        let step = |lane: usize| if lane <= STEPS { lane } else { 0 };
        Self {
            down: std::array::from_fn(weights),
            across: std::array::from_fn(|i| std::array::from_fn(|lane| weights(step(lane))[i])),
            u: std::array::from_fn(|lane| step(lane) as f32 / STEPS as f32),
        }
    }
}

/// The largest difference in metres between the bicubic surface in a cell and the cell's two triangles.
pub(super) fn cell_error_m(served: &[f32], finest: LevelSize, column: u32, row: u32, steps: &Steps) -> f32 {
    let origin = served[row as usize * finest.width as usize + column as usize];
    // Differences from the first corner, so that f32 is enough.
    let four: [[f32; 4]; 4] = std::array::from_fn(|k| {
        let start = bicubic::neighbour(row, k as u32, finest.height) as usize * finest.width as usize;
        std::array::from_fn(|i| served[start + bicubic::neighbour(column, i as u32, finest.width) as usize] - origin)
    });
    let (right, down, opposite) = (four[1][2], four[2][1], four[2][2]);
    let mut worst = [0.0_f32; LANES];
    for (step, weights) in steps.down.iter().enumerate() {
        let v = step as f32 / STEPS as f32;
        let mut columns = [0.0_f32; 4];
        for (samples, weight) in four.iter().zip(weights) {
            for (column, sample) in columns.iter_mut().zip(samples) {
                *column += weight * sample;
            }
        }
        let mut surface = [0.0_f32; LANES];
        for (column, weights) in columns.iter().zip(&steps.across) {
            for (surface, weight) in surface.iter_mut().zip(weights) {
                *surface += column * weight;
            }
        }
        for ((worst, surface), &u) in worst.iter_mut().zip(surface).zip(&steps.u) {
            let upper = u * right + v * (opposite - right);
            let lower = v * down + u * (opposite - down);
            let error = (surface - if u >= v { upper } else { lower }).abs();
            *worst = if error > *worst { error } else { *worst };
        }
    }
    worst.into_iter().fold(0.0, f32::max)
}

/// For every patch of stride 2^`j`, row-major, the largest |h(f) − triangle(f)| in metres over its valid samples f.
fn coarse_errors_m(heights_m: &[f32], served: &[f32], finest: LevelSize, j: u32) -> Vec<f32> {
    let (count_x, count_y) = patch_counts(finest, j);
    let stride = 1_u64 << j;
    let width = finest.width as usize;
    let clamped = |quad: u64, samples: u32| (quad * stride).min(u64::from(samples) - 1) as usize;
    let vertex = |x: usize, y: usize| {
        let height = heights_m[y * width + x];
        f64::from(if height.is_nan() { served[y * width + x] } else { height })
    };
    let quads = |count: u32, samples: u32| {
        (u64::from(count) * u64::from(PATCH_QUADS)).min((u64::from(samples) - 1).div_ceil(stride))
    };
    let (quads_x, quads_y) = (quads(count_x, finest.width), quads(count_y, finest.height));
    let rows: Vec<Vec<f64>> = (0..quads_y)
        .into_par_iter()
        .map(|quad_y| {
            let (top, bottom) = (clamped(quad_y, finest.height), clamped(quad_y + 1, finest.height));
            let mut errors_m = vec![0.0; count_x as usize];
            for quad_x in 0..quads_x {
                let (left, right) = (clamped(quad_x, finest.width), clamped(quad_x + 1, finest.width));
                let corners = [vertex(left, top), vertex(right, top), vertex(left, bottom), vertex(right, bottom)];
                let worst: &mut f64 = &mut errors_m[(quad_x / u64::from(PATCH_QUADS)) as usize];
                let rows = heights_m[top * width..(bottom + 1) * width].chunks_exact(width);
                for (y, row) in rows.enumerate() {
                    let v = y as f64 / (bottom - top) as f64;
                    *worst = worst.max(row_error_m(&row[left..=right], corners, v));
                }
            }
            errors_m
        })
        .collect();
    let mut errors_m = vec![0.0; count_x as usize * count_y as usize];
    for (quad_y, row) in rows.into_iter().enumerate() {
        let patches = &mut errors_m[quad_y / PATCH_QUADS as usize * count_x as usize..];
        for (worst, error) in patches.iter_mut().zip(row) {
            *worst = rounded_up(error).max(*worst);
        }
    }
    errors_m
}

/// The largest difference between the heights of a row across a quad (both ends included) and the quad's triangles,
/// at the fraction `v` down the quad.
fn row_error_m(heights_m: &[f32], [first, right, down, opposite]: [f64; 4], v: f64) -> f64 {
    let last = (heights_m.len() - 1) as f64;
    let mut worst = 0.0_f64;
    for (x, height) in heights_m.iter().enumerate() {
        let u = x as f64 / last;
        let flat = if u >= v {
            first + u * (right - first) + v * (opposite - right)
        } else {
            first + v * (down - first) + u * (opposite - down)
        };
        // A void's NaN is lost here: f64::max takes the other operand.
        worst = worst.max((f64::from(*height) - flat).abs());
    }
    worst
}
