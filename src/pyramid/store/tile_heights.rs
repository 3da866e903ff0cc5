//! The heights of a tile of any level, also where a sparse pyramid has only a coarser one.

use std::sync::Arc;

use glam::{DVec2, UVec2};

use super::tile_store::TileStore;
use crate::pyramid::PyramidError;
use crate::pyramid::surface::levels::LevelSize;
use crate::pyramid::surface::loaded_tile::LoadedTile;
use crate::pyramid::surface::tile_height::{height_in_tile, tile_at};
use crate::pyramid::tile::{TILE_BORDER, TILE_SAMPLES, TILE_STRIDE, TileAddress, is_void};

/// Number of coarser tiles in memory while a missing tile is read.
const COARSER_TILES: usize = 4;

/// Reads the 256 × 256 heights of a tile in metres, row by row: NaN where there is no land, and anything beyond the
/// border of the level.
///
/// # Errors
/// The tile, or a coarser one that has its detail, cannot be read.
pub(crate) fn tile_heights_m(store: &Arc<dyn TileStore>, address: TileAddress) -> Result<Vec<f32>, PyramidError> {
    if store.has_tile(address) {
        let loaded = Arc::clone(store).load(address)?;
        let height_of = |served: f32| if is_void(served) { f32::NAN } else { served };
        let rows = (0..TILE_SAMPLES).flat_map(|row| {
            let start = ((row + TILE_BORDER) * TILE_STRIDE + TILE_BORDER) as usize;
            loaded.tile.samples[start..start + TILE_SAMPLES as usize].iter().map(move |served| height_of(*served))
        });
        return Ok(rows.collect());
    }
    // A sparse pyramid: a coarser tile has all the detail.
    let levels = store.levels();
    let scale = samples_of(levels[0]) / samples_of(levels[address.level as usize]);
    let first = UVec2::new(address.x, address.y) * TILE_SAMPLES;
    // Rows cross the borders of coarser tiles.
    let mut loaded: Vec<(TileAddress, LoadedTile)> = Vec::new();
    let mut heights_m = Vec::with_capacity((TILE_SAMPLES * TILE_SAMPLES) as usize);
    for (row, column) in (0..TILE_SAMPLES).flat_map(|row| (0..TILE_SAMPLES).map(move |column| (row, column))) {
        let at = ((first + UVec2::new(column, row)).as_dvec2() + 0.5) * scale - 0.5;
        let coarser = (address.level..levels.len() as u32).map(|level| tile_at(levels, level, at.x, at.y));
        let known = coarser.flatten().find(|address| store.has_tile(*address));
        let height_m = match known {
            None => None,
            Some(address) => {
                if !loaded.iter().any(|(of, _)| *of == address) {
                    loaded.truncate(COARSER_TILES - 1);
                    loaded.insert(0, (address, Arc::clone(store).load(address)?));
                }
                let from = loaded.iter().find(|(of, _)| *of == address);
                from.and_then(|(_, from)| height_in_tile(levels, address, &from.tile, at.x, at.y))
            }
        };
        heights_m.push(height_m.map_or(f32::NAN, |height_m| height_m as f32));
    }
    Ok(heights_m)
}

fn samples_of(size: LevelSize) -> DVec2 {
    DVec2::new(f64::from(size.width), f64::from(size.height))
}
