//! The distance between the two triangles of a quad and the bicubic surface between its corners.
//!
//! A mesh of stride 1 has a quad on every cell of four samples. Baking measures its patches with this, and stores
//! without measured errors estimate theirs with it. Each quad is split along the diagonal from its first sample to the
//! opposite one.

use super::bicubic;
use crate::pyramid::tile::PATCH_QUADS;

/// Number of steps per sample at which a cell is compared with its two triangles.
const STEPS: usize = 4;

/// Number of cells that are processed together.
pub(crate) const ROW_CELLS: usize = PATCH_QUADS as usize;
/// Number of samples of a row that these cells depend on: one before, two after.
pub(crate) const ROW_SAMPLES: usize = ROW_CELLS + 3;

/// The weights of the four samples along an axis at the steps; exact in f32.
pub(crate) struct Steps {
    down: Vec<(f32, [f32; 4])>,
    across: Vec<(f32, [f32; 4])>,
}

impl Steps {
    /// Returns all quarters of a cell, both ways: for measuring.
    pub(crate) fn new() -> Self {
        let weights = |step: usize| bicubic::weights(step as f64 / STEPS as f64).map(|weight| weight as f32);
        let steps: Vec<_> = (0..=STEPS).map(|step| (step as f32 / STEPS as f32, weights(step))).collect();
        Self { down: steps.clone(), across: steps }
    }

    /// Returns only the steps along the upper side and the middle of a cell: for estimates.
    pub(crate) fn few() -> Self {
        let mut steps = Self::new();
        steps.down.retain(|(v, _)| *v == 0.0 || *v == 0.5);
        steps
    }
}

/// For the cells of a row, returns the largest difference in metres between the bicubic surface in the cell and the
/// cell's two triangles. `rows` are the samples of the row before the cells, of the cells' upper and lower corners, and
/// of the row after; each begins one sample before the first cell.
pub(crate) fn row_errors_m(rows: [&[f32; ROW_SAMPLES]; 4], steps: &Steps) -> [f32; ROW_CELLS] {
    // Differences from the first corner, so that f32 is precise enough.
    let origin = rows[1][1];
    let rows = rows.map(|row| row.map(|sample| sample - origin));
    let mut worst = [0.0_f32; ROW_CELLS];
    for &(v, weights) in &steps.down {
        let line: [f32; ROW_SAMPLES] = std::array::from_fn(|i| {
            weights[0] * rows[0][i] + weights[1] * rows[1][i] + weights[2] * rows[2][i] + weights[3] * rows[3][i]
        });
        for &(u, weights) in &steps.across {
            for (i, worst) in worst.iter_mut().enumerate() {
                let surface = weights[0] * line[i]
                    + weights[1] * line[i + 1]
                    + weights[2] * line[i + 2]
                    + weights[3] * line[i + 3];
                let (first, opposite) = (rows[1][i + 1], rows[2][i + 2]);
                let adjacent = if u >= v { rows[1][i + 2] } else { rows[2][i + 1] };
                let flat = first + u.max(v) * (adjacent - first) + u.min(v) * (opposite - adjacent);
                let error = (surface - flat).abs();
                *worst = if error > *worst { error } else { *worst };
            }
        }
    }
    worst
}
