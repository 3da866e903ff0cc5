//! A grid of the segments of all contour lines, for finding those in a box.

use glam::DVec2;

use super::paths::Paths;

/// Largest number of cells.
const MAX_CELLS: f64 = 4e6;

/// The segments of each cell, in one list.
pub(super) struct Segments {
    low: DVec2,
    cell_px: f64,
    columns: usize,
    rows: usize,
    /// For each cell, the index of its first entry; then the number of all entries.
    begins: Vec<u32>,
    /// The first point of a segment, and its line.
    entries: Vec<[u32; 2]>,
}

impl Segments {
    /// Sorts the segments inside of a box into cells of about `cell_px`.
    pub(super) fn new(paths: &Paths, [low, high]: [DVec2; 2], cell_px: f64) -> Self {
        let size = (high - low).max(DVec2::splat(cell_px));
        let cell_px =
            cell_px.max((size.x * size.y / MAX_CELLS).sqrt()).max(size.max_element() / MAX_CELLS.sqrt() / 8.0);
        let [columns, rows] = [size.x, size.y].map(|side| (side / cell_px) as usize + 1);
        let mut grid = Self { low, cell_px, columns, rows, begins: vec![0; columns * rows + 1], entries: Vec::new() };
        let mut counts = vec![0_u32; columns * rows];
        for (point, _) in paths.segments() {
            grid.cells(paths.segment(point), |cell| counts[cell] += 1);
        }
        let mut sum = 0;
        for (begin, count) in grid.begins.iter_mut().skip(1).zip(&counts) {
            sum += count;
            *begin = sum;
        }
        counts.copy_from_slice(&grid.begins[..columns * rows]);
        let mut entries = vec![[0; 2]; sum as usize];
        for (point, line) in paths.segments() {
            grid.cells(paths.segment(point), |cell| {
                entries[counts[cell] as usize] = [point as u32, line as u32];
                counts[cell] += 1;
            });
        }
        grid.entries = entries;
        grid
    }

    /// Calls `f` with the cells that a segment may cross.
    fn cells(&self, [a, b]: [DVec2; 2], mut f: impl FnMut(usize)) {
        let [a, b] = [(a - self.low) / self.cell_px, (b - self.low) / self.cell_px];
        let [a, b] = if a.y <= b.y { [a, b] } else { [b, a] };
        let [columns, rows] = [self.columns as f64, self.rows as f64];
        if b.y < 0.0 || a.y >= rows || a.x.max(b.x) < 0.0 || a.x.min(b.x) >= columns {
            return;
        }
        let [first, last] = [a.y.max(0.0) as usize, b.y.min(rows - 1.0) as usize];
        let slope = (b.x - a.x) / (b.y - a.y);
        for row in first..=last {
            // The part of the segment in this row.
            let [mut from, mut to] = [a.x, b.x];
            if first != last {
                from = if row as f64 > a.y { a.x + slope * (row as f64 - a.y) } else { a.x };
                to = if row as f64 + 1.0 < b.y { a.x + slope * (row as f64 + 1.0 - a.y) } else { b.x };
            }
            let [left, right] = [from.min(to), from.max(to)];
            if right < 0.0 || left >= columns {
                continue;
            }
            for column in left.max(0.0) as usize..=right.min(columns - 1.0) as usize {
                f(row * self.columns + column);
            }
        }
    }

    /// Calls `f` with the first point and the line of each segment that may touch a box, until it returns `false`; with
    /// some segments repeatedly.
    pub(super) fn visit(&self, [low, high]: [DVec2; 2], mut f: impl FnMut(usize, usize) -> bool) {
        let [low, high] = [(low - self.low) / self.cell_px, (high - self.low) / self.cell_px];
        let [columns, rows] = [self.columns as f64, self.rows as f64];
        if !(high.x >= 0.0 && high.y >= 0.0 && low.x < columns && low.y < rows) {
            return;
        }
        let [left, right] = [low.x.max(0.0) as usize, high.x.min(columns - 1.0) as usize];
        for row in low.y.max(0.0) as usize..=high.y.min(rows - 1.0) as usize {
            let [first, last] = [left, right + 1].map(|column| self.begins[row * self.columns + column] as usize);
            for [point, line] in &self.entries[first..last] {
                if !f(*point as usize, *line as usize) {
                    return;
                }
            }
        }
    }
}
