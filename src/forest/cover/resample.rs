//! Resampling of a raster to the cells of a grid, block by block. The samples for a block are read as one window, and
//! the mapping to the raster is computed exactly at nodes and bilinearly between them.

use glam::DVec2;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::aligned::{AlignedRaster, Ground};
use super::{CoverError, MAX_CELLS};
use crate::source::Window;

/// Largest number of cells between two nodes.
const NODES_APART: u32 = 16;
/// A block has at most this many cells along each side…
const MAX_SIDE_CELLS: f64 = 256.0;
/// … and at most this many samples along each side of a tiled raster…
const MAX_SIDE_SAMPLES: f64 = 2048.0;
/// … or this many samples in all, for a raster that is read in whole rows.
const MAX_SAMPLES: f64 = (1 << 24) as f64;
/// Largest number of points along the side of a cell.
const MAX_POINTS: u32 = 32;
/// If a cell has few samples, each is read at two points per side, up to this many points.
const TWICE: u32 = 8;

/// A grid of cells over the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid {
    pub low_m: DVec2,
    pub cell_m: f64,
    pub size: [u32; 2],
}

/// The values of a raster for a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Answer {
    pub density: f32,
    pub class: u8,
    pub quarters_m: u8,
}

/// Observations made while resampling.
#[derive(Clone, Debug, Default)]
pub(super) struct Tally {
    /// Number of points inside of the raster.
    pub inside: u64,
    /// For each class that the scene does not list, the number of points.
    pub unlisted: FxHashMap<i32, u64>,
    /// Largest value of a mask.
    pub largest: f32,
    /// A value that is not a valid class, if one was found.
    pub odd: Option<f32>,
}

impl Tally {
    fn join(&mut self, other: Self) {
        self.inside += other.inside;
        self.largest = self.largest.max(other.largest);
        self.odd = self.odd.or(other.odd);
        other.unlisted.into_iter().for_each(|(class, count)| *self.unlisted.entry(class).or_default() += count);
    }
}

impl Grid {
    /// Returns the grid over the intersection of the world and all rasters, as fine as the finest of them.
    ///
    /// # Errors
    /// A raster does not overlap the others.
    pub(super) fn over<'a>(
        ground: &Ground<'_>,
        rasters: impl Iterator<Item = &'a AlignedRaster<'a>> + Clone,
    ) -> Result<Self, CoverError> {
        let (mut low_m, mut high_m) = (ground.low_m, ground.high_m);
        for raster in rasters.clone() {
            (low_m, high_m) = (low_m.max(raster.low_m), high_m.min(raster.high_m));
            if !low_m.cmplt(high_m).all() {
                return Err(CoverError::OutsideWorld { path: raster.path.to_owned() });
            }
        }
        let mut cell_m = f64::INFINITY;
        if let Some(finest) = rasters.min_by(|a, b| a.spacing_m().total_cmp(&b.spacing_m())) {
            low_m = finest.corner_at(low_m);
            cell_m = finest.spacing_m();
        }
        let extent_m = high_m - low_m;
        let cell_m = cell_m.max(extent_m.max_element() / f64::from(MAX_CELLS)).min(extent_m.max_element());
        let cells = |extent_m: f64| ((extent_m / cell_m - 1e-6).ceil() as u32).clamp(1, MAX_CELLS);
        Ok(Self { low_m, cell_m, size: extent_m.to_array().map(cells) })
    }

    pub(super) fn cells(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    pub(super) fn high_m(&self) -> DVec2 {
        self.low_m + self.cell_m * DVec2::from_array(self.size.map(f64::from))
    }

    /// Returns the number of points along each side of a cell at which a raster is read.
    pub(super) fn points_along(&self, raster: &AlignedRaster<'_>) -> u32 {
        let samples = self.cell_m / raster.spacing_m();
        if samples < 1.01 {
            return 1;
        }
        let samples = samples.ceil().min(f64::from(MAX_POINTS)) as u32;
        samples.max((2 * samples).min(TWICE))
    }

    /// Returns columns and rows of a block, in cells.
    fn block(&self, raster: &AlignedRaster<'_>) -> [u32; 2] {
        let samples = (self.cell_m / raster.spacing_m()).max(1e-3);
        let even = |cells: f64| {
            let cells = cells.clamp(1.0, MAX_SIDE_CELLS) as u32;
            if cells > NODES_APART { cells / NODES_APART * NODES_APART } else { cells }
        };
        if raster.reader.block()[0] < raster.reader.size()[0] {
            return [even(MAX_SIDE_SAMPLES / samples); 2];
        }
        [self.size[0], even(MAX_SAMPLES / (f64::from(self.size[0]) * samples * samples))]
    }
}

/// Resamples a raster for all cells, those in the north first; `put` receives the index of each cell and its answer.
///
/// # Errors
/// The raster cannot be read.
pub(super) fn resample(
    raster: &AlignedRaster<'_>,
    grid: &Grid,
    answer: impl Fn(&[f32], &mut Tally) -> Answer + Sync,
    mut put: impl FnMut(usize, Answer),
) -> Result<Tally, CoverError> {
    let [wide, high] = grid.block(raster);
    let mut all = Tally::default();
    for row in (0..grid.size[1].div_ceil(high)).rev().map(|band| band * high) {
        let firsts: Vec<u32> = (0..grid.size[0]).step_by(wide as usize).collect();
        let block = |first: &u32| {
            let count = [wide.min(grid.size[0] - first), high.min(grid.size[1] - row)];
            read_cells(
                raster,
                grid,
                Window { x: *first, y: row, width: count[0], height: count[1] },
                wide.min(high),
                &answer,
            )
        };
        let blocks: Vec<_> = match raster.reader.is_serial() {
            true => firsts.iter().map(block).collect::<Result<_, _>>()?,
            false => firsts.par_iter().map(block).collect::<Result<_, _>>()?,
        };
        for (first, rows) in firsts.into_iter().zip(blocks) {
            for ((answers, tally), y) in rows.into_iter().zip(row as usize..) {
                all.join(tally);
                let start = y * grid.size[0] as usize + first as usize;
                answers.into_iter().zip(start..).for_each(|(answer, cell)| put(cell, answer));
            }
        }
    }
    Ok(all)
}

/// Resamples one block; returns its rows.
fn read_cells(
    raster: &AlignedRaster<'_>,
    grid: &Grid,
    block: Window,
    side: u32,
    answer: &(impl Fn(&[f32], &mut Tally) -> Answer + Sync),
) -> Result<Vec<(Vec<Answer>, Tally)>, CoverError> {
    let apart = side.clamp(1, NODES_APART);
    let [columns, rows] = [block.width, block.height].map(|cells| cells.div_ceil(apart) + 1);
    let nodes: Vec<DVec2> = (0..columns * rows)
        .map(|node| {
            let cell =
                DVec2::new(f64::from(block.x + node % columns * apart), f64::from(block.y + node / columns * apart));
            raster.sample_at(grid.low_m + grid.cell_m * cell)
        })
        .collect();
    let window = window(&nodes, raster.reader.size());
    let values = raster.reader.read(window)?;
    let value = |at: DVec2, tally: &mut Tally| {
        let at = at + 0.5;
        let is_inside = |at: f64, first: u32, count: u32| at >= f64::from(first) && at < f64::from(first + count);
        if !(is_inside(at.x, window.x, window.width) && is_inside(at.y, window.y, window.height)) {
            return f32::NAN;
        }
        tally.inside += 1;
        let (column, row) = (at.x as usize - window.x as usize, at.y as usize - window.y as usize);
        values[row * window.width as usize + column]
    };

    let points = grid.points_along(raster);
    // The position of a point between nodes: the index of the node before it, and the fraction of the way to the next.
    let between = |cell: u32, point: u32| {
        let inside = (f64::from(point) + 0.5) / f64::from(points);
        (cell / apart, (f64::from(cell % apart) + inside) / f64::from(apart))
    };
    let of_row = |row: u32| {
        let mut tally = Tally::default();
        let mut here = Vec::with_capacity((points * points) as usize);
        let mut answers = Vec::with_capacity(block.width as usize);
        for column in 0..block.width {
            here.clear();
            for (y, v) in (0..points).map(|point| between(row, point)) {
                for (x, u) in (0..points).map(|point| between(column, point)) {
                    let node = |x: u32, y: u32| nodes[(y * columns + x) as usize];
                    let south = node(x, y).lerp(node(x + 1, y), u);
                    let north = node(x, y + 1).lerp(node(x + 1, y + 1), u);
                    here.push(value(south.lerp(north, v), &mut tally));
                }
            }
            answers.push(answer(&here, &mut tally));
        }
        (answers, tally)
    };
    Ok((0..block.height).into_par_iter().map(of_row).collect())
}

/// Returns the window of samples that contains the positions; empty if all are outside.
fn window(places: &[DVec2], size: [u32; 2]) -> Window {
    let finite = || places.iter().filter(|at| at.is_finite());
    let low = finite().fold(DVec2::INFINITY, |low, at| low.min(*at));
    let high = finite().fold(DVec2::NEG_INFINITY, |high, at| high.max(*at));
    // One more sample on each side allows for the interpolation between nodes.
    let first = [low.x, low.y].map(|at| (at - 1.0).floor().max(0.0));
    let end = [0, 1].map(|axis| ([high.x, high.y][axis] + 3.0).floor().min(f64::from(size[axis])));
    if !(first[0] < end[0] && first[1] < end[1]) {
        return Window { x: 0, y: 0, width: 0, height: 0 };
    }
    let [x, y] = first.map(|at| at as u32);
    Window { x, y, width: end[0] as u32 - x, height: end[1] as u32 - y }
}
