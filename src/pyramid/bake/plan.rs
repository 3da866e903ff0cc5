//! The division of a bake into pieces that fit into memory.
//!
//! A *round* makes several levels out of one: the first makes levels 0 to k from the heights, the next levels k + 1 to
//! 2k from level k, and so on. The work of a round is divided into *chunks* of 2^k × 2^k tiles of the level that it
//! reads: a chunk makes all tiles of the round's levels above these. Tiles have two by two children by their numbers,
//! so no tile belongs to two chunks.
//!
//! The result of a chunk depends on a border around its own samples: the surface reaches two samples beyond a tile, the
//! filling of no-data four more and whatever the coarser levels need for it, and a coarse sample needs the finer ones
//! under it. For odd sizes (see `levels`) coarse tiles are shifted a little to the left of the fine ones with the same
//! numbers, by less than a coarse sample. [`Plan::regions`] computes all that from the coarsest level to the finest, so
//! that a chunk has the same heights as the whole grid would have, bit for bit.

use crate::pyramid::surface::fill::{RADIUS, parent_region};
use crate::pyramid::surface::levels::{LevelSize, Region};
use crate::pyramid::surface::overview::cover_region;
use crate::pyramid::surface::statistics::patch_counts;
use crate::pyramid::tile::{PATCH_QUADS, TILE_BORDER, TILE_SAMPLES};

/// Number of patches along the side of a page.
const PAGE: u32 = TILE_SAMPLES / PATCH_QUADS;

/// The rounds and chunks of a bake.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    /// The sizes of all levels, finest first.
    pub sizes: Vec<LevelSize>,
    /// Number of levels that a round goes up: k.
    pub chunk_levels: u32,
}

/// A round, which makes several levels out of one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Round {
    /// Number of the round, from 0.
    pub number: u32,
    /// The level that the round reads.
    pub base: usize,
    /// The coarsest level that the round makes.
    pub top: usize,
    /// Whether `top` is the coarsest level of the pyramid.
    pub last: bool,
}

impl Round {
    /// Returns the finest level that the round makes.
    pub(super) fn first_made(self) -> usize {
        if self.number == 0 { 0 } else { self.base + 1 }
    }
}

/// A chunk of a round.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Chunk {
    /// Column among the chunks of its round.
    pub x: u32,
    /// Row among the chunks of its round.
    pub y: u32,
}

/// The regions of a level that a chunk needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Regions {
    /// The samples of the chunk's own tiles.
    pub own: Region,
    /// The region where the level is needed as tiles serve it.
    pub served: Region,
    /// The region where the level's heights are needed.
    pub raw: Region,
}

fn hull(a: Region, b: Region) -> Region {
    let (x, y) = (a.x.min(b.x), a.y.min(b.y));
    let right = (a.x + a.width).max(b.x + b.width);
    let bottom = (a.y + a.height).max(b.y + b.height);
    Region { x, y, width: right - x, height: bottom - y }
}

impl Plan {
    /// Returns all rounds in the order of baking; at least one.
    pub(super) fn rounds(&self) -> Vec<Round> {
        let coarsest = self.sizes.len() - 1;
        let mut rounds: Vec<Round> = Vec::new();
        loop {
            let base = rounds.last().map_or(0, |round| round.top);
            let top = (base + self.chunk_levels as usize).min(coarsest);
            let last = top == coarsest;
            rounds.push(Round { number: rounds.len() as u32, base, top, last });
            if last {
                return rounds;
            }
        }
    }

    /// Returns the number of chunks of a round in x and y.
    pub(super) fn chunk_counts(&self, round: Round) -> (u32, u32) {
        let size = self.sizes[round.base];
        let side = 1 << self.chunk_levels;
        (size.tiles_x().div_ceil(side), size.tiles_y().div_ceil(side))
    }

    /// Returns the chunks of a round, row by row.
    pub(super) fn chunks(&self, round: Round) -> Vec<Chunk> {
        let (count_x, count_y) = self.chunk_counts(round);
        (0..count_y).flat_map(|y| (0..count_x).map(move |x| Chunk { x, y })).collect()
    }

    /// Returns the chunk of a round that makes the tile (`x`, `y`) of one of its levels.
    pub(super) fn chunk_of(&self, round: Round, level: usize, x: u32, y: u32) -> Chunk {
        let shift = (round.base + self.chunk_levels as usize - level) as u32;
        Chunk { x: x >> shift, y: y >> shift }
    }

    /// Returns the tiles of a level over a chunk, in tiles; at least one.
    pub(super) fn own_tiles(&self, round: Round, chunk: Chunk, level: usize) -> Region {
        let shift = (round.base + self.chunk_levels as usize - level) as u32;
        let size = self.sizes[level];
        let span = |at: u32, count: u32| {
            let first = at << shift;
            (first, ((at + 1) << shift).min(count) - first)
        };
        let ((x, width), (y, height)) = (span(chunk.x, size.tiles_x()), span(chunk.y, size.tiles_y()));
        Region { x, y, width, height }
    }

    /// Returns the samples of the tiles of a level over a chunk, without borders.
    pub(super) fn own_samples(&self, round: Round, chunk: Chunk, level: usize) -> Region {
        let tiles = self.own_tiles(round, chunk, level);
        let size = self.sizes[level];
        let span = |first: u32, count: u32, samples: u32| {
            let start = first * TILE_SAMPLES;
            (start, ((first + count) * TILE_SAMPLES).min(samples) - start)
        };
        let (x, width) = span(tiles.x, tiles.width, size.width);
        let (y, height) = span(tiles.y, tiles.height, size.height);
        Region { x, y, width, height }
    }

    /// Returns the patches of stride 2^`level` in the pages of a level's tiles over a chunk, in patches. The width or
    /// height may be 0.
    pub(super) fn own_patches(&self, round: Round, chunk: Chunk, level: usize) -> Region {
        let (count_x, count_y) = patch_counts(self.sizes[0], level as u32);
        if level > round.top {
            return Region { x: 0, y: 0, width: count_x, height: count_y };
        }
        let tiles = self.own_tiles(round, chunk, level);
        let span = |first: u32, tiles: u32, count: u32| {
            let start = (first * PAGE).min(count);
            (start, ((first + tiles) * PAGE).min(count) - start)
        };
        let ((x, width), (y, height)) = (span(tiles.x, tiles.width, count_x), span(tiles.y, tiles.height, count_y));
        Region { x, y, width, height }
    }

    /// Returns the regions that a chunk needs of each level from the round's base to its top.
    pub(super) fn regions(&self, round: Round, chunk: Chunk) -> Vec<Regions> {
        let reach = 1 << self.chunk_levels;
        let levels = round.base..round.top + 1;
        let mut regions: Vec<Regions> = Vec::new();
        let mut filled: Option<Region> = None;
        for level in levels.clone() {
            let size = self.sizes[level];
            let own = self.own_samples(round, chunk, level);
            // Later rounds compare their levels with the surface of the base, under tiles that are shifted to the left.
            let against = round.number > 0 && level == round.base;
            let served = own.grown(TILE_BORDER + if against { 1 + reach } else { 0 }, size);
            let under = filled.map(|finer| parent_region(finer, self.sizes[level - 1], size));
            let here = under.map_or(served, |under| hull(under, served));
            filled = Some(here);
            regions.push(Regions { own, served, raw: here.grown(RADIUS, size) });
        }
        for i in (0..regions.len()).rev() {
            if let Some(coarser) = regions.get(i + 1).map(|coarser| coarser.raw) {
                let (fine, coarse) = (self.sizes[round.base + i], self.sizes[round.base + i + 1]);
                regions[i].raw = hull(regions[i].raw, cover_region(coarser, fine, coarse));
            }
        }
        // The areas of coarse tiles begin earlier than the tiles of the base, and vertices without data take a mean
        // over their surroundings.
        let base = &mut regions[0];
        base.raw = hull(base.raw, base.own.grown(reach + 1, self.sizes[round.base]));
        regions
    }
}

/// The vertices along an axis: every `step`-th sample of full resolution, and the last.
#[derive(Clone, Copy, Debug)]
pub(super) struct Steps {
    /// Number of samples of full resolution along the axis.
    pub samples: u32,
    /// Distance between vertices, in samples of full resolution.
    pub step: u64,
}

impl Steps {
    /// Returns the number of vertices.
    pub(super) fn count(self) -> u32 {
        // At most the number of samples, so it fits u32.
        u64::from(self.samples - 1).div_ceil(self.step) as u32 + 1
    }

    /// Returns the sample at vertex `i`.
    pub(super) fn position(self, i: u32) -> u32 {
        (u64::from(i) * self.step).min(u64::from(self.samples) - 1) as u32
    }
}

/// Returns the vertices at every 2^`level`-th sample that belong to a chunk whose top is that level: those in its area,
/// and the last vertex of the axis for the last chunk.
pub(super) fn own_vertices(plan: &Plan, round: Round, chunk: Chunk) -> Region {
    let counts = plan.chunk_counts(round);
    let finest = plan.sizes[0];
    let span = |at: u32, chunks: u32, samples: u32| {
        let count = Steps { samples, step: 1 << round.top }.count();
        let end = if at + 1 == chunks { count } else { (at + 1) * TILE_SAMPLES };
        (at * TILE_SAMPLES, end - at * TILE_SAMPLES)
    };
    let ((x, width), (y, height)) = (span(chunk.x, counts.0, finest.width), span(chunk.y, counts.1, finest.height));
    Region { x, y, width, height }
}
