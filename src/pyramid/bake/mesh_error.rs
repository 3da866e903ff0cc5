//! The measured error of every mesh patch: how far its triangles are from the data.
//!
//! A patch of stride 1 is held against the surface between its own samples, at quarter steps in each valid cell; this
//! is here. A patch of stride 2^j, j ≥ 1, is held against the full-resolution heights under it: that is in `vertices`.
//! Each quad is split along the diagonal from its first sample to the one opposite.

use rayon::prelude::*;

use super::field::Field;
use super::tile_error::{LARGEST_WEIGHTS, LevelView, range_of};
use crate::pyramid::fill::is_void;
use crate::pyramid::levels::{LevelSize, Region};
use crate::pyramid::statistics::PatchStatistics;
use crate::pyramid::{PATCH_QUADS, bicubic};

/// The steps per sample at which a cell is compared with its two triangles.
const STEPS: usize = 4;

/// The patches of stride 1 in `patches` (in numbers of patches), row-major; `view` is level 0.
pub fn finest_patches(view: &LevelView<'_>, patches: Region) -> Vec<PatchStatistics> {
    let steps = Steps::new();
    let (finest, served) = (view.size, view.served);
    (0..patches.samples() as u32)
        .into_par_iter()
        .map(|patch| {
            let (px, py) = (patches.x + patch % patches.width, patches.y + patch / patches.width);
            let (x0, y0) = (px * PATCH_QUADS, py * PATCH_QUADS);
            let (x1, y1) = ((x0 + PATCH_QUADS).min(finest.width - 1), (y0 + PATCH_QUADS).min(finest.height - 1));
            let range = range_of(view, Region { x: x0, y: y0, width: x1 + 1 - x0, height: y1 + 1 - y0 });
            let mut worst = 0.0_f32;
            for row in y0..y1 {
                for column in x0..x1 {
                    let valid = |row| served.span(column, row, 2).iter().all(|&corner| !is_void(corner));
                    if valid(row) && valid(row + 1) {
                        worst = worst.max(cell_error_m(served, finest, column, row, &steps));
                    }
                }
            }
            // Near its edges the patch takes heights that are not the chunk's own, and fillings.
            let doubt_m = if certain(view, x0, y0, x1, y1) { 0.0 } else { (LARGEST_WEIGHTS + 1.0) * view.doubt_m };
            let mesh_error_m = crate::pyramid::statistics::rounded_up(f64::from(worst) + doubt_m);
            PatchStatistics { min_m: range.min_m, max_m: range.max_m, mesh_error_m, voids: range.voids() }
        })
        .collect()
}

/// Whether all heights that the surface over a patch takes are stored ones of the chunk's own tiles.
fn certain(view: &LevelView<'_>, x0: u32, y0: u32, x1: u32, y1: u32) -> bool {
    if view.doubt_m == 0.0 {
        return true;
    }
    let taken = Region { x: x0, y: y0, width: x1 + 1 - x0, height: y1 + 1 - y0 }.grown(1, view.size);
    let Region { x, y, width, height } = view.own;
    let inside = taken.x >= x && taken.y >= y && taken.x + taken.width <= x + width;
    inside
        && taken.y + taken.height <= y + height
        && (taken.y..taken.y + taken.height)
            .all(|row| view.served.span(taken.x, row, taken.width).iter().all(|height| !is_void(*height)))
}

/// The quarter steps across a cell, five of them, in as many lanes as vector units like: the others repeat the first.
const LANES: usize = 8;

/// The weights of the four samples along an axis at the quarter steps; their f32 values are exact.
pub struct Steps {
    /// By step.
    down: [[f32; 4]; STEPS + 1],
    /// By sample, then by lane.
    across: [[f32; LANES]; 4],
    /// The fraction of each lane.
    u: [f32; LANES],
}

impl Steps {
    pub fn new() -> Self {
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
pub fn cell_error_m(served: &Field, finest: LevelSize, column: u32, row: u32, steps: &Steps) -> f32 {
    let left = served.region.x;
    let columns: [usize; 4] =
        std::array::from_fn(|i| (bicubic::neighbour(column, i as u32, finest.width) - left) as usize);
    let origin = served.at(column, row);
    // Differences from the first corner, so that f32 is enough.
    let four: [[f32; 4]; 4] = std::array::from_fn(|k| {
        let line = served.row(bicubic::neighbour(row, k as u32, finest.height));
        columns.map(|x| line[x] - origin)
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
