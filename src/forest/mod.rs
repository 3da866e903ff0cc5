//! Forests: where trees stand, without a list of them.
//!
//! The world is covered with square tiles of [`TILE_M`], all of them with the same points ([`points`]), which lie evenly
//! and fit together across the borders of tiles. A point has a rank: the points whose rank is below a density lie evenly,
//! too. A tree exists because its point says so: the density that the land asks for there ([`Forest`]) is above the
//! point's rank. All else about it (species, height, turn) follows from the number of its point and of its tile. So a
//! world may have any number of trees, and a frame asks only about the blocks that an eye may see ([`blocks`]): near ones
//! with all of their points, farther ones with the few of lowest rank.
//!
//! The points are a progressive sample (Yuksel 2015), repeated (as the point patterns of Lagae and Dutré 2006 are): what
//! is repeated is where trees could stand, and the land and the numbers that differ from tile to tile hide it.

pub mod blocks;
pub mod colors;
pub mod cover;
pub mod edges;
pub mod impostor;
pub mod model;
pub mod points;
pub mod species;

use crate::scene::Forest;

/// Side of a tile of points.
pub const TILE_M: f64 = 256.0;
/// Blocks of level 0 along the side of a tile.
pub const BLOCKS: u32 = 8;
/// Of blocks that are parts of a tile, up to the whole tile.
pub const LEVELS_OF_TILE: u32 = 4;
/// Points of a tile.
pub const POINTS: u32 = 4096;

// As many as there can be trees.
const _: () = assert!(POINTS as f64 * 10_000.0 == Forest::MOST_TREES_PER_HA * TILE_M * TILE_M);
const _: () = assert!(BLOCKS >> (LEVELS_OF_TILE - 1) == 1);
