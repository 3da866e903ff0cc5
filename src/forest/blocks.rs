//! The blocks of a forest that an eye may see, and how many of their points are evaluated.
//!
//! A block of level 0 has all of its points. Each further level is twice as wide and keeps a quarter of the points,
//! those of lowest rank, so every block has about 64 points. Up to the size of a tile, blocks are parts of a tile;
//! larger ones contain several tiles. Far away only trees of low rank are drawn ([`Thinning`]), so blocks are visited
//! from the widest down, and a block with all points that may be drawn at its distance is not split. In blocks so wide
//! that their tiles have one point each, only some tiles have one ([`chosen_tile`]). A view has a few thousand blocks,
//! whatever the density and the view distance.

use glam::{DVec2, DVec3, IVec2};

use super::points::{Point, Points};
use super::{BLOCKS, LEVELS_OF_TILE, POINTS, TILE_M};
#[cfg(test)]
use crate::gpu::wgsl::shared::tree_ranks::CHOOSES;
use crate::gpu::wgsl::shared::tree_ranks::MAX_SPARSE;
use crate::scene::frustum::{Bounds, Frustum};

/// From the level above this one, not all tiles have a point in a block: one of four in the next level, and so on.
pub(crate) const SPARSE: u32 = 6;
const _: () = assert!(POINTS >> (2 * SPARSE) == 1);
/// Level of the widest blocks.
pub(crate) const WIDEST: u32 = SPARSE + MAX_SPARSE;

/// Rounds in which thinning is adapted until the trees of a view fit.
const MAX_ROUNDS: u32 = 64;
/// Multiple of the trees that fit at which counting stops: then thinning begins at a quarter of the distance at most.
const MUCH_TOO_MANY: u64 = 16;
/// Margin for the rounding of positions on the GPU, in metres.
const FOOT_MARGIN_M: f64 = 0.25;

/// A square block of candidate points in the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Block {
    /// Level; the side is 2^level times that of the smallest block.
    pub level: u32,
    /// The tile that contains the block, or the tile in its south-west corner: east and north, counted in tiles from
    /// the world's origin.
    pub tile: IVec2,
    /// Index of the block in its tile, row by row; 0 for whole tiles.
    pub number: u32,
}

impl Block {
    /// Returns one of the widest blocks; `at` counts in units of their size.
    fn widest(at: IVec2) -> Self {
        Self { level: WIDEST, tile: at * (1 << (WIDEST + 1 - LEVELS_OF_TILE)), number: 0 }
    }

    /// Returns the side in metres.
    pub(crate) fn side_m(self) -> f64 {
        TILE_M / f64::from(BLOCKS) * f64::from(1_u32 << self.level)
    }

    /// Returns the number of tiles with points along its side; 1 for a part of a tile.
    pub(crate) fn tiles(self) -> u32 {
        1 << (self.level.min(SPARSE) + 1).saturating_sub(LEVELS_OF_TILE)
    }

    /// Returns how many times four groups of tiles were merged into one that has a point.
    pub(crate) fn sparseness(self) -> u32 {
        self.level.saturating_sub(SPARSE)
    }

    /// Returns its south-west corner in the world.
    pub(crate) fn corner_m(self) -> DVec2 {
        let side = (BLOCKS >> self.level).max(1);
        let in_tile = DVec2::new((self.number % side).into(), (self.number / side).into());
        self.tile.as_dvec2() * TILE_M + in_tile * self.side_m()
    }

    /// Returns the four blocks of the level below.
    fn parts(self) -> [Self; 4] {
        let level = self.level - 1;
        [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[x, y]| {
            if self.level < LEVELS_OF_TILE {
                let side = BLOCKS >> self.level;
                let (column, row) = (self.number % side, self.number / side);
                return Self { level, number: (2 * row + y) * 2 * side + 2 * column + x, ..self };
            }
            let half = 1 << (level + 1 - LEVELS_OF_TILE);
            Self { level, tile: self.tile + IVec2::new(x as i32, y as i32) * half, number: 0 }
        })
    }

    /// Returns the points that each of its tiles has in this block, by rank.
    pub(crate) fn points(self, points: &Points) -> &[Point] {
        let own = points.of_block(self.level.min(LEVELS_OF_TILE - 1), self.number);
        if self.tiles() == 1 { own } else { &own[..(POINTS >> (2 * self.level.min(SPARSE))) as usize] }
    }
}

/// Returns the tile that has a point, of a group of 2^`sparseness` × 2^`sparseness` tiles; `group` counts in groups.
#[cfg(test)]
pub(crate) fn chosen_tile(group: IVec2, sparseness: u32) -> IVec2 {
    let mut at = group;
    for level in (0..sparseness).rev() {
        let mixed = pcg([(at.x as u32) ^ CHOOSES, (at.y as u32) ^ level])[0] >> 16;
        at = at * 2 + IVec2::new((mixed & 1) as i32, (mixed >> 1 & 1) as i32);
    }
    at
}

/// Returns the rank of a tile's first point: below all others, and the lower the more levels choose the tile.
#[cfg(test)]
pub(crate) fn first_rank(tile: IVec2) -> f64 {
    let mut level = 0;
    while level < WIDEST - SPARSE && chosen_tile(tile >> (level + 1) as i32, level + 1) == tile {
        level += 1;
    }
    let own = f64::from(pcg([tile.x as u32, tile.y as u32])[1] >> 8) / f64::from(1 << 24);
    (0.25 + 0.75 * own) / f64::from(POINTS) / f64::from(1_u32 << (2 * level))
}

/// Hash function, the same as in `shaders/shared/pcg.wgsl`.
#[cfg(test)]
fn pcg(value: [u32; 2]) -> [u32; 2] {
    let [mut x, mut y] = value.map(|v| v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    x = x.wrapping_add(y.wrapping_mul(1_664_525));
    y = y.wrapping_add(x.wrapping_mul(1_664_525));
    (x, y) = (x ^ (x >> 16), y ^ (y >> 16));
    x = x.wrapping_add(y.wrapping_mul(1_664_525));
    y = y.wrapping_add(x.wrapping_mul(1_664_525));
    [x ^ (x >> 16), y ^ (y >> 16)]
}

/// Thinning with distance: fewer trees are drawn far away, so that their number per area of the picture stays the same
/// as at `full_m`. Trees of low rank remain, and are evenly spaced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Thinning {
    /// Share of the points that can have trees: the rank below which trees may exist.
    pub density: f64,
    /// Distance up to which all trees are drawn, in metres.
    pub full_m: f64,
}

impl Thinning {
    /// Returns an upper bound of the rank below which trees are drawn at a distance.
    pub(crate) fn rank_at(&self, away_m: f64) -> f64 {
        self.density * (self.full_m / away_m.max(self.full_m)).powi(2)
    }
}

/// An eye, and the limits of what it can see of a forest.
#[derive(Clone, Debug)]
pub(crate) struct Sight<'a> {
    /// Position of the eye in the world.
    pub eye_m: DVec3,
    pub frustum: &'a Frustum,
    /// Distance beyond which trees are not drawn.
    pub reach_m: f64,
    /// South-west and north-east corners of the land.
    pub land_m: [DVec2; 2],
    /// Lowest and highest height of the land.
    pub range_m: [f64; 2],
    /// Height of the tallest tree.
    pub tallest_m: f64,
    /// Vector from a tree's foot to the end of its longest shadow; 0 without shadows.
    pub shadow_m: DVec3,
    /// Largest distance that wind moves any part of a tree.
    pub sways_m: f64,
    pub thinning: Thinning,
}

impl Sight<'_> {
    /// Returns the box around the feet of a block's trees, relative to the eye. Thinning depends on their distance: that
    /// of crowns and shadows would give a tall forest around the eye all of its trees, however much is thinned.
    fn feet(&self, block: Block) -> Bounds {
        let (corner_m, margin_m) = (block.corner_m(), DVec3::splat(FOOT_MARGIN_M));
        Bounds {
            low_m: corner_m.extend(self.range_m[0]) - margin_m - self.eye_m,
            high_m: (corner_m + block.side_m()).extend(self.range_m[1]) + margin_m - self.eye_m,
        }
    }

    /// Returns how many points of each of a block's tiles may have trees, those of lowest rank: at its distance the others
    /// are thinned out.
    pub(crate) fn listed(&self, block: Block, points: &Points) -> usize {
        let rank = self.thinning.rank_at(self.feet(block).distance_m());
        // The first point of a tile may have a lower rank than its number gives.
        block.points(points).partition_point(|point| point.number == 0 || point.rank() < rank)
    }

    /// Returns whether the frustum may see trees of a block within a distance. The parts of the block are tested, down
    /// to the smallest: a wide block of sparse trees may be seen where none of its parts is.
    pub(crate) fn sees_within(&self, block: Block, within_m: f64) -> bool {
        let bounds = self.bounds(block);
        let is_seen = bounds.distance_m() < within_m && self.frustum.may_see(&bounds);
        is_seen && (block.level == 0 || block.parts().into_iter().any(|part| self.sees_within(part, within_m)))
    }

    /// Returns the box around the trees of a block and their shadows, relative to the eye.
    pub(crate) fn bounds(&self, block: Block) -> Bounds {
        let &Self { eye_m, range_m, tallest_m, shadow_m, sways_m, .. } = self;
        let corner_m = block.corner_m();
        // Crowns extend over the borders of blocks, canopies are wider than their trees, and the earth curves down.
        let margin_m = DVec3::splat(0.5 * tallest_m + sways_m + 0.25 * block.side_m());
        let low_m = corner_m.extend(range_m[0]);
        let high_m = (corner_m + block.side_m()).extend(range_m[1] + tallest_m);
        Bounds {
            low_m: low_m - margin_m - eye_m + shadow_m.min(DVec3::ZERO),
            high_m: high_m + margin_m - eye_m + shadow_m.max(DVec3::ZERO),
        }
    }
}

/// Returns the blocks in range that the frustum may see, with at most `max_trees` trees: if there would be more, thinning
/// begins nearer to the eye. `sight` then has the thinning that was found.
pub(crate) fn fitted(sight: &mut Sight<'_>, points: &Points, max_trees: u64) -> Vec<Block> {
    for _ in 0..MAX_ROUNDS {
        let (blocks, most) = in_view(sight, points, MUCH_TOO_MANY * max_trees);
        if most <= max_trees {
            return blocks;
        }
        let full_m = sight.thinning.full_m.min(sight.reach_m);
        sight.thinning.full_m = full_m * 0.95 * (max_trees as f64 / most as f64).sqrt();
    }
    // Thinning never needs as many rounds. If it did, the farthest trees would be missing.
    let (mut blocks, _) = in_view(sight, points, MUCH_TOO_MANY * max_trees);
    let away_m = |block: &Block| sight.feet(*block).distance_m();
    blocks.sort_by(|a, b| away_m(a).total_cmp(&away_m(b)));
    let mut room = max_trees;
    blocks.retain(|block| {
        let own = sight.listed(*block, points) as u64 * u64::from(block.tiles()).pow(2);
        let fits = own <= room;
        room = if fits { room - own } else { 0 };
        fits
    });
    blocks
}

/// Returns the blocks in range that the frustum may see, and an upper bound of the number of trees in them. Stops when
/// there are more than `enough` trees.
fn in_view(sight: &Sight<'_>, points: &Points, enough: u64) -> (Vec<Block>, u64) {
    let &Sight { eye_m, frustum, reach_m, land_m, thinning, .. } = sight;
    let (mut blocks, mut most) = (Vec::new(), 0);
    let side_m = Block::widest(IVec2::ZERO).side_m();
    let first = ((eye_m.truncate() - reach_m).max(land_m[0]) / side_m).floor().as_ivec2();
    let last = ((eye_m.truncate() + reach_m).min(land_m[1]) / side_m).floor().as_ivec2();
    let mut rest: Vec<Block> =
        (first.y..=last.y).flat_map(|y| (first.x..=last.x).map(move |x| Block::widest(IVec2::new(x, y)))).collect();
    while let Some(block) = rest.pop() {
        let corner_m = block.corner_m();
        let bounds = sight.bounds(block);
        let away_m = bounds.distance_m();
        let is_outside = corner_m.cmpgt(land_m[1]).any() || (corner_m + block.side_m()).cmplt(land_m[0]).any();
        if is_outside || away_m > reach_m || !frustum.may_see(&bounds) {
            continue;
        }
        let rank = thinning.rank_at(sight.feet(block).distance_m());
        if block.level > 0 && rank * 4.0_f64.powi(block.level as i32) > 1.0 {
            rest.extend(block.parts());
            continue;
        }
        let own = sight.listed(block, points) as u64;
        if own > 0 {
            most += own * u64::from(block.tiles()).pow(2);
            blocks.push(block);
            if most > enough {
                break;
            }
        }
    }
    (blocks, most)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn sight(frustum: &Frustum, thinning: Thinning) -> Sight<'_> {
        let eye_m = DVec3::new(1234.5, -987.0, 150.0);
        let land_m = [DVec2::splat(-1e6), DVec2::splat(1e6)];
        let (reach_m, range_m, tallest_m, shadow_m, sways_m) = (20_000.0, [0.0, 100.0], 20.0, DVec3::ZERO, 0.0);
        Sight { eye_m, frustum, reach_m, land_m, range_m, tallest_m, shadow_m, sways_m, thinning }
    }

    /// Returns the trees of blocks, each as its tile and number.
    fn trees(blocks: &[Block], points: &Points) -> Vec<(IVec2, u32)> {
        let of = |block: &Block| {
            let own = block.points(points).to_vec();
            let (tile, tiles, sparseness) = (block.tile, block.tiles() as i32, block.sparseness());
            let first = tile >> sparseness as i32;
            let groups = (0..tiles).flat_map(move |y| (0..tiles).map(move |x| first + IVec2::new(x, y)));
            let tiles = groups.map(move |group| chosen_tile(group, sparseness));
            tiles
                .flat_map(move |tile| own.clone().into_iter().map(move |point| (tile, point.number)))
                .collect::<Vec<_>>()
        };
        blocks.iter().flat_map(of).collect()
    }

    #[test]
    fn blocks_have_every_tree_that_is_drawn_and_each_once() {
        let points = Points::new();
        let rays = [[-1.0, 1.0, 0.4], [1.0, 1.0, 0.4], [1.0, 1.0, -0.6], [-1.0, 1.0, -0.6]].map(DVec3::from_array);
        let frustum = Frustum::new(rays);
        let thinning = Thinning { density: 0.5, full_m: 80.0 };
        let sight = sight(&frustum, thinning);
        let (blocks, most) = in_view(&sight, &points, u64::MAX);
        let all = trees(&blocks, &points);
        let each: BTreeSet<[i64; 3]> =
            all.iter().map(|(tile, number)| [tile.x.into(), tile.y.into(), i64::from(*number)]).collect();
        assert_eq!(each.len(), all.len(), "each once");
        let levels: BTreeSet<u32> = blocks.iter().map(|block| block.level).collect();
        assert!(
            levels.len() >= 6 && levels.last() > Some(&SPARSE) && blocks.len() < 4000,
            "{levels:?} {}",
            blocks.len()
        );
        // Every point of every tile in range, by brute force.
        let missing = |each: &BTreeSet<[i64; 3]>| {
            let (mut missing, mut drawn) = (0, 0_u64);
            for tile in (-84..84).flat_map(|y| (-84..84).map(move |x| IVec2::new(x, y))) {
                let first = first_rank(tile);
                for point in &points.points[..POINTS as usize] {
                    let rank = if point.number == 0 { first } else { point.rank() };
                    let at_m = (tile.as_dvec2() + DVec2::from_array(point.at)) * TILE_M;
                    let from_eye_m = at_m.extend(50.0) - sight.eye_m;
                    let away_m = from_eye_m.length();
                    let is_drawn = away_m < sight.reach_m
                        && frustum.may_see_sphere(from_eye_m, 0.0)
                        && rank < thinning.rank_at(away_m);
                    drawn += u64::from(is_drawn);
                    let key = [tile.x.into(), tile.y.into(), i64::from(point.number)];
                    missing += u64::from(is_drawn && !each.contains(&key));
                }
            }
            (missing, drawn)
        };
        let (lost, drawn) = missing(&each);
        assert!(lost == 0 && drawn > 300 && drawn <= most && most < 8 * drawn, "{lost} of {drawn}, at most {most}");
        // Planted: half of the blocks are missing.
        let fewer = trees(&blocks[..blocks.len() / 2], &points);
        let fewer = fewer.iter().map(|(tile, number)| [tile.x.into(), tile.y.into(), i64::from(*number)]).collect();
        assert!(missing(&fewer).0 > 0);
    }

    #[test]
    fn one_tile_of_four_is_chosen_again_and_again() {
        let tiles = (0..256).flat_map(|y| (0..256).map(move |x| IVec2::new(x - 128, y - 64)));
        let ranks: Vec<f64> = tiles.map(first_rank).collect();
        for level in 0..4 {
            let below = 4.0_f64.powi(-level) / f64::from(POINTS);
            let count = ranks.iter().filter(|rank| **rank < below).count();
            assert_eq!(count, 65_536 >> (2 * level), "{level}");
        }
    }

    #[test]
    fn far_blocks_are_thinned_out() {
        let points = Points::new();
        let frustum = Frustum::new(
            [[-1.0, 1.0, 0.4], [1.0, 1.0, 0.4], [1.0, 1.0, -0.6], [-1.0, 1.0, -0.6]].map(DVec3::from_array),
        );
        let listed = |density: f64, reach_m: f64| {
            let sight = Sight { reach_m, ..sight(&frustum, Thinning { density, full_m: 300.0 }) };
            in_view(&sight, &points, u64::MAX).0.len()
        };
        let (near, far) = (listed(0.5, 2500.0), listed(0.5, 40_000.0));
        // Four octaves of distance: 256 times the area.
        assert!(far < 8 * near, "{near} {far}");
    }

    #[test]
    fn a_forest_of_giants_is_thinned_until_it_fits() {
        let points = Points::new();
        let frustum = Frustum::new(
            [[-1.0, 1.0, 0.4], [1.0, 1.0, 0.4], [1.0, 1.0, -0.6], [-1.0, 1.0, -0.6]].map(DVec3::from_array),
        );
        let max_trees = 1 << 17;
        // Trees of 1000 m with shadows of four times as much, through a long lens at a fine detail.
        for (tallest_m, shadow_m, full_m) in [
            (1350.0, DVec3::new(3800.0, -3800.0, -1100.0), 1e7),
            (1350.0, DVec3::ZERO, 1e12),
            (405.0, DVec3::new(1100.0, -1100.0, -340.0), 3e4),
            (0.01, DVec3::ZERO, 1e300),
        ] {
            let mut sight = Sight { reach_m: 60_000.0, ..sight(&frustum, Thinning { density: 1.0, full_m }) };
            (sight.tallest_m, sight.shadow_m) = (tallest_m, shadow_m);
            let (_, at_first) = in_view(&sight, &points, MUCH_TOO_MANY * max_trees);
            assert!(at_first > max_trees, "the case must be one: {at_first}");
            let blocks = fitted(&mut sight, &points, max_trees);
            let (again, most) = in_view(&sight, &points, u64::MAX);
            assert!(again == blocks && most <= max_trees && most > max_trees / 8, "{most}");
            // Without thinning that is far too near, and no nearer than necessary.
            let slightly = Thinning { full_m: 2.5 * sight.thinning.full_m, ..sight.thinning };
            assert!(in_view(&Sight { thinning: slightly, ..sight.clone() }, &points, u64::MAX).1 > max_trees);
            if shadow_m.x < 2000.0 {
                continue;
            }
            // Planted: by the distance of crowns and shadows all trees around the eye are at a distance of 0, where
            // nothing is thinned. They never fit.
            let tiles = (-24..24).flat_map(|y| (-24..24).map(move |x| IVec2::new(x, y)));
            let blocks =
                tiles.flat_map(|tile| (0..BLOCKS * BLOCKS).map(move |number| Block { level: 0, tile, number }));
            let holds = |block: &Block| {
                let bounds = sight.bounds(*block);
                bounds.distance_m() == 0.0 && frustum.may_see(&bounds)
            };
            let never_thinned: usize = blocks.filter(holds).map(|block| block.points(&points).len()).sum();
            assert!(never_thinned as u64 > 2 * max_trees, "{never_thinned}");
        }
    }
}
