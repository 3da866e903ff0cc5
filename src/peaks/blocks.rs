//! Maximum heights of square blocks of samples, and of blocks of blocks.

/// Largest number of blocks of the finest level.
const MOST_BLOCKS: usize = 1 << 22;

/// A pyramid of maxima, finest level first. The last level has one block.
pub(super) struct Blocks {
    /// Samples along a side of a block of the finest level.
    pub side: usize,
    /// Number of columns and rows of the DEM.
    pub size: [usize; 2],
    pub levels: Vec<Level>,
}

/// One level of the pyramid.
pub(super) struct Level {
    /// Number of columns and rows of blocks.
    pub size: [usize; 2],
    /// Maximum height of each block in metres; NaN if it has no data.
    pub highest_m: Vec<f32>,
}

impl Level {
    fn new(size: [usize; 2]) -> Self {
        Self { size, highest_m: vec![f32::NAN; size[0] * size[1]] }
    }

    /// Takes the maximum of a block's height and another one.
    fn raise(&mut self, block: [usize; 2], height_m: f32) {
        let highest_m = &mut self.highest_m[block[1] * self.size[0] + block[0]];
        // The maximum of NaN and a number is the number.
        *highest_m = highest_m.max(height_m);
    }
}

impl Blocks {
    /// Creates the pyramid of a DEM without data. The blocks are larger than `least_side` if there would be too many.
    pub(super) fn new(size: [usize; 2], least_side: usize) -> Self {
        let mut side = least_side.max(1);
        let count = |side: usize| size.map(|samples| samples.div_ceil(side));
        while count(side)[0].saturating_mul(count(side)[1]) > MOST_BLOCKS {
            side *= 2;
        }
        Self { side, size, levels: vec![Level::new(count(side))] }
    }

    /// Adds a row of heights in metres, from a column on. Columns beyond the last one start again at the first.
    pub(super) fn add_row(&mut self, first: [usize; 2], heights_m: &[f32]) {
        let [columns, _] = self.size;
        let (mut column, mut rest) = (first[0] % columns, heights_m);
        while !rest.is_empty() {
            let end = ((column / self.side + 1) * self.side).min(columns);
            let (some, others) = rest.split_at(rest.len().min(end - column));
            let highest_m = some.iter().copied().fold(f32::NAN, f32::max);
            self.levels[0].raise([column / self.side, first[1] / self.side], highest_m);
            (column, rest) = (end % columns, others);
        }
    }

    /// Computes the coarser levels, once all rows have been added.
    pub(super) fn finish(&mut self) {
        while let Some(fine) = self.levels.last().filter(|level| level.size != [1, 1]) {
            let mut coarse = Level::new(fine.size.map(|blocks| blocks.div_ceil(2)));
            for (at, highest_m) in fine.highest_m.iter().enumerate() {
                coarse.raise([at % fine.size[0] / 2, at / fine.size[0] / 2], *highest_m);
            }
            self.levels.push(coarse);
        }
    }

    /// Returns the first and the last column, and the first and the last row of a block.
    pub(super) fn bounds(&self, level: usize, block: [usize; 2]) -> [[usize; 2]; 2] {
        let side = self.side << level;
        let range = |axis: usize| [block[axis] * side, ((block[axis] + 1) * side).min(self.size[axis]) - 1];
        [range(0), range(1)]
    }
}
