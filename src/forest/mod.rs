//! Forests: where trees stand, without a list of them.
//!
//! The world is covered with square tiles of [`TILE_M`], all of them with the same points ([`points`]), which lie evenly
//! and fit together across the borders of tiles. A point has a rank: the points whose rank is below a density lie evenly,
//! too. A tree exists because its point says so: the density that the land asks for there ([`Forest`]) is above the
//! point's rank. All else about it (height, turn) follows from the number of its point and of its tile. So a world may
//! have any number of trees, and a frame asks only about those cells of [`CELL_M`] that an eye may see ([`cells`]).
//!
//! The points are a progressive sample (Yuksel 2015), repeated (as the point patterns of Lagae and Dutré 2006 are): what
//! is repeated is where trees could stand, and the land and the numbers that differ from tile to tile hide it.

pub mod cells;
pub mod conifer;
pub mod points;

use crate::scene::Forest;

/// Side of a tile of points.
pub const TILE_M: f64 = 256.0;
/// Side of a cell, of which a frame sees all points or none.
pub const CELL_M: f64 = 32.0;
/// Cells along a side of a tile.
pub const CELLS: u32 = 8;
/// Points of a tile.
pub const POINTS: u32 = 4096;

// As many as there can be trees.
const _: () = assert!(POINTS as f64 * 10_000.0 == Forest::MOST_TREES_PER_HA * TILE_M * TILE_M);
