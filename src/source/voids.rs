//! Holes in heights, filled as a reader is read: [`Filled`] stands over any reader, and whoever reads it gets land where
//! the file has small voids.
//!
//! A hole is a set of voids that touch each other, also at their corners. It is filled if land closes it on all sides,
//! it lies in a square of [`MOST_EXTENT`] samples, and no square of more than [`MOST_WIDTH`] samples is void in it. What
//! is larger stays a hole, as does what touches the border of the grid: the land beyond a country's border, a sea, the
//! collar of a rotated raster. Voids get the surface of `spline`; spikes beside voids (`spikes`) are voids that are filled.
//!
//! Every hole is filled for itself, from nothing but itself and the two samples around it, and the rule looks no
//! farther. So the result is a function of the place: windows of any size agree on every bit. A window with voids is
//! read with about [`MOST_EXTENT`] samples more on each side; one without is read as it is, with the few that may tell of a spike.
//!
//! Why: `docs/decisions/voids.md`.

mod holes;
mod spikes;
mod spline;

use rayon::prelude::*;
use serde::Deserialize;

use super::georeference::Georeference;
use super::reader::{HeightReader, Window};
use super::{SourceError, WorldMapping};

/// A hole lies in a square of so many samples, or it is not filled.
pub const MOST_EXTENT: u32 = 256;
/// The widest square of voids in a hole that is filled, in samples.
pub const MOST_WIDTH: u32 = 64;
/// What says whether a sample is a spike lies so near.
const NEAR: u32 = spikes::BESIDE + 1;

/// Which holes are filled, in samples of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Limits {
    extent: u32,
    width: u32,
}

impl Limits {
    /// Of the file's own samples.
    pub const FINEST: Self = Self { extent: MOST_EXTENT, width: MOST_WIDTH };

    /// Of an overview whose samples are 2^`level` as far apart: the same holes, where none is smaller than a sample.
    pub fn of_level(level: usize) -> Option<Self> {
        let level = u32::try_from(level).ok().filter(|level| MOST_WIDTH >> level.min(&31) > 0)?;
        Some(Self { extent: MOST_EXTENT >> level, width: MOST_WIDTH >> level })
    }

    /// How far from a window its holes are looked for: a hole that reaches into it, the samples around that, and what
    /// may make spikes of those.
    fn margin(self) -> u32 {
        self.extent + spline::RING + NEAR
    }

    /// Whether a hole that holds all of a window is too wide.
    fn is_wide(self, window: Window) -> bool {
        window.width > self.width && window.height > self.width
    }
}

/// What is done with voids.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum VoidMode {
    /// Small holes that land closes are filled smoothly, and spikes beside voids are removed.
    Fill,
    /// Voids are holes, as the file has them.
    #[default]
    Holes,
}

/// Samples of a window that a file does not have, or that were not believed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FilledSamples {
    /// Voids that got a height.
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

/// Stands over a reader of whatever kind; several files as one grid are filled after they were put together, as a void
/// of one may be land in another.
pub fn filled(inner: Box<dyn HeightReader>) -> Box<dyn HeightReader> {
    let spacing_m = spacing_m(inner.georeference(), inner.size());
    Box::new(Filled { inner, spacing_m })
}

/// Metres between samples in the middle of a grid, the geometric mean of both ways; infinite where nothing says where
/// the grid lies, so that nothing is a spike.
pub(crate) fn spacing_m(georeference: &Georeference, [width, height]: [u32; 2]) -> f64 {
    let Ok(mapping) = WorldMapping::new(georeference, width, height) else { return f64::INFINITY };
    let [x, y] = [width, height].map(|count| f64::from(count / 2));
    let here = mapping.world_from_grid(x, y);
    let across = mapping.world_from_grid(x - 1.0, y).distance(here);
    let spacing_m = (across * mapping.world_from_grid(x, y - 1.0).distance(here)).sqrt();
    if spacing_m > 0.0 { spacing_m } else { f64::INFINITY }
}

impl Filled {
    /// The reader as the file is, with its holes.
    pub fn bare(&self) -> &dyn HeightReader {
        &*self.inner
    }

    /// Fills the holes of a whole grid in memory.
    pub fn fill_whole(&self, heights_m: &mut [f32]) -> FilledSamples {
        let [width, height] = self.size();
        let whole = Window { x: 0, y: 0, width, height };
        fill(heights_m, whole, whole, &self.way())
    }

    /// As [`HeightReader::read`], and how many of the samples were filled.
    ///
    /// # Errors
    /// As [`HeightReader::read`].
    pub fn read_counted(&self, window: Window) -> Result<(Vec<f32>, FilledSamples), SourceError> {
        read_filled(&|window| self.inner.read(window), window, &self.way())
    }

    fn way(&self) -> Way {
        Way { size: self.size(), spacing_m: self.spacing_m, limits: Limits::FINEST }
    }
}

/// What filling has to know of a grid.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// Columns and rows of all of it.
    pub size: [u32; 2],
    /// Metres between samples; infinite where no sample is to be a spike.
    pub spacing_m: f64,
    /// Which holes are filled.
    pub limits: Limits,
}

/// A window of what `read` gives, with its holes filled, and how many samples were.
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

    /// One height everywhere is no spike; voids are known to stay such if they are too wide.
    fn known_m(&self, window: Window) -> Option<f32> {
        self.inner.known_m(window).filter(|height_m| height_m.is_finite() || Limits::FINEST.is_wide(window))
    }

    fn is_serial(&self) -> bool {
        self.inner.is_serial()
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

/// How many samples of a grid are filled; `report` hears the share that was looked at. Windows are squares, of which
/// those without voids cost little.
pub(super) fn count(filled: &Filled, report: &dyn Fn(f32)) -> Result<FilledSamples, SourceError> {
    const SIDE: u32 = 1024;
    let [width, height] = filled.size();
    let mut counts = FilledSamples::default();
    for y in (0..height).step_by(SIDE as usize) {
        for x in (0..width).step_by(SIDE as usize) {
            let window = Window { x, y, width: SIDE.min(width - x), height: SIDE.min(height - y) };
            if filled.known_m(window).is_none() {
                counts = counts.with(filled.read_counted(window)?.1);
            }
        }
        report(y as f32 / height as f32);
    }
    Ok(counts)
}
