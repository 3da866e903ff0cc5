//! The order in which tiles are requested.

use rustc_hash::FxHashSet;

use super::needed::Needed;
use crate::pyramid::TileAddress;

/// The requests of a frame; each tile occurs once.
pub(super) struct Queues {
    /// Tiles that this view needs and misses, the most urgent first.
    pub urgent: Vec<Needed>,
    /// Tiles that will probably be needed soon, in the order of the views that will need them.
    pub soon: Vec<Needed>,
    /// Number of urgent tiles for which there is no slot.
    pub without_room: u64,
}

/// Orders the urgent tiles before those that are needed soon, up to the number of slots of the atlas. Duplicates are
/// removed before that cut: the tiles that are needed soon begin with many urgent ones, which would use up the
/// remaining slots.
pub(super) fn queues(urgent: Vec<Needed>, mut soon: Vec<Needed>, slots: usize) -> Queues {
    let mut urgent = in_order(urgent);
    let mut met = FxHashSet::default();
    urgent.retain(|tile| met.insert(tile.address));
    let without_room = urgent.len().saturating_sub(slots) as u64;
    urgent.truncate(slots);
    soon.retain(|tile| met.insert(tile.address));
    soon.truncate(slots - urgent.len());
    Queues { urgent, soon, without_room }
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
        let tile = |x| Needed { address: TileAddress { level: 0, x, y: 0 }, urgency: 100.0 - x as f32 };
        columns.into_iter().map(tile).collect()
    }

    fn columns(tiles: &[Needed]) -> Vec<u32> {
        tiles.iter().map(|tile| tile.address.x).collect()
    }

    #[test]
    fn urgent_tiles_take_no_slot_twice() {
        // The view ahead sees the tiles of this view and one more, the wider view two more.
        let ahead = [tiles(0..5), tiles(0..7)].concat();
        let found = queues(tiles([2, 0, 3, 1, 0]), ahead.clone(), 7);
        assert_eq!((columns(&found.urgent), found.without_room), (vec![0, 1, 2, 3], 0));
        assert_eq!(columns(&found.soon), [4, 5, 6], "what lies ahead has the slots that are left");
        // The planted error: when cut first, no new tile is left.
        let mut cut_first = ahead;
        cut_first.truncate(7 - found.urgent.len());
        assert!(columns(&cut_first).iter().all(|column| columns(&found.urgent).contains(column)));
    }

    #[test]
    fn without_room_the_most_urgent_stay() {
        let found = queues(tiles([4, 1, 3, 0, 2, 1]), tiles(0..9), 3);
        assert_eq!((columns(&found.urgent), found.without_room), (vec![0, 1, 2], 2));
        assert!(found.soon.is_empty());
    }
}
