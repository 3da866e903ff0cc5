//! The procedural continent as a pyramid of tiles, each computed on demand.
//!
//! A smaller world is a square cut from the middle of the continent of the same seed, sample for sample; its side and
//! its corner are multiples of the coarsest level's sample size, so that its levels are those of the continent. Levels
//! coarser than the continent's base are averages of the base. Statistics are those of [`derive()`](super::derive()).

use std::path::Path;
use std::sync::Arc;

use super::cache::open_or_grow_store;
use super::derive::{coarse_patches, derive};
use super::tile_store::{Cancel, Decode, TileStore};
use crate::pyramid::error::PyramidError;
use crate::pyramid::surface::field::Field;
use crate::pyramid::surface::levels::{LevelSize, level_sizes};
use crate::pyramid::surface::loaded_tile::LoadedTile;
use crate::pyramid::surface::overview;
use crate::pyramid::surface::statistics::{PAGE_PATCHES, PatchStatistics};
use crate::pyramid::tile::{PATCH_QUADS, TILE_BORDER, TILE_SAMPLES, TILE_STRIDE, Tile, TileAddress, flagged};
use crate::source::continent::{self, BASE_LEVEL, BASE_SAMPLES, Continent, Exemplar, SIZE_SAMPLES, SPACING_M};
use crate::source::georeference::Georeference;
use crate::source::{HeightGrid, Progress, Window, procedural};

/// The version of the continent, part of the keys in the cache.
const VERSION: u32 = 1;

/// The seed of the built-in world that is the exemplar of all continents.
const EXEMPLAR_SEED: u32 = 1;

/// The smallest number of samples along a side.
pub(crate) const SMALLEST_SAMPLES: u32 = 64;

/// A continent, or a square from its middle.
pub struct ContinentStore {
    name: String,
    land: Continent,
    levels: Vec<LevelSize>,
    /// First column and row of the cut, in samples of level 0.
    offset: u32,
    /// The factor of heights: the sample spacing relative to the continent's own, times the exaggeration.
    scale: f32,
    /// The averages of the base, in metres, for the levels above [`BASE_LEVEL`].
    averages_m: Vec<Vec<f32>>,
    georeference: Georeference,
    range_m: [f32; 2],
    coarse_patches: Vec<Vec<PatchStatistics>>,
}

impl ContinentStore {
    /// Opens the continent of `seed`, which is grown into the cache at first use (seconds). A square of `size_samples`
    /// along a side is cut from its middle, a few more if levels need it, at most [`SIZE_SAMPLES`] and at least
    /// [`SMALLEST_SAMPLES`]. A `spacing_m` other than 10 scales the land, heights included. `cache_dir` is as for
    /// [`open_or_grow_store`].
    ///
    /// # Errors
    /// If the cache cannot be read or written.
    pub fn open(
        seed: u32,
        size_samples: u32,
        spacing_m: f64,
        cache_dir: Option<&Path>,
        progress: &dyn Progress,
    ) -> Result<Self, PyramidError> {
        let grow = move |progress: &dyn Progress| {
            let heights_m = continent::grow_base(seed, progress);
            let georeference = continent::georeference(BASE_SAMPLES, SPACING_M * f64::from(1_u32 << BASE_LEVEL));
            HeightGrid { width: BASE_SAMPLES, height: BASE_SAMPLES, heights_m, georeference }
        };
        let key = format!("continent {VERSION} seed {seed}");
        let base = open_or_grow_store(&key, &format!("continent-{seed}"), grow, cache_dir, progress)?;
        let grow = |progress: &dyn Progress| procedural::generate(EXEMPLAR_SEED, progress);
        let key = format!("procedural {} seed {EXEMPLAR_SEED}", procedural::VERSION);
        let exemplar = open_or_grow_store(&key, &format!("procedural-{EXEMPLAR_SEED}"), grow, cache_dir, progress)?;
        let exemplar = Exemplar::new(procedural::SIZE_SAMPLES, &level_0(&exemplar)?);
        Self::over(Continent::new(seed, level_0(&base)?, exemplar), seed, size_samples, spacing_m)
    }

    /// Creates the store of a continent in memory; otherwise like [`ContinentStore::open`].
    ///
    /// # Errors
    /// If the coarsest tile cannot be evaluated.
    pub(crate) fn over(land: Continent, seed: u32, size_samples: u32, spacing_m: f64) -> Result<Self, PyramidError> {
        let size = cut(size_samples);
        let levels = level_sizes(size, size);
        let mut averages: Vec<Field> = Vec::new();
        let mut width = BASE_SAMPLES;
        let square = |width: u32| LevelSize { width, height: width };
        for _ in BASE_LEVEL + 1..levels.len() as u32 {
            let whole = |heights_m: &[f32]| Field { region: square(width).region(), heights_m: heights_m.to_vec() };
            let finer = averages.last().cloned().unwrap_or_else(|| whole(land.base_m()));
            let coarser = square(width / 2);
            averages.push(overview::next_level(&finer, square(width), coarser, coarser.region()));
            width /= 2;
        }
        let offset = (SIZE_SAMPLES - size) / 2;
        let scale = (spacing_m / SPACING_M) as f32;
        let mut store = Self {
            name: format!("continent {seed} of {size} × {size} samples"),
            range_m: land.range_m(offset, size).map(|height| height * scale),
            georeference: continent::georeference(size, spacing_m),
            land,
            levels,
            offset,
            scale,
            averages_m: averages.into_iter().map(|field| field.heights_m).collect(),
            coarse_patches: Vec::new(),
        };
        let top = TileAddress { level: store.levels.len() as u32 - 1, x: 0, y: 0 };
        store.coarse_patches = coarse_patches(&store.levels, &store.evaluate(top)?);
        Ok(store)
    }

    /// Returns the heights in metres of a window of a level, row by row; the window is inside the level.
    pub(crate) fn heights_m(&self, level: u32, window: Window) -> Vec<f32> {
        let first = self.offset >> level;
        let window = Window { x: window.x + first, y: window.y + first, ..window };
        let mut heights_m = match level.checked_sub(BASE_LEVEL + 1) {
            None => self.land.heights_m(level, window),
            Some(above) => {
                let width = (SIZE_SAMPLES >> level) as usize;
                let rows = self.averages_m[above as usize].chunks_exact(width);
                let rows = rows.skip(window.y as usize).take(window.height as usize);
                rows.flat_map(|row| &row[window.x as usize..(window.x + window.width) as usize]).copied().collect()
            }
        };
        if self.scale != 1.0 {
            heights_m.iter_mut().for_each(|height| *height *= self.scale);
        }
        heights_m
    }

    /// Returns a whole level as a grid, for worlds that fit in memory.
    #[cfg(test)]
    pub(crate) fn grid(&self, level: u32) -> HeightGrid {
        let size = self.levels[level as usize];
        let spacing_m = self.georeference.crs_from_grid[1] * f64::from(1_u32 << level);
        HeightGrid {
            width: size.width,
            height: size.height,
            heights_m: self.heights_m(level, size.region()),
            georeference: continent::georeference(size.width, spacing_m),
        }
    }

    fn evaluate(&self, address: TileAddress) -> Result<LoadedTile, PyramidError> {
        if !self.has_tile(address) {
            return Err(PyramidError::NoSuchTile { path: self.name.clone().into(), address });
        }
        let size = self.levels[address.level as usize];
        let region = size.tile_region(address.x, address.y, TILE_BORDER);
        let heights_m = self.heights_m(address.level, region);
        let inside = |tile: u32, offset: u32, first: u32, count: u32| {
            (tile * TILE_SAMPLES + offset).saturating_sub(TILE_BORDER).min(count - 1) - first
        };
        let mut samples = Vec::with_capacity((TILE_STRIDE * TILE_STRIDE) as usize);
        for row in 0..TILE_STRIDE {
            let start = inside(address.y, row, region.y, size.height) * region.width;
            samples.extend((0..TILE_STRIDE).map(|column| {
                let column = inside(address.x, column, region.x, size.width);
                flagged(heights_m[(start + column) as usize], false)
            }));
        }
        let loaded = derive(&self.levels, address, Tile { samples });
        Ok(self.with_relief(address, loaded))
    }

    /// Adds the relief that a tile loses. From the base's level on, the pieces of relief do not show in a tile at all,
    /// so no estimate from its samples includes them.
    fn with_relief(&self, address: TileAddress, loaded: LoadedTile) -> LoadedTile {
        let Some(above) = address.level.checked_sub(BASE_LEVEL) else { return loaded };
        let first = |tile: u32| (self.offset >> BASE_LEVEL) + ((tile * TILE_SAMPLES) << above);
        let (x, y) = (first(address.x), first(address.y));
        let relief_m = |x: u32, y: u32, samples: u32| self.scale * self.land.max_relief_m(x, y, samples << above);
        let lost_m = relief_m(x, y, TILE_SAMPLES);
        let LoadedTile { tile, mut statistics, mut patches, .. } = loaded;
        statistics.error_m += lost_m;
        statistics.corner_errors_m = statistics.corner_errors_m.map(|error_m| error_m + lost_m);
        statistics.min_m -= lost_m;
        statistics.max_m += lost_m;
        for (i, patch) in (0..).zip(patches.patches_mut()) {
            let place = |first: u32, patch: u32| first + ((patch * PATCH_QUADS) << above);
            let lost_m = relief_m(place(x, i % PAGE_PATCHES), place(y, i / PAGE_PATCHES), PATCH_QUADS);
            patch.mesh_error_m += lost_m;
            patch.min_m -= lost_m;
            patch.max_m += lost_m;
        }
        LoadedTile::new(tile, statistics, patches)
    }
}

impl TileStore for ContinentStore {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn levels(&self) -> &[LevelSize] {
        &self.levels
    }

    fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    fn range_m(&self) -> [f32; 2] {
        self.range_m
    }

    fn is_measured(&self) -> bool {
        false
    }

    fn is_sparse(&self) -> bool {
        false
    }

    fn coarse_patches(&self) -> &[Vec<PatchStatistics>] {
        &self.coarse_patches
    }

    fn fetch(self: Arc<Self>, address: TileAddress, _cancel: &Cancel) -> Result<Decode, PyramidError> {
        Ok(Box::new(move || self.evaluate(address)))
    }
}

/// Returns the side of the cut for the requested size: its coarsest level must align with that of the whole continent.
fn cut(size_samples: u32) -> u32 {
    let wish = size_samples.clamp(SMALLEST_SAMPLES, SIZE_SAMPLES);
    let step = 1_u32 << level_sizes(wish, wish).len();
    (wish.div_ceil(step) * step).min(SIZE_SAMPLES)
}

/// Reads all of level 0 of a pyramid.
fn level_0(pyramid: &Arc<dyn TileStore>) -> Result<Vec<f32>, PyramidError> {
    let size = pyramid.levels()[0];
    let mut heights_m = vec![0.0; size.samples()];
    for y in 0..size.tiles_y() {
        for x in 0..size.tiles_x() {
            let tile = Arc::clone(pyramid).load(TileAddress { level: 0, x, y })?.tile;
            let region = size.tile_region(x, y, 0);
            for row in 0..region.height {
                let from = ((row + TILE_BORDER) * TILE_STRIDE + TILE_BORDER) as usize;
                let to = (region.y + row) as usize * size.width as usize + region.x as usize;
                let count = region.width as usize;
                heights_m[to..to + count].copy_from_slice(&tile.samples[from..from + count]);
            }
        }
    }
    Ok(heights_m)
}
