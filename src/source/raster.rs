//! Square rasters centred on the world's origin, which pass data between the levels of the procedural world.

use rayon::prelude::*;

/// A square grid of values whose centre is the world's origin; row 0 is in the north.
#[derive(Clone, Debug)]
pub(super) struct Raster {
    /// Samples per side.
    pub(super) size: usize,
    /// Distance between neighbouring samples in metres.
    pub(super) spacing_m: f64,
    /// Row-major, `size * size`.
    pub(super) values: Vec<f32>,
}

impl Raster {
    /// Evaluates `value_at(x_east_m, y_north_m)` at every sample, rows in parallel.
    pub(super) fn from_fn(size: usize, spacing_m: f64, value_at: impl Fn(f64, f64) -> f32 + Sync) -> Self {
        let mut values = vec![0.0; size * size];
        let half_m = (size as f64 - 1.0) * 0.5 * spacing_m;
        values.par_chunks_mut(size).enumerate().for_each(|(row, line)| {
            let y_m = half_m - row as f64 * spacing_m;
            for (column, value) in line.iter_mut().enumerate() {
                *value = value_at(column as f64 * spacing_m - half_m, y_m);
            }
        });
        Self { size, spacing_m, values }
    }

    /// Returns the fractional (column, row) of a position in metres.
    pub(super) fn column_row(&self, x_m: f64, y_m: f64) -> (f64, f64) {
        let half = (self.size as f64 - 1.0) * 0.5;
        (half + x_m / self.spacing_m, half - y_m / self.spacing_m)
    }

    /// Interpolates with the cubic B-spline kernel (`sharpness` 0: smooth, never overshoots), with Catmull–Rom
    /// (`sharpness` 1: passes through the samples), or with a blend of the two; clamps at the border.
    pub(super) fn sample_cubic(&self, x_m: f64, y_m: f64, sharpness: f32) -> f32 {
        let (column, row) = self.column_row(x_m, y_m);
        let (column_0, row_0) = (column.floor(), row.floor());
        let weights_x = cubic_weights((column - column_0) as f32, sharpness);
        let weights_y = cubic_weights((row - row_0) as f32, sharpness);
        let last = self.size as i64 - 1;
        let columns: [usize; 4] = std::array::from_fn(|i| (column_0 as i64 - 1 + i as i64).clamp(0, last) as usize);
        let mut sum = 0.0;
        for (i, weight_y) in weights_y.iter().enumerate() {
            let line = (row_0 as i64 - 1 + i as i64).clamp(0, last) as usize * self.size;
            let along: f32 = columns.iter().zip(weights_x).map(|(&c, weight)| self.values[line + c] * weight).sum();
            sum += along * weight_y;
        }
        sum
    }

    /// Returns the largest of the 3 × 3 samples around a position.
    pub(super) fn max_near(&self, x_m: f64, y_m: f64) -> f32 {
        let (column, row) = self.column_row(x_m, y_m);
        let last = self.size as i64 - 1;
        let mut largest = f32::NEG_INFINITY;
        for dy in -1..=1 {
            for dx in -1..=1 {
                let c = (column.round() as i64 + dx).clamp(0, last) as usize;
                let r = (row.round() as i64 + dy).clamp(0, last) as usize;
                largest = largest.max(self.values[r * self.size + c]);
            }
        }
        largest
    }
}

fn cubic_weights(t: f32, sharpness: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    let smooth = [
        (1.0 - 3.0 * t + 3.0 * t2 - t3) / 6.0,
        (4.0 - 6.0 * t2 + 3.0 * t3) / 6.0,
        (1.0 + 3.0 * t + 3.0 * t2 - 3.0 * t3) / 6.0,
        t3 / 6.0,
    ];
    let sharp = [
        (-t + 2.0 * t2 - t3) * 0.5,
        (2.0 - 5.0 * t2 + 3.0 * t3) * 0.5,
        (t + 4.0 * t2 - 3.0 * t3) * 0.5,
        (t3 - t2) * 0.5,
    ];
    std::array::from_fn(|i| smooth[i] + (sharp[i] - smooth[i]) * sharpness)
}

/// Returns the eight neighbours as (index offset, distance in samples, width in samples of the contour piece that a
/// flow in this direction crosses). The widths are those of Quinn et al. 1991.
pub(super) fn neighbours(size: usize) -> [(isize, f32, f32); 8] {
    let n = size as isize;
    let diagonal = std::f32::consts::SQRT_2;
    [
        (-1, 1.0, 0.5),
        (1, 1.0, 0.5),
        (-n, 1.0, 0.5),
        (n, 1.0, 0.5),
        (-n - 1, diagonal, 0.354),
        (-n + 1, diagonal, 0.354),
        (n - 1, diagonal, 0.354),
        (n + 1, diagonal, 0.354),
    ]
}

/// Returns whether sample `index` is on the outermost ring.
pub(super) fn is_border(index: usize, size: usize) -> bool {
    let (row, column) = (index / size, index % size);
    row == 0 || column == 0 || row + 1 == size || column + 1 == size
}
