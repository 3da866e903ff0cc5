//! The blocks of rows that a view needs.
//!
//! A level is visible at the distances at which a cell is one to two mark spacings wide on the picture, and a little
//! beyond, where two levels cross-fade. The mesh patches that are drawn decide which levels are needed where, so land
//! that is hidden by nearer land has no blocks; and of their blocks those are needed that are within [`Reach`].

use rustc_hash::FxHashMap;

use super::reach::Reach;
use crate::gpu::wgsl::shared::rows::CELLS;
use crate::tiles::selection::Selection;
use crate::tiles::terrain::Terrain;

/// Distance from its middle at which a mark may still come onto a patch, in cells.
const AROUND: f64 = 4.0;
/// Blocks that are remembered while the blocks of a view are found: four levels, and four by four of each.
const RECENT: usize = 64;
/// Largest number of blocks of a rectangle that are looked up one by one. Larger rectangles are culled as a whole, or
/// halved.
const FEW: i64 = 4;
/// Distance of a block that is culled, in place of that of its nearest patch: no patch is nearer.
const CULLED_M: f64 = f64::NEG_INFINITY;

/// Level and position of a block in the quadtree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Address {
    pub level: i32,
    pub x: i32,
    pub y: i32,
}

/// Blocks of a level, from the column and row `low` to and including `high`.
#[derive(Clone, Copy)]
pub(super) struct Blocks {
    pub level: i32,
    pub low: [i32; 2],
    pub high: [i32; 2],
}

impl Blocks {
    fn side(&self, axis: usize) -> i64 {
        i64::from(self.high[axis]) - i64::from(self.low[axis]) + 1
    }

    /// Returns the two halves along the longer side.
    fn halves(self) -> [Self; 2] {
        let axis = usize::from(self.side(1) > self.side(0));
        let (mut first, mut second) = (self, self);
        let middle = self.low[axis] + (self.side(axis) / 2) as i32;
        first.high[axis] = middle - 1;
        second.low[axis] = middle;
        [first, second]
    }
}

/// The blocks that a view needs. Its lists are reused from frame to frame.
#[derive(Default)]
pub(super) struct Needed {
    /// Distance of the nearest patch of each block that was tested, in metres, or [`CULLED_M`].
    nearest_m: FxHashMap<Address, f64>,
    /// Number of those that are not culled.
    count: usize,
    sorted: Vec<(Address, f64)>,
    wanted: Vec<Address>,
}

/// A search in progress, for one patch.
struct Search<'a> {
    needed: &'a mut Needed,
    terrain: &'a Terrain,
    reach: &'a Reach,
    /// The block that was looked up last in each place of the table, with its distance.
    recent: [(Address, f64); RECENT],
    /// Distance of the patch.
    near_m: f64,
    most: usize,
}

impl Needed {
    /// Finds the blocks within reach of the land that is drawn. Returns `false` if there are more than `most`.
    pub(super) fn find(&mut self, selection: &Selection, terrain: &Terrain, reach: &Reach, most: usize) -> bool {
        self.nearest_m.clear();
        self.sorted.clear();
        self.wanted.clear();
        self.count = 0;
        // Neighbouring patches see the same blocks, and most come from near to far: most need no look into the table.
        let recent = [(Address { level: i32::MAX, x: 0, y: 0 }, 0.0); RECENT];
        let mut search = Search { needed: self, terrain, reach, recent, near_m: 0.0, most };
        for (patch, [near_m, far_m]) in selection.leaves.iter().zip(&selection.distances_m) {
            search.near_m = *near_m;
            let (first, side) = patch.area();
            for level in reach.levels(*near_m, *far_m) {
                let cell = f64::from(level).exp2();
                let per_block = 1.0 / (f64::from(CELLS) * cell);
                let number = |sample: f64| (sample * per_block).floor() as i32;
                let last = reach.last_block(level);
                let [low, high] = [first - AROUND * cell, first + side + AROUND * cell];
                let blocks = Blocks {
                    level,
                    low: [number(low.x).max(0), number(low.y).max(0)],
                    high: [number(high.x).min(last), number(high.y).min(last)],
                };
                if !search.look_at(blocks) {
                    return false;
                }
            }
        }
        let found = self.nearest_m.iter().filter(|(_, nearest_m)| **nearest_m != CULLED_M);
        self.sorted.extend(found.map(|(address, nearest_m)| (*address, *nearest_m)));
        self.sorted.sort_unstable_by(|(a, a_m), (b, b_m)| a_m.total_cmp(b_m).then(a.cmp(b)));
        self.wanted.extend(self.sorted.iter().map(|(address, _)| *address));
        true
    }

    /// Returns the blocks that were found, nearest first.
    pub(super) fn nearest_first(&self) -> &[Address] {
        &self.wanted
    }
}

impl Search<'_> {
    /// Adds the blocks of a rectangle that are within reach. Returns `false` if there are too many.
    fn look_at(&mut self, blocks: Blocks) -> bool {
        let [columns, rows] = [blocks.side(0), blocks.side(1)];
        if columns <= 0 || rows <= 0 {
            return true;
        }
        if columns.saturating_mul(rows) > FEW {
            return !self.reach.may_draw(self.terrain, blocks)
                || blocks.halves().into_iter().all(|half| self.look_at(half));
        }
        for y in blocks.low[1]..=blocks.high[1] {
            for x in blocks.low[0]..=blocks.high[0] {
                self.look_up(Address { level: blocks.level, x, y });
            }
        }
        self.needed.count <= self.most
    }

    fn look_up(&mut self, address: Address) {
        let Address { level, x, y } = address;
        let place = (x & 3 | (y & 3) << 2 | (level & 3) << 4) as usize;
        if self.recent[place].0 == address && self.recent[place].1 <= self.near_m {
            return;
        }
        let (near_m, count) = (self.near_m, &mut self.needed.count);
        let nearest_m = self.needed.nearest_m.entry(address).or_insert_with(|| {
            let is_kept = self.reach.may_draw(self.terrain, Blocks { level, low: [x, y], high: [x, y] });
            *count += usize::from(is_kept);
            if is_kept { f64::INFINITY } else { CULLED_M }
        });
        *nearest_m = nearest_m.min(near_m);
        self.recent[place] = (address, *nearest_m);
    }
}
