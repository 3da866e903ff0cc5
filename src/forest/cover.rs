//! Forest cover from rasters: a density mask, land-cover classes, canopy heights.
//!
//! Whatever their reference systems and resolutions, the rasters are resampled once, when a scene opens, to one grid
//! aligned with the world's axes ([`Cover`]), which a shader then samples. The grid covers the intersection of the
//! world and all rasters, so a small raster in a large world keeps its detail. Its cells are squares as small as the
//! samples of the finest raster, or as [`MAX_CELLS`] along a side allow. If the axes agree, cells coincide with the
//! samples of that raster.
//!
//! `aligned` maps a position in the world to the samples of a raster, through the samples of the DEM, as mosaics do. A
//! cell reads points within it (`resample`): one if its raster is no finer than the grid, otherwise several for each
//! sample. Its density is the mean over them, its class the one with the most trees, its canopy height the mean over
//! the points that have trees. The densities of several rasters are multiplied.
//!
//! Outside of a raster, or where it has no data, there are no trees. A mask without a georeference is stretched over
//! the DEM, with its upper edge in the north.

mod aligned;
mod resample;
#[cfg(test)]
mod scratch;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use rustc_hash::FxHashMap;

use self::aligned::{AlignedRaster, Ground};
use self::resample::{Answer, Grid, Tally, resample};
use crate::file::message::named;
use crate::scene::{CoverClass, CoverFiles};
use crate::source::georeference::Georeference;
use crate::source::{Holds, SourceError, open_values};

/// Largest number of cells along each side of a cover.
pub(crate) const MAX_CELLS: u32 = 4096;
/// Canopy lower than this has no trees, in metres.
pub(crate) const LOWEST_TREE_M: f32 = 2.0;
/// Largest number of classes that a warning lists.
const NAMED_CLASSES: usize = 24;

/// The forest cover of a world from rasters. Outside of it there are no trees.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Cover {
    /// South-western corner of the first cell: east and north, in the world, in metres.
    pub low_m: [f64; 2],
    /// North-eastern corner of the last cell.
    pub high_m: [f64; 2],
    /// Columns, counted from the west, and rows, counted from the south.
    pub size: [u32; 2],
    /// Cells row by row, with four values each: the share of the trees allowed by the rules (255 is all); the class, as
    /// an index into [`CoverFiles::classes`] plus 1 (0 is none); the height of its trees in quarters of a metre (0 if
    /// no raster gives it or there are no trees; 255 is that or more); and 255.
    pub texels: Vec<[u8; 4]>,
}

/// Why the rasters of a forest cannot be used. One line.
#[derive(Debug, thiserror::Error)]
pub enum CoverError {
    /// The file cannot be read.
    #[error(transparent)]
    Read(#[from] SourceError),
    /// The raster has no reference system.
    #[error(
        "{}: has no coordinate reference system, so it cannot be aligned with the world; assign one with gdal_edit -a_srs",
        named(path)
    )]
    Nowhere {
        /// Path of the raster.
        path: PathBuf,
    },
    /// The world has no reference system.
    #[error("{}: cannot be aligned with the world, which has no coordinate reference system", named(path))]
    WorldNowhere {
        /// Path of the raster.
        path: PathBuf,
    },
    /// There is no transformation between the reference systems.
    #[error("{}: cannot be aligned with the world: {cause}", named(path))]
    NoWay {
        /// Path of the raster.
        path: PathBuf,
        /// The reason, as a clause.
        cause: String,
    },
    /// The raster does not overlap the others, so there would be no trees.
    #[error("{}: does not overlap the world, or the other rasters of the forest", named(path))]
    OutsideWorld {
        /// Path of the raster.
        path: PathBuf,
    },
    /// A value of a land-cover raster is not a whole number.
    #[error("{}: has the value {value}, but a class must be a whole number", named(path))]
    NoClass {
        /// Path of the raster.
        path: PathBuf,
        value: f32,
    },
}

/// The quantity that a raster gives.
enum Question<'a> {
    Mask { full: f32 },
    Class { classes: &'a [CoverClass], numbers: FxHashMap<i32, u8> },
    Canopy,
}

impl Cover {
    /// Reads the rasters of a forest, for a world whose DEM has the georeference `place` and `samples` columns and
    /// rows. Returns `None` if the forest has no rasters.
    ///
    /// # Errors
    /// The first raster that cannot be read, or cannot be aligned with the world.
    pub(crate) fn load(
        files: &CoverFiles,
        place: &Georeference,
        samples: [u32; 2],
    ) -> Result<Option<Self>, CoverError> {
        let Some((_, first)) = files.files().next() else { return Ok(None) };
        let ground = Ground::new(place, samples)
            .map_err(|error| CoverError::NoWay { path: first.clone(), cause: error.to_string() })?;
        let mut rasters: Vec<(AlignedRaster<'_>, Question<'_>)> = Vec::new();
        if let Some(path) = &files.mask {
            let values = open_values(path, Holds::Shades)?;
            let question = Question::Mask { full: values.full as f32 };
            let aligned = match values.is_located {
                true => AlignedRaster::by_place(path, values.reader, &ground)?,
                false => AlignedRaster::stretched(path, values.reader, &ground)?,
            };
            rasters.push((aligned, question));
        }
        if let Some(path) = &files.land_cover {
            let reader = open_values(path, Holds::Classes)?.reader;
            let numbers = files.classes.iter().zip(1..).map(|(class, number)| (class.class, number)).collect();
            rasters.push((
                AlignedRaster::by_place(path, reader, &ground)?,
                Question::Class { classes: &files.classes, numbers },
            ));
        }
        if let Some(path) = &files.canopy_height {
            let reader = open_values(path, Holds::Heights)?.reader;
            rasters.push((AlignedRaster::by_place(path, reader, &ground)?, Question::Canopy));
        }
        let grid = Grid::over(&ground, rasters.iter().map(|(aligned, _)| aligned))?;

        let mut densities = vec![1_f32; grid.cells()];
        let mut texels = vec![[0, 0, 0, 255_u8]; grid.cells()];
        for (aligned, question) in &rasters {
            let put = |cell: usize, answer: Answer| {
                densities[cell] *= answer.density;
                texels[cell][1] = texels[cell][1].max(answer.class);
                texels[cell][2] = texels[cell][2].max(answer.quarters_m);
            };
            let tally = resample(aligned, &grid, |values, tally| question.answer(values, tally), put)?;
            let factor = question.check_tally(aligned.path, &tally, aligned.samples_per_point(&grid))?;
            densities.iter_mut().for_each(|density| *density *= factor);
        }
        for (texel, density) in texels.iter_mut().zip(densities) {
            texel[0] = (255.0 * density).round() as u8;
        }
        let (low_m, high_m) = (grid.low_m.to_array(), grid.high_m().to_array());
        Ok(Some(Self { low_m, high_m, size: grid.size, texels }))
    }

    /// Returns the values of the cell at a position in the world; `None` outside of the grid.
    pub(crate) fn at(&self, [east_m, north_m]: [f64; 2]) -> Option<[u8; 4]> {
        let along = |at_m: f64, axis: usize| {
            let part = (at_m - self.low_m[axis]) / (self.high_m[axis] - self.low_m[axis]);
            (0.0..1.0).contains(&part).then(|| (part * f64::from(self.size[axis])) as usize)
        };
        let (column, row) = (along(east_m, 0)?, along(north_m, 1)?);
        self.texels.get(row * self.size[0] as usize + column).copied()
    }
}

impl Question<'_> {
    /// Returns the answer for a cell with these values; NaN is no data.
    fn answer(&self, values: &[f32], tally: &mut Tally) -> Answer {
        let count = values.len() as f32;
        let none = Answer { density: 0.0, class: 0, quarters_m: 0 };
        match self {
            Self::Mask { full } => {
                let known = values.iter().filter(|value| !value.is_nan());
                let shades = known.map(|value| {
                    tally.largest = tally.largest.max(*value);
                    value.clamp(0.0, *full)
                });
                Answer { density: shades.sum::<f32>() / (full * count), ..none }
            }
            Self::Class { classes, numbers } => {
                // For each class in the cell: the number of values.
                let mut here: Vec<(u8, f32)> = Vec::new();
                for value in values.iter().filter(|value| !value.is_nan()) {
                    let class = *value as i32;
                    if class as f32 != *value {
                        tally.odd.get_or_insert(*value);
                    } else if let Some(number) = numbers.get(&class) {
                        match here.iter_mut().find(|(other, _)| other == number) {
                            Some((_, count)) => *count += 1.0,
                            None => here.push((*number, 1.0)),
                        }
                    } else {
                        *tally.unlisted.entry(class).or_default() += 1;
                    }
                }
                let trees = |(number, count): &(u8, f32)| count * classes[usize::from(*number) - 1].density as f32;
                let most = here.iter().max_by(|a, b| trees(a).total_cmp(&trees(b)).then(a.1.total_cmp(&b.1)));
                let class = most.map_or(0, |(number, _)| *number);
                Answer { density: here.iter().map(trees).sum::<f32>() / count, class, ..none }
            }
            Self::Canopy => {
                let trees = || values.iter().filter(|height_m| **height_m >= LOWEST_TREE_M);
                let number = trees().count() as f32;
                if number == 0.0 {
                    return none;
                }
                let mean_m = trees().sum::<f32>() / number;
                Answer { density: number / count, quarters_m: (4.0 * mean_m).round() as u8, ..none }
            }
        }
    }

    /// Checks the tally after all cells, logs unlisted classes, and returns a factor for the raster's densities.
    ///
    /// # Errors
    /// The raster does not overlap the grid, or has values that are not classes.
    fn check_tally(&self, path: &Path, tally: &Tally, samples_per_point: f64) -> Result<f32, CoverError> {
        if tally.inside == 0 {
            return Err(CoverError::OutsideWorld { path: path.to_owned() });
        }
        if let Some(value) = tally.odd {
            return Err(CoverError::NoClass { path: path.to_owned(), value });
        }
        if let Some(line) = unlisted_line(path, tally, samples_per_point) {
            tracing::warn!("{line}");
        }
        Ok(match self {
            // The mask has only zeros and ones.
            Self::Mask { full } if tally.largest > 0.0 && tally.largest <= 1.0 => *full,
            _ => 1.0,
        })
    }
}

/// Returns a warning about classes that the scene does not list, most frequent first, with their approximate numbers of
/// samples in the grid.
fn unlisted_line(path: &Path, tally: &Tally, samples_per_point: f64) -> Option<String> {
    let mut classes: Vec<(i32, u64)> = tally.unlisted.iter().map(|(class, count)| (*class, *count)).collect();
    classes.sort_by_key(|(class, count)| (std::cmp::Reverse(*count), *class));
    let samples = |count: u64| (count as f64 * samples_per_point).round().max(1.0);
    let names = classes.iter().take(NAMED_CLASSES).map(|(class, count)| format!("{class} ({})", samples(*count)));
    let mut names = names.collect::<Vec<_>>().join(", ");
    if classes.len() > NAMED_CLASSES {
        names += &format!(" and {} more", classes.len() - NAMED_CLASSES);
    }
    let path = path.display();
    (!classes.is_empty())
        .then(|| format!("{path}: classes that the scene does not list have no trees; class (samples): {names}"))
}
