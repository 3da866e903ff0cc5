//! Fills holes in heights while a reader is read: [`Filled`] wraps any reader and returns land where the file has small
//! no-data holes.
//!
//! A hole is a set of no-data samples that touch each other, also at their corners. It is filled if land surrounds it
//! on all sides, it fits in a square of [`MAX_EXTENT`] samples, and it contains no square of more than [`MAX_WIDTH`]
//! no-data samples. Larger holes stay holes, and so do those that touch the border of the grid: the land beyond a
//! country's border, a sea, the collar of a rotated raster. A filled hole gets the surface of `spline`. Spikes near
//! no-data (`spikes`) are treated as no-data and filled.
//!
//! Every hole is filled independently, from nothing but itself and the two samples around it, and the rule depends on
//! nothing farther away. So the result is a function of the position: windows of any size agree bit for bit. For a
//! window with no-data, about [`MAX_EXTENT`] more samples are read on each side; a window without is read with only
//! the few samples that decide about spikes.
//!
//! The reasons are in `docs/decisions/voids.md`.

mod holes;
mod spikes;
mod spline;

use rayon::prelude::*;
use serde::Deserialize;

use super::georeference::Georeference;
use super::reader::{HeightReader, Window};
use super::{Encoding, HeightGrid, SourceError, WorldMapping};

/// Largest extent of a hole that is filled: it must fit in a square of this many samples.
pub(crate) const MAX_EXTENT: u32 = 256;
/// Largest square of no-data in a hole that is filled, in samples.
pub(crate) const MAX_WIDTH: u32 = 64;
/// Distance in samples within which heights decide whether a sample is a spike.
const NEAR: u32 = spikes::REACH + 1;

/// The limits of the holes that are filled, in samples of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Limits {
    extent: u32,
    width: u32,
}

impl Limits {
    /// The limits for the file's own samples.
    pub(crate) const FINEST: Self = Self { extent: MAX_EXTENT, width: MAX_WIDTH };

    /// Returns the limits that select the same holes in an overview whose samples are 2^`level` as far apart; `None` if
    /// the widest of these holes is smaller than a sample.
    pub(crate) fn of_level(level: usize) -> Option<Self> {
        let level = u32::try_from(level).ok().filter(|level| MAX_WIDTH >> level.min(&31) > 0)?;
        Some(Self { extent: MAX_EXTENT >> level, width: MAX_WIDTH >> level })
    }

    /// Returns how far around a window holes must be searched: the extent of a hole that reaches into it, the samples
    /// around that, and those that decide about spikes.
    fn margin(self) -> u32 {
        self.extent + spline::RING + NEAR
    }

    /// Returns whether a hole that covers a whole window is too wide.
    fn is_wide(self, window: Window) -> bool {
        window.width > self.width && window.height > self.width
    }
}

/// The treatment of no-data samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum VoidMode {
    /// Fill small holes that are surrounded by land, and remove spikes near no-data.
    Fill,
    /// Leave no-data as holes, as in the file.
    #[default]
    Holes,
}

/// The number of samples of a window that were filled or replaced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FilledSamples {
    /// No-data samples that got a height.
    pub voids: u64,
    /// Spikes that got another height.
    pub spikes: u64,
}

impl FilledSamples {
    fn with(self, other: Self) -> Self {
        Self { voids: self.voids + other.voids, spikes: self.spikes + other.spikes }
    }
}

/// A reader whose small holes are filled.
pub struct Filled {
    inner: Box<dyn HeightReader>,
    spacing_m: f64,
}

/// Wraps a reader of any kind. Several files as one grid are filled after they have been combined, because no-data of
/// one may be land in another.
pub(crate) fn filled(inner: Box<dyn HeightReader>) -> Box<dyn HeightReader> {
    let spacing_m = spacing_m(inner.georeference(), inner.size());
    Box::new(Filled { inner, spacing_m })
}

/// Fills the small holes of a grid in memory, and removes its spikes, as [`VoidMode::Fill`] does for a file.
pub(crate) fn fill_grid(grid: &mut HeightGrid) -> FilledSamples {
    if grid.heights_m.iter().all(|height_m| height_m.is_finite()) {
        return FilledSamples::default();
    }
    let size = [grid.width, grid.height];
    let way = Way { size, spacing_m: spacing_m(&grid.georeference, size), limits: Limits::FINEST };
    let whole = Window::whole(size);
    fill(&mut grid.heights_m, whole, whole, &way)
}

/// Returns the sample spacing in metres in the middle of a grid, as the geometric mean of both directions; infinite for
/// a grid without a valid georeference, so that nothing is a spike.
pub(crate) fn spacing_m(georeference: &Georeference, [width, height]: [u32; 2]) -> f64 {
    let Ok(mapping) = WorldMapping::new(georeference, width, height) else { return f64::INFINITY };
    let [x, y] = [width, height].map(|count| f64::from(count / 2));
    let here = mapping.world_from_grid(x, y);
    let across = mapping.world_from_grid(x - 1.0, y).distance(here);
    let spacing_m = (across * mapping.world_from_grid(x, y - 1.0).distance(here)).sqrt();
    if spacing_m > 0.0 { spacing_m } else { f64::INFINITY }
}

impl Filled {
    /// Returns the reader without filling.
    pub fn bare(&self) -> &dyn HeightReader {
        &*self.inner
    }

    /// Fills the holes of a whole grid in memory.
    pub fn fill_whole(&self, heights_m: &mut [f32]) -> FilledSamples {
        let [width, height] = self.size();
        let whole = Window::whole([width, height]);
        fill(heights_m, whole, whole, &self.way())
    }

    /// Does the same as [`HeightReader::read`], and returns how many of the samples were filled.
    ///
    /// # Errors
    /// The same as [`HeightReader::read`].
    pub fn read_counted(&self, window: Window) -> Result<(Vec<f32>, FilledSamples), SourceError> {
        read_filled(&|window| self.inner.read(window), window, &self.way())
    }

    fn way(&self) -> Way {
        Way { size: self.size(), spacing_m: self.spacing_m, limits: Limits::FINEST }
    }
}

/// The parameters of filling for a grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// Columns and rows of the whole grid.
    pub size: [u32; 2],
    /// Sample spacing in metres; infinite if no sample should be a spike.
    pub spacing_m: f64,
    /// Limits of the holes that are filled.
    pub limits: Limits,
}

/// Returns a window of `read` with its holes filled, and the number of filled samples.
pub(crate) fn read_filled<E>(
    read: &dyn Fn(Window) -> Result<Vec<f32>, E>,
    window: Window,
    way: &Way,
) -> Result<(Vec<f32>, FilledSamples), E> {
    let near = grown(window, NEAR, way.size);
    let heights_m = read(near)?;
    let land = heights_m.iter().all(|height_m| height_m.is_finite());
    let own_m = window.cut(near, &heights_m);
    if land || way.limits.is_wide(window) && own_m.iter().all(|height_m| !height_m.is_finite()) {
        return Ok((own_m, FilledSamples::default()));
    }
    let around = grown(window, way.limits.margin(), way.size);
    let mut heights_m = read(around)?;
    let counts = fill(&mut heights_m, around, window, way);
    Ok((window.cut(around, &heights_m), counts))
}

impl HeightReader for Filled {
    fn size(&self) -> [u32; 2] {
        self.inner.size()
    }

    fn georeference(&self) -> &Georeference {
        self.inner.georeference()
    }

    fn read(&self, window: Window) -> Result<Vec<f32>, SourceError> {
        self.read_counted(window).map(|(heights_m, _)| heights_m)
    }

    fn block(&self) -> [u32; 2] {
        self.inner.block()
    }

    /// Uniform heights contain no spike; no-data is known to stay no-data if the hole is too wide.
    fn known_m(&self, window: Window) -> Option<f32> {
        self.inner.known_m(window).filter(|height_m| height_m.is_finite() || Limits::FINEST.is_wide(window))
    }

    fn is_serial(&self) -> bool {
        self.inner.is_serial()
    }

    fn is_coarse(&self) -> bool {
        self.inner.is_coarse()
    }

    fn encoding(&self) -> Option<Encoding> {
        self.inner.encoding()
    }

    fn has_unmatched_no_data(&self) -> bool {
        self.inner.has_unmatched_no_data()
    }

    fn warnings(&self) -> Vec<String> {
        self.inner.warnings()
    }

    fn identity(&self) -> String {
        format!("{}\nvoids filled, 1", self.inner.identity())
    }

    fn filled(&self) -> Option<&Filled> {
        Some(self)
    }
}

fn grown(window: Window, by: u32, size: [u32; 2]) -> Window {
    let (x, y) = (window.x.saturating_sub(by), window.y.saturating_sub(by));
    let right = (window.x + window.width).saturating_add(by).min(size[0]);
    let bottom = (window.y + window.height).saturating_add(by).min(size[1]);
    Window { x, y, width: right - x, height: bottom - y }
}

/// Fills the holes that reach into `within`, in heights of the window `around`.
fn fill(heights_m: &mut [f32], around: Window, within: Window, way: &Way) -> FilledSamples {
    let spikes = spikes::find(heights_m, around, way.spacing_m);
    let is_spike = |index: usize| spikes.binary_search(&(index as u32)).is_ok();
    let holes = holes::find(heights_m, &spikes, around, within, way);
    let filled: Vec<Vec<(u32, f32)>> =
        holes.par_iter().map(|hole| spline::fill(heights_m, &spikes, around, hole)).collect();
    let mut counts = FilledSamples::default();
    for (index, height_m) in filled.into_iter().flatten() {
        let (x, y) = (around.x + index % around.width, around.y + index / around.width);
        if within.has(x, y) {
            let spike = is_spike(index as usize);
            counts = counts.with(FilledSamples { voids: u64::from(!spike), spikes: u64::from(spike) });
        }
        heights_m[index as usize] = height_m;
    }
    counts
}

/// Counts the filled samples of a grid, and returns the lowest and highest height of windows with filled samples, NaN
/// if there are none. `report` receives the finished share. Windows are squares; those without no-data cost little.
pub(super) fn count(filled: &Filled, report: &dyn Fn(f32)) -> Result<(FilledSamples, [f32; 2]), SourceError> {
    const SIDE: u32 = 1024;
    let [width, height] = filled.size();
    let mut counts = FilledSamples::default();
    let mut range_m = [f32::NAN; 2];
    for y in (0..height).step_by(SIDE as usize) {
        for x in (0..width).step_by(SIDE as usize) {
            let window = Window { x, y, width: SIDE.min(width - x), height: SIDE.min(height - y) };
            if filled.known_m(window).is_none() {
                let (heights_m, here) = filled.read_counted(window)?;
                if here != FilledSamples::default() {
                    // `min` and `max` ignore NaN.
                    let join = |[low, high]: [f32; 2], height_m: &f32| [low.min(*height_m), high.max(*height_m)];
                    range_m = heights_m.iter().fold(range_m, join);
                    counts = counts.with(here);
                }
            }
        }
        report(y as f32 / height as f32);
    }
    Ok((counts, range_m))
}
