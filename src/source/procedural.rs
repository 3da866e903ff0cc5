//! The embedded procedural world: an alpine range from a seed, for a first look without any file.
//!
//! The land is grown by simulation, because mountains are only believable if their valleys join.
//!
//! 1. `relief`: where the land rises and how hard the rock is, from ridged multifractals and warped noise (Musgrave, in
//!    Ebert et al., "Texturing and Modeling", 3rd edition, 2003). The noise determines the range, the massifs and the
//!    foothills, but not the heights; those result from the rivers.
//! 2. `erosion`: rivers cut while the land rises (Braun and Willett 2013; for terrain synthesis Cordonnier et al.,
//!    "Large scale terrain generation from tectonic uplift and fluvial erosion", 2016). This runs on a coarse grid with
//!    many steps first, then on grids of doubled resolution with ever fewer steps, because a finer grid adds only
//!    smaller gullies. Between the grids the ground is displaced by a fraction of a sample, so that a direction of the
//!    coarse grid does not survive as a straight valley.
//! 3. `hillslope`: rock slides to its talus angle (Musgrave et al. 1989, Olsen 2004).
//! 4. `valley`: gravel floors and fans, then a last flood and a light smoothing.
//!
//! The coarse grids reach beyond the required square and are then cut to it: rivers enter and leave, and the range
//! continues past the edge. All parallel code writes each sample from fixed inputs, so that the result does not depend
//! on the number of threads.

use super::georeference::{Crs, Georeference};
use super::raster::{Raster, is_border};
use super::relief::Relief;
use super::{HeightGrid, Progress, erosion, hillslope, valley};
use rayon::prelude::*;

/// Version of [`generate`], increased whenever it gives other heights for a seed; part of cache keys.
pub(crate) const VERSION: u32 = 1;
/// Samples per side of [`generate`].
pub const SIZE_SAMPLES: u32 = 2048;
/// Sample spacing of [`generate`] in metres.
pub const SPACING_M: f64 = 12.0;

/// Width in metres of the land around the required square on which the coarse grids run.
const MARGIN_M: f64 = 6_000.0;
/// Largest sample spacing of the coarsest grid in metres.
const COARSEST_M: f64 = 200.0;
/// Spacing in metres below which the grids are cut to the required square.
const CUT_BELOW_M: f64 = 40.0;
/// Rings of samples that are simulated and then discarded, because their neighbours at the edge are held fixed.
const TRIM_SAMPLES: usize = 6;
/// Uplift at strength 1, in metres per duration of 1.
const UPLIFT_M: f32 = 520.0;
/// Lowest and highest ground of the whole land in metres.
const LOWEST_M: f32 = 320.0;
const HIGHEST_M: f32 = 3_150.0;

/// Generates the built-in world: [`SIZE_SAMPLES`]² samples, [`SPACING_M`] apart, about 300 to 3,200 m high.
///
/// The result is bit-identical for the same seed, on any number of threads.
pub fn generate(seed: u32, progress: &dyn Progress) -> HeightGrid {
    generate_sized(seed, SIZE_SAMPLES, SPACING_M, progress)
}

/// Generates a square of the land of `seed` around its centre: `size_samples`² heights in metres (at least 2 per side;
/// smaller values count as 2), `spacing_m` apart (10 to 100 is sensible). No sample is NaN.
///
/// The same seed at another size or spacing gives a similar land, not the same: rivers take other courses on another
/// grid.
pub fn generate_sized(seed: u32, size_samples: u32, spacing_m: f64, progress: &dyn Progress) -> HeightGrid {
    let size = size_samples.max(2) as usize;
    let relief = Relief::new(seed);
    let (mut land, inflow_m2) = grow(&relief, size + 2 * TRIM_SAMPLES, spacing_m, progress);
    progress.report("valley floors", 0.85);
    finish(&relief, &mut land, inflow_m2.as_deref());
    progress.report("done", 1.0);
    let heights_m = land
        .values
        .chunks(land.size)
        .skip(TRIM_SAMPLES)
        .take(size)
        .flat_map(|line| &line[TRIM_SAMPLES..TRIM_SAMPLES + size])
        .copied()
        .collect();
    let half_m = (size as f64 - 1.0) * 0.5 * spacing_m;
    HeightGrid {
        width: size as u32,
        height: size as u32,
        heights_m,
        georeference: Georeference {
            crs_from_grid: [-half_m, spacing_m, 0.0, half_m, 0.0, -spacing_m],
            crs: Crs::Local,
            geokeys: Default::default(),
        },
    }
}

/// Runs uplift and incision from the coarsest grid to the finest. Returns heights in metres, and the upstream area that
/// streams bring in across the border, in square metres per sample.
fn grow(
    relief: &Relief,
    final_size: usize,
    final_spacing_m: f64,
    progress: &dyn Progress,
) -> (Raster, Option<Vec<f32>>) {
    let level_count = (COARSEST_M / final_spacing_m).max(1.0).log2().floor() as u32;
    let extent_m = (final_size as f64 - 1.0) * final_spacing_m;
    let mut land: Option<(Raster, Vec<f32>)> = None;
    let mut scale = 1.0_f32;
    let mut final_inflow_m2 = None;
    let mut is_cut = false;
    for level in (0..=level_count).rev() {
        let spacing_m = final_spacing_m * f64::from(1u32 << level);
        let cut_now = spacing_m < CUT_BELOW_M || level == 0;
        let size = if level == 0 {
            final_size
        } else {
            let level_extent_m = extent_m + if cut_now { 4.0 * spacing_m } else { 2.0 * MARGIN_M };
            (level_extent_m / spacing_m).ceil() as usize + 1
        };
        let uplift = Raster::from_fn(size, spacing_m, |x_m, y_m| relief.uplift(x_m, y_m));
        let hardness = Raster::from_fn(size, spacing_m, |x_m, y_m| relief.hardness(x_m, y_m)).values;
        let (mut heights, inflow_m2) = match &land {
            None => (first_land(relief, &uplift), None),
            Some((coarse, areas_m2)) => {
                if cut_now && !is_cut {
                    // The land has its shape now: from here on its heights are not rescaled.
                    scale = (HIGHEST_M - LOWEST_M) / highest(&coarse.values).max(1.0);
                }
                let factor = if cut_now && !is_cut { scale } else { 1.0 };
                let heights = refine(relief, coarse, &uplift, level, factor);
                let inflow_m2 = cut_now.then(|| inflow(coarse, areas_m2, &heights));
                (heights, inflow_m2)
            }
        };
        is_cut |= cut_now;
        let uplift_m: Vec<f32> = uplift.values.iter().map(|strength| strength * UPLIFT_M * scale).collect();
        let (steps, duration) = match (land.is_none(), level) {
            (true, _) => (60, 0.16),
            (false, 0) => (2, 0.1),
            (false, 1) => (5, 0.1),
            (false, 2) => (12, 0.12),
            (false, _) => (24, 0.15),
        };
        let mut areas_m2 = Vec::new();
        for step in 0..steps {
            let flow = erosion::route(&mut heights);
            areas_m2 = erosion::upstream_areas(&heights, &flow, inflow_m2.as_deref());
            erosion::incise(&mut heights, &flow, &areas_m2, &uplift_m, &hardness, duration);
            let part = (step + 1) as f32 / steps as f32;
            progress.report("rivers", 0.8 * ((level_count - level) as f32 + part) / (level_count + 1) as f32);
        }
        land = Some((heights, areas_m2));
        final_inflow_m2 = inflow_m2;
    }
    // The loop runs at least once, for level 0.
    let bare = || Raster::from_fn(final_size, final_spacing_m, |_, _| 0.0);
    let mut heights = land.map_or_else(bare, |(heights, _)| heights);
    heights.values.par_iter_mut().for_each(|height_m| *height_m += LOWEST_M);
    (heights, final_inflow_m2)
}

/// Returns the initial ground before erosion; its border is the sea level of this land.
fn first_land(relief: &Relief, uplift: &Raster) -> Raster {
    let mut heights = Raster::from_fn(uplift.size, uplift.spacing_m, |x_m, y_m| {
        (1.0 + relief.first_ground(x_m, y_m)) * 60.0 + relief.uplift(x_m, y_m) * 300.0
    });
    for (index, height_m) in heights.values.iter_mut().enumerate() {
        if is_border(index, uplift.size) {
            *height_m = 0.0;
        }
    }
    heights
}

/// Returns the ground of the next finer grid: interpolated, slightly displaced, and roughened.
fn refine(relief: &Relief, coarse: &Raster, uplift: &Raster, level: u32, factor: f32) -> Raster {
    let coarse_m = coarse.spacing_m;
    let stream = 10 * level;
    let half_m = (uplift.size as f64 - 1.0) * 0.5 * uplift.spacing_m;
    Raster::from_fn(uplift.size, uplift.spacing_m, |x_m, y_m| {
        let shift = |part: u32| {
            relief.roughness(x_m, y_m, 7.0 * coarse_m, stream + part) * 1.1
                + relief.roughness(x_m, y_m, 3.1 * coarse_m, stream + part + 1) * 0.5
        };
        let height_m = coarse.sample_cubic(x_m + shift(1) * coarse_m, y_m + shift(3) * coarse_m, 0.5);
        let strength = uplift.sample_cubic(x_m, y_m, 1.0).clamp(0.02, 1.0);
        let rough = relief.roughness(x_m, y_m, 2.3 * coarse_m, stream + 5) * 0.22 * coarse_m;
        let is_edge = x_m.abs().max(y_m.abs()) > half_m - 0.5 * uplift.spacing_m;
        (height_m + if is_edge { 0.0 } else { rough as f32 * strength }) * factor
    })
}

/// Returns the upstream area that streams bring in across the border of a grid that was cut from a larger one, in
/// square metres per sample.
fn inflow(coarse: &Raster, coarse_areas_m2: &[f32], heights: &Raster) -> Vec<f32> {
    let coarse_areas = Raster { values: coarse_areas_m2.to_vec(), ..*coarse };
    let size = heights.size;
    let last = size - 1;
    let half_m = last as f64 * 0.5 * heights.spacing_m;
    let mut inflow_m2 = vec![0.0; size * size];
    for place in 3..last.saturating_sub(3) {
        // The loop goes over the four sides; a stream crosses where the border is lowest within three samples to either
        // side.
        for (start, stride) in [(0, 1), (last * size, 1), (0, size), (last, size)] {
            let at = |p: usize| start + p * stride;
            let height_m = heights.values[at(place)];
            let is_lowest =
                (1..=3).all(|d| height_m <= heights.values[at(place - d)] && height_m < heights.values[at(place + d)]);
            if is_lowest {
                let (row, column) = (at(place) / size, at(place) % size);
                let x_m = column as f64 * heights.spacing_m - half_m;
                let y_m = half_m - row as f64 * heights.spacing_m;
                inflow_m2[at(place)] = coarse_areas.max_near(x_m, y_m);
            }
        }
    }
    inflow_m2
}

/// Applies slides, valley floors, and the last flood and smoothing.
fn finish(relief: &Relief, land: &mut Raster, inflow_m2: Option<&[f32]>) {
    let spacing_m = land.spacing_m;
    let hardness = Raster::from_fn(land.size, spacing_m, |x_m, y_m| relief.hardness(x_m, y_m)).values;
    // Talus angles are 41° for common rock, 36° for soft and up to 52° for hard rock.
    let talus: Vec<f32> = hardness.iter().map(|hardness| (0.87 * hardness.powf(0.7)).clamp(0.72, 1.3)).collect();
    hillslope::slide(land, &talus, 10);
    let flow = erosion::route(land);
    let areas_m2 = erosion::upstream_areas(land, &flow, inflow_m2);
    // In the plain, where divides are low, deep gravel would be higher than the neighbouring stream.
    let depth_factors =
        Raster::from_fn(land.size, spacing_m, |x_m, y_m| (relief.uplift(x_m, y_m) * 5.0).min(1.0)).values;
    let depths_m = valley::lay_floors(land, &flow.order, &areas_m2, &depth_factors);
    // The deep fill is smoothed strongly, the rock hardly.
    hillslope::creep(land, |index| if depths_m[index] > 0.0 { 0.9 } else { 0.0 }, 8);
    // At 3/4 the kernel is the binomial one, which removes variation that alternates from sample to sample.
    hillslope::creep(land, |_| 0.75, 1);
    hillslope::creep(land, |_| 0.3, 1);
    erosion::flood(land);
}

fn highest(values: &[f32]) -> f32 {
    values.iter().copied().fold(f32::NEG_INFINITY, f32::max)
}
