//! Forests: the positions of trees, computed without a list of them.
//!
//! The world is covered with square tiles of [`TILE_M`], all with the same points ([`points`]), which are evenly
//! spaced, also across the borders of tiles. Each point has a rank; the points whose rank is below a density are evenly
//! spaced, too. A tree exists at a point if the density that the land allows there ([`Forest`]) is above the point's
//! rank. All else about the tree (species, height, rotation) follows from the numbers of its point and its tile. So a
//! world can have any number of trees, and a frame evaluates only the blocks that an eye may see ([`blocks`]): near
//! blocks with all of their points, farther ones with the few of lowest rank.
//!
//! The points are a progressive sample (Yuksel 2015), repeated like the point patterns of Lagae and Dutré 2006. Only
//! the places where trees could be repeat; the land, and numbers that differ from tile to tile, hide the repetition.

pub(crate) mod blocks;
pub(crate) mod colors;
pub(crate) mod cover;
pub(crate) mod edges;
pub(crate) mod hull;
pub(crate) mod impostor;
pub(crate) mod model;
pub(crate) mod points;
pub(crate) mod species;

use crate::scene::Forest;

/// Side of a tile of points, in metres.
pub(crate) const TILE_M: f64 = 256.0;
/// Blocks of level 0 along the side of a tile.
pub(crate) const BLOCKS: u32 = 8;
/// Number of levels at which blocks are parts of a tile or the whole tile.
pub(crate) const LEVELS_OF_TILE: u32 = 4;
/// Number of points in a tile.
pub(crate) const POINTS: u32 = 4096;

// There is one point for each tree of the highest density.
const _: () = assert!(POINTS as f64 * 10_000.0 == Forest::MAX_TREES_PER_HA * TILE_M * TILE_M);
const _: () = assert!(BLOCKS >> (LEVELS_OF_TILE - 1) == 1);
