//! Which cells of a forest an eye may see.

use glam::{DVec2, DVec3, IVec2};

use super::{CELL_M, CELLS, TILE_M};
use crate::scene::frustum::{Bounds, Frustum};

/// A cell in the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Of its tile: east and north, from the world's origin.
    pub tile: IVec2,
    /// Which of the tile's, row by row.
    pub number: u32,
}

impl Cell {
    /// Its corner with the least coordinates, in the world.
    pub fn corner_m(self) -> DVec2 {
        let in_tile = DVec2::new((self.number % CELLS).into(), (self.number / CELLS).into());
        self.tile.as_dvec2() * TILE_M + in_tile * CELL_M
    }
}

/// The cells within `reach_m` of an eye that its frustum may see, of trees that stand on land between `range_m` heights
/// and are at most `tree_m` tall; tile by tile.
pub fn in_view(eye_m: DVec3, frustum: &Frustum, reach_m: f64, range_m: [f64; 2], tree_m: f64) -> Vec<Cell> {
    let sees = |corner_m: DVec2, side_m: f64| {
        // Crowns lean over the borders of their cells, and the earth bends down.
        let margin_m = DVec3::splat(0.5 * tree_m);
        let bounds = Bounds {
            low_m: corner_m.extend(range_m[0]) - margin_m - eye_m,
            high_m: (corner_m + side_m).extend(range_m[1] + tree_m) + margin_m - eye_m,
        };
        bounds.distance_m() <= reach_m && frustum.may_see(&bounds)
    };
    let first = ((eye_m.truncate() - reach_m) / TILE_M).floor().as_ivec2();
    let last = ((eye_m.truncate() + reach_m) / TILE_M).floor().as_ivec2();
    let tiles = (first.y..=last.y).flat_map(|y| (first.x..=last.x).map(move |x| IVec2::new(x, y)));
    let tiles = tiles.filter(|tile| sees(tile.as_dvec2() * TILE_M, TILE_M));
    let cells = tiles.flat_map(|tile| (0..CELLS * CELLS).map(move |number| Cell { tile, number }));
    cells.filter(|cell| sees(cell.corner_m(), CELL_M)).collect()
}
