//! An index of boxes: which of them may overlap another one.

use super::Rect;

/// Largest number of columns and rows.
const MAX_SIDE: f64 = 256.0;

/// Boxes by the cells of a regular grid.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    from_px: [f64; 2],
    cell_px: [f64; 2],
    size: [usize; 2],
    cells: Vec<Vec<(u32, Rect)>>,
}

impl Grid {
    /// Creates an index for boxes in `area`, most of which have a side of about `usual_px`. Boxes outside of the area
    /// are found as well, but more slowly.
    pub(super) fn new(area: Rect, usual_px: f64) -> Self {
        let sides_px = [0, 1].map(|axis| (area.to_px[axis] - area.from_px[axis]).max(1e-3));
        let size = sides_px.map(|side_px| (side_px / usual_px.max(1e-3)).ceil().clamp(1.0, MAX_SIDE));
        let cell_px = [sides_px[0] / size[0], sides_px[1] / size[1]];
        let size = size.map(|side| side as usize);
        Self { from_px: area.from_px, cell_px, size, cells: vec![Vec::new(); size[0] * size[1]] }
    }

    /// Adds a box with a number.
    pub(super) fn insert(&mut self, number: u32, area: Rect) {
        for cell in self.covered(&area, 0.0) {
            self.cells[cell].push((number, area));
        }
    }

    /// Removes a box with a number, which must have been added with the same corners.
    pub(super) fn remove(&mut self, number: u32, area: Rect) {
        for cell in self.covered(&area, 0.0) {
            self.cells[cell].retain(|(other, _)| *other != number);
        }
    }

    /// Returns whether any box for which `matters` holds is closer than a gap to an area.
    pub(super) fn is_occupied(&self, area: &Rect, gap_px: f64, matters: impl Fn(u32) -> bool) -> bool {
        self.covered(area, gap_px)
            .any(|cell| self.cells[cell].iter().any(|(number, other)| area.overlaps(other, gap_px) && matters(*number)))
    }

    /// Collects the numbers of all boxes that are closer than a gap to an area, in ascending order.
    pub(super) fn find(&self, area: &Rect, gap_px: f64, found: &mut Vec<u32>) {
        found.clear();
        for cell in self.covered(area, gap_px) {
            let overlapping = self.cells[cell].iter().filter(|(_, other)| area.overlaps(other, gap_px));
            found.extend(overlapping.map(|(number, _)| *number));
        }
        found.sort_unstable();
        found.dedup();
    }

    /// Returns the cells that an area covers after it has grown by a gap.
    fn covered(&self, area: &Rect, gap_px: f64) -> impl Iterator<Item = usize> + use<> {
        // Conversions saturate: boxes outside of the grid are in the cells at its border.
        let cell = |axis: usize, at_px: f64| {
            let cell = ((at_px - self.from_px[axis]) / self.cell_px[axis]).floor();
            (cell.max(0.0) as usize).min(self.size[axis] - 1)
        };
        let [columns, rows] =
            [0, 1].map(|axis| cell(axis, area.from_px[axis] - gap_px)..=cell(axis, area.to_px[axis] + gap_px));
        let width = self.size[0];
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
    }
}
