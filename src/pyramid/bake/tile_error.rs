//! The measured error of every tile: how far its level's surface is from the full-resolution heights in its area.
//!
//! The first round has these heights and measures against them. A later one has the level that it reads, as tiles serve
//! it, and the error of each of that level's tiles, which bounds the distance of its surface from the data at each
//! full-resolution sample. The distance between the two surfaces, measured at the same samples, plus that error bounds
//! the error of the coarser tile. (Between the samples of the base the surfaces bend, so comparing them at those
//! samples alone would not suffice.)
//!
//! A chunk knows the original heights around its own, but not the decoded ones: these are within the codec's bound.
//! Where the surface depends on such a height, or on the filling of no-data, which depends on such heights, the error
//! is raised by their largest influence. In lossless pyramids, and where one chunk covers the grid, nothing is added.
//!
//! Where the surface depends on a filling that only coarser levels know, the sample is deferred until they exist
//! (`deferred`).
//!
//! Why: `docs/decisions/measured-errors.md`.

use rayon::prelude::*;

use super::deferred::Deferred;
use super::surface_rows::{AxisSample, Surface, area};
use crate::pyramid::surface::field::Field;
use crate::pyramid::surface::levels::{LevelSize, Region};
use crate::pyramid::surface::statistics::{Range, TileStatistics, rounded_up};
use crate::pyramid::tile::{TILE_SAMPLES, is_void};

/// The largest sum of the absolute weights of the sixteen samples of a cell.
pub(super) const LARGEST_WEIGHTS: f64 = 1.5625;

/// A level over a chunk.
pub(super) struct LevelView<'a> {
    /// Number of the level; 0 is the finest.
    pub level: u32,
    /// Size of the whole level.
    pub size: LevelSize,
    /// The samples of the chunk's own tiles.
    pub own: Region,
    /// The level as tiles serve it; NaN where a filling is not known yet.
    pub served: &'a Field,
    /// Largest difference, in metres, between heights outside `own` and their stored values.
    pub doubt_m: f64,
}

impl LevelView<'_> {
    /// Returns the full-resolution samples in the area of its own tiles.
    pub(super) fn area(&self, finest: LevelSize) -> Region {
        let (x, right) = area(self.own.x, self.own.width, finest.width, self.size.width);
        let (y, bottom) = area(self.own.y, self.own.height, finest.height, self.size.height);
        Region { x, y, width: right - x, height: bottom - y }
    }

    /// Returns the chunk's own tiles, in tiles, not samples.
    pub(super) fn tiles(&self) -> Region {
        let Region { x, y, width, height } = self.own;
        let tile = TILE_SAMPLES;
        Region { x: x / tile, y: y / tile, width: width.div_ceil(tile), height: height.div_ceil(tile) }
    }

    /// Returns what is added to every error at full-resolution samples because of fillings, in metres.
    fn doubt_of_voids_m(&self) -> f64 {
        // At a valid sample of level 0 the surface passes through that sample.
        let fillings =
            self.level > 0 && self.doubt_m > 0.0 && self.served.heights_m.iter().any(|height| is_void(*height));
        if fillings { LARGEST_WEIGHTS * self.doubt_m } else { 0.0 }
    }
}

/// The largest errors of tiles, while they are accumulated.
pub(super) struct Errors {
    pub errors_m: Vec<f64>,
    pub deferred: Vec<Deferred>,
}

impl Errors {
    fn none(tiles: usize) -> Self {
        Self { errors_m: vec![0.0; tiles], deferred: Vec::new() }
    }

    fn or(mut self, other: Self) -> Self {
        for (mine, other) in self.errors_m.iter_mut().zip(other.errors_m) {
            *mine = mine.max(other);
        }
        self.deferred.extend(other.deferred);
        self
    }

    /// Rounds the errors up, and sorts the deferred samples into an order that does not depend on threads.
    fn finish(self) -> (Vec<f32>, Vec<Deferred>) {
        let mut deferred = self.deferred;
        deferred.sort_by_key(Deferred::key);
        deferred.dedup_by_key(|deferred| deferred.key());
        (self.errors_m.into_iter().map(rounded_up).collect(), deferred)
    }
}

/// Returns, for every own tile of the level, row-major, the largest |H(f) − h(f)| in metres over the valid samples f of
/// `heights` (full resolution, NaN for no-data) in its area. A sample f belongs to the tile of the level's sample whose
/// area covers the centre of f.
pub(super) fn against_heights(heights: &Field, finest: LevelSize, view: &LevelView<'_>) -> (Vec<f32>, Vec<Deferred>) {
    let over = view.area(finest);
    let surface = Surface::new(view.served, finest, view.size, over, view.own);
    let tiles = view.tiles();
    let doubt_of_voids_m = view.doubt_of_voids_m();
    let doubt_m = LARGEST_WEIGHTS * view.doubt_m;
    let work = |(mut errors, mut across): (Errors, Vec<f64>), i: usize| {
        let row = &surface.rows[i];
        surface.across(row, &mut across);
        let always_m = if row.inside { doubt_of_voids_m } else { doubt_m };
        let y = over.y + i as u32;
        let first = (row.sample / TILE_SAMPLES - tiles.y) as usize * tiles.width as usize;
        let here = &mut errors.errors_m[first..first + tiles.width as usize];
        for (f, (height, column)) in heights.span(over.x, y, over.width).iter().zip(&surface.columns).enumerate() {
            if height.is_nan() {
                continue;
            }
            let error = (surface.height_m(&across, column) - f64::from(*height)).abs();
            let error = error + if column.inside { always_m } else { doubt_m };
            let worst = &mut here[(column.sample / TILE_SAMPLES - tiles.x) as usize];
            if error > *worst {
                *worst = error;
            } else if error.is_nan() {
                let x = over.x + f as u32;
                errors.deferred.push(Deferred { level: view.level, x, y, height_m: *height });
            }
        }
        (errors, across)
    };
    let none = || (Errors::none(tiles.samples()), Vec::new());
    let all = (0..over.height as usize).into_par_iter().fold(none, work);
    all.map(|(errors, _)| errors).reduce(|| Errors::none(tiles.samples()), Errors::or).finish()
}

/// The base level of a later round, used in place of the full-resolution heights.
pub(super) struct Base<'a> {
    /// The level that the round reads.
    pub view: LevelView<'a>,
    /// The errors of its tiles in `error_tiles`, row-major, in metres.
    pub errors_m: Vec<f32>,
    /// The region of `errors_m`, in tiles, not samples.
    pub error_tiles: Region,
    /// Returns whether there may be data at a full-resolution sample.
    pub data: &'a (dyn Fn(u32, u32) -> bool + Sync),
    /// Side of the squares over which `data` is constant, in full-resolution samples.
    pub data_step: u32,
}

/// Returns, for each of several levels and every own tile, row-major, an upper bound in metres of |H(f) − h(f)| over
/// the valid full-resolution samples f in its area.
pub(super) fn against_base(
    base: &Base<'_>,
    finest: LevelSize,
    views: &[LevelView<'_>],
) -> Vec<(Vec<f32>, Vec<Deferred>)> {
    let over = views.iter().map(|view| view.area(finest)).reduce(|a, b| {
        let (x, y) = (a.x.min(b.x), a.y.min(b.y));
        let (right, bottom) = ((a.x + a.width).max(b.x + b.width), (a.y + a.height).max(b.y + b.height));
        Region { x, y, width: right - x, height: bottom - y }
    });
    let Some(over) = over else { return Vec::new() };
    let view = &base.view;
    let under = Surface::new(view.served, finest, view.size, over, view.size.region());
    let areas: Vec<Region> = views.iter().map(|view| view.area(finest)).collect();
    let surfaces: Vec<Surface<'_>> = views
        .iter()
        .zip(&areas)
        .map(|(view, area)| Surface::new(view.served, finest, view.size, *area, view.own))
        .collect();
    let doubts: Vec<f64> = views.iter().map(|level| level.doubt_of_voids_m() + view.doubt_of_voids_m()).collect();
    let tile_of = |place: &AxisSample, first: u32| (place.sample / TILE_SAMPLES - first) as usize;
    let none = || views.iter().map(|view| Errors::none(view.tiles().samples())).collect::<Vec<_>>();
    let work = |(mut all, mut across, mut line): (Vec<Errors>, Vec<f64>, Vec<(f64, f64)>), i: usize| {
        let y = over.y + i as u32;
        let row = &under.rows[i];
        under.across(row, &mut across);
        let errors_m = &base.errors_m[tile_of(row, base.error_tiles.y) * base.error_tiles.width as usize..];
        // The base's surface and its error bound; both NaN where there is no data.
        line.clear();
        let mut has_data = (u32::MAX, false);
        for (x, column) in (over.x..).zip(&under.columns) {
            if has_data.0 != x / base.data_step {
                has_data = (x / base.data_step, (base.data)(x, y));
            }
            line.push(match has_data.1 {
                true => (under.height_m(&across, column), errors_m[tile_of(column, base.error_tiles.x)].into()),
                false => (f64::NAN, f64::NAN),
            });
        }
        for (number, (view, area)) in views.iter().zip(&areas).enumerate() {
            if !(area.y..area.y + area.height).contains(&y) {
                continue;
            }
            let (surface, errors, tiles) = (&surfaces[number], &mut all[number], view.tiles());
            let row = &surface.rows[(y - area.y) as usize];
            surface.across(row, &mut across);
            let doubt_m = LARGEST_WEIGHTS * view.doubt_m;
            let always_m = doubts[number] + if row.inside { 0.0 } else { doubt_m };
            let first = tile_of(row, tiles.y) * tiles.width as usize;
            let line = &line[(area.x - over.x) as usize..];
            for (f, (column, &(under_m, under_error_m))) in surface.columns.iter().zip(line).enumerate() {
                if under_error_m.is_nan() {
                    continue;
                }
                let error = (surface.height_m(&across, column) - under_m).abs() + under_error_m + always_m;
                let error = if column.inside { error } else { error + doubt_m };
                let worst = &mut errors.errors_m[first + tile_of(column, tiles.x)];
                if error > *worst {
                    *worst = error;
                } else if error.is_nan() {
                    let (x, y) = ((area.x + f as u32) / base.data_step, y / base.data_step);
                    let put_off = Deferred { level: view.level, x, y, height_m: f32::NAN };
                    if errors.deferred.last() != Some(&put_off) {
                        errors.deferred.push(put_off);
                    }
                }
            }
        }
        (all, across, line)
    };
    let start = || (none(), Vec::new(), Vec::new());
    let all = (0..over.height as usize).into_par_iter().fold(start, work).map(|(all, ..)| all);
    let or = |a: Vec<Errors>, b: Vec<Errors>| a.into_iter().zip(b).map(|(a, b)| a.or(b)).collect();
    all.reduce(none, or).into_iter().map(Errors::finish).collect()
}

/// Computes the statistics of every own tile of a level, row-major; ranges and errors are not yet raised to those of
/// the children.
pub(super) fn tile_statistics(view: &LevelView<'_>, errors_m: &[f32]) -> Vec<TileStatistics> {
    let tiles = view.tiles();
    errors_m
        .par_iter()
        .enumerate()
        .map(|(tile, &error_m)| {
            let (x, y) = (tiles.x + tile as u32 % tiles.width, tiles.y + tile as u32 / tiles.width);
            let region = view.size.tile_region(x, y, 1);
            let range = range_of(view, region);
            TileStatistics {
                min_m: range.min_m,
                max_m: range.max_m,
                error_m,
                corner_errors_m: [error_m; 4],
                voids: range.voids(),
            }
        })
        .collect()
}

/// Returns the height range of a region of a level; heights outside the chunk's own tiles are widened by their doubt.
pub(super) fn range_of(view: &LevelView<'_>, region: Region) -> Range {
    let mut range = Range::EMPTY;
    let mut around = Range::EMPTY;
    let own = view.own;
    let (left, right) = (own.x.max(region.x), (own.x + own.width).min(region.x + region.width));
    for y in region.y..region.y + region.height {
        let row = view.served.span(region.x, y, region.width);
        if view.doubt_m == 0.0 {
            range.add(row);
        } else if (own.y..own.y + own.height).contains(&y) {
            let (before, rest) = row.split_at((left - region.x) as usize);
            let (inside, after) = rest.split_at((right - left) as usize);
            range.add(inside);
            around.add(before);
            around.add(after);
        } else {
            around.add(row);
        }
    }
    if view.doubt_m > 0.0 {
        range.join(around, view.doubt_m);
    }
    range
}
