//! The one surface between samples: bicubic convolution with a = −0.5 (Catmull-Rom, GDAL's `cubic`).
//!
//! A coordinate `c` counts samples along an axis: 0 is the centre of the first one (GDAL's pixel coordinate minus 0.5).
//! Among `n` samples it is in the cell `floor(c)`, clamped to `[0, n − 2]`, at the fraction `c − cell`. The fraction is
//! not clamped: coarse levels have coordinates up to half a sample beyond their outermost sample centres, where the
//! polynomial of the outermost cell is continued (so the surface stays C1). The four samples of a cell are `cell − 1
//! ..= cell + 2`, with indices clamped to the level. In f64 the surface passes through the samples exactly; away from
//! the borders it reproduces planes (and quadratics) up to rounding.
//!
//! Everything is evaluated relative to one of the samples, so that a large height above the sea costs no precision; the
//! same formula in f32 (`shaders/shared/surface.wgsl`) does so too.

/// Returns the weights of the samples −1, 0, 1, 2 at the fraction `t` of the cell between samples 0 and 1.
pub(crate) fn weights(t: f64) -> [f64; 4] {
    [
        ((-0.5 * t + 1.0) * t - 0.5) * t,
        (1.5 * t - 2.5) * t * t + 1.0,
        ((-1.5 * t + 2.0) * t + 0.5) * t,
        (0.5 * t - 0.5) * t * t,
    ]
}

/// Returns the derivatives of [`weights`] with respect to `t`, per sample spacing.
pub(crate) fn derivative_weights(t: f64) -> [f64; 4] {
    [(-1.5 * t + 2.0) * t - 0.5, (4.5 * t - 5.0) * t, (-4.5 * t + 4.0) * t + 0.5, (1.5 * t - 1.0) * t]
}

/// Returns the cell, and the fraction in it, of the coordinate `c` along an axis of `count` samples (at least 1).
pub(crate) fn cell(c: f64, count: u32) -> (u32, f64) {
    let last_cell = count.saturating_sub(2);
    // The cast saturates: negative coordinates are in cell 0. For NaN, the fraction is NaN.
    let cell = (c.floor() as u32).min(last_cell);
    (cell, c - f64::from(cell))
}

/// Upper bound of how far the surface between samples exceeds them, as a fraction of their height range.
pub(crate) const OVERSHOOT: f32 = 0.15;

/// Returns the index of neighbour `k` (0..4, meaning −1, 0, 1, 2) of `cell` along an axis of `count` samples, clamped.
pub(crate) fn neighbour(cell: u32, k: u32, count: u32) -> u32 {
    (cell + k).saturating_sub(1).min(count - 1)
}

/// Returns the height and its gradient at the fraction (`fx`, `fy`) of a cell.
///
/// `samples[row][column]` are the heights in metres of the samples −1, 0, 1, 2 around the cell, with no-data filled.
/// The result is `(h, dh/dx, dh/dy)`: metres, and metres per sample spacing along the columns and down the rows.
pub(crate) fn height_and_gradient(samples: &[[f32; 4]; 4], fx: f64, fy: f64) -> (f64, f64, f64) {
    let origin = f64::from(samples[1][1]);
    let (wx, wy) = (weights(fx), weights(fy));
    let (dx, dy) = (derivative_weights(fx), derivative_weights(fy));
    let mut above_origin = 0.0;
    let mut slope_x = 0.0;
    let mut slope_y = 0.0;
    for (row, (wy, dy)) in samples.iter().zip(wy.iter().zip(dy)) {
        let mut row_height = 0.0;
        let mut row_slope = 0.0;
        for (sample, (wx, dx)) in row.iter().zip(wx.iter().zip(dx)) {
            let difference = f64::from(*sample) - origin;
            row_height += wx * difference;
            row_slope += dx * difference;
        }
        above_origin += wy * row_height;
        slope_x += wy * row_slope;
        slope_y += dy * row_height;
    }
    (origin + above_origin, slope_x, slope_y)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surface(heights: &[f32], width: u32, height: u32, x: f64, y: f64) -> (f64, f64, f64) {
        let (cx, fx) = cell(x, width);
        let (cy, fy) = cell(y, height);
        let mut samples = [[0.0; 4]; 4];
        for (k, row) in samples.iter_mut().enumerate() {
            for (i, sample) in row.iter_mut().enumerate() {
                let (column, row) = (neighbour(cx, i as u32, width), neighbour(cy, k as u32, height));
                *sample = heights[(row * width + column) as usize];
            }
        }
        height_and_gradient(&samples, fx, fy)
    }

    fn rough(width: u32, height: u32) -> Vec<f32> {
        (0..width * height).map(|i| 4000.0 + ((i * 2_654_435_761_u32) >> 20) as f32 * 0.37).collect()
    }

    #[test]
    fn passes_through_samples_exactly() {
        let (width, height) = (9, 7);
        let heights = rough(width, height);
        for row in 0..height {
            for column in 0..width {
                let (h, _, _) = surface(&heights, width, height, column.into(), row.into());
                assert_eq!(h, f64::from(heights[(row * width + column) as usize]));
            }
        }
    }

    #[test]
    fn reproduces_planes() {
        let (width, height) = (9, 8);
        let plane = |x: f64, y: f64| 1000.0 + 3.0 * x - 0.5 * y;
        let heights: Vec<f32> =
            (0..width * height).map(|i| plane(f64::from(i % width), f64::from(i / width)) as f32).collect();
        for i in 0..50 {
            let (x, y) = (1.0 + 0.11 * f64::from(i), 1.0 + 0.09 * f64::from(i));
            let (h, dx, dy) = surface(&heights, width, height, x, y);
            assert!((h - plane(x, y)).abs() < 1e-9 && (dx - 3.0).abs() < 1e-9 && (dy + 0.5).abs() < 1e-9);
        }
    }

    #[test]
    fn is_continuous_with_its_gradient_across_cells() {
        let (width, height) = (9, 7);
        let heights = rough(width, height);
        let near = 1e-7;
        for step in 0..40 {
            let y = 0.15 * f64::from(step);
            for column in 0..width {
                let x = f64::from(column);
                let before = surface(&heights, width, height, x - near, y);
                let after = surface(&heights, width, height, x + near, y);
                for (a, b) in [(before.0, after.0), (before.1, after.1), (before.2, after.2)] {
                    assert!((a - b).abs() < 0.02, "{a} and {b} at {x}, {y}");
                }
            }
        }
    }

    #[test]
    fn the_gradient_is_the_derivative() {
        let (width, height) = (9, 7);
        let heights = rough(width, height);
        let step = 1e-5;
        for i in 0..60 {
            let (x, y) = (0.013 + 0.13 * f64::from(i), 0.017 + 0.09 * f64::from(i));
            let at = |x, y| surface(&heights, width, height, x, y).0;
            let (_, dx, dy) = surface(&heights, width, height, x, y);
            assert!((dx - (at(x + step, y) - at(x - step, y)) / (2.0 * step)).abs() < 1e-2);
            assert!((dy - (at(x, y + step) - at(x, y - step)) / (2.0 * step)).abs() < 1e-2);
        }
    }
}
