//! The measured error of every tile: how far its level's surface is from the full-resolution heights in its area.
//!
//! All full-resolution samples of a row share their vertical weights, so a row costs one weighted sum of four level
//! rows and then four products for each sample.

use rayon::prelude::*;

use super::levels::{LevelSize, coordinate};
use super::statistics::{Range, TileStatistics, rounded_up};
use super::{TILE_SAMPLES, bicubic};

/// Where a full-resolution column lies on the level.
struct Column {
    cell: u32,
    weights: [f64; 4],
    tile: u32,
}

/// For every tile of the level, row-major, the largest |H(f) − h(f)| in metres over the valid samples f of `heights_m`
/// (full resolution, NaN for voids) in its area. `served` is the level as its tiles serve it. A sample f belongs to
/// the tile that holds the level's sample whose area covers the centre of f.
pub fn tile_errors_m(heights_m: &[f32], finest: LevelSize, served: &[f32], size: LevelSize) -> Vec<f32> {
    let columns: Vec<Column> = (0..finest.width)
        .map(|f| {
            let c = coordinate(f.into(), finest.width, size.width);
            let (cell, fraction) = bicubic::cell(c, size.width);
            Column { cell, weights: bicubic::weights(fraction), tile: (c + 0.5) as u32 / TILE_SAMPLES }
        })
        .collect();
    let tiles_x = size.tiles_x() as usize;
    let rows: Vec<(usize, Vec<f64>)> = heights_m
        .par_chunks_exact(finest.width as usize)
        .enumerate()
        .map_init(Vec::new, |across, (f, heights_m)| {
            let c = coordinate(f as f64, finest.height, size.height);
            across_row(served, size, c, across);
            let mut errors_m = vec![0.0; tiles_x];
            for (height, column) in heights_m.iter().zip(&columns) {
                if !height.is_nan() {
                    // `across` begins with column −1.
                    let four = &across[column.cell as usize..column.cell as usize + 4];
                    let surface: f64 = four.iter().zip(column.weights).map(|(across, weight)| across * weight).sum();
                    let error = (surface - f64::from(*height)).abs();
                    let worst: &mut f64 = &mut errors_m[column.tile as usize];
                    *worst = worst.max(error);
                }
            }
            ((c + 0.5) as usize / TILE_SAMPLES as usize, errors_m)
        })
        .collect();
    let mut errors_m = vec![0.0; tiles_x * size.tiles_y() as usize];
    for (tile_row, row) in rows {
        for (worst, error) in errors_m[tile_row * tiles_x..].iter_mut().zip(row) {
            *worst = rounded_up(error).max(*worst);
        }
    }
    errors_m
}

/// The level's surface along the row coordinate `c`, at its columns −1 ..= width + 1 (clamped).
fn across_row(served: &[f32], size: LevelSize, c: f64, across: &mut Vec<f64>) {
    let width = size.width as usize;
    let (cell, fraction) = bicubic::cell(c, size.height);
    let weights = bicubic::weights(fraction);
    let row = |k: u32| {
        let start = bicubic::neighbour(cell, k, size.height) as usize * width;
        &served[start..start + width]
    };
    let rows = [row(0), row(1), row(2), row(3)];
    across.clear();
    across.push(0.0);
    across.extend((0..width).map(|x| (0..4).map(|k| weights[k] * f64::from(rows[k][x])).sum::<f64>()));
    across[0] = across[1];
    let last = across[width];
    across.extend([last; 2]);
}

/// The statistics of every tile of a level, row-major, from the level as its tiles serve it.
pub fn tile_statistics(served: &[f32], size: LevelSize, errors_m: &[f32]) -> Vec<TileStatistics> {
    (0..size.tiles_x() * size.tiles_y())
        .into_par_iter()
        .map(|tile| {
            let region = size.tile_region(tile % size.tiles_x(), tile / size.tiles_x(), 1);
            let mut range = Range::EMPTY;
            for row in region.y..region.y + region.height {
                let start = row as usize * size.width as usize + region.x as usize;
                range.add(&served[start..start + region.width as usize]);
            }
            let error_m = errors_m[tile as usize];
            TileStatistics {
                min_m: range.min_m,
                max_m: range.max_m,
                error_m,
                corner_errors_m: [error_m; 4],
                voids: range.voids(),
            }
        })
        .collect()
}
