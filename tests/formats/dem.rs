//! The grid that all formats are to hold.

/// Whole metres, by rows from the north.
#[derive(Clone)]
pub struct Dem {
    pub width: usize,
    pub height: usize,
    /// -32768 where there is no data.
    pub heights: Vec<i16>,
}

impl Dem {
    /// Waves from below the sea to above the clouds, different in every row and column, with `voids` of every hundred
    /// samples void.
    pub fn new(width: usize, height: usize, voids: usize) -> Self {
        let heights = (0..width * height).map(|index| {
            let (column, row) = ((index % width) as f64, (index / width) as f64);
            if (index * 7919) % 100 < voids {
                return i16::MIN;
            }
            (1200.0 + 1300.0 * (column * 0.11).sin() + 900.0 * (row * 0.07 + column * 0.01).cos()) as i16
        });
        Self { width, height, heights: heights.collect() }
    }

    pub fn at(&self, column: usize, row: usize) -> i16 {
        self.heights[row * self.width + column]
    }

    /// In metres, NaN where there is no data.
    pub fn expected(&self) -> Vec<f32> {
        self.heights.iter().map(|&it| if it == i16::MIN { f32::NAN } else { f32::from(it) }).collect()
    }

    pub fn rows(&self) -> impl Iterator<Item = &[i16]> {
        self.heights.chunks(self.width)
    }

    /// With heights of at least 0, for formats of unsigned samples.
    pub fn above_sea(mut self) -> Self {
        self.heights.iter_mut().filter(|it| **it != i16::MIN).for_each(|it| *it = (*it).max(1));
        self
    }
}
