//! The page table, by which `shaders/shared/terrain.wgsl` finds a tile: for each level the rows of tiles that the view
//! needs, for each row its first column and number of tiles, and for each tile its slot in the atlas, its residency
//! floor, and its errors. Its size depends on the view, not on the world.
//!
//! Why: `docs/decisions/page-table.md`.

use bytemuck::Zeroable;
use glam::{DVec2, Vec2};
use rustc_hash::{FxHashMap, FxHashSet};

use super::atlas::Atlas;
use super::needed::children;
use super::residency::Residency;
use super::residency_floor::ResidencyFloor;
use super::slot_maps::SlotMaps;
use super::water_maps::WaterMaps;
pub(crate) use crate::gpu::wgsl::shared::terrain::Level as LevelInfo;
pub(crate) use crate::gpu::wgsl::shared::terrain::TileRecord;
pub(crate) use crate::gpu::wgsl::shared::terrain::TileRow;
use crate::pyramid::{LevelSize, TileAddress, TileStore};

/// The slot of a tile that is not in the atlas.
const NO_SLOT: u32 = crate::gpu::wgsl::shared::terrain::NO_SLOT;
/// The map floor of a tile without a map.
const NO_MAP: u32 = crate::gpu::wgsl::shared::terrain::NO_MAP;
/// The map floor of a tile whose map is not used: nearly 1 at each corner, which is as good as 1 but not `NO_MAP`.
const ALL_BLOCKED: u32 = 0xfefe_fefe;
/// The record of a tile that the surface does not use.
const NOTHING: TileRecord = TileRecord {
    errors_m: [0.0; 4],
    blocked: u32::MAX,
    slot: NO_SLOT,
    is_finest: 0,
    unlit: NO_MAP,
    shoreless: NO_MAP,
    pad_a: 0,
    pad_b: 0,
    pad_c: 0,
};

/// The versions of all that a page table depends on: tables of the same versions are equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TableVersion {
    /// Version of the needed tiles and of those on the GPU.
    pub residency: u64,
    /// Version of the residency floor.
    pub floor: u64,
    /// Versions of the maps; `None` while they are not requested.
    pub horizon_maps: Option<u64>,
    pub water_maps: Option<u64>,
}

/// The page table, as three lists for the GPU.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct PageTable {
    /// The levels of the pyramid, finest first; not registered ([`PageTable::registered`]).
    levels: Vec<LevelInfo>,
    /// The rows of tiles that the view needs, by level.
    pub rows: Vec<TileRow>,
    /// The tiles of these rows, by row.
    pub tiles: Vec<TileRecord>,
}

impl PageTable {
    /// Builds the table of the tiles that are needed and in the atlas.
    pub(crate) fn new(
        store: &dyn TileStore,
        residency: &Residency,
        horizon_maps: Option<&SlotMaps<Vec2>>,
        water_maps: Option<&WaterMaps>,
    ) -> Self {
        let (atlas, floor) = (&residency.atlas, &residency.floor);
        let is_there = |address: &TileAddress| atlas.get(*address).is_some();
        let mut there: Vec<TileAddress> = residency.needed.iter().map(|tile| tile.address).filter(is_there).collect();
        there.sort_unstable_by_key(|tile| (tile.level, tile.y, tile.x));
        there.dedup();
        let corner_errors = (!store.is_measured()).then(|| shared_corners(atlas, &there));
        // A tile may be in both lists.
        let needed: FxHashSet<TileAddress> = there.iter().copied().collect();
        let of_maps = residency.map_neighbours.iter().chain(&residency.mapped_ahead).copied();
        let for_maps: FxHashSet<TileAddress> =
            of_maps.filter(|tile| is_there(tile) && !needed.contains(tile)).collect();
        if !for_maps.is_empty() {
            there.extend(&for_maps);
            there.sort_unstable_by_key(|tile| (tile.level, tile.y, tile.x));
        }
        let mut table = Self::default();
        let mut next = there.iter().copied().peekable();
        for level in 0..store.levels().len() {
            let (first_row, mut top) = (table.rows.len(), 0);
            while let Some(first) = next.peek().copied().filter(|tile| tile.level as usize == level) {
                if table.rows.len() == first_row {
                    top = first.y;
                }
                // Rows without tiles between other rows are empty.
                table.rows.resize(first_row + (first.y - top) as usize, TileRow::default());
                let first_tile = table.tiles.len();
                while let Some(tile) = next.next_if(|tile| (tile.level, tile.y) == (first.level, first.y)) {
                    table.tiles.resize(first_tile + (tile.x - first.x) as usize, NOTHING);
                    let mut record = if for_maps.contains(&tile) {
                        // The surface uses only tiles that the view needs; this one is only for its maps.
                        TileRecord { slot: atlas.get(tile).map_or(NO_SLOT, |resident| resident.slot), ..NOTHING }
                    } else {
                        record(store, atlas, floor, tile, corner_errors.as_ref())
                    };
                    let unlit = horizon_maps.and_then(|maps| maps.floor_at(atlas, tile));
                    record.unlit = unlit.map_or(NO_MAP, |unlit| without_map(record.blocked, unlit));
                    let shoreless = water_maps.and_then(|maps| maps.floor_at(atlas, tile));
                    record.shoreless = shoreless.map_or(NO_MAP, |floor| without_map(record.blocked, floor));
                    table.tiles.push(record);
                }
                table.rows.push(TileRow {
                    left: first.x as i32,
                    count: (table.tiles.len() - first_tile) as i32,
                    first_tile: first_tile as i32,
                    pad: 0,
                });
            }
            let row_count = (table.rows.len() - first_row) as i32;
            let rows = LevelInfo { first_row: first_row as i32, top: top as i32, row_count, ..Zeroable::zeroed() };
            table.levels.push(rows);
        }
        table
    }

    /// Returns the levels for grid coordinates that count from the sample `anchor`. `levels` are their sizes.
    pub(crate) fn registered(&self, levels: &[LevelSize], anchor: DVec2) -> Vec<LevelInfo> {
        let sizes = levels.iter().copied();
        self.levels.iter().zip(sizes).map(|(rows, size)| registered(*rows, size, levels[0], anchor)).collect()
    }
}

/// Returns the registration of a level relative to the finest one, around the anchor.
fn registered(rows: LevelInfo, size: LevelSize, finest: LevelSize, anchor: DVec2) -> LevelInfo {
    let scale =
        DVec2::new(f64::from(size.width) / f64::from(finest.width), f64::from(size.height) / f64::from(finest.height));
    // In the registration of the pyramid, areas coincide, not samples.
    let at_anchor = (anchor + 0.5) * scale - 0.5;
    let cell = at_anchor.floor();
    LevelInfo {
        scale: scale.as_vec2().to_array(),
        fraction: (at_anchor - cell).as_vec2().to_array(),
        cell: cell.as_ivec2().to_array(),
        size: [size.width as i32, size.height as i32],
        ..rows
    }
}

type CornerErrors = FxHashMap<(u32, u32, u32), f32>;

/// Computes the errors at corners where errors are estimates of single tiles: the largest of those that meet at a
/// corner.
fn shared_corners(atlas: &Atlas, tiles: &[TileAddress]) -> CornerErrors {
    let mut corners = CornerErrors::default();
    for tile in tiles {
        let Some(resident) = atlas.get(*tile) else { continue };
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let error_m = corners.entry((tile.level, tile.x + dx, tile.y + dy)).or_insert(0.0);
            *error_m = error_m.max(resident.statistics().error_m);
        }
    }
    corners
}

fn record(
    store: &dyn TileStore,
    atlas: &Atlas,
    floor: &ResidencyFloor,
    tile: TileAddress,
    corners: Option<&CornerErrors>,
) -> TileRecord {
    let (slot, mut errors_m) = match atlas.get(tile) {
        Some(resident) => (resident.slot, resident.statistics().corner_errors_m),
        None => (NO_SLOT, [0.0; 4]),
    };
    if let Some(corners) = corners {
        let at = |i: u32| corners.get(&(tile.level, tile.x + i % 2, tile.y + i / 2)).copied().unwrap_or(0.0);
        errors_m = [at(0), at(1), at(2), at(3)];
    }
    let blocked = u32::from_le_bytes(floor.at(tile).map(byte));
    TileRecord { errors_m, blocked, slot, is_finest: u32::from(is_finest(store, tile)), ..NOTHING }
}

/// Converts 0 to 1 into 8 bits; only 0 gives 0.
fn byte(value: f32) -> u8 {
    (value.clamp(0.0, 1.0) * 255.0).ceil() as u8
}

/// Returns the floor of a tile with a map: the map is used where the surface of its tile is, and where the maps around
/// it exist.
fn without_map(blocked: u32, floor: [f32; 4]) -> u32 {
    let blocked = blocked.to_le_bytes();
    let bytes = std::array::from_fn(|corner| byte(floor[corner]).max(blocked[corner]));
    if bytes == [255; 4] { ALL_BLOCKED } else { u32::from_le_bytes(bytes) }
}

/// Returns whether somewhere in this tile no finer tile exists.
fn is_finest(store: &dyn TileStore, tile: TileAddress) -> bool {
    tile.level == 0 || children(store.levels(), tile).any(|child| !store.has_tile(child))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_is_used_where_its_surface_is() {
        assert_eq!(without_map(0, [0.0; 4]), 0);
        assert_eq!(without_map(0x40, [0.0, 0.5, 0.0, 1.0]).to_le_bytes(), [0x40, 128, 0, 255]);
        assert_eq!(without_map(0x40, [0.5; 4]).to_le_bytes(), [128; 4]);
        // A map that exists but is not used differs from no map.
        assert!(without_map(u32::MAX, [0.0; 4]) != NO_MAP && without_map(0, [1.0; 4]) != NO_MAP);
    }
}
