//! A world in memory: the tiles of an array of heights, with measured errors and without a file.
//!
//! The levels are averaged once, and errors are measured by the code of the baker ([`measure`]), which here neither
//! encodes tiles nor writes them. Tiles, errors and patch statistics are bit-identical to those of the same grid in a
//! lossless pyramid on disk.
//!
//! A store holds 5⅓ bytes per sample: 4 for level 0, and a third of that for the coarser levels. The statistics are 1.1
//! kB for each tile of 256 × 256 samples. While a store is made, the baker needs about 0.4 GB more for each chunk of
//! 4096 × 4096 samples in progress, and in proportion less for a smaller grid.
//!
//! Why: `docs/decisions/world-in-memory.md`.

use std::path::Path;
use std::sync::Arc;

use super::tile_store::{Cancel, Decode, TileStore};
use crate::pyramid::bake::{Measured, check_grid, measure};
use crate::pyramid::error::PyramidError;
use crate::pyramid::format::record::{PAGE_BYTES, parse_page};
use crate::pyramid::surface::field::Field;
use crate::pyramid::surface::fill::HeightLevels;
use crate::pyramid::surface::levels::{LevelSize, Region, level_sizes};
use crate::pyramid::surface::loaded_tile::LoadedTile;
use crate::pyramid::surface::overview::average_into;
use crate::pyramid::surface::served::serve;
use crate::pyramid::surface::statistics::{PatchStatistics, TileStatistics, tile_index};
use crate::pyramid::tile::TileAddress;
use crate::source::georeference::Georeference;
use crate::source::{self, HeightGrid, HeightReader, MAX_SAMPLES, Progress, SourceError, memory};

/// The tiles of a grid that is held in memory. All methods may be called from several threads at once, and none waits.
pub struct MemoryStore {
    name: String,
    levels: Levels,
    georeference: Georeference,
    measured: Measured,
}

impl MemoryStore {
    /// Makes a store of a grid, whose heights it takes over: row-major, in metres. Heights that are not finite are
    /// no-data. `name` stands for the heights in messages, where a file would have its path. Work is spread over the
    /// threads of rayon.
    ///
    /// # Errors
    /// [`PyramidError::BadGrid`] if the grid has fewer than 2 × 2 or more than 2³¹ samples, another number of heights
    /// than width × height, or a georeference that is not finite; [`PyramidError::NoHeights`] if every sample is
    /// no-data; [`PyramidError::Source`] with [`SourceError::Memory`] if there is not enough memory.
    pub fn new(grid: HeightGrid, name: &str, progress: &dyn Progress) -> Result<Self, PyramidError> {
        let path = Path::new(name);
        let HeightGrid { width, height, mut heights_m, georeference } = grid;
        check_size(width, height, path)?;
        check_grid([width, height], &georeference, path)?;
        if heights_m.len() != width as usize * height as usize {
            let cause = format!("{} heights for {width} × {height} samples", heights_m.len());
            return Err(PyramidError::BadGrid { path: path.to_owned(), cause });
        }
        heights_m.iter_mut().filter(|height| height.is_infinite()).for_each(|height| *height = f32::NAN);
        let levels = Levels::new(LevelSize { width, height }, heights_m, path)?;
        let finest = Finest { field: &levels.fields[0], georeference: &georeference };
        let measured = measure(&levels, &finest, path, progress)?;
        Ok(Self { name: name.to_owned(), levels, georeference, measured })
    }

    /// Makes a store of everything that a reader has, as [`MemoryStore::new`] does.
    ///
    /// # Errors
    /// The errors of [`MemoryStore::new`] and of reading the heights.
    pub fn of_reader(reader: &dyn HeightReader, name: &str, progress: &dyn Progress) -> Result<Self, PyramidError> {
        let [width, height] = reader.size();
        check_size(width, height, Path::new(name))?;
        Self::new(source::read_all(reader, Path::new(name), progress)?, name, progress)
    }

    /// Returns the memory that the heights and statistics take, in bytes.
    pub fn bytes(&self) -> u64 {
        let heights = self.levels.fields.iter().map(|field| size_of_val(&field.heights_m[..])).sum::<usize>();
        let tiles = self.measured.tiles.iter().map(|tiles| size_of_val(&tiles[..])).sum::<usize>();
        let coarse = self.measured.coarse_patches.iter().map(|patches| size_of_val(&patches[..])).sum::<usize>();
        (heights + tiles + coarse + self.measured.pages.len()) as u64
    }

    /// Returns the number of no-data samples of level 0.
    pub fn void_samples(&self) -> u64 {
        self.measured.void_samples
    }

    /// Makes a tile with its statistics and those of its patches.
    fn tile(&self, address: TileAddress) -> Result<LoadedTile, PyramidError> {
        let (statistics, page) = self.record(address).ok_or_else(|| self.no_such_tile(address))?;
        let patches = parse_page(page, [statistics.min_m, statistics.max_m]);
        let patches = patches.ok_or_else(|| self.no_such_tile(address))?;
        Ok(LoadedTile::new(serve(&self.levels, address, self.measured.range_m[0])?, *statistics, patches))
    }

    /// Returns the statistics of a tile and its encoded page, if the tile exists.
    fn record(&self, address: TileAddress) -> Option<(&TileStatistics, &[u8])> {
        let index = tile_index(&self.levels.sizes, address)?;
        let finer = &self.measured.tiles[..address.level as usize];
        let number = finer.iter().map(Vec::len).sum::<usize>() + index;
        let page = self.measured.pages.get(number * PAGE_BYTES..(number + 1) * PAGE_BYTES)?;
        Some((&self.measured.tiles[address.level as usize][index], page))
    }

    fn no_such_tile(&self, address: TileAddress) -> PyramidError {
        PyramidError::NoSuchTile { path: self.name.clone().into(), address }
    }
}

fn check_size(width: u32, height: u32, path: &Path) -> Result<(), PyramidError> {
    if u64::from(width) * u64::from(height) > MAX_SAMPLES {
        let cause = format!("{width} × {height} samples are too many to hold in memory; {MAX_SAMPLES} are possible");
        return Err(PyramidError::BadGrid { path: path.to_owned(), cause });
    }
    Ok(())
}

impl TileStore for MemoryStore {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn levels(&self) -> &[LevelSize] {
        &self.levels.sizes
    }

    fn georeference(&self) -> &Georeference {
        &self.georeference
    }

    fn range_m(&self) -> [f32; 2] {
        self.measured.range_m
    }

    fn is_measured(&self) -> bool {
        true
    }

    fn is_sparse(&self) -> bool {
        false
    }

    fn coarse_patches(&self) -> &[Vec<PatchStatistics>] {
        &self.measured.coarse_patches
    }

    fn fetch(self: Arc<Self>, address: TileAddress, _cancel: &Cancel) -> Result<Decode, PyramidError> {
        if tile_index(&self.levels.sizes, address).is_none() {
            return Err(self.no_such_tile(address));
        }
        // There is nothing to wait for: all work is in the second step.
        Ok(Box::new(move || self.tile(address)))
    }
}

/// All levels of a grid, whole.
struct Levels {
    sizes: Vec<LevelSize>,
    fields: Vec<Field>,
}

impl Levels {
    /// Averages the coarser levels of a grid, after reserving the memory for each.
    fn new(finest: LevelSize, heights_m: Vec<f32>, path: &Path) -> Result<Self, SourceError> {
        let sizes = level_sizes(finest.width, finest.height);
        let mut fields = vec![Field { region: finest.region(), heights_m }];
        for (fine, coarse) in sizes.iter().zip(&sizes[1..]) {
            let mut heights_m = memory::room(path, [coarse.width, coarse.height], coarse.samples() as u64)?;
            heights_m.resize(coarse.samples(), f32::NAN);
            average_into(&fields[fields.len() - 1], *fine, *coarse, coarse.region(), &mut heights_m);
            fields.push(Field { region: coarse.region(), heights_m });
        }
        Ok(Self { sizes, fields })
    }
}

impl HeightLevels for Levels {
    fn sizes(&self) -> &[LevelSize] {
        &self.sizes
    }

    fn read(&self, level: usize, region: Region) -> Result<Vec<f32>, PyramidError> {
        Ok(self.fields[level].cut(region))
    }
}

/// Level 0, as the baker reads it.
struct Finest<'a> {
    field: &'a Field,
    georeference: &'a Georeference,
}

impl HeightReader for Finest<'_> {
    fn size(&self) -> [u32; 2] {
        [self.field.region.width, self.field.region.height]
    }

    fn georeference(&self) -> &Georeference {
        self.georeference
    }

    fn read(&self, window: Region) -> Result<Vec<f32>, SourceError> {
        Ok(self.field.cut(window))
    }

    fn block(&self) -> [u32; 2] {
        [self.field.region.width, 1]
    }

    fn identity(&self) -> String {
        "heights in memory".into()
    }
}
