//! Which blocks of a forest an eye may see, and with how many of their points.
//!
//! A block of level 0 has all of its points. Each further level is twice as wide and has a quarter of the points, those
//! of lowest rank, so that every block has about 64: up to a tile, blocks are its parts, and above they are several
//! tiles. Far away only trees of low rank are drawn ([`Thinning`]), so blocks are walked from the widest ones down, and
//! one that has all points which may be drawn at its distance is not split. A view has some thousand blocks, whatever
//! the density and the reach.

use glam::{DVec2, DVec3, IVec2};

use super::points::{Point, Points};
use super::{BLOCKS, LEVELS_OF_TILE, POINTS, TILE_M};
use crate::scene::frustum::{Bounds, Frustum};

/// The widest blocks: each of their tiles has one point.
pub const WIDEST: u32 = 6;
const _: () = assert!(POINTS >> (2 * WIDEST) == 1);

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

    /// Tiles along its side; 1 for a part of one.
    pub fn tiles(self) -> u32 {
        1 << (self.level + 1).saturating_sub(LEVELS_OF_TILE)
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
            let half = (self.tiles() / 2) as i32;
            Self { level, tile: self.tile + IVec2::new(x as i32, y as i32) * half, number: 0 }
        })
    }

    /// The points that each of its tiles has here, by rank.
    pub fn points(self, points: &Points) -> &[Point] {
        let own = points.of_block(self.level.min(LEVELS_OF_TILE - 1), self.number);
        if self.tiles() == 1 { own } else { &own[..(POINTS >> (2 * self.level)) as usize] }
    }
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
    /// How few are drawn far away.
    pub thinning: Thinning,
}

/// The blocks within reach that the frustum may see, and the most trees that they may draw.
pub fn in_view(sight: &Sight<'_>, points: &Points) -> (Vec<Block>, u64) {
    let &Sight { eye_m, frustum, reach_m, land_m, range_m, tallest_m, thinning } = sight;
    let (mut blocks, mut most) = (Vec::new(), 0);
    let side_m = Block::widest(IVec2::ZERO).side_m();
    let first = ((eye_m.truncate() - reach_m).max(land_m[0]) / side_m).floor().as_ivec2();
    let last = ((eye_m.truncate() + reach_m).min(land_m[1]) / side_m).floor().as_ivec2();
    let mut rest: Vec<Block> =
        (first.y..=last.y).flat_map(|y| (first.x..=last.x).map(move |x| Block::widest(IVec2::new(x, y)))).collect();
    while let Some(block) = rest.pop() {
        let corner_m = block.corner_m();
        // Crowns lean over the borders of their blocks, canopies are wider than their trees, and the earth bends down.
        let margin_m = DVec3::splat(0.5 * tallest_m + 0.25 * block.side_m());
        let bounds = Bounds {
            low_m: corner_m.extend(range_m[0]) - margin_m - eye_m,
            high_m: (corner_m + block.side_m()).extend(range_m[1] + tallest_m) + margin_m - eye_m,
        };
        let away_m = bounds.distance_m();
        let is_beside = corner_m.cmpgt(land_m[1]).any() || (corner_m + block.side_m()).cmplt(land_m[0]).any();
        if is_beside || away_m > reach_m || !frustum.may_see(&bounds) {
            continue;
        }
        let rank = thinning.rank_at(away_m);
        if block.level > 0 && rank * f64::from(1_u32 << (2 * block.level)) > 1.0 {
            rest.extend(block.parts());
            continue;
        }
        let own = block.points(points).partition_point(|point| point.rank() < rank) as u64;
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
        Sight { eye_m, frustum, reach_m: 9000.0, land_m, range_m: [0.0, 100.0], tallest_m: 20.0, thinning }
    }

    /// The trees of blocks: each one's tile and number.
    fn trees(blocks: &[Block], points: &Points) -> Vec<(IVec2, u32)> {
        let of = |block: &Block| {
            let own = block.points(points).to_vec();
            let (tile, tiles) = (block.tile, block.tiles() as i32);
            let tiles = (0..tiles).flat_map(move |y| (0..tiles).map(move |x| tile + IVec2::new(x, y)));
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
        let thinning = Thinning { density: 0.5, full_m: 300.0 };
        let sight = sight(&frustum, thinning);
        let (blocks, most) = in_view(&sight, &points);
        let all = trees(&blocks, &points);
        let each: BTreeSet<[i64; 3]> =
            all.iter().map(|(tile, number)| [tile.x.into(), tile.y.into(), i64::from(*number)]).collect();
        assert_eq!(each.len(), all.len(), "each once");
        let levels: BTreeSet<u32> = blocks.iter().map(|block| block.level).collect();
        assert!(levels.len() >= 4 && blocks.len() < 4000, "{levels:?} {}", blocks.len());
        // Every tile in reach, every point of it, by hand.
        let missing = |each: &BTreeSet<[i64; 3]>| {
            let (mut missing, mut drawn) = (0, 0_u64);
            for tile in (-40..40).flat_map(|y| (-40..40).map(move |x| IVec2::new(x, y))) {
                for point in &points.points[..POINTS as usize] {
                    let at_m = (tile.as_dvec2() + DVec2::from_array(point.at)) * TILE_M;
                    let from_eye_m = at_m.extend(50.0) - sight.eye_m;
                    let away_m = from_eye_m.length();
                    let is_drawn = away_m < sight.reach_m
                        && frustum.may_see_sphere(from_eye_m, 0.0)
                        && point.rank() < thinning.rank_at(away_m);
                    drawn += u64::from(is_drawn);
                    let key = [tile.x.into(), tile.y.into(), i64::from(point.number)];
                    missing += u64::from(is_drawn && !each.contains(&key));
                }
            }
            (missing, drawn)
        };
        let (lost, drawn) = missing(&each);
        assert!(lost == 0 && drawn > 3000 && drawn <= most && most < 4 * drawn, "{lost} of {drawn}, at most {most}");
        // Planted: a block that is lost.
        let fewer = trees(&blocks[..blocks.len() - 1], &points);
        let fewer = fewer.iter().map(|(tile, number)| [tile.x.into(), tile.y.into(), i64::from(*number)]).collect();
        assert!(missing(&fewer).0 > 0);
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
