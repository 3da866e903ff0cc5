//! A grid of points in square cells, for nearest-neighbour queries.

/// Numbered points, sorted into square cells.
pub(crate) struct Grid {
    low: [f64; 2],
    cell: f64,
    columns: usize,
    rows: usize,
    /// For each cell, the points in it and their numbers.
    cells: Vec<Vec<([f64; 2], u32)>>,
}

/// Mean number of points in a cell.
const PLACES_PER_CELL: f64 = 2.0;

impl Grid {
    /// Builds the grid. The points must be finite; their indices are their numbers.
    pub(crate) fn new(places: &[[f64; 2]]) -> Self {
        let low = places.iter().fold([f64::INFINITY; 2], |low, place| [0, 1].map(|i| low[i].min(place[i])));
        let high = places.iter().fold([f64::NEG_INFINITY; 2], |high, place| [0, 1].map(|i| high[i].max(place[i])));
        let low = if places.is_empty() { [0.0; 2] } else { low };
        let sides = [0, 1].map(|i| (high[i] - low[i]).max(1e-6));
        let wanted = (places.len() as f64 / PLACES_PER_CELL).max(1.0);
        // Long and thin sets of points also get square cells, and no more of them than wanted.
        let cell = (sides[0] * sides[1] / wanted).sqrt().max(sides[0].max(sides[1]) / wanted);
        let [columns, rows] = sides.map(|side| (side / cell) as usize + 1);
        let mut grid = Self { low, cell, columns, rows, cells: vec![Vec::new(); columns * rows] };
        for (place, number) in places.iter().zip(0..) {
            let [x, y] = grid.cell_of(*place);
            grid.cells[y * columns + x].push((*place, number));
        }
        grid
    }

    fn cell_of(&self, place: [f64; 2]) -> [usize; 2] {
        let index = |i: usize, count: usize| (((place[i] - self.low[i]) / self.cell).max(0.0) as usize).min(count - 1);
        [index(0, self.columns), index(1, self.rows)]
    }

    /// Returns the number and the distance of the nearest wanted point; among equally near ones, that with the smallest
    /// number. Points that are not wanted are removed from the searched cells.
    pub(crate) fn take_nearest(&mut self, from: [f64; 2], is_wanted: impl Fn(u32) -> bool) -> Option<(u32, f64)> {
        let mut best: Option<(f64, u32)> = None;
        for ring in 0..=self.columns.max(self.rows) {
            if best.is_some_and(|(distance, _)| distance < self.clear_of(from, ring)) {
                break;
            }
            for cell in self.ring(from, ring) {
                self.cells[cell].retain(|(_, number)| is_wanted(*number));
                for (place, number) in &self.cells[cell] {
                    let found = (distance(from, *place), *number);
                    if best.is_none_or(|best| found < best) {
                        best = Some(found);
                    }
                }
            }
        }
        best.map(|(distance, number)| (number, distance))
    }

    /// Returns up to `count` of the nearest wanted points, nearest first.
    pub(crate) fn nearest(&self, from: [f64; 2], count: usize, is_wanted: impl Fn(u32) -> bool) -> Vec<u32> {
        let mut found: Vec<(f64, u32)> = Vec::new();
        for ring in 0..=self.columns.max(self.rows) {
            if found.len() >= count && found[count - 1].0 < self.clear_of(from, ring) {
                break;
            }
            for cell in self.ring(from, ring) {
                let wanted = self.cells[cell].iter().filter(|(_, number)| is_wanted(*number));
                found.extend(wanted.map(|(place, number)| (distance(from, *place), *number)));
            }
            found.sort_by(|a, b| f64::total_cmp(&a.0, &b.0).then(a.1.cmp(&b.1)));
        }
        found.into_iter().take(count).map(|(_, number)| number).collect()
    }

    /// Returns a lower bound of the distance from `from` to all points in this ring of cells and those farther out.
    fn clear_of(&self, from: [f64; 2], ring: usize) -> f64 {
        // For a point outside the grid the distance to the grid would be added; leaving it out keeps the bound valid.
        let inside = (0..2).map(|i| {
            let at = (from[i] - self.low[i]) / self.cell;
            let own = self.cell_of(from)[i] as f64;
            (at - own).clamp(0.0, 1.0).min(1.0 - (at - own).clamp(0.0, 1.0))
        });
        (ring as f64 - 1.0 + inside.fold(1.0, f64::min)).max(0.0) * self.cell
    }

    /// Returns the cells at Chebyshev distance `ring` from the cell of a point.
    fn ring(&self, from: [f64; 2], ring: usize) -> Vec<usize> {
        let [x, y] = self.cell_of(from).map(|at| at as i64);
        let ring = ring as i64;
        let (columns, rows) = (self.columns as i64, self.rows as i64);
        let mut cells = Vec::new();
        for row in (y - ring).max(0)..=(y + ring).min(rows - 1) {
            if (row - y).abs() == ring {
                cells.extend(((x - ring).max(0)..=(x + ring).min(columns - 1)).map(|x| (row * columns + x) as usize));
            } else {
                let sides = [x - ring, x + ring].into_iter().filter(|x| (0..columns).contains(x));
                cells.extend(sides.map(|x| (row * columns + x) as usize));
            }
        }
        cells
    }
}

/// Returns the distance between two points.
pub(crate) fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (b[0] - a[0]).hypot(b[1] - a[1])
}
