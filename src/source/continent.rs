//! A procedural continent of a seed: 327,680 × 327,680 samples, 10 m apart, of which any window of any level is
//! evaluated on its own. The 10¹¹ heights are never stored; a base of 1280 × 1280 and an exemplar of 2048 × 2048
//! samples suffice.
//!
//! 1. `base`: ranges, plains and great valleys, 2.56 km apart and 3,277 km wide, grown as the built-in world is: by
//!    uplift and river incision (Cordonnier et al., "Large scale terrain generation from tectonic uplift and fluvial
//!    erosion", 2016). Between its samples the surface is bicubic; its averages are the levels above.
//! 2. `exemplar`: the built-in world itself, without features wider than 5 km: 20 km of eroded land with ridges,
//!    gullies and gravel floors, and its averages at every level.
//! 3. `tiling`: pieces of the exemplar are laid over the base on a lattice of triangles and blended so that their
//!    variance is preserved (Heitz and Neyret, "High-performance by-example noise using a histogram-preserving blending
//!    operator", HPG 2018). A piece is chosen at random among those with the roughness that the base requires there, as
//!    in example-based terrain synthesis (Zhou et al., "Terrain synthesis from digital elevation models", TVCG 2007),
//!    and rotated and mirrored at random.
//!
//! Pieces are moved by whole samples of the coarsest level in question, so each level of the land is read from the same
//! level of the exemplar, sample by sample: a level is the average of the finer one except for the slow change of the
//! weights, and nothing aliases. Positions are whole numbers of a level's lattice, so that land 10⁷ m away is as exact
//! as in the middle.
//!
//! The reasons are in `docs/decisions/procedural-worlds.md`.

mod base;
mod exemplar;
mod tiling;

pub(crate) use exemplar::Exemplar;

use super::georeference::{Crs, Georeference};
use super::{Progress, Window};

/// Samples along the side of the whole land at level 0.
pub(crate) const SIZE_SAMPLES: u32 = 1280 << BASE_LEVEL;

/// Distance between samples of level 0 in metres.
pub(crate) const SPACING_M: f64 = 10.0;

/// The level whose heights are stored.
pub(crate) const BASE_LEVEL: u32 = 8;

/// Samples along the side of the base.
pub(crate) const BASE_SAMPLES: u32 = SIZE_SAMPLES >> BASE_LEVEL;

/// The land of a seed. All methods may be called from several threads at once.
#[derive(Clone, Debug)]
pub(crate) struct Continent {
    seed: u32,
    /// [`BASE_SAMPLES`]² heights in metres.
    base_m: Vec<f32>,
    /// Strength of the pieces' relief at each sample of the base: its standard deviation in metres.
    relief_m: Vec<f32>,
    exemplar: Exemplar,
}

/// Grows the base of the land of `seed`: [`BASE_SAMPLES`]² heights in metres, row by row. Takes some seconds; the
/// result is bit-identical for the same seed, on any number of threads.
pub(crate) fn grow_base(seed: u32, progress: &dyn Progress) -> Vec<f32> {
    base::grow(seed, BASE_SAMPLES as usize, progress)
}

/// Returns the georeference of a local metric grid of `size` samples a side, `spacing_m` apart, centred on the origin.
pub(crate) fn georeference(size: u32, spacing_m: f64) -> Georeference {
    let half_m = (f64::from(size) - 1.0) * 0.5 * spacing_m;
    Georeference {
        crs_from_grid: [-half_m, spacing_m, 0.0, half_m, 0.0, -spacing_m],
        crs: Crs::Local,
        geokeys: Default::default(),
    }
}

impl Continent {
    /// Builds the land from a base of [`grow_base`] and the relief of `exemplar`.
    ///
    /// # Panics
    /// Panics if `base_m` has not [`BASE_SAMPLES`]² heights.
    pub(crate) fn new(seed: u32, base_m: Vec<f32>, exemplar: Exemplar) -> Self {
        assert_eq!(base_m.len(), (BASE_SAMPLES * BASE_SAMPLES) as usize);
        let base_m = deepened(&base_m, BASE_SAMPLES as usize);
        let relief_m = relief_m(&base_m, BASE_SAMPLES as usize);
        // The base is lifted, so that mountains are on top of the land and not half inside it.
        let base_m = base_m.iter().zip(&relief_m).map(|(base_m, relief_m)| base_m + LIFT * relief_m).collect();
        Self { seed, base_m, relief_m, exemplar }
    }

    /// Returns the heights of the base in metres.
    pub(crate) fn base_m(&self) -> &[f32] {
        &self.base_m
    }

    /// Returns how far pieces of relief probably reach above and below the base, in metres, over the `side` × `side`
    /// samples of the base that begin at (`x`, `y`). Samples beyond the base count as its border.
    pub(crate) fn max_relief_m(&self, x: u32, y: u32, side: u32) -> f32 {
        let width = BASE_SAMPLES as usize;
        let span = |first: u32| {
            let last = (first as usize + side as usize + 1).min(width - 1);
            (first as usize).saturating_sub(1).min(last)..=last
        };
        let rows = span(y).map(|row| &self.relief_m[row * width..(row + 1) * width]);
        MAX_RELIEF * rows.flat_map(|row| &row[span(x)]).copied().fold(0.0, f32::max)
    }

    /// Returns probable bounds of the heights in metres over `size` × `size` samples of level 0 that begin at
    /// (`offset`, `offset`).
    pub(crate) fn range_m(&self, offset: u32, size: u32) -> [f32; 2] {
        let (first, last) = ((offset >> BASE_LEVEL) as usize, ((offset + size - 1) >> BASE_LEVEL) as usize);
        let width = BASE_SAMPLES as usize;
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for row in first.saturating_sub(1)..=(last + 1).min(width - 1) {
            for at in row * width + first.saturating_sub(1)..=row * width + (last + 1).min(width - 1) {
                // Pieces of relief are asymmetric: summits rise farther above the base than valleys descend below it.
                low = low.min(self.base_m[at] - 2.5 * self.relief_m[at]);
                high = high.max(self.base_m[at] + MAX_RELIEF * self.relief_m[at]);
            }
        }
        [low, high]
    }

    /// Returns the heights in metres of a window of a level up to [`BASE_LEVEL`], row by row. The level's lattice has
    /// [`SIZE_SAMPLES`] / 2^level samples a side; beyond it the border samples are repeated.
    ///
    /// # Panics
    /// Panics if `level` is above [`BASE_LEVEL`].
    pub(crate) fn heights_m(&self, level: u32, window: Window) -> Vec<f32> {
        assert!(level <= BASE_LEVEL);
        let span = Span { x: window.x.into(), y: window.y.into(), width: window.width, height: window.height };
        if level == BASE_LEVEL - 1 {
            // Pieces move by half of this level's samples, so it is averaged from the finer level.
            let Window { x, y, width, height } = window;
            let finer = Window { x: 2 * x, y: 2 * y, width: 2 * width, height: 2 * height };
            return exemplar::halved(&self.heights_m(level - 1, finer), finer.width as usize);
        }
        let mut field = self.smooth(&self.base_m, level, span);
        if level < BASE_LEVEL {
            let relief = self.smooth(&self.relief_m, level, span);
            tiling::lay(self, level, &relief, &mut field);
        }
        field.heights_m
    }

    /// Evaluates the bicubic surface over the base's samples.
    fn smooth(&self, base: &[f32], level: u32, span: Span) -> Field {
        if level < BASE_LEVEL {
            return self.smooth(base, level + 1, span.coarse()).doubled(span);
        }
        let last = i64::from(BASE_SAMPLES) - 1;
        let mut heights_m = Vec::with_capacity(span.samples());
        for row in span.y..span.y + i64::from(span.height) {
            let start = row.clamp(0, last) * (last + 1);
            let columns = span.x..span.x + i64::from(span.width);
            heights_m.extend(columns.map(|column| base[(start + column.clamp(0, last)) as usize]));
        }
        Field { span, heights_m }
    }
}

/// Largest height of a summit above the base, as a multiple of the strength of the relief.
const MAX_RELIEF: f32 = 3.5;

/// Lift of the base, as a fraction of the strength of the relief.
const LIFT: f32 = 1.1;

/// Base samples to each side that determine the roughness of the land: 7.7 km.
const AROUND: usize = 3;

/// Exaggerates the valleys and ranges of the base: multiplies the difference from the mean of the 18 km around by
/// [`DEEPEN`].
fn deepened(base_m: &[f32], size: usize) -> Vec<f32> {
    let mean = |line: &dyn Fn(usize) -> f32, at: usize| {
        (at.saturating_sub(AROUND)..=(at + AROUND).min(size - 1)).map(line).sum::<f32>()
            / ((at + AROUND).min(size - 1) - at.saturating_sub(AROUND) + 1) as f32
    };
    let across: Vec<f32> = (0..size * size).map(|i| mean(&|x| base_m[i / size * size + x], i % size)).collect();
    let around = (0..size * size).map(|i| mean(&|y| across[y * size + i % size], i / size));
    base_m.iter().zip(around).map(|(base_m, mean_m)| base_m + (DEEPEN - 1.0) * (base_m - mean_m)).collect()
}

/// Factor by which valleys become deeper.
const DEEPEN: f32 = 2.3;

/// Returns the strength of the pieces' relief at every sample of the base: a fraction of the base's own relief around
/// it, and little in the valleys of the base, so that these are open and lead through the ranges.
fn relief_m(base_m: &[f32], size: usize) -> Vec<f32> {
    use rayon::prelude::*;
    let raw: Vec<f32> = (0..size * size)
        .into_par_iter()
        .map(|i| {
            let (x, y) = (i % size, i / size);
            let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
            for row in y.saturating_sub(AROUND)..=(y + AROUND).min(size - 1) {
                for &height in &base_m[row * size + x.saturating_sub(AROUND)..=row * size + (x + AROUND).min(size - 1)]
                {
                    (low, high) = (low.min(height), high.max(height));
                }
            }
            let above = ((base_m[i] - low) / (high - low).max(1.0) / 0.6).clamp(0.0, 1.0);
            let open = 0.06 + 0.94 * above * above * (3.0 - 2.0 * above);
            (3.0 + 0.24 * (high - low)).min(330.0) * open
        })
        .collect();
    // The result is smoothed once, so that the sides of a valley are not walls.
    let at = |x: usize, y: usize| raw[y.min(size - 1) * size + x.min(size - 1)];
    (0..size * size)
        .map(|i| {
            let (x, y) = (i % size, i / size);
            let (west, north) = (x.saturating_sub(1), y.saturating_sub(1));
            let cross = at(west, y) + at(x + 1, y) + at(x, north) + at(x, y + 1);
            0.6 * at(x, y) + 0.1 * cross
        })
        .collect()
}

/// A rectangle of a level's lattice; it may reach beyond the land.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Span {
    x: i64,
    y: i64,
    width: u32,
    height: u32,
}

impl Span {
    fn samples(self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Returns the samples of the next coarser lattice on which the bicubic surface over this span depends. Coarse
    /// sample i covers samples 2 i and 2 i + 1.
    fn coarse(self) -> Self {
        let axis = |first: i64, count: u32| {
            let from = (first >> 1) - 2;
            let to = ((first + i64::from(count) - 1) >> 1) + 2;
            (from, (to - from + 1) as u32)
        };
        let ((x, width), (y, height)) = (axis(self.x, self.width), axis(self.y, self.height));
        Self { x, y, width, height }
    }
}

/// Heights in metres over a span.
struct Field {
    span: Span,
    heights_m: Vec<f32>,
}

impl Field {
    /// Evaluates the bicubic surface (Catmull-Rom) at the samples `fine` of the next finer lattice; this field must
    /// span `fine.coarse()`.
    fn doubled(&self, fine: Span) -> Field {
        let (width, coarse_width) = (fine.width as usize, self.span.width as usize);
        let mut across = Vec::with_capacity(width * self.span.height as usize);
        for row in self.heights_m.chunks_exact(coarse_width) {
            across.extend((0..fine.width).map(|column| {
                let (first, weights) = taps(fine.x + i64::from(column), self.span.x);
                let four = &row[first..first + 4];
                // Heights are taken relative to one of the four, so that high land loses no precision.
                let near = four[1];
                near + weights[0] * (four[0] - near) + weights[2] * (four[2] - near) + weights[3] * (four[3] - near)
            }));
        }
        let mut heights_m = Vec::with_capacity(fine.samples());
        for row in 0..fine.height {
            let (first, weights) = taps(fine.y + i64::from(row), self.span.y);
            let line = |k: usize| &across[(first + k) * width..(first + k + 1) * width];
            let (a, b, c, d) = (line(0), line(1), line(2), line(3));
            heights_m.extend((0..width).map(|x| {
                let near = b[x];
                near + weights[0] * (a[x] - near) + weights[2] * (c[x] - near) + weights[3] * (d[x] - near)
            }));
        }
        Field { span: fine, heights_m }
    }
}

/// Returns the first of the four coarse samples (counted from `begin`) around a fine one, and their weights: a fine
/// sample is a quarter of the coarse spacing away from its coarse one.
fn taps(fine: i64, begin: i64) -> (usize, [f32; 4]) {
    const BEFORE: [f32; 4] = [-0.023_437_5, 0.226_562_5, 0.867_187_5, -0.070_312_5];
    let own = (fine >> 1) - begin;
    match fine & 1 {
        0 => ((own - 2) as usize, BEFORE),
        _ => ((own - 1) as usize, [BEFORE[3], BEFORE[2], BEFORE[1], BEFORE[0]]),
    }
}
