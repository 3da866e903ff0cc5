//! Which blocks of a forest an eye may see, and with how many of their points.
//!
//! A block of level 0 has all of its points. Each further level is twice as wide and has a quarter of the points, those
//! of lowest rank, so that every block has about 64: up to a tile, blocks are its parts, and above they are several
//! tiles. Far away only trees of low rank are drawn ([`Thinning`]), so blocks are walked from the widest ones down, and
//! one that has all points which may be drawn at its distance is not split. Beyond blocks whose tiles have one point
//! each, only some tiles have one ([`chosen_tile`]). A view has some thousand blocks, whatever the density and the reach.

use glam::{DVec2, DVec3, IVec2};

use super::points::{Point, Points};
use super::{BLOCKS, LEVELS_OF_TILE, POINTS, TILE_M};
use crate::gpu::wgsl::shared::tree_ranks::{CHOOSES, MOST_SPARSE};
use crate::scene::frustum::{Bounds, Frustum};

/// From this level on not all tiles have a point in a block: one of four in the next level, and so on.
pub const SPARSE: u32 = 6;
const _: () = assert!(POINTS >> (2 * SPARSE) == 1);
/// The widest blocks.
pub const WIDEST: u32 = SPARSE + MOST_SPARSE;

/// A block of points in the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// How often its side is twice that of the smallest.
    pub level: u32,
    /// The tile that it is a part of, or the one in its south-west corner: east and north, from the world's origin.
    pub tile: IVec2,
    /// Which part of its tile, row by row; 0 for whole tiles.
    pub number: u32,
}

impl Block {
    /// Of one of the widest, counted in its own size.
    fn widest(at: IVec2) -> Self {
        Self { level: WIDEST, tile: at * (1 << (WIDEST + 1 - LEVELS_OF_TILE)), number: 0 }
    }

    /// Its side.
    pub fn side_m(self) -> f64 {
        TILE_M / f64::from(BLOCKS) * f64::from(1_u32 << self.level)
    }

    /// Tiles along its side that have points; 1 for a part of one.
    pub fn tiles(self) -> u32 {
        1 << (self.level.min(SPARSE) + 1).saturating_sub(LEVELS_OF_TILE)
    }

    /// How often four groups of tiles have become one that has a point.
    pub fn sparseness(self) -> u32 {
        self.level.saturating_sub(SPARSE)
    }

    /// Its corner with the least coordinates, in the world.
    pub fn corner_m(self) -> DVec2 {
        let side = (BLOCKS >> self.level).max(1);
        let in_tile = DVec2::new((self.number % side).into(), (self.number / side).into());
        self.tile.as_dvec2() * TILE_M + in_tile * self.side_m()
    }

    /// The four of the level below.
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

    /// The points that each of its tiles has here, by rank.
    pub fn points(self, points: &Points) -> &[Point] {
        let own = points.of_block(self.level.min(LEVELS_OF_TILE - 1), self.number);
        if self.tiles() == 1 { own } else { &own[..(POINTS >> (2 * self.level.min(SPARSE))) as usize] }
    }
}

/// Of a group of 2^`sparseness` by as many tiles, counted in groups, the tile that has a point.
pub fn chosen_tile(group: IVec2, sparseness: u32) -> IVec2 {
    let mut at = group;
    for level in (0..sparseness).rev() {
        let mixed = pcg([(at.x as u32) ^ CHOOSES, (at.y as u32) ^ level])[0] >> 16;
        at = at * 2 + IVec2::new((mixed & 1) as i32, (mixed >> 1 & 1) as i32);
    }
    at
}

/// The rank of the first point of a tile: below that of all others, and so much lower as the tile is chosen more often.
pub fn first_rank(tile: IVec2) -> f64 {
    let mut level = 0;
    while level < WIDEST - SPARSE && chosen_tile(tile >> (level + 1) as i32, level + 1) == tile {
        level += 1;
    }
    let own = f64::from(pcg([tile.x as u32, tile.y as u32])[1] >> 8) / f64::from(1 << 24);
    (0.25 + 0.75 * own) / f64::from(POINTS) / f64::from(1_u32 << (2 * level))
}

/// As `shaders/shared/pcg.wgsl`.
fn pcg(value: [u32; 2]) -> [u32; 2] {
    let [mut x, mut y] = value.map(|v| v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    x = x.wrapping_add(y.wrapping_mul(1_664_525));
    y = y.wrapping_add(x.wrapping_mul(1_664_525));
    (x, y) = (x ^ (x >> 16), y ^ (y >> 16));
    x = x.wrapping_add(y.wrapping_mul(1_664_525));
    y = y.wrapping_add(x.wrapping_mul(1_664_525));
    [x ^ (x >> 16), y ^ (y >> 16)]
}

/// Far away fewer trees are drawn, as many for a part of the picture as where they are as tall as trees may be that are
/// drawn one by one; those of low rank stay, and lie evenly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thinning {
    /// Of the points: the rank below which trees may stand at all.
    pub density: f64,
    /// Up to this distance all trees are drawn.
    pub full_m: f64,
}

impl Thinning {
    /// The rank below which trees are drawn at a distance, at most.
    pub fn rank_at(&self, away_m: f64) -> f64 {
        self.density * (self.full_m / away_m.max(self.full_m)).powi(2)
    }
}

/// An eye, and what it can see of a forest.
#[derive(Clone, Debug)]
pub struct Sight<'a> {
    /// Where it is in the world.
    pub eye_m: DVec3,
    /// What it sees.
    pub frustum: &'a Frustum,
    /// Trees that are farther away are not drawn.
    pub reach_m: f64,
    /// Between which corners there is land.
    pub land_m: [DVec2; 2],
    /// The least and the greatest height of the land.
    pub range_m: [f64; 2],
    /// The height of the tallest tree.
    pub tallest_m: f64,
    /// From its foot to where its shadow ends; 0 where there are no shadows.
    pub shadow_m: DVec3,
    /// How far wind moves a tree, at most.
    pub sways_m: f64,
    /// How few are drawn far away.
    pub thinning: Thinning,
}

impl Sight<'_> {
    /// What holds the trees of a block and their shadows, from the eye.
    pub fn bounds(&self, block: Block) -> Bounds {
        let &Self { eye_m, range_m, tallest_m, shadow_m, sways_m, .. } = self;
        let corner_m = block.corner_m();
        // Crowns lean over the borders of their blocks, canopies are wider than their trees, and the earth bends down.
        let margin_m = DVec3::splat(0.5 * tallest_m + sways_m + 0.25 * block.side_m());
        let low_m = corner_m.extend(range_m[0]);
        let high_m = (corner_m + block.side_m()).extend(range_m[1] + tallest_m);
        Bounds {
            low_m: low_m - margin_m - eye_m + shadow_m.min(DVec3::ZERO),
            high_m: high_m + margin_m - eye_m + shadow_m.max(DVec3::ZERO),
        }
    }
}

/// The blocks within reach that the frustum may see, and the most trees that they may draw.
pub fn in_view(sight: &Sight<'_>, points: &Points) -> (Vec<Block>, u64) {
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
        let is_beside = corner_m.cmpgt(land_m[1]).any() || (corner_m + block.side_m()).cmplt(land_m[0]).any();
        if is_beside || away_m > reach_m || !frustum.may_see(&bounds) {
            continue;
        }
        let rank = thinning.rank_at(away_m);
        if block.level > 0 && rank * 4.0_f64.powi(block.level as i32) > 1.0 {
            rest.extend(block.parts());
            continue;
        }
        // The first of a tile may have a lower rank than its number says.
        let own = block.points(points).partition_point(|point| point.number == 0 || point.rank() < rank) as u64;
        if own > 0 {
            most += own * u64::from(block.tiles()).pow(2);
            blocks.push(block);
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

    /// The trees of blocks: each one's tile and number.
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
        let (blocks, most) = in_view(&sight, &points);
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
        // Every tile in reach, every point of it, by hand.
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
        // Planted: blocks that are lost.
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
    fn what_a_view_lists_follows_what_is_drawn() {
        let points = Points::new();
        let frustum = Frustum::new(
            [[-1.0, 1.0, 0.4], [1.0, 1.0, 0.4], [1.0, 1.0, -0.6], [-1.0, 1.0, -0.6]].map(DVec3::from_array),
        );
        let listed = |density: f64, reach_m: f64| {
            let sight = Sight { reach_m, ..sight(&frustum, Thinning { density, full_m: 300.0 }) };
            in_view(&sight, &points).0.len()
        };
        let (near, far) = (listed(0.5, 2500.0), listed(0.5, 40_000.0));
        // Four octaves of distance: the area is 256 times as large.
        assert!(far < 8 * near, "{near} {far}");
    }
}
