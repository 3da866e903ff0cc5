//! What `shaders/shared/terrain.wgsl` reads to find a tile: for each level the rows of tiles that the view needs, for
//! each row its first column and number of tiles, and for each tile its slot in the atlas, what blocks it, and its
//! errors. Their size follows the view and not the world.
//!
//! This is the page table. Why: `docs/decisions/page-table.md`.

use bytemuck::{Pod, Zeroable};
use glam::DVec2;
use rustc_hash::{FxHashMap, FxHashSet};

use super::atlas::Atlas;
use super::blocked::Blocked;
use super::needed::children;
use super::residency::Residency;
use super::seen::SeenTiles;
use crate::pyramid::{LevelSize, TileAddress, TileStore};

/// A level as the shader reads it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable, PartialEq)]
pub struct LevelInfo {
    scale: [f32; 2],
    fraction: [f32; 2],
    cell: [i32; 2],
    size: [i32; 2],
    /// In the list of rows.
    first_row: i32,
    /// The row of tiles that it is.
    top: i32,
    row_count: i32,
    pad: i32,
}

crate::gpu::shared::describe!(LevelInfo as "Level" in "surface/resolve": scale, fraction, cell, size, first_row, top, row_count, pad);

/// A row of tiles.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable, PartialEq)]
pub struct TileRow {
    /// Column of its first tile.
    left: i32,
    count: i32,
    /// In the list of tiles.
    first_tile: i32,
    pad: i32,
}

crate::gpu::shared::describe!(TileRow as "TileRow" in "surface/resolve": left, count, first_tile, pad);

/// A tile.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable, PartialEq)]
pub struct TileRecord {
    /// At its corners, in metres: see `TileStatistics::corner_errors_m`.
    errors_m: [f32; 4],
    /// At its corners: see [`Blocked`]. Four numbers of 8 bits.
    blocked: u32,
    /// In the atlas; [`NO_SLOT`] for a tile that is not there.
    slot: u32,
    /// 1 where no finer tile exists: its surface is followed between the samples.
    is_finest: u32,
    /// 1 where what the tile sees of the sun and the sky is known.
    lit: u32,
}

crate::gpu::shared::describe!(TileRecord as "TileRecord" in "surface/resolve": errors_m, blocked, slot, is_finest, lit);

/// What a record says of a tile that is not there.
const NO_SLOT: u32 = u32::MAX;
/// Of a tile that the surface does not use.
const NOTHING: TileRecord = TileRecord { errors_m: [0.0; 4], blocked: u32::MAX, slot: NO_SLOT, is_finest: 0, lit: 0 };

/// All of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tables {
    /// Finest first.
    pub levels: Vec<LevelInfo>,
    /// By level.
    pub rows: Vec<TileRow>,
    /// By row.
    pub tiles: Vec<TileRecord>,
}

impl Tables {
    /// For the tiles that are needed and in the atlas. `anchor` is the sample that grid coordinates count from.
    pub fn new(store: &dyn TileStore, residency: &Residency, seen: Option<&SeenTiles>, anchor: DVec2) -> Self {
        let (atlas, blocked) = (&residency.atlas, &residency.blocked);
        let is_there = |address: &TileAddress| atlas.get(*address).is_some();
        let mut there: Vec<TileAddress> = residency.needed.iter().map(|tile| tile.address).filter(is_there).collect();
        there.sort_unstable_by_key(|tile| (tile.level, tile.y, tile.x));
        there.dedup();
        let corner_errors = (!store.is_measured()).then(|| shared_corners(atlas, &there));
        let beside: FxHashSet<TileAddress> = residency.beside.iter().copied().filter(is_there).collect();
        if !beside.is_empty() {
            there.extend(&beside);
            there.sort_unstable_by_key(|tile| (tile.level, tile.y, tile.x));
        }
        let mut tables = Self::default();
        let mut next = there.iter().copied().peekable();
        for (level, size) in store.levels().iter().enumerate() {
            let (first_row, mut top) = (tables.rows.len(), 0);
            while let Some(first) = next.peek().copied().filter(|tile| tile.level as usize == level) {
                if tables.rows.len() == first_row {
                    top = first.y;
                }
                // Rows without tiles between others are empty.
                tables.rows.resize(first_row + (first.y - top) as usize, TileRow::default());
                let first_tile = tables.tiles.len();
                while let Some(tile) = next.next_if(|tile| (tile.level, tile.y) == (first.level, first.y)) {
                    tables.tiles.resize(first_tile + (tile.x - first.x) as usize, NOTHING);
                    let mut record = if beside.contains(&tile) {
                        // The surface goes by what the view needs; only horizons look at this one.
                        TileRecord { slot: atlas.get(tile).map_or(NO_SLOT, |resident| resident.slot), ..NOTHING }
                    } else {
                        record(store, atlas, blocked, tile, corner_errors.as_ref())
                    };
                    record.lit = u32::from(seen.is_some_and(|seen| seen.is_lit(atlas, tile)));
                    tables.tiles.push(record);
                }
                tables.rows.push(TileRow {
                    left: first.x as i32,
                    count: (tables.tiles.len() - first_tile) as i32,
                    first_tile: first_tile as i32,
                    pad: 0,
                });
            }
            let row_count = (tables.rows.len() - first_row) as i32;
            let rows = LevelInfo { first_row: first_row as i32, top: top as i32, row_count, ..Zeroable::zeroed() };
            tables.levels.push(registered(rows, *size, store.levels()[0], anchor));
        }
        tables
    }
}

/// How a level lies over the finest one, as seen from the anchor.
fn registered(rows: LevelInfo, size: LevelSize, finest: LevelSize, anchor: DVec2) -> LevelInfo {
    let scale =
        DVec2::new(f64::from(size.width) / f64::from(finest.width), f64::from(size.height) / f64::from(finest.height));
    // The registration of the pyramid: areas, not samples, lie on each other.
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

/// Where errors are estimates of single tiles: the largest of those that meet at a corner.
fn shared_corners(atlas: &Atlas, tiles: &[TileAddress]) -> CornerErrors {
    let mut corners = CornerErrors::default();
    for tile in tiles {
        let Some(resident) = atlas.get(*tile) else { continue };
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let error_m = corners.entry((tile.level, tile.x + dx, tile.y + dy)).or_insert(0.0);
            *error_m = error_m.max(resident.statistics.error_m);
        }
    }
    corners
}

fn record(
    store: &dyn TileStore,
    atlas: &Atlas,
    blocked: &Blocked,
    tile: TileAddress,
    corners: Option<&CornerErrors>,
) -> TileRecord {
    let (slot, mut errors_m) = match atlas.get(tile) {
        Some(resident) => (resident.slot, resident.statistics.corner_errors_m),
        None => (NO_SLOT, [0.0; 4]),
    };
    if let Some(corners) = corners {
        let at = |i: u32| corners.get(&(tile.level, tile.x + i % 2, tile.y + i / 2)).copied().unwrap_or(0.0);
        errors_m = [at(0), at(1), at(2), at(3)];
    }
    let bytes = blocked.at(tile).map(|value| (value.clamp(0.0, 1.0) * 255.0).ceil() as u8);
    TileRecord {
        errors_m,
        blocked: u32::from_le_bytes(bytes),
        slot,
        is_finest: u32::from(is_finest(store, tile)),
        lit: 0,
    }
}

/// Whether somewhere in this tile nothing finer exists.
fn is_finest(store: &dyn TileStore, tile: TileAddress) -> bool {
    tile.level == 0 || children(store.levels(), tile).any(|child| !store.has_tile(child))
}
