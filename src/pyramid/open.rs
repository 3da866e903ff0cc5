//! A pyramid on disk → tiles, statistics and ground heights.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use super::fill::{HeightLevels, flagged, is_void, read_filled};
use super::levels::{LevelSize, level_sizes};
use super::sidecar::Sidecar;
use super::statistics::{PatchStatistics, Statistics, TileStatistics, patch_counts, tile_index};
use super::store::{Cancel, Decode, LoadedTile, PAGE_PATCHES, PatchPage, TileStore};
use super::stored::StoredLevels;
use super::{PyramidError, TILE_BORDER, TILE_SAMPLES, TILE_STRIDE, Tile, TileAddress, bicubic};
use crate::source::georeference::Georeference;

/// Level-0 tiles kept for ground queries.
const GROUND_TILES: usize = 32;

/// An open pyramid. All methods may be called from several threads at once.
pub struct Pyramid {
    path: PathBuf,
    stored: StoredLevels,
    sidecar: Sidecar,
    vertical_exaggeration: f32,
    /// Most recently used first.
    ground: Mutex<VecDeque<(TileAddress, Arc<Tile>)>>,
}

impl Pyramid {
    /// Opens the GeoTIFF at `path`, which needs its sidecar.
    ///
    /// # Errors
    /// [`PyramidError::NoSidecar`], [`PyramidError::StaleSidecar`] and [`PyramidError::CorruptSidecar`] ask for a new
    /// bake ([`PyramidError::wants_bake`]).
    pub fn open(path: &Path) -> Result<Self, PyramidError> {
        let mut sidecar = Sidecar::read(path)?;
        let sizes = level_sizes(sidecar.finest.width, sidecar.finest.height);
        complete(&mut sidecar.statistics, &sizes);
        let stored = StoredLevels::open(path, path, sizes)?;
        Ok(Self { path: path.to_owned(), stored, sidecar, vertical_exaggeration: 1.0, ground: Mutex::default() })
    }

    /// The same land with every height, and every error of a height, times `factor`, which is above 0.
    pub fn exaggerated(mut self, factor: f64) -> Self {
        let factor = factor as f32;
        let sidecar = &mut self.sidecar;
        sidecar.min_m *= factor;
        sidecar.max_m *= factor;
        for tile in sidecar.statistics.tiles.iter_mut().flatten() {
            tile.min_m *= factor;
            tile.max_m *= factor;
            tile.error_m *= factor;
            tile.corner_errors_m = tile.corner_errors_m.map(|error_m| error_m * factor);
        }
        for patch in sidecar.statistics.patches.iter_mut().flatten() {
            patch.min_m *= factor;
            patch.max_m *= factor;
            patch.mesh_error_m *= factor;
        }
        self.vertical_exaggeration *= factor;
        self.ground = Mutex::default();
        self
    }

    /// The GeoTIFF.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The sizes of the levels in samples, finest first; at least one.
    pub fn levels(&self) -> &[LevelSize] {
        self.stored.sizes()
    }

    /// Where level 0 lies.
    pub fn georeference(&self) -> &Georeference {
        &self.sidecar.georeference
    }

    /// How far stored heights are from the original ones at most, in metres; 0 if every bit was kept.
    pub fn max_error_m(&self) -> f64 {
        self.sidecar.max_error_m
    }

    /// Lowest height of level 0, in metres.
    pub fn min_m(&self) -> f32 {
        self.sidecar.min_m
    }

    /// Highest height of level 0, in metres.
    pub fn max_m(&self) -> f32 {
        self.sidecar.max_m
    }

    /// What is known of a tile.
    ///
    /// # Panics
    /// If there is no such tile: see [`Pyramid::levels`] and [`LevelSize::tiles_x`].
    pub fn tile(&self, address: TileAddress) -> &TileStatistics {
        let index = tile_index(self.levels(), address).expect("the caller asks for tiles of this pyramid only");
        &self.sidecar.statistics.tiles[address.level as usize][index]
    }

    /// How many strides of mesh patches there are: patches of stride 2^j exist for j below this.
    pub fn patch_levels(&self) -> u32 {
        self.sidecar.statistics.patches.len() as u32
    }

    /// How many patches of stride 2^`j` there are in x and y.
    pub fn patch_counts(&self, j: u32) -> (u32, u32) {
        patch_counts(self.sidecar.finest, j)
    }

    /// What is known of the patch (`x`, `y`) of stride 2^`j`; none if it does not exist.
    pub fn patch(&self, j: u32, x: u32, y: u32) -> Option<&PatchStatistics> {
        let patches = self.sidecar.statistics.patches.get(j as usize)?;
        let (count_x, count_y) = self.patch_counts(j);
        (x < count_x && y < count_y).then(|| &patches[y as usize * count_x as usize + x as usize])
    }

    /// Reads a tile with its borders.
    ///
    /// # Errors
    /// If there is no such tile, or the file is damaged or gone.
    pub fn read_tile(&self, address: TileAddress) -> Result<Tile, PyramidError> {
        if tile_index(self.levels(), address).is_none() {
            return Err(PyramidError::NoSuchTile { path: self.path.clone(), address });
        }
        let level = address.level as usize;
        let size = self.levels()[level];
        let region = size.tile_region(address.x, address.y, TILE_BORDER);
        let lowest_m = self.sidecar.min_m / self.vertical_exaggeration;
        let mut served = read_filled(&self.stored, level, region, lowest_m)?;
        if self.vertical_exaggeration != 1.0 {
            served
                .iter_mut()
                .for_each(|sample| *sample = flagged(*sample * self.vertical_exaggeration, is_void(*sample)));
        }
        let mut samples = Vec::with_capacity((TILE_STRIDE * TILE_STRIDE) as usize);
        for row in 0..TILE_STRIDE {
            let row = inside(address.y, row, size.height) - region.y;
            let row = &served[(row * region.width) as usize..((row + 1) * region.width) as usize];
            for column in 0..TILE_STRIDE {
                samples.push(row[(inside(address.x, column, size.width) - region.x) as usize]);
            }
        }
        Ok(Tile { samples })
    }

    /// The height in metres of the level-0 surface at a place in grid coordinates (sample centres are whole numbers);
    /// none outside the outermost samples, in cells with a void corner, and where the file cannot be read.
    pub fn height_m(&self, column: f64, row: f64) -> Option<f64> {
        let finest = self.levels()[0];
        let inside = |c: f64, count: u32| (0.0..=f64::from(count - 1)).contains(&c);
        if !inside(column, finest.width) || !inside(row, finest.height) {
            return None;
        }
        let (cell_x, fx) = bicubic::cell(column, finest.width);
        let (cell_y, fy) = bicubic::cell(row, finest.height);
        let address = TileAddress { level: 0, x: cell_x / TILE_SAMPLES, y: cell_y / TILE_SAMPLES };
        let tile = self.ground_tile(address)?;
        // The tile's rows begin TILE_BORDER samples early and the four samples one early.
        let (left, top) = (cell_x % TILE_SAMPLES + TILE_BORDER - 1, cell_y % TILE_SAMPLES + TILE_BORDER - 1);
        let samples: [[f32; 4]; 4] = std::array::from_fn(|k| {
            let start = ((top + k as u32) * TILE_STRIDE + left) as usize;
            std::array::from_fn(|i| tile.samples[start + i])
        });
        let void = samples[1..3].iter().any(|row| row[1..3].iter().any(|&sample| is_void(sample)));
        (!void).then(|| bicubic::height_and_gradient(&samples, fx, fy).0)
    }

    fn ground_tile(&self, address: TileAddress) -> Option<Arc<Tile>> {
        // A poisoned lock guards only a cache, which is whole between statements.
        let mut ground = self.ground.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = ground.iter().position(|(kept, _)| *kept == address) {
            if let Some(found) = ground.remove(at) {
                ground.push_front(found);
            }
            return ground.front().map(|(_, tile)| tile.clone());
        }
        drop(ground);
        let tile = match self.read_tile(address) {
            Ok(tile) => Arc::new(tile),
            Err(error) => {
                tracing::warn!("{error}");
                return None;
            }
        };
        let mut ground = self.ground.lock().unwrap_or_else(PoisonError::into_inner);
        ground.push_front((address, tile.clone()));
        ground.truncate(GROUND_TILES);
        Some(tile)
    }
}

impl TileStore for Pyramid {
    fn name(&self) -> String {
        self.path.display().to_string()
    }

    fn levels(&self) -> &[LevelSize] {
        self.stored.sizes()
    }

    fn georeference(&self) -> &Georeference {
        &self.sidecar.georeference
    }

    fn range_m(&self) -> [f32; 2] {
        [self.min_m(), self.max_m()]
    }

    fn is_measured(&self) -> bool {
        true
    }

    fn coarse_patches(&self) -> &[Vec<PatchStatistics>] {
        self.sidecar.statistics.patches.get(self.levels().len()..).unwrap_or_default()
    }

    fn fetch(self: Arc<Self>, address: TileAddress, _cancel: &Cancel) -> Result<Decode, PyramidError> {
        Ok(Box::new(move || {
            let page = (0..PAGE_PATCHES * PAGE_PATCHES).map(|i| {
                let (x, y) = (address.x * PAGE_PATCHES + i % PAGE_PATCHES, address.y * PAGE_PATCHES + i / PAGE_PATCHES);
                self.patch(address.level, x, y).copied().unwrap_or(PatchPage::NOTHING)
            });
            let patches = PatchPage::new(page.collect());
            Ok(LoadedTile { tile: self.read_tile(address)?, statistics: *self.tile(address), patches })
        }))
    }
}

/// What follows from the statistics of single tiles: the errors at corners, and ranges that hold those of the children.
fn complete(statistics: &mut Statistics, sizes: &[LevelSize]) {
    for level in 1..sizes.len() {
        let (finer, coarser) = statistics.tiles.split_at_mut(level);
        for (i, child) in finer[level - 1].iter().enumerate() {
            let (x, y) = (i as u32 % sizes[level - 1].tiles_x(), i as u32 / sizes[level - 1].tiles_x());
            let parent = &mut coarser[0][(y / 2 * sizes[level].tiles_x() + x / 2) as usize];
            parent.min_m = parent.min_m.min(child.min_m);
            parent.max_m = parent.max_m.max(child.max_m);
        }
    }
    for (tiles, size) in statistics.tiles.iter_mut().zip(sizes) {
        let (tiles_x, tiles_y) = (size.tiles_x(), size.tiles_y());
        let errors_m: Vec<f32> = tiles.iter().map(|tile| tile.error_m).collect();
        let error_m = |x: u32, y: u32| match x < tiles_x && y < tiles_y {
            true => errors_m[(y * tiles_x + x) as usize],
            false => 0.0,
        };
        for (i, tile) in tiles.iter_mut().enumerate() {
            let (x, y) = (i as u32 % tiles_x, i as u32 / tiles_x);
            tile.corner_errors_m = std::array::from_fn(|corner| {
                let (x, y) = (x + corner as u32 % 2, y + corner as u32 / 2);
                let (west, north) = (x.wrapping_sub(1), y.wrapping_sub(1));
                error_m(west, north).max(error_m(x, north)).max(error_m(west, y)).max(error_m(x, y))
            });
        }
    }
}

/// The sample at offset `offset` of a tile's row or column, borders included, replicated beyond the level.
fn inside(tile: u32, offset: u32, count: u32) -> u32 {
    (tile * TILE_SAMPLES + offset).saturating_sub(TILE_BORDER).min(count - 1)
}
