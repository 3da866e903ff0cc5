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

use crate::file::geojson_polygons::{Polygons, PolygonsError, Rings};
use crate::file::message::{named, printable};
use crate::forest::cover::{Cover, CoverError};
use crate::scene::{CoverFiles, WaterFiles};
use crate::source::WorldMapping;
use crate::source::earth_projection::turn_in_crs;
use crate::source::georeference::{Crs, Georeference, GeoreferenceError};
use crate::source::mosaic::SampleTransform;

/// Largest number of cells of the finest level.
const MAX_CELLS: u64 = 1 << 24;
/// Number of samples beyond the border of the DEM up to which water is rasterised, for shores near its border.
const BEYOND: i64 = 64;
/// Largest number of levels of a pyramid.
const MAX_LEVELS: u32 = 24;
/// Number of words before the tables of levels, and of words of a table.
const HEAD_WORDS: usize = 4;
const TABLE_WORDS: usize = 5;
/// Number of crossings of outlines and rows of cells that are stored; of a polygon with more, one bit for each cell is.
const MAX_SORTED: u64 = 1 << 20;
/// Largest number of crossings, and of [`CELLS_AT_ONCE`] cells, of all polygons: some seconds of work. An outline of a
/// million vertices has as many crossings, and a few more, unless it is made to have more.
const MAX_WORK: u64 = 1 << 28;
/// Number of cells that are filled in the time of a crossing, and of cells that follow toggled ones.
const CELLS_AT_ONCE: u64 = 64;
const CELLS_TOGGLED_AT_ONCE: u64 = 8;
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
    /// The outlines cross the rows of the grid too often.
    #[error(
        "{}: its outlines cross the {} rows of the world more than {MAX_WORK} times; simplify them",
        named(path),
        samples[1]
    )]
    TooMuch {
        path: PathBuf,
        /// Columns and rows of the DEM.
        samples: [u32; 2],
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
        let polygons = files.polygons.as_ref().map(|path| OnGrid::read(path, place, samples)).transpose()?;
        let cover_files = CoverFiles { mask: files.mask.clone(), ..CoverFiles::default() };
        let cover = Cover::load(&cover_files, place, samples)?;
        let mask = cover.as_ref().and_then(|cover| {
            let mapping = WorldMapping::new(place, samples[0], samples[1]).ok()?;
            Some((cover, mapping))
        });
        let shown: Vec<(Rings<'_>, DVec2)> = polygons.iter().flat_map(|polygons| polygons.copies(samples)).collect();
        let of_polygons =
            shown.iter().flat_map(|(polygon, shift)| polygon.places().map(|at| DVec2::from_array(*at) + *shift));
        let of_mask = mask.iter().flat_map(|(cover, mapping)| border_on_grid(cover, mapping));
        let Some(bounds) = bounds(of_polygons.chain(of_mask), samples) else {
            for (_, path) in files.files() {
                tracing::warn!("{}: is outside the world, and adds no water", named(path));
            }
            return Ok(None);
        };
        let (mut level, stride_level) = empty_level(bounds);
        let stride = f64::from(1_u32 << stride_level);
        let mut work = Work { left: MAX_WORK };
        if !shown.into_iter().all(|(polygon, shift)| fill(&mut level, polygon, shift, stride, &mut work)) {
            let path = files.polygons.clone().unwrap_or_default();
            return Err(GivenWaterError::TooMuch { path, samples });
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

/// Polygons in columns and rows of the DEM.
struct OnGrid {
    polygons: Polygons,
    /// A whole turn of longitude in columns and rows, if all parallels of the DEM are straight.
    turn: Option<DVec2>,
}

impl OnGrid {
    fn read(path: &Path, place: &Georeference, samples: [u32; 2]) -> Result<Self, GivenWaterError> {
        let mut polygons = Polygons::read(path)?;
        let own = Georeference::of_coordinates(polygons.epsg)
            .map_err(|cause| GivenWaterError::Crs { path: path.to_owned(), cause })?;
        let no_way = |cause: String| GivenWaterError::NoWay { path: path.to_owned(), cause: printable(&cause, 120) };
        if place.crs == Crs::Local {
            return Err(no_way("the heights have no coordinate reference system".to_owned()));
        }
        let turn = match (&own.crs, turn_in_crs(place)) {
            // Longitudes keep their turns: the edge from -179° to 179° goes around the earth.
            (Crs::Geographic { radians_per_unit, .. }, Some(turn)) => {
                let way = SampleTransform::between(&own, place, None).map_err(no_way)?;
                let [x0, a, b, _, c, d] = place.crs_from_grid;
                let step = DVec2::new(d, -c) * (turn / (a * d - b * c));
                let x = |[column, row]: [f64; 2]| x0 + a * column + b * row;
                let greenwich = x(way.map(0.0, 0.0));
                polygons.places_mut().par_iter_mut().for_each(|at| {
                    let expected = greenwich + at[0] * radians_per_unit / std::f64::consts::TAU * turn;
                    let on_grid = way.map(at[0], at[1]);
                    *at = (DVec2::from(on_grid) + step * ((expected - x(on_grid)) / turn).round()).to_array();
                });
                Some(step)
            }
            _ => {
                let way = SampleTransform::to_grid(&own, place, samples).map_err(no_way)?;
                polygons.places_mut().par_iter_mut().for_each(|at| *at = way.map(at[0], at[1]));
                None
            }
        };
        // A projection may cover only a part of the earth.
        let hidden = polygons.polygons().filter(|polygon| !is_finite(polygon)).count();
        if hidden > 0 {
            tracing::warn!("{}: ignored {hidden} polygons outside the range of the world's projection", named(path));
        }
        Ok(Self { polygons, turn })
    }

    /// Returns each polygon that may be on the DEM, with the whole turns by which it is shifted there, in columns and
    /// rows.
    fn copies(&self, samples: [u32; 2]) -> impl Iterator<Item = (Rings<'_>, DVec2)> {
        let (last, beyond) = (DVec2::from_array(samples.map(f64::from)), DVec2::splat(BEYOND as f64));
        let shifts: Vec<DVec2> = match self.turn {
            Some(turn) => vec![DVec2::ZERO, -turn, turn],
            None => vec![DVec2::ZERO],
        };
        self.polygons.polygons().filter(is_finite).flat_map(move |polygon| {
            let nothing = (DVec2::INFINITY, DVec2::NEG_INFINITY);
            let (low, high) =
                polygon.places().fold(nothing, |(low, high), at| (low.min((*at).into()), high.max((*at).into())));
            let meets =
                move |shift: &DVec2| (low + *shift).cmple(last + beyond).all() && (high + *shift).cmpge(-beyond).all();
            shifts.clone().into_iter().filter(meets).map(move |shift| (polygon, shift))
        })
    }
}

/// Returns whether all vertices of a polygon have a place on the grid.
fn is_finite(polygon: &Rings<'_>) -> bool {
    polygon.places().flatten().all(|coordinate| coordinate.is_finite())
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

/// The work that may still be done to fill polygons.
struct Work {
    left: u64,
}

impl Work {
    /// Takes some of the work that is left; returns false if there is not as much.
    fn take(&mut self, work: u64) -> bool {
        let left = self.left.checked_sub(work);
        self.left = left.unwrap_or(0);
        left.is_some()
    }
}

/// The rows that an edge crosses, and where.
struct Edge {
    above: [f64; 2],
    below: [f64; 2],
    /// From the row at its upper end to the one before its lower end.
    rows: std::ops::Range<usize>,
}

impl Edge {
    /// Returns the column at which it crosses a row.
    fn column(&self, row: usize) -> f64 {
        let part = (row as f64 - self.above[1]) / (self.below[1] - self.above[1]);
        self.above[0] + part * (self.below[0] - self.above[0])
    }
}

/// Returns the edges of a polygon, in cells of a level. The polygon is shifted by `shift`, in samples.
fn edges<'a>(level: &Level, polygon: Rings<'a>, shift: DVec2, stride: f64) -> impl Iterator<Item = Edge> + use<'a> {
    let (low, rows) = (level.low.map(|low| low as f64), level.size[1] as f64);
    // Sample coordinates count from sample centres.
    let cell = move |at: f64, axis: usize| (at + shift[axis] + 0.5) / stride - 0.5 - low[axis];
    let cell_of = move |[x, y]: [f64; 2]| [cell(x, 0), cell(y, 1)];
    polygon.rings().flat_map(move |ring| {
        let ends = ring.iter().zip(ring.iter().cycle().skip(1));
        ends.map(move |(begin, end)| {
            let [a, b] = [*begin, *end].map(cell_of);
            let [above, below] = if a[1] < b[1] { [a, b] } else { [b, a] };
            let [first, end] = [above, below].map(|at| at[1].ceil().clamp(0.0, rows) as usize);
            Edge { above, below, rows: first..end }
        })
    })
}

/// Marks cells as water whose centre is inside an odd number of rings. Returns false if that is more work than is left.
fn fill(level: &mut Level, polygon: Rings<'_>, shift: DVec2, stride: f64, work: &mut Work) -> bool {
    let [columns, _] = level.size;
    let (mut crossings, mut first_row, mut end_row) = (0, usize::MAX, 0);
    for edge in edges(level, polygon, shift, stride).filter(|edge| !edge.rows.is_empty()) {
        crossings += edge.rows.len() as u64;
        (first_row, end_row) = (first_row.min(edge.rows.start), end_row.max(edge.rows.end));
    }
    let rows = first_row..end_row;
    let edge_count = polygon.places().count() as u64;
    if !work.take(crossings.saturating_add(edge_count)) {
        return false;
    }
    let column_of = |x: f64| x.ceil().clamp(0.0, columns as f64) as usize;
    if crossings <= MAX_SORTED {
        // The crossings of each row in order: between the first and the second is water, and so on.
        let all = edges(level, polygon, shift, stride).flat_map(|edge| {
            let rows = edge.rows.clone();
            rows.map(move |row| (row as u32, column_of(edge.column(row)) as u32))
        });
        let mut all: Vec<(u32, u32)> = all.collect();
        all.sort_unstable();
        return all.chunk_by(|a, b| a.0 == b.0).all(|of_row| {
            of_row.chunks_exact(2).all(|pair| {
                let row = pair[0].0 as usize * columns;
                level.cells[row + pair[0].1 as usize..row + pair[1].1 as usize].fill(255);
                work.take(u64::from(pair[1].1 - pair[0].1) / CELLS_AT_ONCE)
            })
        });
    }
    // Too many to store: each crossing toggles one cell, and all cells behind it follow.
    if !work.take((rows.len() * columns) as u64 / CELLS_TOGGLED_AT_ONCE) {
        return false;
    }
    let mut toggled = vec![false; rows.len() * columns];
    for edge in edges(level, polygon, shift, stride) {
        for row in edge.rows.clone() {
            let column = column_of(edge.column(row));
            if column < columns {
                toggled[(row - rows.start) * columns + column] ^= true;
            }
        }
    }
    let own = level.cells[rows.start * columns..].chunks_mut(columns);
    for (cells, toggled) in own.zip(toggled.chunks(columns)) {
        let mut is_water = false;
        for (cell, toggled) in cells.iter_mut().zip(toggled) {
            is_water ^= toggled;
            *cell = if is_water { 255 } else { *cell };
        }
    }
    true
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
    #![allow(clippy::unwrap_used, reason = "a test fails by it")]

    use super::*;

    type Ring = Vec<[f64; 2]>;

    fn polygons(rings: &[Ring]) -> Polygons {
        Polygons::parse(&format!("{{\"type\":\"Polygon\",\"coordinates\":{rings:?}}}")).unwrap()
    }

    /// Fills the one polygon of these rings.
    fn fill_rings(level: &mut Level, rings: &[Ring], stride: f64, work: &mut Work) -> bool {
        polygons(rings).polygons().all(|polygon| fill(level, polygon, DVec2::ZERO, stride, work))
    }

    fn filled(polygon: &[Ring], low: [i64; 2], high: [i64; 2]) -> Vec<String> {
        let (mut level, number) = empty_level([low, high]);
        assert!(fill_rings(&mut level, polygon, f64::from(1_u32 << number), &mut Work { left: MAX_WORK }));
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
        let ring = vec![[-0.5, 1.5], [3.5, 1.5], [3.5, 5.5], [-0.5, 5.5]];
        assert!(fill_rings(&mut level, &[ring], 1.0, &mut Work { left: MAX_WORK }));
        let coarse = halved(&level);
        assert_eq!((coarse.low, coarse.size), ([-2, 0], [5, 4]));
        assert_eq!(coarse.cells[5..10], [0, 0, 255, 255, 0]);
        assert_eq!(coarse.cells[..5], [0; 5]);
    }

    #[test]
    fn outlines_that_cross_every_row_take_bounded_work() {
        // A zigzag over all rows: it has more crossings than are stored.
        let (side, teeth) = (600_i64, 2000);
        let at = |i: i32| [f64::from(i % 97) * 6.0 + 0.25, if i % 2 == 0 { -3.0 } else { 700.0 }];
        let zigzag: Ring = (0..teeth).map(at).chain([[300.0, -3.0]]).collect();
        let edges = zigzag.len() as u64;
        assert!(edges * 600 > MAX_SORTED, "the case must be one");
        let (mut level, _) = empty_level([[0, 0], [side - 1, side - 1]]);
        let mut work = Work { left: MAX_WORK };
        assert!(fill_rings(&mut level, std::slice::from_ref(&zigzag), 1.0, &mut work));
        assert!(MAX_WORK - work.left <= 601 * edges + 600 * 600 / CELLS_TOGGLED_AT_ONCE);
        // The same cells as by counting crossings to the left of each.
        let ends = |i: usize| [zigzag[i], zigzag[(i + 1) % zigzag.len()]];
        for (column, row) in [(0, 0), (17, 3), (300, 301), (301, 302), (599, 599), (5, 598)] {
            let left = (0..zigzag.len()).map(ends).filter(|[a, b]| {
                let y = row as f64;
                (a[1] < y) != (b[1] < y) && a[0] + (y - a[1]) / (b[1] - a[1]) * (b[0] - a[0]) <= column as f64
            });
            let is_water = left.count() % 2 == 1;
            assert_eq!(level.cells[row * side as usize + column] == 255, is_water, "{column} {row}");
        }
        // Planted: less work than it takes is refused, for crossings and for cells.
        let (mut level, _) = empty_level([[0, 0], [side - 1, side - 1]]);
        assert!(!fill_rings(&mut level, &[zigzag], 1.0, &mut Work { left: 600 * (edges - 10) }));
        let square = vec![[0.0, 0.0], [599.0, 0.0], [599.0, 599.0], [0.0, 599.0]];
        let cells = 600 * 600 / CELLS_AT_ONCE;
        assert!(fill_rings(&mut level, std::slice::from_ref(&square), 1.0, &mut Work { left: 2 * 600 + cells }));
        assert!(!fill_rings(&mut level, &[square], 1.0, &mut Work { left: 2 * 600 + cells / 2 }));
    }
}
