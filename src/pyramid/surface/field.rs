//! The heights of a rectangle of a level.

use super::fill::HeightLevels;
use super::levels::{LevelSize, Region};
use crate::pyramid::error::PyramidError;

/// The heights of a region, row-major, addressed by the columns and rows of the level.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Field {
    /// The region of the level.
    pub region: Region,
    /// The heights in metres, row by row of the region; NaN for no-data.
    pub heights_m: Vec<f32>,
}

impl Field {
    /// Returns whether a sample is inside the region.
    pub(crate) fn has(&self, x: u32, y: u32) -> bool {
        let Region { x: left, y: top, width, height } = self.region;
        (left..left + width).contains(&x) && (top..top + height).contains(&y)
    }

    /// Returns a row of the region, by the row's number in the level.
    pub(crate) fn row(&self, y: u32) -> &[f32] {
        let start = (y - self.region.y) as usize * self.region.width as usize;
        &self.heights_m[start..start + self.region.width as usize]
    }

    /// Returns `count` heights of a row, from column `x` on.
    pub(crate) fn span(&self, x: u32, y: u32, count: u32) -> &[f32] {
        let first = (x - self.region.x) as usize;
        &self.row(y)[first..first + count as usize]
    }

    /// Returns the height of a sample inside the region.
    pub(crate) fn at(&self, x: u32, y: u32) -> f32 {
        self.row(y)[(x - self.region.x) as usize]
    }

    /// Copies the heights of a region inside this one.
    pub(crate) fn cut(&self, region: Region) -> Vec<f32> {
        let mut heights_m = Vec::with_capacity(region.samples());
        for y in region.y..region.y + region.height {
            heights_m.extend_from_slice(self.span(region.x, y, region.width));
        }
        heights_m
    }

    /// Replaces the heights of a region inside this one.
    pub(crate) fn paste(&mut self, region: Region, heights_m: &[f32]) {
        let (left, top, width) = (self.region.x, self.region.y, self.region.width as usize);
        for (y, row) in (region.y..).zip(heights_m.chunks_exact(region.width as usize)) {
            let start = (y - top) as usize * width + (region.x - left) as usize;
            self.heights_m[start..start + row.len()].copy_from_slice(row);
        }
    }
}

/// Several consecutive levels, each as far as its field reaches.
pub(crate) struct Fields<'a> {
    /// The sizes of the levels, finest first.
    pub sizes: &'a [LevelSize],
    /// The heights of each level, NaN for no-data.
    pub fields: &'a [&'a Field],
}

impl HeightLevels for Fields<'_> {
    fn sizes(&self) -> &[LevelSize] {
        self.sizes
    }

    fn read(&self, level: usize, region: Region) -> Result<Vec<f32>, PyramidError> {
        Ok(self.fields[level].cut(region))
    }
}
