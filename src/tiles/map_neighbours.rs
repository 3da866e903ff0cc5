//! The tiles that a tile's maps depend on: tiles of its own level and of all coarser ones, near enough for
//! `shaders/surface/land/horizons.wgsl` and `shaders/surface/lakes` to read them.
//!
//! Horizons read a level at most sixteen samples away, and lakes sixty, so a tile depends on at most nine tiles of its
//! own level and four of each coarser one. Each has a fixed position in a list, so a set of them is a bit mask.

use rustc_hash::FxHashSet;

use super::needed::Needed;
use crate::pyramid::tile::TILE_SAMPLES;
use crate::pyramid::{LevelSize, TileAddress, TileStore};

/// Largest distance at which a level is read, in its samples. (The sixteen of horizons are up to forty where the
/// samples of a geographic grid are narrow.)
const REACH: i64 = 60;

/// The existing tiles around a tile: a bit for each.
pub(crate) type Around = u128;

/// Returns the tiles around `tile`, itself included, with the bit number of each.
pub(crate) fn around(levels: &[LevelSize], tile: TileAddress) -> impl Iterator<Item = (u32, TileAddress)> + use<'_> {
    let side = i64::from(TILE_SAMPLES);
    (tile.level..levels.len() as u32).flat_map(move |level| {
        let up = level - tile.level;
        let size = levels[level as usize];
        let range = |at: u32, count: u32| {
            let (first, end) = ((i64::from(at) * side) >> up, ((i64::from(at) + 1) * side) >> up);
            (first - REACH).div_euclid(side)..=(end - 1 + REACH).div_euclid(side).min(i64::from(count) - 1)
        };
        let (columns, rows) = (range(tile.x, size.tiles_x()), range(tile.y, size.tiles_y()));
        // Three in a row on the tile's own level, two on coarser ones.
        let (first_bit, width) = if up == 0 { (0, 3) } else { (9 + 4 * (up - 1), 2) };
        let (left, top) = (*columns.start(), *rows.start());
        rows.filter(|y| *y >= 0).flat_map(move |y| {
            columns.clone().filter(|x| *x >= 0).map(move |x| {
                let bit = first_bit + (y - top) as u32 * width + (x - left) as u32;
                (bit, TileAddress { level, x: x as u32, y: y as u32 })
            })
        })
    })
}

/// Returns the tiles that the maps of `needed` tiles depend on and that the view does not need itself, coarser ones
/// first.
pub(crate) fn map_neighbours(store: &dyn TileStore, needed: &[Needed]) -> Vec<TileAddress> {
    let mut met: FxHashSet<TileAddress> = needed.iter().map(|tile| tile.address).collect();
    let mut found = Vec::new();
    for tile in needed {
        // Ancestors are needed, too, and reach as far as their descendants: the tile's own level is enough.
        let own_level = |(_, address): &(u32, TileAddress)| address.level == tile.address.level;
        for (_, address) in around(store.levels(), tile.address).take_while(own_level) {
            if met.insert(address) && store.has_tile(address) {
                found.push(address);
            }
        }
    }
    found.sort_unstable_by_key(|tile| (std::cmp::Reverse(tile.level), tile.y, tile.x));
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_tile_around_has_a_bit_of_its_own() {
        let levels: Vec<LevelSize> =
            (0..17).map(|level| LevelSize { width: 1 << (24 - level), height: 3 << (20 - level.min(16)) }).collect();
        for (x, y) in [(0, 0), (1, 1), (40_000, 700), (65_535, 12_287), (333, 2)] {
            let tile = TileAddress { level: 0, x, y };
            let found: Vec<_> = around(&levels, tile).collect();
            let bits: FxHashSet<u32> = found.iter().map(|(bit, _)| *bit).collect();
            assert_eq!(bits.len(), found.len(), "{tile:?}");
            assert!(bits.iter().all(|bit| *bit < Around::BITS));
            assert!(found.iter().any(|(_, address)| *address == tile));
            // The parent's neighbours include all coarser ones, so a list of them needs each tile's own level only.
            let coarser: FxHashSet<TileAddress> =
                found.iter().map(|(_, address)| *address).filter(|address| address.level > 0).collect();
            let parent = TileAddress { level: 1, x: x / 2, y: y / 2 };
            let of_parent: FxHashSet<TileAddress> = around(&levels, parent).map(|(_, address)| address).collect();
            assert!(coarser.is_subset(&of_parent), "{tile:?}");
            // All ancestors are included.
            let is_parent =
                |level: u32| found.iter().any(|(_, at)| *at == TileAddress { level, x: x >> level, y: y >> level });
            assert!((0..17).all(is_parent), "{tile:?}");
        }
    }
}
