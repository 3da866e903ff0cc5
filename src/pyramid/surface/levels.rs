//! The sizes of the levels, and the registration of their samples.
//!
//! Level 0 is the grid itself; each level has half the samples of the one before, rounded up, until one tile contains a
//! whole level. The registration is GDAL's: all levels cover the same area, in which sample `i` of `n` covers `[i/n, (i
//! + 1)/n]`. For odd sizes the ratio of two levels is therefore not exactly 2.

use crate::pyramid::tile::TILE_SAMPLES;

/// The size of a level in samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelSize {
    /// Number of samples per row.
    pub width: u32,
    /// Number of rows of samples.
    pub height: u32,
}

impl LevelSize {
    /// Returns the number of tiles per row.
    pub fn tiles_x(self) -> u32 {
        self.width.div_ceil(TILE_SAMPLES)
    }

    /// Returns the number of rows of tiles.
    pub fn tiles_y(self) -> u32 {
        self.height.div_ceil(TILE_SAMPLES)
    }

    /// Returns the number of tiles.
    pub fn tiles(self) -> u64 {
        u64::from(self.tiles_x()) * u64::from(self.tiles_y())
    }

    /// Returns the number of samples.
    pub(crate) fn samples(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Returns the region of all samples of the level.
    pub(crate) fn region(self) -> Region {
        Region { x: 0, y: 0, width: self.width, height: self.height }
    }

    /// Returns the samples of tile (`x`, `y`) and `border` more on every side, clipped to the level.
    pub(crate) fn tile_region(self, x: u32, y: u32, border: u32) -> Region {
        let (x0, x1) = span(x, border, self.width);
        let (y0, y1) = span(y, border, self.height);
        Region { x: x0, y: y0, width: x1 - x0, height: y1 - y0 }
    }
}

fn span(tile: u32, border: u32, count: u32) -> (u32, u32) {
    let first = tile * TILE_SAMPLES;
    (first.saturating_sub(border), (first + TILE_SAMPLES + border).min(count))
}

/// A rectangle of samples inside a level.
pub(crate) use crate::source::Window as Region;

impl Region {
    /// Returns the region with `border` more samples on every side, clipped to a level of `size`.
    pub(crate) fn grown(self, border: u32, size: LevelSize) -> Self {
        let (x, y) = (self.x.saturating_sub(border), self.y.saturating_sub(border));
        let right = (self.x + self.width + border).min(size.width);
        let bottom = (self.y + self.height + border).min(size.height);
        Self { x, y, width: right - x, height: bottom - y }
    }
}

/// Returns the sizes of all levels over a grid of `width` × `height` samples, finest first; at least one.
pub(crate) fn level_sizes(width: u32, height: u32) -> Vec<LevelSize> {
    let mut size = LevelSize { width, height };
    let mut sizes = vec![size];
    while size.width > TILE_SAMPLES || size.height > TILE_SAMPLES {
        size = LevelSize { width: size.width.div_ceil(2), height: size.height.div_ceil(2) };
        sizes.push(size);
    }
    sizes
}

/// Converts the coordinate `c` on an axis of `from` samples to the same axis with `to` samples. Coordinates count
/// sample centres.
pub(crate) fn coordinate(c: f64, from: u32, to: u32) -> f64 {
    (c + 0.5) * f64::from(to) / f64::from(from) - 0.5
}
