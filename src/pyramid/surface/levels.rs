//! The sizes of the levels, and how their samples lie over one another.
//!
//! Level 0 is the grid itself; each level has half the samples of the one before, rounded up, until one tile holds a
//! whole level. The registration is GDAL's: all levels cover the same area, in which sample `i` of `n` covers
//! `[i/n, (i + 1)/n]`. For odd sizes the ratio of two levels is therefore not exactly 2.

use crate::pyramid::tile::TILE_SAMPLES;

/// How many samples a level has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelSize {
    /// Samples per row.
    pub width: u32,
    /// Rows of samples.
    pub height: u32,
}

impl LevelSize {
    /// Tiles in a row of tiles.
    pub fn tiles_x(self) -> u32 {
        self.width.div_ceil(TILE_SAMPLES)
    }

    /// Rows of tiles.
    pub fn tiles_y(self) -> u32 {
        self.height.div_ceil(TILE_SAMPLES)
    }

    /// Tiles in all.
    pub fn tiles(self) -> u64 {
        u64::from(self.tiles_x()) * u64::from(self.tiles_y())
    }

    /// Samples in all.
    pub fn samples(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// All samples of the level.
    pub fn region(self) -> Region {
        Region { x: 0, y: 0, width: self.width, height: self.height }
    }

    /// The samples of tile (`x`, `y`) and `border` more on every side, as far as the level goes.
    pub fn tile_region(self, x: u32, y: u32, border: u32) -> Region {
        let (x0, x1) = span(x, border, self.width);
        let (y0, y1) = span(y, border, self.height);
        Region { x: x0, y: y0, width: x1 - x0, height: y1 - y0 }
    }
}

fn span(tile: u32, border: u32, count: u32) -> (u32, u32) {
    let first = tile * TILE_SAMPLES;
    (first.saturating_sub(border), (first + TILE_SAMPLES + border).min(count))
}

/// A rectangle of samples of one level, inside it.
pub use crate::source::Window as Region;

impl Region {
    /// The region with `border` more samples on every side, as far as a level of `size` goes.
    pub fn grown(self, border: u32, size: LevelSize) -> Self {
        let (x, y) = (self.x.saturating_sub(border), self.y.saturating_sub(border));
        let right = (self.x + self.width + border).min(size.width);
        let bottom = (self.y + self.height + border).min(size.height);
        Self { x, y, width: right - x, height: bottom - y }
    }
}

/// The sizes of all levels over a grid of `width` × `height` samples, finest first; at least one.
pub fn level_sizes(width: u32, height: u32) -> Vec<LevelSize> {
    let mut size = LevelSize { width, height };
    let mut sizes = vec![size];
    while size.width > TILE_SAMPLES || size.height > TILE_SAMPLES {
        size = LevelSize { width: size.width.div_ceil(2), height: size.height.div_ceil(2) };
        sizes.push(size);
    }
    sizes
}

/// The coordinate on an axis of `to` samples of the place that has coordinate `c` on the same axis with `from` samples.
/// Coordinates count sample centres.
pub fn coordinate(c: f64, from: u32, to: u32) -> f64 {
    (c + 0.5) * f64::from(to) / f64::from(from) - 0.5
}
