//! The part of the land whose drainage a view shows, and its heights.

use std::sync::Arc;

use glam::{DVec2, DVec3, UVec2, dvec2};
use rayon::prelude::*;

use super::flow::Grid;
use crate::pyramid::PyramidError;
use crate::pyramid::store::{TileStore, tile_heights_m};
use crate::pyramid::surface::levels::LevelSize;
use crate::pyramid::tile::{TILE_SAMPLES, TileAddress};
use crate::scene::view::Rig;
use crate::tiles::grid_projection::GridProjection;

/// Largest number of samples of a region.
const MAX_SAMPLES: u64 = 1 << 22;
/// Largest number of samples to a pixel, along a side.
const SAMPLES_PER_PX: f64 = 1.3;
/// A region extends beyond what is in view by this part of its size, so that lines in view have most of what drains into
/// them.
const MARGIN: f64 = 0.15;
/// Land that is farther away than this many times the eye's height above it, or the range of heights if that is more, is
/// not looked at.
const FARTHEST: f64 = 20.0;
/// Rays along each side of the picture that find what is in view.
const RAYS: u32 = 8;

/// A rectangle of tiles of one level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Region {
    level: u32,
    /// First column and row of tiles, and those after the last.
    tiles: [UVec2; 2],
}

/// The land and where its samples are.
#[derive(Clone)]
pub(crate) struct Land {
    pub store: Arc<dyn TileStore>,
    pub projection: GridProjection,
}

impl Region {
    /// Returns the region that a rig sees; `None` if it sees no land.
    pub(crate) fn seen(land: &Land, rig: &Rig) -> Option<Self> {
        let range_m = land.store.range_m().map(f64::from);
        let ground_m = 0.5 * (range_m[0] + range_m[1]);
        let places = rig.eyes.iter().flat_map(|eye| {
            let eye_m = eye.pose.position_m;
            let above_m = (eye_m.z - ground_m).max(range_m[1] - range_m[0]).max(1.0);
            let size_px = DVec2::new(f64::from(eye.picture_px[0]), f64::from(eye.picture_px[1]));
            let steps = (0..=RAYS).flat_map(|y| (0..=RAYS).map(move |x| dvec2(f64::from(x), f64::from(y))));
            steps.map(move |step| {
                let ray = eye.ray(size_px * step / f64::from(RAYS));
                let across = ray.truncate().length();
                let reach = if ray.z < 0.0 { -above_m / ray.z } else { f64::INFINITY };
                let reach = reach.min(FARTHEST * above_m / across.max(1e-9));
                eye_m.truncate() + ray.truncate() * reach
            })
        });
        let finest = land.store.levels()[0];
        let last = samples_of(finest) - DVec2::ONE;
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for place_m in places {
            let place = land.projection.grid_from_world(place_m);
            if place.is_finite() {
                (low, high) = (low.min(place), high.max(place));
            }
        }
        let seen = (high - low).max(DVec2::ONE);
        let margin = MARGIN * seen;
        let (low, high) = ((low - margin).max(DVec2::ZERO), (high + margin).min(last));
        if !high.cmpgt(low).all() {
            return None;
        }
        let widest_px = rig.eyes.iter().map(|eye| f64::from(eye.picture_px[0].max(eye.picture_px[1])));
        let widest_px = widest_px.fold(1.0, f64::max);
        let wanted = (seen.max_element() / (SAMPLES_PER_PX * widest_px)).log2().ceil().max(0.0) as u32;
        Some(Self::bounded(land, wanted, [low, high]))
    }

    /// Returns the region around places on the grid, in samples of the finest level: at the wanted level, or at a coarser
    /// one if it would have more than [`MAX_SAMPLES`] samples.
    pub(crate) fn bounded(land: &Land, wanted: u32, [low, high]: [DVec2; 2]) -> Self {
        let levels = land.store.levels();
        let mut region = Self::around(land, wanted.min(levels.len() as u32 - 1), low, high);
        while region.level + 1 < levels.len() as u32 {
            let size = region.size(levels);
            if u64::from(size.x) * u64::from(size.y) <= MAX_SAMPLES {
                break;
            }
            region = Self::around(land, region.level + 1, low, high);
        }
        region
    }

    /// Returns the level of the pyramid.
    pub(crate) fn level(&self) -> u32 {
        self.level
    }

    /// Returns the column and the row in the region of a place on the grid, which is in samples of the finest level.
    pub(crate) fn column_and_row(&self, land: &Land, place: DVec2) -> DVec2 {
        let levels = land.store.levels();
        let scale = samples_of(levels[self.level as usize]) / samples_of(levels[0]);
        (place + 0.5) * scale - 0.5 - (self.tiles[0] * TILE_SAMPLES).as_dvec2()
    }

    /// Returns the tiles of a level around places in samples of the finest one.
    fn around(land: &Land, level: u32, low: DVec2, high: DVec2) -> Self {
        let levels = land.store.levels();
        let scale = samples_of(levels[level as usize]) / samples_of(levels[0]);
        let size = levels[level as usize];
        let last = UVec2::new(size.tiles_x(), size.tiles_y()) - UVec2::ONE;
        let tile =
            |place: DVec2| ((place * scale) / f64::from(TILE_SAMPLES)).floor().max(DVec2::ZERO).as_uvec2().min(last);
        Self { level, tiles: [tile(low), tile(high) + UVec2::ONE] }
    }

    /// Returns the number of columns and rows of samples.
    fn size(&self, levels: &[LevelSize]) -> UVec2 {
        let size = levels[self.level as usize];
        let end = (self.tiles[1] * TILE_SAMPLES).min(UVec2::new(size.width, size.height));
        end - self.tiles[0] * TILE_SAMPLES
    }

    /// Returns the place in the world, in metres, of a column and a row of the region.
    pub(crate) fn place_m(&self, land: &Land, at: DVec2) -> DVec2 {
        let levels = land.store.levels();
        let scale = samples_of(levels[0]) / samples_of(levels[self.level as usize]);
        let at = at + (self.tiles[0] * TILE_SAMPLES).as_dvec2();
        land.projection.world_from_grid((at + 0.5) * scale - 0.5)
    }

    /// Reads the heights.
    ///
    /// # Errors
    /// The first tile that cannot be read.
    pub(crate) fn read(&self, land: &Land) -> Result<Grid, PyramidError> {
        let size = self.size(land.store.levels());
        let middle = 0.5 * size.as_dvec2();
        let steps = [DVec2::X, DVec2::Y].map(|step| self.place_m(land, middle + step) - self.place_m(land, middle));
        let [first, end] = self.tiles;
        let tiles: Vec<UVec2> =
            (first.y..end.y).flat_map(|y| (first.x..end.x).map(move |x| UVec2::new(x, y))).collect();
        let read = |tile: &UVec2| tile_heights_m(&land.store, TileAddress { level: self.level, x: tile.x, y: tile.y });
        let read = tiles.par_iter().map(read).collect::<Result<Vec<_>, _>>()?;
        let mut heights_m = vec![f32::NAN; size.x as usize * size.y as usize];
        for (tile, heights) in tiles.iter().zip(&read) {
            let corner = (*tile - first) * TILE_SAMPLES;
            let columns = TILE_SAMPLES.min(size.x - corner.x) as usize;
            for (row, heights) in heights.chunks_exact(TILE_SAMPLES as usize).enumerate() {
                let y = corner.y as usize + row;
                if y < size.y as usize {
                    heights_m[y * size.x as usize + corner.x as usize..][..columns]
                        .copy_from_slice(&heights[..columns]);
                }
            }
        }
        Ok(Grid { size: [size.x as usize, size.y as usize], step_m: steps.map(DVec2::length), heights_m })
    }

    /// Returns a point of the world in the middle of the region, at height 0.
    pub(crate) fn middle_m(&self, land: &Land) -> DVec3 {
        self.place_m(land, 0.5 * self.size(land.store.levels()).as_dvec2()).extend(0.0)
    }
}

fn samples_of(size: LevelSize) -> DVec2 {
    DVec2::new(f64::from(size.width), f64::from(size.height))
}
