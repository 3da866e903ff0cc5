//! The order in which tiles are requested.

use rustc_hash::FxHashSet;

use super::needed::Needed;
use crate::pyramid::TileAddress;

/// Returns the most urgent tiles in order, each once, as many as there are slots, and the number of those left out.
pub(super) fn most_urgent(tiles: Vec<Needed>, slots: usize) -> (Vec<Needed>, u64) {
    let mut urgent = in_order(tiles);
    let mut met = FxHashSet::default();
    urgent.retain(|tile| met.insert(tile.address));
    let without_room = urgent.len().saturating_sub(slots) as u64;
    urgent.truncate(slots);
    (urgent, without_room)
}

/// Sorts tiles, the most urgent first, then the coarser, then by address, so that runs are deterministic.
pub(super) fn in_order(mut tiles: Vec<Needed>) -> Vec<Needed> {
    tiles.sort_by(|a, b| {
        let level = |tile: &Needed| std::cmp::Reverse(tile.address.level);
        b.urgency.total_cmp(&a.urgency).then(level(a).cmp(&level(b))).then(a.address.cmp(&b.address))
    });
    tiles
}

/// Merges two lists of tiles, coarser levels first.
pub(super) fn by_level(
    tiles: impl Iterator<Item = (TileAddress, bool)>,
    more: Vec<(TileAddress, bool)>,
) -> impl Iterator<Item = (TileAddress, bool)> {
    let mut all: Vec<_> = tiles.chain(more).collect();
    all.sort_by_key(|(tile, _)| std::cmp::Reverse(tile.level));
    all.into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tiles(columns: impl IntoIterator<Item = u32>) -> Vec<Needed> {
        let tile = |x| Needed::requested(TileAddress { level: 0, x, y: 0 }, 100.0 - x as f32);
        columns.into_iter().map(tile).collect()
    }

    fn columns(tiles: &[Needed]) -> Vec<u32> {
        tiles.iter().map(|tile| tile.address.x).collect()
    }

    #[test]
    fn without_room_the_most_urgent_stay() {
        let (urgent, without_room) = most_urgent(tiles([4, 1, 3, 0, 2, 1]), 3);
        assert_eq!((columns(&urgent), without_room), (vec![0, 1, 2], 2));
        let (urgent, without_room) = most_urgent(tiles([2, 0, 3, 1, 0]), 7);
        assert_eq!((columns(&urgent), without_room), (vec![0, 1, 2, 3], 0), "a tile takes one slot");
    }
}
