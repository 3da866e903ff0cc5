//! The levels of a pyramid, from the images of a COG that another program wrote.
//!
//! A level that the file has as an overview is read from it: GDAL's overviews have the sizes and the registration of
//! our levels. Other levels are averaged: from an overview whose size is one sample off (some writers round down),
//! otherwise from the level before. Small ones are averaged once and cached, large ones region by region on demand.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::OnceLock;

use crate::pyramid::error::PyramidError;
use crate::pyramid::surface::field::Field;
use crate::pyramid::surface::fill::{HeightLevels, RADIUS};
use crate::pyramid::surface::levels::{LevelSize, Region, level_sizes};
use crate::pyramid::surface::overview;
use crate::pyramid::tile::{TILE_SAMPLES, TileAddress};
use crate::source::cog::{Pictures, is_unread};
use crate::source::voids::{self, Limits, Way};

/// Levels of at most this many samples are averaged once and cached: 16 MiB.
const KEPT_SAMPLES: usize = 2048 * 2048;

/// Number of successive levels that may be averaged region by region; each needs four times as much of the last stored
/// one.
const MAX_AVERAGED: u32 = 2;

/// Upper bound of the samples of a block that is decoded for a tile.
const MAX_BLOCK_SAMPLES: u64 = 2048 * 2048;

/// The origin of a level.
enum Origin {
    /// An image of the same size.
    Picture(usize),
    /// Averages of an image or of another level.
    Averaged { of: Finer, kept: OnceLock<Vec<f32>> },
}

#[derive(Clone, Copy)]
enum Finer {
    Picture(usize),
    Level(usize),
}

/// The levels over the images of a file, read or averaged on demand.
pub(super) struct CogLevels {
    name: PathBuf,
    pictures: Pictures,
    sizes: Vec<LevelSize>,
    origins: Vec<Origin>,
    /// Distance between the finest samples in metres, if small holes are filled.
    filled_m: Option<f64>,
}

impl CogLevels {
    /// Finds an origin for every level.
    ///
    /// # Errors
    /// [`PyramidError::NoOverviews`] if too much of the file would have to be read for a tile.
    pub(super) fn new(pictures: Pictures, name: PathBuf) -> Result<Self, PyramidError> {
        let all: Vec<LevelSize> =
            pictures.pictures().iter().map(|it| LevelSize { width: it.width, height: it.height }).collect();
        let sizes = level_sizes(all[0].width, all[0].height);
        let too_much = |cause: String| PyramidError::NoOverviews { path: name.clone(), cause };
        let mut origins = Vec::with_capacity(sizes.len());
        let mut averaged = 0;
        for (level, size) in sizes.iter().enumerate() {
            let near = |picture: &LevelSize| {
                level > 0 && picture.width.abs_diff(size.width) <= 1 && picture.height.abs_diff(size.height) <= 1
            };
            let origin = match (all.iter().position(|it| it == size), all.iter().position(near)) {
                (Some(same), _) => Origin::Picture(same),
                (None, Some(near)) => Origin::Averaged { of: Finer::Picture(near), kept: OnceLock::new() },
                (None, None) => Origin::Averaged { of: Finer::Level(level - 1), kept: OnceLock::new() },
            };
            averaged = if matches!(origin, Origin::Averaged { of: Finer::Level(_), .. }) { averaged + 1 } else { 0 };
            if averaged > MAX_AVERAGED && size.samples() > KEPT_SAMPLES
                || averaged == 1 && size.samples() <= KEPT_SAMPLES && sizes[level - 1].samples() > 4 * KEPT_SAMPLES
            {
                let LevelSize { width, height } = sizes[level - averaged as usize];
                return Err(too_much(format!("it has no overview below {width} × {height} samples")));
            }
            origins.push(origin);
        }
        let used = pictures.pictures().iter().enumerate().filter(|(index, _)| {
            let of_it = |origin: &Origin| match origin {
                Origin::Picture(picture) | Origin::Averaged { of: Finer::Picture(picture), .. } => picture == index,
                Origin::Averaged { .. } => false,
            };
            origins.iter().any(of_it)
        });
        for (_, picture) in used {
            // An image that is a single small block may be one strip.
            let [columns, rows] = [picture.block[0].min(picture.width), picture.block[1].min(picture.height)];
            if u64::from(columns) * u64::from(rows) > MAX_BLOCK_SAMPLES
                || columns == picture.width && picture.width > 16 * TILE_SAMPLES
            {
                return Err(too_much(format!("it is stored in blocks of {columns} × {rows} samples, not in tiles")));
            }
        }
        Ok(Self { name, pictures, sizes, origins, filled_m: None })
    }

    /// Enables the filling of small holes in each level as it is read.
    pub(super) fn fill_voids(&mut self) {
        let LevelSize { width, height } = self.sizes[0];
        self.filled_m = Some(voids::spacing_m(self.pictures.georeference(), [width, height]));
    }

    /// Returns the images of the file, with its georeference.
    pub(super) fn pictures(&self) -> &Pictures {
        &self.pictures
    }

    /// Returns the byte range of a tile, if the level is an image in tiles of our size.
    pub(super) fn stored(&self, address: TileAddress) -> Option<Range<u64>> {
        let Origin::Picture(picture) = self.origins.get(address.level as usize)? else { return None };
        let is_ours = self.pictures.pictures()[*picture].block == [TILE_SAMPLES; 2];
        is_ours.then(|| self.pictures.stored(*picture, address.x * TILE_SAMPLES, address.y * TILE_SAMPLES))?
    }

    /// Returns the byte ranges from which a region of a level is made, except what is cached already.
    pub(super) fn ranges(&self, level: usize, region: Region) -> Vec<Range<u64>> {
        match &self.origins[level] {
            Origin::Picture(picture) => self.pictures.ranges(*picture, region),
            Origin::Averaged { kept, .. } if kept.get().is_some() => Vec::new(),
            Origin::Averaged { of, .. } => {
                let size = self.sizes[level];
                let region = if size.samples() <= KEPT_SAMPLES { size.region() } else { region };
                let under = overview::cover_region(region, self.size(*of), size);
                match *of {
                    Finer::Picture(picture) => self.pictures.ranges(picture, under),
                    Finer::Level(finer) => self.ranges(finer, under),
                }
            }
        }
    }

    /// Returns the same for all levels that fill the no-data of a region: those above `level`.
    pub(super) fn ranges_above(&self, level: usize, mut region: Region) -> Vec<Range<u64>> {
        let mut ranges = Vec::new();
        for above in level + 1..self.sizes.len() {
            let size = self.sizes[above];
            let (x, y) = (region.x / 2, region.y / 2);
            let half = Region { x, y, width: region.width / 2 + 2, height: region.height / 2 + 2 };
            let x = half.x.min(size.width - 1);
            let y = half.y.min(size.height - 1);
            region = Region { x, y, width: half.width.min(size.width - x), height: half.height.min(size.height - y) };
            ranges.extend(self.ranges(above, region.grown(RADIUS + 2, size)));
        }
        ranges
    }

    fn size(&self, finer: Finer) -> LevelSize {
        match finer {
            Finer::Level(level) => self.sizes[level],
            Finer::Picture(picture) => {
                let picture = &self.pictures.pictures()[picture];
                LevelSize { width: picture.width, height: picture.height }
            }
        }
    }

    fn averaged(&self, of: Finer, size: LevelSize, region: Region) -> Result<Vec<f32>, PyramidError> {
        let fine = self.size(of);
        let under = overview::cover_region(region, fine, size);
        let heights_m = match of {
            Finer::Picture(picture) => self.picture(picture, under)?,
            Finer::Level(level) => self.read_bare(level, under)?,
        };
        let field = Field { region: under, heights_m };
        Ok(overview::next_level(&field, fine, size, region).heights_m)
    }

    fn picture(&self, picture: usize, region: Region) -> Result<Vec<f32>, PyramidError> {
        self.pictures.read(picture, region).map_err(|error| {
            if is_unread(&error) {
                PyramidError::Unread { source: error }
            } else {
                PyramidError::Decode { path: self.name.clone(), source: error.into() }
            }
        })
    }

    /// Averages a whole level, in bands of rows.
    fn whole(&self, of: Finer, size: LevelSize) -> Result<Vec<f32>, PyramidError> {
        let mut heights_m = Vec::with_capacity(size.samples());
        for y in (0..size.height).step_by(TILE_SAMPLES as usize) {
            let height = TILE_SAMPLES.min(size.height - y);
            heights_m.extend(self.averaged(of, size, Region { y, height, ..size.region() })?);
        }
        Ok(heights_m)
    }
}

impl HeightLevels for CogLevels {
    fn sizes(&self) -> &[LevelSize] {
        &self.sizes
    }

    /// Reads a region of a level. Each level fills about the same holes, from its own samples, because the size limit
    /// of holes halves with the level. Spikes are removed at the finest level only, since they are single samples of
    /// it.
    fn read(&self, level: usize, region: Region) -> Result<Vec<f32>, PyramidError> {
        let (Some(finest_m), Some(limits)) = (self.filled_m, Limits::of_level(level)) else {
            return self.read_bare(level, region);
        };
        let LevelSize { width, height } = self.sizes[level];
        let spacing_m = if level == 0 { finest_m } else { f64::INFINITY };
        let way = Way { size: [width, height], spacing_m, limits };
        voids::read_filled(&|region| self.read_bare(level, region), region, &way).map(|(heights_m, _)| heights_m)
    }
}

impl CogLevels {
    fn read_bare(&self, level: usize, region: Region) -> Result<Vec<f32>, PyramidError> {
        let size = self.sizes[level];
        match &self.origins[level] {
            Origin::Picture(picture) => self.picture(*picture, region),
            Origin::Averaged { of, .. } if size.samples() > KEPT_SAMPLES => self.averaged(*of, size, region),
            Origin::Averaged { of, kept } => {
                // Not under a lock: the decoder spreads its work over threads, which may come here meanwhile. Two may
                // do the same then, with the same result.
                let level = match kept.get() {
                    Some(level) => level,
                    None => {
                        let level = self.whole(*of, size)?;
                        kept.get_or_init(|| level)
                    }
                };
                let mut heights_m = Vec::with_capacity(region.samples());
                for row in region.y..region.y + region.height {
                    let start = row as usize * size.width as usize + region.x as usize;
                    heights_m.extend_from_slice(&level[start..start + region.width as usize]);
                }
                Ok(heights_m)
            }
        }
    }
}
