//! Computes the statistics by brute force from their definitions, using only the library's stored tiles.

use hachure::pyramid::{Pyramid, TileAddress};
use hachure::source::HeightGrid;

/// A level composed of the tiles that the pyramid returns.
pub(crate) struct Level {
    pub width: usize,
    pub height: usize,
    pub samples: Vec<f32>,
}

impl Level {
    pub(crate) fn read(pyramid: &Pyramid, level: u32) -> Self {
        let size = pyramid.levels()[level as usize];
        let (width, height) = (size.width as usize, size.height as usize);
        let mut samples = vec![0.0; width * height];
        for y in 0..height.div_ceil(256) {
            for x in 0..width.div_ceil(256) {
                let tile = pyramid.read_tile(TileAddress { level, x: x as u32, y: y as u32 }).unwrap();
                for row in 0..256.min(height - y * 256) {
                    for column in 0..256.min(width - x * 256) {
                        samples[(y * 256 + row) * width + x * 256 + column] =
                            tile.samples[(row + 2) * 260 + column + 2];
                    }
                }
            }
        }
        Self { width, height, samples }
    }

    pub(crate) fn at(&self, column: isize, row: isize) -> f64 {
        let column = column.clamp(0, self.width as isize - 1) as usize;
        let row = row.clamp(0, self.height as isize - 1) as usize;
        self.samples[row * self.width + column].into()
    }

    pub(crate) fn void(&self, column: usize, row: usize) -> bool {
        self.samples[row * self.width + column].to_bits() & 1 == 1
    }

    /// Evaluates Catmull-Rom by Keys' kernel of distances, which is another method than the library's.
    pub(crate) fn surface(&self, x: f64, y: f64) -> f64 {
        let kernel = |t: f64| {
            let t = t.abs();
            if t <= 1.0 { 1.5 * t.powi(3) - 2.5 * t * t + 1.0 } else { -0.5 * t.powi(3) + 2.5 * t * t - 4.0 * t + 2.0 }
        };
        let cell = |c: f64, count: usize| (c.floor() as isize).clamp(0, (count as isize - 2).max(0));
        let (cx, cy) = (cell(x, self.width), cell(y, self.height));
        // Beyond the outermost samples the polynomial is extrapolated, which the kernel does not do, so the Hermite
        // form is used there.
        let (fx, fy) = (x - cx as f64, y - cy as f64);
        if (0.0..=1.0).contains(&fx) && (0.0..=1.0).contains(&fy) {
            let mut sum = 0.0;
            for j in -1..3 {
                for i in -1..3 {
                    sum += kernel(fx - i as f64) * kernel(fy - j as f64) * self.at(cx + i, cy + j);
                }
            }
            return sum;
        }
        let hermite = |p: [f64; 4], t: f64| {
            let (m0, m1) = ((p[2] - p[0]) / 2.0, (p[3] - p[1]) / 2.0);
            let (t2, t3) = (t * t, t * t * t);
            (2.0 * t3 - 3.0 * t2 + 1.0) * p[1]
                + (t3 - 2.0 * t2 + t) * m0
                + (3.0 * t2 - 2.0 * t3) * p[2]
                + (t3 - t2) * m1
        };
        let row = |j: isize| hermite([-1, 0, 1, 2].map(|i| self.at(cx + i, cy + j)), fx);
        hermite([-1, 0, 1, 2].map(row), fy)
    }
}

/// Returns for every tile of a level the largest |H(f) − h(f)|, not yet raised to that of its children.
pub(crate) fn tile_errors_m(grid: &HeightGrid, level: &Level) -> Vec<f64> {
    let tiles_x = level.width.div_ceil(256);
    let mut errors_m = vec![0.0_f64; tiles_x * level.height.div_ceil(256)];
    for row in 0..grid.height as usize {
        for column in 0..grid.width as usize {
            let height = grid.heights_m[row * grid.width as usize + column];
            if height.is_nan() {
                continue;
            }
            let x = (column as f64 + 0.5) * level.width as f64 / f64::from(grid.width) - 0.5;
            let y = (row as f64 + 0.5) * level.height as f64 / f64::from(grid.height) - 0.5;
            let error = (level.surface(x, y) - f64::from(height)).abs();
            let tile = ((y + 0.5) / 256.0) as usize * tiles_x + ((x + 0.5) / 256.0) as usize;
            errors_m[tile] = errors_m[tile].max(error);
        }
    }
    errors_m
}

/// Returns the largest distance between the patch's triangles and the data, not yet raised to that of its children. It
/// searches both triangles of the quad that contains the point, by barycentric weights.
pub(crate) fn mesh_error_m(grid: &HeightGrid, finest: &Level, j: u32, px: usize, py: usize) -> f64 {
    let (width, height) = (finest.width, finest.height);
    let stride = 1_usize << j;
    let vertex = |x: usize, y: usize| {
        let h = grid.heights_m[y * width + x];
        if j > 0 && !h.is_nan() { f64::from(h) } else { finest.at(x as isize, y as isize) }
    };
    let mut worst = 0.0_f64;
    for k in 0..16 {
        for i in 0..16 {
            let x0 = ((px * 16 + i) * stride).min(width - 1);
            let x1 = ((px * 16 + i + 1) * stride).min(width - 1);
            let y0 = ((py * 16 + k) * stride).min(height - 1);
            let y1 = ((py * 16 + k + 1) * stride).min(height - 1);
            if x0 == x1 || y0 == y1 {
                continue;
            }
            let corners = [(x0, y0), (x1, y0), (x0, y1), (x1, y1)];
            let h = corners.map(|(x, y)| vertex(x, y));
            let flat = |x: f64, y: f64| {
                let u = (x - x0 as f64) / (x1 - x0) as f64;
                let v = (y - y0 as f64) / (y1 - y0) as f64;
                // Barycentric weights of (first, right, opposite), otherwise of (first, down, opposite).
                let (a, b, c) = (1.0 - u, u - v, v);
                if b >= 0.0 { a * h[0] + b * h[1] + c * h[3] } else { (1.0 - v) * h[0] + (v - u) * h[2] + u * h[3] }
            };
            if j == 0 {
                if corners.iter().any(|&(x, y)| finest.void(x, y)) {
                    continue;
                }
                for (v, u) in (0..=4).flat_map(|v| (0..=4).map(move |u| (v, u))) {
                    let (x, y) = (x0 as f64 + f64::from(u) / 4.0, y0 as f64 + f64::from(v) / 4.0);
                    worst = worst.max((finest.surface(x, y) - flat(x, y)).abs());
                }
            } else {
                for (y, x) in (y0..=y1).flat_map(|y| (x0..=x1).map(move |x| (y, x))) {
                    let h = grid.heights_m[y * width + x];
                    if !h.is_nan() {
                        worst = worst.max((f64::from(h) - flat(x as f64, y as f64)).abs());
                    }
                }
            }
        }
    }
    worst
}
