//! Water given by a scene: a mask or polygons, rasterised once to the samples of the DEM.
//!
//! A cell is a sample of the DEM, or a square of several where the extent of the water would give more than
//! `MAX_CELLS` cells; it is water if its centre is. Coarser levels have the mean of the four cells under theirs, as
//! heights have. The passes that compute water maps (`surface/lakes`) read these levels in addition to the heights, so
//! the shore of given water is found, smoothed and measured like that of a lake that heights show.
//!
//! Why: `docs/decisions/water.md`.

use std::path::{Path, PathBuf};

use glam::DVec2;
use rayon::prelude::*;

use crate::file::geojson_polygons::{Polygons, PolygonsError, Ring};
use crate::file::message::{named, printable};
use crate::forest::cover::{Cover, CoverError};
use crate::scene::{CoverFiles, WaterFiles};
use crate::source::WorldMapping;
use crate::source::georeference::{Crs, Georeference, GeoreferenceError};
use crate::source::mosaic::Way;

/// Largest number of cells of the finest level.
const MAX_CELLS: u64 = 1 << 24;
/// Number of samples beyond the border of the DEM up to which water is rasterised, for shores near its border.
const BEYOND: i64 = 64;
/// Largest number of levels of a pyramid.
const MAX_LEVELS: u32 = 24;
/// Number of words before the tables of levels, and of words of a table.
const HEAD_WORDS: usize = 4;
const TABLE_WORDS: usize = 5;
/// Number of places along each side of a mask by which its extent is found.
const BORDER_PLACES: u32 = 32;

/// The reason why a water file cannot be used. The message is one line that names the file.
#[derive(Debug, thiserror::Error)]
pub enum GivenWaterError {
    /// The polygons are invalid.
    #[error(transparent)]
    Polygons(#[from] PolygonsError),
    /// The mask cannot be read or placed on the world.
    #[error(transparent)]
    Mask(#[from] CoverError),
    /// The reference system of the polygons is unknown.
    #[error("{}: {cause}", named(path))]
    Crs {
        path: PathBuf,
        /// The defect of the reference system.
        cause: GeoreferenceError,
    },
    /// The polygons cannot be projected into the world's coordinates.
    #[error("{}: cannot be projected onto the world: {cause}", named(path))]
    NoWay {
        path: PathBuf,
        /// The reason, as a clause.
        cause: String,
    },
}

/// The given water in the layout that `shaders/surface/lakes/blocks.wgsl` reads.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenWater {
    /// The number of levels, the number of the first level, whether there is no other water, and 0; then for each level
    /// the offset of its cells, the column and row of its first cell among the samples of that level, and the numbers
    /// of columns and rows; then cells, four per word: 255 is water.
    pub words: Vec<i32>,
}

/// The cells of a level.
struct Level {
    low: [i64; 2],
    size: [usize; 2],
    cells: Vec<u8>,
}

impl GivenWater {
    /// Reads the water files of a world whose DEM has the georeference `place` and `samples` columns and rows. Returns
    /// `None` if they name nothing, or, after a warning, if they contain nothing within the world.
    ///
    /// # Errors
    /// The first file that is invalid, or whose reference system is unknown.
    pub fn load(files: &WaterFiles, place: &Georeference, samples: [u32; 2]) -> Result<Option<Self>, GivenWaterError> {
        let polygons = files.polygons.as_ref().map(|path| polygons_on_grid(path, place, samples)).transpose()?;
        let cover_files = CoverFiles { mask: files.mask.clone(), ..CoverFiles::default() };
        let cover = Cover::load(&cover_files, place, samples)?;
        let mask = cover.as_ref().and_then(|cover| {
            let mapping = WorldMapping::new(place, samples[0], samples[1]).ok()?;
            Some((cover, mapping))
        });
        let of_polygons = polygons.iter().flatten().flatten().flatten().map(|at| DVec2::from_array(*at));
        let of_mask = mask.iter().flat_map(|(cover, mapping)| border_on_grid(cover, mapping));
        let Some(bounds) = bounds(of_polygons.chain(of_mask), samples) else {
            for (_, path) in files.files() {
                tracing::warn!("{}: is outside the world, and adds no water", named(path));
            }
            return Ok(None);
        };
        let (mut level, stride_level) = empty_level(bounds);
        let stride = f64::from(1_u32 << stride_level);
        for polygon in polygons.iter().flatten() {
            fill(&mut level, polygon, stride);
        }
        if let Some((cover, mapping)) = mask {
            let [columns, _] = level.size;
            level.cells.par_chunks_mut(columns).enumerate().for_each(|(row, cells)| {
                for (column, cell) in cells.iter_mut().enumerate() {
                    let at = [(level.low[0] + column as i64) as f64, (level.low[1] + row as i64) as f64];
                    let [x, y] = at.map(|at| (at + 0.5) * stride - 0.5);
                    let is_water = cover.at(mapping.world_from_grid(x, y).to_array()).is_some_and(|texel| texel[0] > 0);
                    *cell = if is_water { 255 } else { *cell };
                }
            });
        }
        if level.cells.iter().all(|cell| *cell == 0) {
            for (_, path) in files.files() {
                tracing::warn!("{}: has no water at any sample of the world", named(path));
            }
        }
        Ok(Some(Self::of_levels(level, stride_level, files.only_given)))
    }

    /// Computes the coarser levels, and the words of all.
    fn of_levels(finest: Level, first: u32, only_given: bool) -> Self {
        let mut levels = vec![finest];
        while first + (levels.len() as u32) < MAX_LEVELS {
            let Some(coarser) = levels.last().map(halved) else { break };
            levels.push(coarser);
        }
        let mut words = vec![levels.len() as i32, first as i32, i32::from(only_given), 0];
        let mut begin = HEAD_WORDS + TABLE_WORDS * levels.len();
        for level in &levels {
            let [column, row] = level.low.map(|low| low as i32);
            words.extend([begin as i32, column, row, level.size[0] as i32, level.size[1] as i32]);
            begin += level.cells.len().div_ceil(4);
        }
        for level in &levels {
            let four = |cells: &[u8]| {
                let byte = |i: usize| cells.get(i).copied().unwrap_or(0);
                i32::from_le_bytes([byte(0), byte(1), byte(2), byte(3)])
            };
            words.extend(level.cells.chunks(4).map(four));
        }
        Self { words }
    }
}

/// Reads polygons in columns and rows of the DEM.
fn polygons_on_grid(path: &Path, place: &Georeference, samples: [u32; 2]) -> Result<Vec<Vec<Ring>>, GivenWaterError> {
    let polygons = Polygons::read(path)?;
    let own = Georeference::of_coordinates(polygons.epsg)
        .map_err(|cause| GivenWaterError::Crs { path: path.to_owned(), cause })?;
    let no_way = |cause: String| GivenWaterError::NoWay { path: path.to_owned(), cause: printable(&cause, 120) };
    if place.crs == Crs::Local {
        return Err(no_way("the heights have no coordinate reference system".to_owned()));
    }
    let way = Way::to_grid(&own, place, samples).map_err(no_way)?;
    let on_grid = |ring: Ring| -> Ring { ring.into_iter().map(|[x, y]| way.map(x, y)).collect() };
    let all = polygons.polygons.into_iter().map(|polygon| polygon.into_iter().map(on_grid).collect());
    let all: Vec<Vec<Ring>> = all.collect();
    // A projection may cover only a part of the earth.
    let is_shown = |polygon: &Vec<Ring>| polygon.iter().flatten().flatten().all(|c| c.is_finite());
    let (shown, hidden): (Vec<_>, Vec<_>) = all.into_iter().partition(is_shown);
    if !hidden.is_empty() {
        tracing::warn!(
            "{}: ignored {} polygons outside the range of the world's projection",
            named(path),
            hidden.len()
        );
    }
    Ok(shown)
}

/// Returns the border of a mask in columns and rows of the DEM.
fn border_on_grid(cover: &Cover, mapping: &WorldMapping) -> Vec<DVec2> {
    let (low_m, high_m) = (DVec2::from_array(cover.low_m), DVec2::from_array(cover.high_m));
    let along = |i: u32| low_m + (high_m - low_m) * (f64::from(i) / f64::from(BORDER_PLACES));
    let sides = |i: u32| {
        let at_m = along(i);
        [[at_m.x, low_m.y], [at_m.x, high_m.y], [low_m.x, at_m.y], [high_m.x, at_m.y]]
    };
    (0..=BORDER_PLACES).flat_map(sides).map(|at_m| mapping.grid_from_world(at_m.into())).collect()
}

/// Returns the bounds of places in samples, within the DEM and a little beyond, or `None` if there are none.
fn bounds(places: impl Iterator<Item = DVec2>, samples: [u32; 2]) -> Option<[[i64; 2]; 2]> {
    let nothing = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    let (low, high) = places.filter(|at| at.is_finite()).fold(nothing, |(low, high), at| (low.min(at), high.max(at)));
    // A world that is touched only within this margin has no water.
    let last = DVec2::from_array(samples.map(|count| f64::from(count) - 1.0));
    if !(low.cmple(last).all() && high.cmpge(DVec2::ZERO).all()) {
        return None;
    }
    let beyond = DVec2::splat(BEYOND as f64);
    let (low, high) = (low.floor().max(-beyond), high.ceil().min(last + beyond));
    Some([low, high].map(|at| [at.x as i64, at.y as i64]))
}

/// Returns the cells within bounds, all of them land, and their level.
fn empty_level([low, high]: [[i64; 2]; 2]) -> (Level, u32) {
    let level_of = |level: u32| {
        let low = low.map(|low| low >> level);
        let size = [0, 1].map(|axis| ((high[axis] >> level) - low[axis] + 1) as usize);
        (low, size)
    };
    let fits = |level: &u32| level_of(*level).1.iter().map(|side| *side as u64).product::<u64>() <= MAX_CELLS;
    let number = (0..MAX_LEVELS).find(fits).unwrap_or(MAX_LEVELS);
    let (low, size) = level_of(number);
    (Level { low, size, cells: vec![0; size[0] * size[1]] }, number)
}

/// Marks cells as water whose centre is inside an odd number of rings.
fn fill(level: &mut Level, polygon: &[Ring], stride: f64) {
    let [columns, rows] = level.size;
    // Sample coordinates count from sample centres.
    let cell_of = |[x, y]: [f64; 2]| {
        [(x + 0.5) / stride - 0.5 - level.low[0] as f64, (y + 0.5) / stride - 0.5 - level.low[1] as f64]
    };
    let mut crossings: Vec<Vec<f64>> = vec![Vec::new(); rows];
    for ring in polygon {
        for (number, begin) in ring.iter().enumerate() {
            let [a, b] = [*begin, ring[(number + 1) % ring.len()]].map(cell_of);
            let [above, below] = if a[1] < b[1] { [a, b] } else { [b, a] };
            // From the row at its upper end to the one before its lower end.
            let first = above[1].ceil().clamp(0.0, rows as f64) as usize;
            let end = below[1].ceil().clamp(0.0, rows as f64) as usize;
            for (row, crossings) in crossings.iter_mut().enumerate().take(end).skip(first) {
                let part = (row as f64 - above[1]) / (below[1] - above[1]);
                crossings.push(above[0] + part * (below[0] - above[0]));
            }
        }
    }
    for (crossings, cells) in crossings.iter_mut().zip(level.cells.chunks_mut(columns)) {
        crossings.sort_unstable_by(f64::total_cmp);
        for pair in crossings.chunks_exact(2) {
            let [first, end] = [pair[0], pair[1]].map(|x| x.ceil().clamp(0.0, columns as f64) as usize);
            cells[first..end.max(first)].fill(255);
        }
    }
}

/// Computes the next coarser level: each cell is the mean of four.
fn halved(finer: &Level) -> Level {
    let low = finer.low.map(|low| low >> 1);
    let size = [0, 1].map(|axis| {
        let last = finer.low[axis] + finer.size[axis] as i64 - 1;
        ((last >> 1) - low[axis] + 1) as usize
    });
    let at = |column: i64, row: i64| -> u32 {
        let [x, y] = [column - finer.low[0], row - finer.low[1]];
        let is_inside = x >= 0 && y >= 0 && x < finer.size[0] as i64 && y < finer.size[1] as i64;
        if is_inside { finer.cells[y as usize * finer.size[0] + x as usize].into() } else { 0 }
    };
    let mut cells = Vec::with_capacity(size[0] * size[1]);
    for row in (low[1]..).take(size[1]) {
        for column in (low[0]..).take(size[0]) {
            let (x, y) = (2 * column, 2 * row);
            cells.push(((at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1) + 2) / 4) as u8);
        }
    }
    Level { low, size, cells }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn filled(polygon: &[Ring], low: [i64; 2], high: [i64; 2]) -> Vec<String> {
        let (mut level, number) = empty_level([low, high]);
        fill(&mut level, polygon, f64::from(1_u32 << number));
        let line = |cells: &[u8]| cells.iter().map(|cell| if *cell == 255 { '#' } else { '.' }).collect();
        level.cells.chunks(level.size[0]).map(line).collect()
    }

    #[test]
    fn middles_of_cells_are_inside_or_outside() {
        let square = |low: f64, high: f64| vec![[low, low], [high, low], [high, high], [low, high]];
        let ring = [square(0.5, 5.5), square(1.5, 3.5)];
        assert_eq!(
            filled(&ring, [0, 0], [6, 6]),
            [".......", ".#####.", ".#..##.", ".#..##.", ".#####.", ".#####.", "......."]
        );
        // A ring that goes round twice: its inside is within an even number of turns.
        let twice =
            vec![[0.5, 0.5], [4.5, 0.5], [4.5, 4.5], [0.5, 4.5], [0.5, 0.5], [4.5, 0.5], [4.5, 4.5], [0.5, 4.5]];
        assert!(filled(&[twice], [0, 0], [5, 5]).iter().all(|row| !row.contains('#')));
        // Nothing is written beyond the cells, but parts that extend into them from outside are.
        assert_eq!(filled(&[square(-1e7, 1.5)], [0, 0], [3, 2]), ["##..", "##..", "...."]);
    }

    #[test]
    fn coarser_levels_are_means_of_the_same_samples() {
        let (mut level, _) = empty_level([[-3, 1], [4, 6]]);
        fill(&mut level, &[vec![[-0.5, 1.5], [3.5, 1.5], [3.5, 5.5], [-0.5, 5.5]]], 1.0);
        let coarse = halved(&level);
        assert_eq!((coarse.low, coarse.size), ([-2, 0], [5, 4]));
        assert_eq!(coarse.cells[5..10], [0, 0, 255, 255, 0]);
        assert_eq!(coarse.cells[..5], [0; 5]);
    }
}
