//! Finds the place of the next mark: the place that is farthest from all other marks, at every distance.
//!
//! Each mark adds a hill of coverage to grids of doubling coarseness, all of the same volume; their sum falls about as
//! the square of the distance. The place with the least coverage under the whole mark is chosen: the best of many
//! candidates (Praun and others 2001 sum a pyramid of blurred tones), which then slides while that improves it (as
//! swapping in void-and-cluster: Ulichney 1993).

/// Radius of a hill, in cells.
const HILL: f32 = 5.0;

/// Grids of coverage, from fine to coarse.
pub(super) struct Evenness {
    side_px: usize,
    grids: Vec<Grid>,
}

struct Grid {
    cell_px: usize,
    cells: usize,
    coverage: Vec<f32>,
}

impl Evenness {
    /// Creates empty grids. `width_px` is the width of a mark: finer coverage does not matter.
    pub(super) fn new(side_px: usize, width_px: f32) -> Self {
        let mut grids = Vec::new();
        let mut cell_px = 1;
        while 2.0 * cell_px as f32 <= width_px {
            cell_px *= 2;
        }
        // A hill must not wrap around the tile.
        while side_px / cell_px >= 11 {
            let cells = side_px / cell_px;
            grids.push(Grid { cell_px, cells, coverage: vec![0.0; cells * cells] });
            cell_px *= 2;
        }
        Self { side_px, grids }
    }

    /// Returns the mean coverage under a mark whose points are `step_px` apart, moved by `offset`.
    pub(super) fn under(&self, points: &[[f32; 2]], step_px: f32, offset: [f32; 2]) -> f32 {
        let mut sum = 0.0;
        for grid in &self.grids {
            let stride = grid.stride(step_px);
            let (mut under, mut count) = (0.0, 0.0);
            for point in points.iter().skip(stride.min(points.len()) / 2).step_by(stride) {
                let [x, y] = [0, 1].map(|axis| {
                    ((point[axis] + offset[axis]).floor() as i64).rem_euclid(self.side_px as i64) as usize
                        / grid.cell_px
                });
                under += grid.coverage[y * grid.cells + x];
                count += 1.0;
            }
            sum += under / f32::max(count, 1.0);
        }
        sum
    }

    /// Adds a mark to the coverage.
    pub(super) fn lay(&mut self, points: &[[f32; 2]], step_px: f32, offset: [f32; 2]) {
        for grid in &mut self.grids {
            let stride = grid.stride(step_px);
            let laid: Vec<_> = points.iter().skip(stride.min(points.len()) / 2).step_by(stride).collect();
            let volume = 1.0 / (laid.len().max(1) as f32 * (grid.cell_px * grid.cell_px) as f32);
            for point in laid {
                grid.hill([point[0] + offset[0], point[1] + offset[1]], volume);
            }
        }
    }

    /// Slides a mark from `offset` to a place with less coverage, by ever shorter steps.
    pub(super) fn slide(&self, points: &[[f32; 2]], step_px: f32, mut offset: [f32; 2], first_px: f32) -> [f32; 2] {
        let mut least = self.under(points, step_px, offset);
        let mut length_px = first_px;
        while length_px >= 0.5 {
            let mut best = None;
            for [dx, dy] in [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]] {
                let moved = [offset[0] + dx * length_px, offset[1] + dy * length_px];
                let under = self.under(points, step_px, moved);
                if under < least {
                    (least, best) = (under, Some(moved));
                }
            }
            match best {
                Some(moved) => offset = moved,
                None => length_px *= 0.5,
            }
        }
        offset
    }
}

impl Grid {
    /// Returns the stride at which points are sampled: about one per cell.
    fn stride(&self, step_px: f32) -> usize {
        (1.5 * self.cell_px as f32 / step_px).round().max(1.0) as usize
    }

    fn hill(&mut self, at: [f32; 2], volume: f32) {
        let [u, v] = at.map(|place| place / self.cell_px as f32 - 0.5);
        let cells = self.cells as i64;
        let low = [u, v].map(|place| (place - HILL).ceil() as i64);
        let high = [u, v].map(|place| (place + HILL).floor() as i64);
        for y in low[1]..=high[1] {
            let row = y.rem_euclid(cells) as usize * self.cells;
            let dy = y as f32 - v;
            for x in low[0]..=high[0] {
                let dx = x as f32 - u;
                let left = 1.0 - (dx * dx + dy * dy) / (HILL * HILL);
                if left > 0.0 {
                    // Similar to a Gaussian of 2 cells.
                    self.coverage[row + x.rem_euclid(cells) as usize] += volume * left * left * left;
                }
            }
        }
    }
}
