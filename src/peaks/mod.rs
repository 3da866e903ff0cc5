//! The summits of a DEM of any size: topographic prominence and isolation, exact for its samples.
//!
//! ```text
//! heights ─▶ tile: summits and saddles ─▶ forest: what may still matter ─▶ sweep: row of tiles after row of tiles
//!                                                                              │
//!    peaks ◀─ isolation: nearest higher sample ◀─ blocks: maxima ◀─────────────┴─▶ ranking: most prominent summits
//! ```
//!
//! # Definitions
//! *Neighbours* are the eight samples around a sample. Samples without data are a barrier. A *summit* is
//! a plateau of samples of equal height without higher neighbours; its place is its first sample in row order. Of two
//! summits of equal height, the one that comes first in row order counts as the higher one.
//!
//! The *prominence* of a summit is its height above its key saddle: the lowest sample on the way to something higher,
//! on the way that is best in this respect. The highest summit of a connected region has no key saddle. If the region
//! is an island (nothing of it is at the border of the DEM or at a gap in which land may continue), its prominence is
//! its height above the sea level, as is usual; if the summit is below the sea level or there is none, its height above
//! the lowest sample of the island. If the region may continue, the prominence is unknown, and the height above the
//! lowest sample of the region takes its place: with it, neither the summit of a clipped DEM nor a rock in a hole of
//! the data counts for more than is known. A DEM with the sea floor needs its heights below sea level raised to it
//! first, or islands have key saddles on the sea floor.
//!
//! The *isolation* of a summit is its distance from the nearest sample that is higher. Samples of equal height don't
//! count.
//!
//! What is outside of the DEM can make key saddles higher, and higher land nearer. So [`Peak`] also has the least
//! prominence and [`Isolation`] the least distance for which this is possible.
//!
//! # Method, memory and time
//! Kirmse and de Ferranti 2017, "Calculating the prominence and isolation of every mountain
//! in the world", Progress in Physical Geography 41 (6), compute a divide tree for each tile, prune the trees and merge
//! them. Here the trees need no positions, so they are the trees of the highest passes between summits (`forest`), and
//! tiles are merged in rows, so that only the border between what has been read and what has not been read keeps
//! anything from being pruned.
//!
//! In memory are, whatever the number of rows:
//! - one tile (16 bytes a sample: 4 MB for 512 × 512) with its summits and saddles;
//! - 8 bytes for each column of the DEM, for the border of what has been read;
//! - the forest of a row of tiles: about one node (64 bytes) and one edge (32 bytes) for each local maximum along the
//!   borders of its tiles, and one more for each summit that is prominent enough but not decided yet, because what has
//!   not been read may still connect it with something higher;
//! - the maxima of at most 2²² blocks (22 MB), and 64 pages of heights (16 MB for DEMs of up to 10¹⁰ samples);
//! - the result.
//!
//! Each sample is read once, and the surroundings of each summit in the result once more. On one core, 10 000 × 10 000
//! samples of fractal land take 6 to 7 s (16 million samples a second; 6 million of white noise), and 19 MB in addition
//! to the heights. The isolation of a summit takes some 15 µs. A DEM of 100 000 × 5000 samples with 979 summits of at
//! least 100 m takes 36 s and 20 MB.

mod blocks;
mod forest;
mod isolation;
mod land;
mod ranking;
mod sample;
mod spacing;
mod sweep;
mod tile;
#[cfg(test)]
mod reference;
#[cfg(test)]
mod tests;

use self::blocks::Blocks;
use self::isolation::IsolationSearch;
pub(crate) use self::land::{Summit, SummitsError, Wanted, summits_of_reader, summits_of_store};
use self::ranking::{Ranked, Ranking};
use self::sample::Sample;
use self::spacing::Metric;
pub(crate) use self::spacing::Spacing;

/// The part of the progress at which prominences are known.
const PROGRESS_OF_SWEEP: f64 = 0.95;

/// A DEM that is read in pieces.
pub(crate) trait Heights {
    type Error;

    /// Returns the number of columns and rows.
    fn size(&self) -> [usize; 2];

    /// Replaces the contents of `into` with `size[1]` rows of `size[0]` heights in metres, from the column and the row
    /// `first` on. NaN and infinities are no data.
    ///
    /// # Errors
    /// The heights cannot be read.
    fn read(&mut self, first: [usize; 2], size: [usize; 2], into: &mut Vec<f32>) -> Result<(), Self::Error>;
}

/// Which summits to find, and where they are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rules {
    /// Least prominence in metres. Every summit in the result has a prominence of more than zero.
    pub least_prominence_m: f64,
    /// Largest number of summits. The most prominent ones are returned; of equally prominent ones, the highest.
    pub most: usize,
    /// Whether the last column and the first one are neighbours, as on a DEM of the whole Earth.
    pub wraps: bool,
    /// Whether land may continue in samples without data, as it does beyond the borders of the DEM. Otherwise they are
    /// water.
    pub has_open_gaps: bool,
    /// The level from which the highest summit of an island is measured; without one, that is its lowest sample.
    pub sea_level_m: Option<f32>,
    pub spacing: Spacing,
    /// Whether isolations are found; without them, each summit has an [`Isolation::default`].
    pub has_isolation: bool,
    /// Samples along the side of a tile. Affects memory and time, never the result.
    pub tile: usize,
    /// Samples along the side of the blocks of which the maxima are in memory. Affects memory and time, never the
    /// result.
    pub block: usize,
}

impl Rules {
    /// Returns rules for all summits of land that ends at water where it has no data.
    pub(crate) fn new(spacing: Spacing) -> Self {
        Self {
            least_prominence_m: 0.0,
            most: usize::MAX,
            wraps: false,
            has_open_gaps: false,
            sea_level_m: Some(0.0),
            spacing,
            has_isolation: true,
            tile: 512,
            block: 64,
        }
    }
}

/// A sample and its height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Saddle {
    pub column: usize,
    pub row: usize,
    pub height_m: f32,
}

/// A summit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Peak {
    pub column: usize,
    pub row: usize,
    pub height_m: f32,
    /// The prominence, if there is nothing outside of the DEM.
    pub prominence_m: f32,
    /// The lowest prominence that the summit can have, whatever is outside of the DEM: `prominence_m`, or its height
    /// above the highest saddle on the way out if that is less.
    pub certain_prominence_m: f32,
    /// Where the way to something higher is lowest. `None` for the highest summit of a connected region.
    pub key_saddle: Option<Saddle>,
    pub isolation: Isolation,
}

/// How far away the nearest higher sample is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Isolation {
    /// The nearest higher sample. `None` if nothing on the DEM is higher.
    pub higher: Option<Higher>,
    /// The distance of the nearest place outside of the DEM, in metres, if that is nearer than `higher`: the isolation
    /// is at least this much. The grid is continued by one sample beyond its borders.
    pub outside_m: Option<f64>,
}

/// A higher sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Higher {
    pub column: usize,
    pub row: usize,
    pub height_m: f32,
    pub distance_m: f64,
}

/// Finds the most prominent summits of a DEM, most prominent first. Calls `progress` with the part of the work that is
/// done, from 0 to 1; returns `None` as soon as that returns `false`.
///
/// # Errors
/// The first heights that cannot be read.
pub(crate) fn peaks<H: Heights>(
    heights: &mut H,
    rules: &Rules,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Option<Vec<Peak>>, H::Error> {
    let size = heights.size();
    if size.contains(&0) || rules.most == 0 {
        return Ok(Some(Vec::new()));
    }
    // With two columns, both are neighbours already.
    let wraps = rules.wraps && size[0] > 2;
    let mut ranking = Ranking::new(rules.most, rules.least_prominence_m, rules.sea_level_m);
    let mut blocks = Blocks::new(size, rules.block);
    let mut swept = |part: f64| progress(PROGRESS_OF_SWEEP * part);
    if !sweep::sweep(heights, rules, wraps, &mut ranking, &mut blocks, &mut swept)? {
        return Ok(None);
    }
    blocks.finish();
    let metric = Metric::new(rules.spacing, size[0], wraps);
    let mut search = IsolationSearch::new(heights, &blocks, metric, wraps);
    let mut ranked: Vec<(usize, Ranked)> = ranking.finish().into_iter().enumerate().collect();
    ranked.sort_unstable_by_key(|(_, ranked)| search.turn(ranked.found.peak.place(size[0])));
    let mut found = Vec::with_capacity(ranked.len());
    for (done, (rank, summit)) in ranked.iter().enumerate() {
        if !progress(PROGRESS_OF_SWEEP + (1.0 - PROGRESS_OF_SWEEP) * done as f64 / ranked.len() as f64) {
            return Ok(None);
        }
        let isolation = match rules.has_isolation {
            true => search.find(summit.found.peak.place(size[0]), summit.found.peak.height_m())?,
            false => Isolation::default(),
        };
        found.push((*rank, peak(summit, size[0], isolation)));
    }
    found.sort_unstable_by_key(|(rank, _)| *rank);
    progress(1.0);
    Ok(Some(found.into_iter().map(|(_, peak)| peak).collect()))
}

fn peak(summit: &Ranked, columns: usize, isolation: Isolation) -> Peak {
    let Ranked { prominence_m, found } = summit;
    let [column, row] = found.peak.place(columns);
    let key_saddle = (found.saddle != Sample::NONE).then(|| {
        let [column, row] = found.saddle.place(columns);
        Saddle { column, row, height_m: found.saddle.height_m() }
    });
    Peak {
        column,
        row,
        height_m: found.peak.height_m(),
        prominence_m: *prominence_m,
        certain_prominence_m: summit.certain_m(),
        key_saddle,
        isolation,
    }
}

/// Reads heights, with NaN for every sample without data.
fn read_land<H: Heights>(
    heights: &mut H,
    first: [usize; 2],
    size: [usize; 2],
    into: &mut Vec<f32>,
) -> Result<(), H::Error> {
    into.clear();
    heights.read(first, size, into)?;
    into.resize(size[0] * size[1], f32::NAN);
    for height_m in into.iter_mut().filter(|height_m| !height_m.is_finite()) {
        *height_m = f32::NAN;
    }
    Ok(())
}
