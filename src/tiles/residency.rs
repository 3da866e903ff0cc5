//! Which tiles a view needs, and the table that tells the GPU where they are.
//!
//! A tile is needed where the surface's level (`level_at` in `shaders/shared/terrain.wgsl`) may reach down to it: the
//! footprint of a pixel is finer than its parent's samples, or its parent's measured error would be seen. Parents are
//! always needed too, so a tile that is not there has an ancestor that stands in.

use bytemuck::{Pod, Zeroable};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::atlas::Atlas;
use super::frustum::{Bounds, Frustum};
use super::warp::Warp;
use crate::gpu::Gpu;
use crate::pyramid::statistics::Voids;
use crate::pyramid::{Pyramid, PyramidError, TILE_SAMPLES, TileAddress};

/// How the surface chooses its level; shared with the shader.
#[derive(Clone, Debug)]
pub struct LevelRule {
    /// In the world.
    pub camera_m: DVec3,
    /// What is in view.
    pub frusta: Vec<Frustum>,
    /// Pixels per radian.
    pub focal_px: f64,
    /// Height error that the level may add.
    pub error_px: f64,
    /// Added to log2(footprint / spacing).
    pub bias: f64,
}

/// What loading for a frame did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Loaded {
    /// Tiles that the view needs.
    pub wanted: u64,
    /// Tiles read for it.
    pub loaded: u64,
    /// Tiles for which there was no room: coarser ones stand in.
    pub without_room: u64,
    /// Tiles that could not be read: coarser ones stand in.
    pub failed: u64,
}

/// A level as the shader reads it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct LevelInfo {
    scale: [f32; 2],
    fraction: [f32; 2],
    cell: [i32; 2],
    size: [i32; 2],
    first_page: u32,
    tiles_x: u32,
    first_corner: u32,
    pad: u32,
}

crate::gpu::shared::describe!(LevelInfo as "Level" in "surface/resolve": scale, fraction, cell, size, first_page, tiles_x, first_corner, pad);

/// The tiles that `rule` needs, coarse levels first.
pub fn needed(pyramid: &Pyramid, warp: &Warp, rule: &LevelRule) -> Vec<TileAddress> {
    let mut needed = Vec::new();
    let top = pyramid.levels().len() as u32 - 1;
    let size = pyramid.levels()[top as usize];
    let mut wave: Vec<_> =
        (0..size.tiles_y()).flat_map(|y| (0..size.tiles_x()).map(move |x| TileAddress { level: top, x, y })).collect();
    while !wave.is_empty() {
        needed.extend_from_slice(&wave);
        wave = wave
            .into_iter()
            .filter(|tile| reaches_below(pyramid, warp, rule, *tile))
            .flat_map(|tile| children(pyramid, tile))
            .collect();
    }
    needed
}

/// Whether the surface somewhere in the tile is finer than the tile's level.
fn reaches_below(pyramid: &Pyramid, warp: &Warp, rule: &LevelRule, tile: TileAddress) -> bool {
    if tile.level == 0 || pyramid.tile(tile).voids == Voids::All {
        return false;
    }
    let bounds = bounds(pyramid, warp, rule.camera_m, tile);
    if !rule.frusta.iter().any(|view| view.may_see(&bounds)) {
        return false;
    }
    // As the vertex shader does: in height, only the whole terrain's range is known.
    let flat = DVec2::ZERO.clamp(bounds.low_m.truncate(), bounds.high_m.truncate());
    let dz_m = 0_f64.clamp(f64::from(pyramid.min_m()) - rule.camera_m.z, f64::from(pyramid.max_m()) - rule.camera_m.z);
    let pixel_m = flat.extend(dz_m).length() / rule.focal_px;
    let wanted = (pixel_m / warp.spacing_m()).log2() + rule.bias;
    wanted < f64::from(tile.level) || f64::from(error_around_m(pyramid, tile)) > rule.error_px * pixel_m
}

/// The largest error of a tile and its eight neighbours: the shader's continuous bound reaches that far.
fn error_around_m(pyramid: &Pyramid, tile: TileAddress) -> f32 {
    let mut error_m = 0.0_f32;
    for dy in -1..=1 {
        for dx in -1..=1 {
            let (Some(x), Some(y)) = (tile.x.checked_add_signed(dx), tile.y.checked_add_signed(dy)) else { continue };
            error_m = error_m.max(tile_error_m(pyramid, TileAddress { x, y, ..tile }));
        }
    }
    error_m
}

/// The error of a tile; 0 where there is none.
fn tile_error_m(pyramid: &Pyramid, tile: TileAddress) -> f32 {
    let size = pyramid.levels()[tile.level as usize];
    if tile.x < size.tiles_x() && tile.y < size.tiles_y() { pyramid.tile(tile).error_m } else { 0.0 }
}

fn bounds(pyramid: &Pyramid, warp: &Warp, camera_m: DVec3, tile: TileAddress) -> Bounds {
    let finest = pyramid.levels()[0];
    let size = pyramid.levels()[tile.level as usize];
    let scale =
        DVec2::new(f64::from(finest.width) / f64::from(size.width), f64::from(finest.height) / f64::from(size.height));
    let last = DVec2::new(f64::from(finest.width - 1), f64::from(finest.height - 1));
    let side = f64::from(TILE_SAMPLES);
    let first = DVec2::new(f64::from(tile.x), f64::from(tile.y)) * side * scale - 1.0;
    let end = (first + side * scale + 2.0).min(last);
    let first = first.clamp(DVec2::ZERO, last);
    let (low, high) = warp.bounds(first, end);
    // The whole range in height: the level rule knows no better.
    Bounds {
        low_m: low.extend(f64::from(pyramid.min_m())) - camera_m,
        high_m: high.extend(f64::from(pyramid.max_m())) - camera_m,
    }
}

/// The tiles of the next finer level whose samples lie in a tile. In odd sizes a child may reach over two parents; it
/// belongs to both.
fn children(pyramid: &Pyramid, tile: TileAddress) -> impl Iterator<Item = TileAddress> + use<> {
    let fine = pyramid.levels()[tile.level as usize - 1];
    let (last_x, last_y) = (fine.tiles_x() - 1, fine.tiles_y() - 1);
    let range = |t: u32, last: u32| (2 * t).min(last)..=(2 * t + 1).min(last);
    range(tile.y, last_y)
        .flat_map(move |y| range(tile.x, last_x).map(move |x| TileAddress { level: tile.level - 1, x, y }))
}

/// Reads the needed tiles that are not in the atlas, on all cores, and puts them there.
pub fn load(gpu: &Gpu, pyramid: &Pyramid, atlas: &mut Atlas, needed: &[TileAddress], frame: u64) -> Loaded {
    let missing: Vec<_> = needed.iter().copied().filter(|tile| !atlas.want(*tile, frame)).collect();
    let mut loaded = Loaded { wanted: needed.len() as u64, ..Loaded::default() };
    // In parts, so that a long list does not stand in memory twice.
    for part in missing.chunks(64) {
        let tiles: Vec<Result<_, PyramidError>> = part.par_iter().map(|tile| pyramid.read_tile(*tile)).collect();
        for (address, tile) in part.iter().zip(tiles) {
            match tile {
                Ok(tile) if atlas.insert(gpu, *address, &tile, frame) => loaded.loaded += 1,
                Ok(_) => loaded.without_room += 1,
                Err(error) => {
                    tracing::warn!("{}", crate::file::one_line(&chain(&error)));
                    loaded.failed += 1;
                }
            }
        }
    }
    loaded
}

/// An error with its causes.
fn chain(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text += &format!(": {error}");
        cause = error.source();
    }
    text
}

/// The page table: for every tile of every level its slot and level, or those of the ancestor that stands in.
pub fn pages(pyramid: &Pyramid, atlas: &Atlas) -> Vec<u32> {
    let levels = pyramid.levels();
    let mut by_level: Vec<Vec<u32>> = vec![Vec::new(); levels.len()];
    for (level, size) in levels.iter().enumerate().rev() {
        let mut pages = Vec::with_capacity(size.tiles_x() as usize * size.tiles_y() as usize);
        for y in 0..size.tiles_y() {
            for x in 0..size.tiles_x() {
                let address = TileAddress { level: level as u32, x, y };
                pages.push(match atlas.slot(address) {
                    Some(slot) => slot | (level as u32) << 24,
                    None => by_level.get(level + 1).map_or(0, |parents| {
                        let coarse = levels[level + 1];
                        let (x, y) = ((x / 2).min(coarse.tiles_x() - 1), (y / 2).min(coarse.tiles_y() - 1));
                        parents[(y * coarse.tiles_x() + x) as usize]
                    }),
                });
            }
        }
        by_level[level] = pages;
    }
    by_level.concat()
}

/// For each level the errors at the corners of its tiles, row by row.
pub fn corner_errors_m(pyramid: &Pyramid) -> Vec<f32> {
    let mut corners = Vec::new();
    for (level, size) in pyramid.levels().iter().enumerate() {
        for y in 0..=size.tiles_y() {
            for x in 0..=size.tiles_x() {
                let around =
                    [(x.wrapping_sub(1), y.wrapping_sub(1)), (x, y.wrapping_sub(1)), (x.wrapping_sub(1), y), (x, y)];
                let error_m = around
                    .iter()
                    .map(|&(x, y)| tile_error_m(pyramid, TileAddress { level: level as u32, x, y }))
                    .fold(0.0, f32::max);
                corners.push(error_m);
            }
        }
    }
    corners
}

/// The levels relative to an anchor.
pub fn level_infos(pyramid: &Pyramid, anchor: DVec2) -> Vec<LevelInfo> {
    let finest = pyramid.levels()[0];
    let (mut first_page, mut first_corner) = (0, 0);
    let mut infos = Vec::new();
    for size in pyramid.levels() {
        let scale = DVec2::new(
            f64::from(size.width) / f64::from(finest.width),
            f64::from(size.height) / f64::from(finest.height),
        );
        // The registration of the pyramid: areas, not samples, lie on each other.
        let at_anchor = (anchor + 0.5) * scale - 0.5;
        let cell = at_anchor.floor();
        infos.push(LevelInfo {
            scale: scale.as_vec2().to_array(),
            fraction: (at_anchor - cell).as_vec2().to_array(),
            cell: cell.as_ivec2().to_array(),
            size: [size.width as i32, size.height as i32],
            first_page,
            tiles_x: size.tiles_x(),
            first_corner,
            pad: 0,
        });
        first_page += size.tiles_x() * size.tiles_y();
        first_corner += (size.tiles_x() + 1) * (size.tiles_y() + 1);
    }
    infos
}
