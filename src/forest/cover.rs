//! Where trees stand by rasters: a mask, classes of land, heights of a canopy.
//!
//! Whatever their reference systems and resolutions, they are resampled once, when a scene opens, to one grid whose axes
//! are those of the world ([`Cover`]), which a shader then asks about any place. The grid covers what the world and all
//! rasters have in common, so a small raster in a large world keeps its detail; its cells are squares, as small as the
//! samples of the finest raster, or as [`MOST_CELLS`] along a side allow. Where the axes agree, cells are the samples of
//! that raster.
//!
//! `laid` takes a place of the world to the samples of a raster, through the samples of the DEM, as mosaics do it. A
//! cell asks at points within it (`resample`), one where its raster is no finer than the grid, else several for each
//! sample: its density is the mean over them, its class the one that has most trees there, its canopy the mean of those
//! who have trees. Several rasters are multiplied.
//!
//! A raster says nothing about what lies outside of it, or where it has no data: there are no trees. A mask without a
//! georeference is stretched over the DEM, its upper edge in the north.

mod laid;
mod resample;
#[cfg(test)]
mod scratch;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use rustc_hash::FxHashMap;

use self::laid::{Ground, Laid};
use self::resample::{Answer, Grid, Tally, resample};
use crate::file::message::named;
use crate::scene::{CoverClass, CoverFiles};
use crate::source::georeference::Georeference;
use crate::source::{Holds, SourceError, open_values};

/// Of a cover along each of its sides.
pub const MOST_CELLS: u32 = 4096;
/// What is lower is no tree.
pub const LOWEST_TREE_M: f32 = 2.0;
/// So many classes are named in a warning.
const NAMED_CLASSES: usize = 24;

/// What rasters say of the trees of a world. Where it does not reach, there are none.
#[derive(Clone, Debug, PartialEq)]
pub struct Cover {
    /// The south-western corner of the first cell: east and north, in the world.
    pub low_m: [f64; 2],
    /// The north-eastern corner of the last one.
    pub high_m: [f64; 2],
    /// Columns, counted from the west, and rows, counted from the south.
    pub size: [u32; 2],
    /// Row by row: how many of the trees that the rules allow stand there (255 is all); which class it is, counted from
    /// 1 in [`CoverFiles::classes`] (0 is none); how tall its trees are, in quarters of a metre (0 where no raster says
    /// it, or nothing stands; 255 is that or more); 255.
    pub texels: Vec<[u8; 4]>,
}

/// Why rasters say nothing about a forest. One line.
#[derive(Debug, thiserror::Error)]
pub enum CoverError {
    /// It cannot be read.
    #[error(transparent)]
    Read(#[from] SourceError),
    /// Nobody knows where it lies.
    #[error("{}: has no coordinate reference system, so it cannot be aligned with the world", named(path))]
    Nowhere {
        /// Of the raster.
        path: PathBuf,
    },
    /// Nobody knows where the land lies.
    #[error("{}: cannot be aligned with the world, which has no coordinate reference system", named(path))]
    WorldNowhere {
        /// Of the raster.
        path: PathBuf,
    },
    /// Nobody knows how their reference systems lie to one another.
    #[error("{}: cannot be aligned with the world: {cause}", named(path))]
    NoWay {
        /// Of the raster.
        path: PathBuf,
        /// What is not known.
        cause: String,
    },
    /// It would leave no tree.
    #[error("{}: does not overlap the world, or the other rasters of the forest", named(path))]
    OutsideWorld {
        /// Of the raster.
        path: PathBuf,
    },
    /// Land cover that is something else.
    #[error("{}: has the value {value}, but a class must be a whole number", named(path))]
    NoClass {
        /// Of the raster.
        path: PathBuf,
        /// What is none.
        value: f32,
    },
}

/// What a raster is asked about.
enum Asks<'a> {
    Mask { full: f32 },
    Class { classes: &'a [CoverClass], numbers: FxHashMap<i32, u8> },
    Canopy,
}

impl Cover {
    /// Reads the rasters of a forest, for a world whose DEM lies at `place` and has `samples` columns and rows. None
    /// where the forest has no rasters.
    ///
    /// # Errors
    /// The first raster that cannot be read, or laid over the world.
    pub fn load(files: &CoverFiles, place: &Georeference, samples: [u32; 2]) -> Result<Option<Self>, CoverError> {
        let Some((_, first)) = files.files().next() else { return Ok(None) };
        let ground = Ground::new(place, samples)
            .map_err(|error| CoverError::NoWay { path: first.clone(), cause: error.to_string() })?;
        let mut rasters: Vec<(Laid<'_>, Asks<'_>)> = Vec::new();
        if let Some(path) = &files.mask {
            let values = open_values(path, Holds::Shades)?;
            let asks = Asks::Mask { full: values.full as f32 };
            let laid = match values.is_located {
                true => Laid::by_place(path, values.reader, &ground)?,
                false => Laid::stretched(path, values.reader, &ground)?,
            };
            rasters.push((laid, asks));
        }
        if let Some(path) = &files.land_cover {
            let reader = open_values(path, Holds::Classes)?.reader;
            let numbers = files.classes.iter().zip(1..).map(|(class, number)| (class.class, number)).collect();
            rasters.push((Laid::by_place(path, reader, &ground)?, Asks::Class { classes: &files.classes, numbers }));
        }
        if let Some(path) = &files.canopy_height {
            let reader = open_values(path, Holds::Heights)?.reader;
            rasters.push((Laid::by_place(path, reader, &ground)?, Asks::Canopy));
        }
        let grid = Grid::over(&ground, rasters.iter().map(|(laid, _)| laid))?;

        let mut densities = vec![1_f32; grid.cells()];
        let mut texels = vec![[0, 0, 0, 255_u8]; grid.cells()];
        for (laid, asks) in &rasters {
            let put = |cell: usize, answer: Answer| {
                densities[cell] *= answer.density;
                texels[cell][1] = texels[cell][1].max(answer.class);
                texels[cell][2] = texels[cell][2].max(answer.quarters_m);
            };
            let tally = resample(laid, &grid, |values, tally| asks.answer(values, tally), put)?;
            let factor = asks.told(laid.path, &tally, laid.samples_per_point(&grid))?;
            densities.iter_mut().for_each(|density| *density *= factor);
        }
        for (texel, density) in texels.iter_mut().zip(densities) {
            texel[0] = (255.0 * density).round() as u8;
        }
        let (low_m, high_m) = (grid.low_m.to_array(), grid.high_m().to_array());
        Ok(Some(Self { low_m, high_m, size: grid.size, texels }))
    }

    /// What is said of a place in the world; none outside.
    pub fn at(&self, [east_m, north_m]: [f64; 2]) -> Option<[u8; 4]> {
        let along = |at_m: f64, axis: usize| {
            let part = (at_m - self.low_m[axis]) / (self.high_m[axis] - self.low_m[axis]);
            (0.0..1.0).contains(&part).then(|| (part * f64::from(self.size[axis])) as usize)
        };
        let (column, row) = (along(east_m, 0)?, along(north_m, 1)?);
        self.texels.get(row * self.size[0] as usize + column).copied()
    }
}

impl Asks<'_> {
    /// Of a cell with these values; NaN is no data.
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
                // Of each class of the cell: how many values, and how many trees.
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

    /// What is to be said when all cells have been asked, and what densities are to be multiplied by.
    ///
    /// # Errors
    /// A raster that is not what it should be.
    fn told(&self, path: &Path, tally: &Tally, samples_per_point: f64) -> Result<f32, CoverError> {
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
            // A mask of zeros and ones.
            Self::Mask { full } if tally.largest > 0.0 && tally.largest <= 1.0 => *full,
            _ => 1.0,
        })
    }
}

/// The classes that nobody listed, most frequent first, with about how many samples have them in the grid.
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
