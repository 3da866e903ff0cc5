//! The grid that the tests write in all formats.

/// A grid of heights in whole metres, in rows from the north.
#[derive(Clone)]
pub(crate) struct Dem {
    pub width: usize,
    pub height: usize,
    /// Heights in metres; -32768 is no-data.
    pub heights: Vec<i16>,
}

impl Dem {
    /// Returns waves from below sea level to high mountains, different in every row and column; `voids` of every
    /// hundred samples are no-data.
    pub(crate) fn new(width: usize, height: usize, voids: usize) -> Self {
        let heights = (0..width * height).map(|index| {
            let (column, row) = ((index % width) as f64, (index / width) as f64);
            if (index * 7919) % 100 < voids {
                return i16::MIN;
            }
            (1200.0 + 1300.0 * (column * 0.11).sin() + 900.0 * (row * 0.07 + column * 0.01).cos()) as i16
        });
        Self { width, height, heights: heights.collect() }
    }

    pub(crate) fn at(&self, column: usize, row: usize) -> i16 {
        self.heights[row * self.width + column]
    }

    /// Returns the heights in metres, with NaN for no-data.
    pub(crate) fn expected(&self) -> Vec<f32> {
        self.heights.iter().map(|&it| if it == i16::MIN { f32::NAN } else { f32::from(it) }).collect()
    }

    pub(crate) fn rows(&self) -> impl DoubleEndedIterator<Item = &[i16]> {
        self.heights.chunks(self.width)
    }

    /// Raises heights to at least 1 m, for formats of unsigned samples.
    pub(crate) fn above_sea(mut self) -> Self {
        self.heights.iter_mut().filter(|it| **it != i16::MIN).for_each(|it| *it = (*it).max(1));
        self
    }
}
