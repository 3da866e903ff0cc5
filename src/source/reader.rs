//! The interface of all height readers: heights are read by windows, so that grids of any size can be baked.

use std::borrow::Borrow;
use std::ops::Range;

use super::georeference::Georeference;
use super::voids::Filled;
use super::{Encoding, HeightGrid, SourceError};

/// A rectangle of samples inside a grid: its first column `x` and first row `y`, and its size in columns and rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Window {
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
}

impl Window {
    /// Returns the window that is a whole grid.
    pub(crate) fn whole([width, height]: [u32; 2]) -> Self {
        Self { x: 0, y: 0, width, height }
    }

    /// Returns the number of samples.
    pub fn samples(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Returns whether a sample is inside the window.
    pub(crate) fn has(self, x: u32, y: u32) -> bool {
        x.wrapping_sub(self.x) < self.width && y.wrapping_sub(self.y) < self.height
    }

    /// Returns where the rows of this window are among the samples of `around`, which must contain it.
    pub(crate) fn rows_in(self, around: Window) -> impl Iterator<Item = Range<usize>> {
        (self.y - around.y..self.y - around.y + self.height).map(move |row| {
            let first = row as usize * around.width as usize + (self.x - around.x) as usize;
            first..first + self.width as usize
        })
    }

    /// Returns the samples of this window from those of `around`, which must contain it.
    pub(crate) fn cut<T: Copy>(self, around: Window, samples: &[T]) -> Vec<T> {
        let mut own = Vec::with_capacity(self.samples());
        self.rows_in(around).for_each(|row| own.extend_from_slice(&samples[row]));
        own
    }

    /// Sets the samples of this window within those of `around`, which must contain it.
    pub(crate) fn fill<T: Copy>(self, around: Window, samples: &mut [T], value: T) {
        self.rows_in(around).for_each(|row| samples[row].fill(value));
    }
}

/// A height grid that is read one window at a time, from any thread. It may be larger than memory.
pub trait HeightReader: Send + Sync {
    /// Returns the samples per row and the number of rows: at least 2 each.
    fn size(&self) -> [u32; 2];

    /// Returns the georeference of the samples.
    fn georeference(&self) -> &Georeference;

    /// Returns the heights in metres of a window inside the grid, row-major, NaN where there is no data.
    ///
    /// # Errors
    /// Returns a [`SourceError`] that names the file and the cause.
    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError>;

    /// Returns columns and rows of a block. Windows that begin and end at block borders decode nothing twice.
    fn block(&self) -> [u32; 2];

    /// Returns the height in metres (NaN for no-data) that all samples of a window have, if it is known without reading
    /// because the file leaves those blocks out. Returns `None` if the window must be read.
    fn known_m(&self, window: Window) -> Option<f32> {
        let _ = window;
        None
    }

    /// Returns whether windows should be read by one thread from the top down, because data decoded for one window
    /// serves the next: rows of a stream, or parts of a strip that is too large to be decoded twice.
    fn is_serial(&self) -> bool {
        false
    }

    /// Returns metres per unit of the stored heights, if the file declares a unit. The heights that
    /// [`HeightReader::read`] returns are metres all the same.
    fn declared_unit_m(&self) -> Option<f64> {
        None
    }

    /// Returns the encoding by which colours are heights, whether it was given or recognised.
    fn encoding(&self) -> Option<Encoding> {
        None
    }

    /// Returns whether the caller gave a no-data value and no sample that was read so far has it.
    fn has_unmatched_no_data(&self) -> bool {
        false
    }

    /// Returns whether samples have 8 bits or fewer. So few values are no surface, and most such files are pictures.
    fn is_coarse(&self) -> bool {
        false
    }

    /// Returns the warnings about samples that were given while windows were read, as the ends of lines that begin with
    /// the file's name. A cached pyramid repeats them. Warnings that opening gives are not among them.
    fn warnings(&self) -> Vec<String> {
        Vec::new()
    }

    /// Returns the hole filler, if the reader fills holes: code that reads a whole grid reads it unfilled and fills it
    /// at the end.
    fn filled(&self) -> Option<&Filled> {
        None
    }

    /// Returns everything that the heights depend on, as text: files with their sizes and modification times, and
    /// options. Two readers with the same identity give the same heights.
    fn identity(&self) -> String;
}

/// A grid in memory, owned or borrowed, that is read by windows.
#[derive(Clone, Debug)]
pub struct GridReader<G> {
    grid: G,
    identity: String,
}

impl<G: Borrow<HeightGrid>> GridReader<G> {
    /// Wraps a grid; `identity` describes its origin.
    pub fn new(grid: G, identity: String) -> Self {
        Self { grid, identity }
    }
}

impl<G: Borrow<HeightGrid> + Send + Sync> HeightReader for GridReader<G> {
    fn size(&self) -> [u32; 2] {
        let grid = self.grid.borrow();
        [grid.width, grid.height]
    }

    fn georeference(&self) -> &Georeference {
        &self.grid.borrow().georeference
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        Ok(window.cut(Window::whole(self.size()), &self.grid.borrow().heights_m))
    }

    fn block(&self) -> [u32; 2] {
        [self.grid.borrow().width, 1]
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }
}
