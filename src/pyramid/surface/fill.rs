//! The filling of no-data, so that surfaces can be evaluated next to it; the samples stay flagged as no-data.
//!
//! A no-data sample with valid samples within [`RADIUS`] (in rows and columns) takes their mean, weighted by
//! 1/distance⁴. That covers all no-data that affects a valid cell. The others, inside larger areas, take the filled
//! height of the coarser level at their place, bilinearly; on the coarsest level they take a constant. Every filled
//! height is thus a function of its place alone and not of the requested region: two tiles that share a sample agree on
//! its bits.
//!
//! Why: `docs/decisions/voids.md`.

use super::bicubic;
use super::levels::{LevelSize, Region, coordinate};
use crate::pyramid::error::PyramidError;
use crate::pyramid::tile::flagged;

/// Search radius of a no-data sample for valid samples of its own level, in samples.
pub(crate) const RADIUS: u32 = 4;

/// Heights of several levels, on disk or in memory.
pub(crate) trait HeightLevels: Sync {
    /// Returns the sizes of the levels, finest first.
    fn sizes(&self) -> &[LevelSize];

    /// Reads the heights in metres of a region inside the level, row-major, NaN for no-data.
    fn read(&self, level: usize, region: Region) -> Result<Vec<f32>, PyramidError>;
}

/// Reads a region inside a level as tiles serve it: row-major, no-data filled, the lowest mantissa bit 1 for no-data
/// and 0 for valid samples. `fallback_m` is the filling of no-data on the coarsest level that is far from everything.
pub(crate) fn read_filled<L: HeightLevels + ?Sized>(
    levels: &L,
    level: usize,
    region: Region,
    fallback_m: f32,
) -> Result<Vec<f32>, PyramidError> {
    let raw = levels.read(level, region)?;
    if raw.iter().all(|height| !height.is_nan()) {
        return Ok(raw.into_iter().map(|height| flagged(height, false)).collect());
    }
    let around = region.grown(RADIUS, levels.sizes()[level]);
    let neighbours = Neighbours::new(levels.read(level, around)?, around);
    let mut parent = None;
    let mut served = Vec::with_capacity(raw.len());
    for (i, height) in raw.into_iter().enumerate() {
        if !height.is_nan() {
            served.push(flagged(height, false));
            continue;
        }
        let (column, row) = (region.x + i as u32 % region.width, region.y + i as u32 / region.width);
        let filled = match neighbours.mean(column, row) {
            Some(mean) => mean,
            None if level + 1 == levels.sizes().len() => f64::from(fallback_m),
            None => {
                let parent = match &mut parent {
                    Some(parent) => parent,
                    none => none.insert(Parent::read(levels, level, region, fallback_m)?),
                };
                parent.height_m(column, row)
            }
        };
        served.push(flagged(filled as f32, true));
    }
    Ok(served)
}

/// The raw heights around a region, with the number of valid ones up to each column of a row.
struct Neighbours {
    heights_m: Vec<f32>,
    region: Region,
    valid_before: Vec<u32>,
}

impl Neighbours {
    fn new(heights_m: Vec<f32>, region: Region) -> Self {
        let mut valid_before = Vec::with_capacity((region.width as usize + 1) * region.height as usize);
        for row in heights_m.chunks_exact(region.width as usize) {
            let mut valid = 0;
            valid_before.push(valid);
            for height in row {
                valid += u32::from(!height.is_nan());
                valid_before.push(valid);
            }
        }
        Self { heights_m, region, valid_before }
    }

    /// Returns the weighted mean of the valid samples within the radius of (`column`, `row`), or `None` if there are
    /// none.
    fn mean(&self, column: u32, row: u32) -> Option<f64> {
        let width = self.region.width as usize;
        let (column, row) = (column - self.region.x, row - self.region.y);
        let left = column.saturating_sub(RADIUS) as usize;
        let right = ((column + RADIUS + 1) as usize).min(width);
        let mut sum = 0.0;
        let mut total = 0.0;
        for y in row.saturating_sub(RADIUS)..(row + RADIUS + 1).min(self.region.height) {
            let counts = y as usize * (width + 1);
            if self.valid_before[counts + right] == self.valid_before[counts + left] {
                continue;
            }
            let down = f64::from(y) - f64::from(row);
            for x in left..right {
                let height = self.heights_m[y as usize * width + x];
                if !height.is_nan() {
                    let across = x as f64 - f64::from(column);
                    let square = across * across + down * down;
                    let weight = 1.0 / (square * square);
                    sum += weight * f64::from(height);
                    total += weight;
                }
            }
        }
        (total > 0.0).then(|| sum / total)
    }
}

/// The filled heights of the coarser level over a region.
struct Parent {
    fine: LevelSize,
    coarse: LevelSize,
    region: Region,
    heights_m: Vec<f32>,
}

impl Parent {
    fn read<L: HeightLevels + ?Sized>(
        levels: &L,
        level: usize,
        region: Region,
        fallback_m: f32,
    ) -> Result<Self, PyramidError> {
        let (fine, coarse) = (levels.sizes()[level], levels.sizes()[level + 1]);
        let region = parent_region(region, fine, coarse);
        let heights_m = read_filled(levels, level + 1, region, fallback_m)?;
        Ok(Self { fine, coarse, region, heights_m })
    }

    fn height_m(&self, column: u32, row: u32) -> f64 {
        let (x, right) = coarse_cell(column, self.fine.width, self.coarse.width);
        let (y, down) = coarse_cell(row, self.fine.height, self.coarse.height);
        let at = |x: u32, y: u32| {
            let (x, y) = (x.min(self.coarse.width - 1), y.min(self.coarse.height - 1));
            let index = (y - self.region.y) * self.region.width + (x - self.region.x);
            f64::from(self.heights_m[index as usize])
        };
        let above = at(x, y) * (1.0 - right) + at(x + 1, y) * right;
        let below = at(x, y + 1) * (1.0 - right) + at(x + 1, y + 1) * right;
        above * (1.0 - down) + below * down
    }
}

/// Returns the samples of the coarser level on which the filling of a region may depend.
pub(in crate::pyramid) fn parent_region(region: Region, fine: LevelSize, coarse: LevelSize) -> Region {
    let (left, _) = coarse_cell(region.x, fine.width, coarse.width);
    let (right, _) = coarse_cell(region.x + region.width - 1, fine.width, coarse.width);
    let (top, _) = coarse_cell(region.y, fine.height, coarse.height);
    let (bottom, _) = coarse_cell(region.y + region.height - 1, fine.height, coarse.height);
    Region {
        x: left,
        y: top,
        width: (right + 2).min(coarse.width) - left,
        height: (bottom + 2).min(coarse.height) - top,
    }
}

/// Returns the coarse cell under a fine sample, and the fraction in it, clamped to the outermost sample centres.
fn coarse_cell(sample: u32, fine: u32, coarse: u32) -> (u32, f64) {
    let (cell, fraction) = bicubic::cell(coordinate(sample.into(), fine, coarse), coarse);
    (cell, fraction.clamp(0.0, 1.0))
}
