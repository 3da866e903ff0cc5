//! The height of the surface at a place, from the tile that contains it.

use super::bicubic;
use super::levels::{LevelSize, coordinate};
use crate::pyramid::tile::{TILE_BORDER, TILE_SAMPLES, TILE_STRIDE, Tile, TileAddress, is_void};

/// Returns the tile of level `level` whose cell contains a place in grid coordinates of level 0, or `None` outside the
/// outermost samples.
pub(crate) fn tile_at(levels: &[LevelSize], level: u32, column: f64, row: f64) -> Option<TileAddress> {
    let (finest, size) = (levels[0], levels[level as usize]);
    let inside = |c: f64, count: u32| (0.0..=f64::from(count - 1)).contains(&c);
    if !inside(column, finest.width) || !inside(row, finest.height) {
        return None;
    }
    let (x, _) = bicubic::cell(coordinate(column, finest.width, size.width), size.width);
    let (y, _) = bicubic::cell(coordinate(row, finest.height, size.height), size.height);
    Some(TileAddress { level, x: x / TILE_SAMPLES, y: y / TILE_SAMPLES })
}

/// Returns the height in metres of a tile's bicubic surface at a place in grid coordinates of level 0, or `None` in
/// cells with a no-data corner. The place must be in the tile ([`tile_at`]).
pub(crate) fn height_in_tile(
    levels: &[LevelSize],
    address: TileAddress,
    tile: &Tile,
    column: f64,
    row: f64,
) -> Option<f64> {
    let (finest, size) = (levels[0], levels[address.level as usize]);
    let (cell_x, fx) = bicubic::cell(coordinate(column, finest.width, size.width), size.width);
    let (cell_y, fy) = bicubic::cell(coordinate(row, finest.height, size.height), size.height);
    // The tile's rows begin TILE_BORDER samples earlier, and the four samples one earlier.
    let (left, top) = (cell_x % TILE_SAMPLES + TILE_BORDER - 1, cell_y % TILE_SAMPLES + TILE_BORDER - 1);
    let samples: [[f32; 4]; 4] = std::array::from_fn(|k| {
        let start = ((top + k as u32) * TILE_STRIDE + left) as usize;
        std::array::from_fn(|i| tile.samples[start + i])
    });
    let void = samples[1..3].iter().any(|row| row[1..3].iter().any(|&sample| is_void(sample)));
    (!void).then(|| bicubic::height_and_gradient(&samples, fx, fy).0)
}
