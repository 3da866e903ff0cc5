//! Heights read by windows: what a bake of any size needs of a file.

use std::borrow::Borrow;

use super::georeference::Georeference;
use super::voids::Filled;
use super::{HeightGrid, SourceError};

/// A rectangle of samples inside a grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Window {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Window {
    /// Samples in all.
    pub fn samples(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Whether a sample lies in it.
    pub(crate) fn has(self, x: u32, y: u32) -> bool {
        x.wrapping_sub(self.x) < self.width && y.wrapping_sub(self.y) < self.height
    }

    /// The samples of this window of those of `around`, in which it lies.
    pub(crate) fn cut<T: Copy>(self, around: Window, samples: &[T]) -> Vec<T> {
        let mut own = Vec::with_capacity(self.samples());
        for row in self.y - around.y..self.y - around.y + self.height {
            let start = row as usize * around.width as usize + (self.x - around.x) as usize;
            own.extend_from_slice(&samples[start..start + self.width as usize]);
        }
        own
    }

    /// Sets the samples of this window in those of `around`, in which it lies.
    pub(crate) fn fill<T: Copy>(self, around: Window, samples: &mut [T], value: T) {
        for row in self.y - around.y..self.y - around.y + self.height {
            let start = row as usize * around.width as usize + (self.x - around.x) as usize;
            samples[start..start + self.width as usize].fill(value);
        }
    }
}

/// A height grid that is read a window at a time, from any thread. It may be larger than memory.
pub trait HeightReader: Send + Sync {
    /// Samples per row, and rows: at least 2 each.
    fn size(&self) -> [u32; 2];

    /// Where the samples lie.
    fn georeference(&self) -> &Georeference;

    /// The heights in metres of a window inside the grid, row-major, NaN where there is no data.
    ///
    /// # Errors
    /// A [`SourceError`] that names the file and the cause.
    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError>;

    /// What a window should begin and end at so that nothing is decoded twice: columns and rows of a block.
    fn block(&self) -> [u32; 2];

    /// The height in metres of every sample of a window, NaN for voids, where that is known without reading any: the
    /// file leaves those blocks out. `None` where the window has to be read.
    fn known_m(&self, window: Window) -> Option<f32> {
        let _ = window;
        None
    }

    /// Whether windows are to be read by one thread and from the top down, because what is decoded for one of them
    /// serves the next: rows of a stream, or parts of a strip that is too large to be decoded twice.
    fn is_serial(&self) -> bool {
        false
    }

    /// The filling of its holes, if it does that: whoever reads all of a grid reads it bare, and fills it then.
    fn filled(&self) -> Option<&Filled> {
        None
    }

    /// Everything that the heights depend on, as text: files with their sizes and times of change, and options. Two
    /// readers with one identity give the same heights.
    fn identity(&self) -> String;
}

/// A grid in memory, owned or borrowed, read by windows.
#[derive(Clone, Debug)]
pub struct GridReader<G> {
    grid: G,
    identity: String,
}

impl<G: Borrow<HeightGrid>> GridReader<G> {
    /// Of a grid that comes from what `identity` says.
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
        let grid = self.grid.borrow();
        let width = grid.width as usize;
        let mut heights_m = Vec::with_capacity(window.samples());
        for row in window.y as usize..(window.y + window.height) as usize {
            let start = row * width + window.x as usize;
            heights_m.extend_from_slice(&grid.heights_m[start..start + window.width as usize]);
        }
        Ok(heights_m)
    }

    fn block(&self) -> [u32; 2] {
        [self.grid.borrow().width, 1]
    }

    fn identity(&self) -> String {
        self.identity.clone()
    }
}
