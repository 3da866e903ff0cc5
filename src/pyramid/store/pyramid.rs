//! A baked pyramid on disk: its tiles, statistics and ground heights.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::tile_store::{Cancel, Decode, TileStore};
use crate::file::random_access::RandomAccess;
use crate::pyramid::error::PyramidError;
use crate::pyramid::format::pair::open_sidecar;
use crate::pyramid::format::record::{self, RECORD_BYTES, Record};
use crate::pyramid::format::sidecar::{LevelSummary, Sidecar, sidecar_path};
use crate::pyramid::format::stored::StoredLevels;
use crate::pyramid::surface::fill::HeightLevels;
use crate::pyramid::surface::levels::LevelSize;
use crate::pyramid::surface::loaded_tile::LoadedTile;
use crate::pyramid::surface::served::serve;
use crate::pyramid::surface::statistics::{
    PAGE_PATCHES, PatchPage, PatchStatistics, Statistics, TileStatistics, Voids, patch_counts, patch_levels, tile_index,
};
use crate::pyramid::surface::tile_height::{height_in_tile, tile_at};
use crate::pyramid::tile::{Tile, TileAddress};
use crate::source::georeference::Georeference;

/// Number of level-0 tiles that are cached for ground queries.
const GROUND_TILES: usize = 32;

/// An open pyramid. All methods may be called from several threads at once.
pub struct Pyramid {
    path: PathBuf,
    stored: StoredLevels,
    sidecar: Sidecar,
    records: RandomAccess,
    /// Cached level-0 tiles, most recently used first.
    ground: Mutex<VecDeque<(TileAddress, Arc<Tile>)>>,
    /// The statistics of all tiles, for tests and tools; read on first use.
    all: OnceLock<Statistics>,
}

impl Pyramid {
    /// Opens the GeoTIFF at `path`, which needs its sidecar.
    ///
    /// # Errors
    /// [`PyramidError::NoSidecar`], [`PyramidError::StaleSidecar`] and [`PyramidError::CorruptSidecar`] if it has to be
    /// baked again ([`PyramidError::wants_bake`]).
    pub fn open(path: &Path) -> Result<Self, PyramidError> {
        let (sidecar, records) = open_sidecar(path)?;
        let stored = StoredLevels::open(path, path, sidecar.sizes.clone())?;
        Ok(Self { path: path.to_owned(), stored, sidecar, records, ground: Mutex::default(), all: OnceLock::new() })
    }

    /// Returns the path of the GeoTIFF.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the sizes of the levels in samples, finest first; at least one.
    pub fn levels(&self) -> &[LevelSize] {
        self.stored.sizes()
    }

    /// Returns the georeference of level 0.
    pub fn georeference(&self) -> &Georeference {
        &self.sidecar.georeference
    }

    /// Returns the largest difference between stored and original heights, in metres; 0 for lossless.
    pub fn max_error_m(&self) -> f64 {
        self.sidecar.max_error_m
    }

    /// Returns the lowest height of level 0, in metres.
    pub fn min_m(&self) -> f32 {
        self.sidecar.min_m
    }

    /// Returns the highest height of level 0, in metres.
    pub fn max_m(&self) -> f32 {
        self.sidecar.max_m
    }

    /// Returns the number of no-data samples of level 0.
    pub fn void_samples(&self) -> u64 {
        self.sidecar.void_samples
    }

    /// Returns a summary of each level, finest first.
    pub(crate) fn summaries(&self) -> &[LevelSummary] {
        &self.sidecar.levels
    }

    /// Reads the sidecar's record of a tile.
    fn record(&self, address: TileAddress) -> Result<Record, PyramidError> {
        let range = self.sidecar.record_range(address);
        let range = range.ok_or_else(|| PyramidError::NoSuchTile { path: self.path.clone(), address })?;
        let path = sidecar_path(&self.path);
        let bytes = self.records.read(range.start, RECORD_BYTES);
        let bytes = bytes.map_err(PyramidError::io(&path, "reading the tile statistics"))?;
        let record = self.sidecar.parse_record(address, &bytes);
        let TileAddress { level, x, y } = address;
        let cause = || format!("the checksum of the record of tile {level} {x} {y} is wrong");
        record.ok_or_else(|| PyramidError::CorruptSidecar { path, cause: cause() })
    }

    /// Returns the statistics of all tiles and patches, for tests and tools; the first call reads the whole sidecar.
    /// Unreadable records become no-data.
    fn all(&self) -> &Statistics {
        self.all.get_or_init(|| {
            let finest = self.sidecar.finest();
            let no_data = TileStatistics {
                min_m: f32::NAN,
                max_m: f32::NAN,
                error_m: 0.0,
                corner_errors_m: [0.0; 4],
                voids: Voids::All,
            };
            let counts = |j| patch_counts(finest, j);
            let empty = |j| vec![PatchPage::NOTHING; counts(j).0 as usize * counts(j).1 as usize];
            let mut patches: Vec<Vec<PatchStatistics>> = (0..patch_levels(finest)).map(empty).collect();
            let mut tiles = Vec::new();
            for (level, size) in (0..).zip(self.levels()) {
                let mut here = Vec::new();
                for (y, x) in (0..size.tiles_y()).flat_map(|y| (0..size.tiles_x()).map(move |x| (y, x))) {
                    let record = match self.record(TileAddress { level, x, y }) {
                        Ok(record) => record,
                        Err(error) => {
                            tracing::warn!("{error}");
                            here.push(no_data);
                            continue;
                        }
                    };
                    here.push(record.statistics);
                    let Some(patches) = patches.get_mut(level as usize) else { continue };
                    let (count_x, count_y) = counts(level);
                    for (i, patch) in (0..).zip(record.patches.patches()) {
                        let (x, y) = (x * PAGE_PATCHES + i % PAGE_PATCHES, y * PAGE_PATCHES + i / PAGE_PATCHES);
                        if x < count_x && y < count_y {
                            patches[y as usize * count_x as usize + x as usize] = *patch;
                        }
                    }
                }
                tiles.push(here);
            }
            for (patches, coarse) in patches.iter_mut().skip(tiles.len()).zip(&self.sidecar.coarse_patches) {
                patches.clone_from(coarse);
            }
            Statistics { tiles, patches }
        })
    }

    /// Returns the statistics of a tile, for tests and tools; the first call reads the whole sidecar.
    ///
    /// # Panics
    /// If the pyramid has no such tile; see [`Pyramid::levels`] and [`LevelSize::tiles_x`].
    pub fn tile(&self, address: TileAddress) -> &TileStatistics {
        let index = tile_index(self.levels(), address).expect("the caller requests tiles of this pyramid only");
        &self.all().tiles[address.level as usize][index]
    }

    /// Returns the number of strides of mesh patches: patches of stride 2^j exist for j below it.
    pub fn patch_levels(&self) -> u32 {
        patch_levels(self.sidecar.finest())
    }

    /// Returns the number of patches of stride 2^`j` in x and y.
    pub fn patch_counts(&self, j: u32) -> (u32, u32) {
        patch_counts(self.sidecar.finest(), j)
    }

    /// Returns the statistics of the patch (`x`, `y`) of stride 2^`j`, or `None` if it does not exist. For tests and
    /// tools: the first call reads the whole sidecar.
    pub fn patch(&self, j: u32, x: u32, y: u32) -> Option<&PatchStatistics> {
        let patches = self.all().patches.get(j as usize)?;
        let (count_x, count_y) = self.patch_counts(j);
        (x < count_x && y < count_y).then(|| &patches[y as usize * count_x as usize + x as usize])
    }

    /// Reads a tile with its borders.
    ///
    /// # Errors
    /// If there is no such tile, or the file is damaged or missing.
    pub fn read_tile(&self, address: TileAddress) -> Result<Tile, PyramidError> {
        if tile_index(self.levels(), address).is_none() {
            return Err(PyramidError::NoSuchTile { path: self.path.clone(), address });
        }
        serve(&self.stored, address, self.sidecar.min_m)
    }

    /// Reads a tile with its statistics, and verifies the checksum of its bytes.
    ///
    /// # Errors
    /// The errors of [`Pyramid::read_tile`].
    pub(super) fn read_verified(&self, address: TileAddress) -> Result<LoadedTile, PyramidError> {
        let Record { statistics, patches, checksum } = self.record(address)?;
        self.verify(address, checksum)?;
        Ok(LoadedTile::new(self.read_tile(address)?, statistics, patches))
    }

    fn verify(&self, address: TileAddress, sum: Option<u32>) -> Result<(), PyramidError> {
        let bytes = self.stored.tile_bytes(address)?;
        if sum.is_some_and(|sum| sum != record::checksum(&bytes)) {
            let TileAddress { level, x, y } = address;
            let cause = format!("the checksum of tile {level} {x} {y} is wrong: the file is damaged");
            return Err(PyramidError::Mismatch { path: self.path.clone(), cause });
        }
        Ok(())
    }

    /// Returns the height in metres of the level-0 surface at a place in grid coordinates (sample centres are whole
    /// numbers), or `None` outside the outermost samples, in cells with a no-data corner, and where the file cannot be
    /// read.
    pub fn height_m(&self, column: f64, row: f64) -> Option<f64> {
        let address = tile_at(self.levels(), 0, column, row)?;
        height_in_tile(self.levels(), address, &*self.ground_tile(address)?, column, row)
    }

    fn ground_tile(&self, address: TileAddress) -> Option<Arc<Tile>> {
        // The lock guards only a cache, which is consistent between statements, so poisoning is harmless.
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

    fn is_sparse(&self) -> bool {
        false
    }

    fn coarse_patches(&self) -> &[Vec<PatchStatistics>] {
        &self.sidecar.coarse_patches
    }

    fn fetch(self: Arc<Self>, address: TileAddress, cancel: &Cancel) -> Result<Decode, PyramidError> {
        let record = self.record(address)?;
        if cancel.is_cancelled() {
            return Err(PyramidError::Cancelled);
        }
        // Decoding reads the bytes again, from the system's cache; here they are read from disk and verified.
        self.verify(address, record.checksum)?;
        Ok(Box::new(move || {
            let Record { statistics, patches, .. } = record;
            Ok(LoadedTile::new(self.read_tile(address)?, statistics, patches))
        }))
    }
}
