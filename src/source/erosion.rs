//! River erosion: solves the stream power law on a grid.
//!
//! The land rises, and running water cuts it down at the rate `k √A · S` (A the upstream area, S the slope):
//!
//! ```text
//! dh/dt = u − k √(A + A₀) · S
//! ```
//!
//! Braun and Willett ("A very efficient O(n), implicit and parallel method to solve the stream power equation governing
//! fluvial incision and landscape evolution", Geomorphology 2013) solve it implicitly, from the outlets upstream, which
//! is stable at any time step. The differences here are:
//!
//! - Flow leaves a sample towards *all* lower neighbours (Quinn et al. 1991; weights slope⁴), not only the steepest;
//!   eight directions alone would show as straight gullies along the axes and diagonals. With slope exponent 1 the
//!   implicit equation stays linear with several receivers, provided that samples are visited by height.
//! - That order, and an outlet for every hollow, come from one priority flood (Barnes, Lehman and Mulla 2014), which
//!   fills hollows with a slight slope, as sediment would. Its queue already yields the samples by height.
//! - `A₀` bounds the slope at the divides, as debris flows do (Stock and Dietrich 2003). Without it the talus angle
//!   alone would determine the slopes of all small areas, and the mountain sides would be bare planes.

use super::raster::{Raster, is_border, neighbours};
use rayon::prelude::*;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Slope of filled hollows, as a ratio: just large enough for 32-bit heights to resolve.
const FILL_SLOPE: f32 = 1.0e-4;

/// Upstream area below which the slope no longer steepens.
const AREA_OFFSET_M2: f32 = 520.0 * 520.0;

/// Fills the hollows of `heights` (metres) until every sample drains to the border; returns the samples in ascending
/// order of the filled heights.
pub(super) fn flood(heights: &mut Raster) -> Vec<u32> {
    let size = heights.size;
    let count = size * size;
    let step_m = FILL_SLOPE * heights.spacing_m as f32;
    let mut is_reached: Vec<bool> = (0..count).map(|index| is_border(index, size)).collect();
    let mut queue: BinaryHeap<Reverse<u64>> =
        (0..count).filter(|&index| is_reached[index]).map(|i| Reverse(queue_key(heights.values[i], i))).collect();
    let mut order = Vec::with_capacity(count);
    let around = neighbours(size);
    while let Some(Reverse(key)) = queue.pop() {
        let index = key as u32 as usize;
        order.push(index as u32);
        let on_border = is_border(index, size);
        let level_m = heights.values[index] + step_m;
        for (neighbour, _) in each_neighbour(index, size, on_border, &around) {
            if !is_reached[neighbour] {
                is_reached[neighbour] = true;
                let height_m = &mut heights.values[neighbour];
                *height_m = height_m.max(level_m);
                queue.push(Reverse(queue_key(*height_m, neighbour)));
            }
        }
    }
    order
}

/// Returns a key whose order is that of the heights (the bits of a float with its sign folded in); the index makes the
/// order of equal heights unique.
fn queue_key(height_m: f32, index: usize) -> u64 {
    let bits = height_m.to_bits();
    let ordered = if bits >> 31 == 0 { bits | 0x8000_0000 } else { !bits };
    (u64::from(ordered) << 32) | index as u64
}

/// Returns the neighbours of a sample with their index in the table of [`neighbours`]; on the border only those that
/// exist.
fn each_neighbour<'a>(
    index: usize,
    size: usize,
    on_border: bool,
    around: &'a [(isize, f32, f32); 8],
) -> impl Iterator<Item = (usize, usize)> + 'a {
    let column = index % size;
    around.iter().enumerate().filter_map(move |(place, &(offset, _, _))| {
        let neighbour = index.wrapping_add_signed(offset);
        // A wrapped index is past the end; an index that jumps across a side differs in column by more than one.
        let exists = !on_border || (neighbour < size * size && (neighbour % size).abs_diff(column) <= 1);
        exists.then_some((neighbour, place))
    })
}

/// The flow of water from every sample.
pub(super) struct Flow {
    /// Samples in ascending order of height: a sample comes after all those to which it drains.
    pub(super) order: Vec<u32>,
    /// Share of the flow that each neighbour gets, in the order of [`neighbours`]; only the ratios count. One byte each
    /// is precise enough, and the passes over all samples are limited by memory bandwidth.
    shares: Vec<[u8; 8]>,
}

/// Fills the hollows of `heights` (metres) and routes the water.
pub(super) fn route(heights: &mut Raster) -> Flow {
    let order = flood(heights);
    let size = heights.size;
    let around = neighbours(size);
    let heights_m = &heights.values;
    let mut shares = vec![[0_u8; 8]; size * size];
    shares.par_chunks_mut(size).enumerate().for_each(|(row, line)| {
        for (column, shares) in line.iter_mut().enumerate() {
            let index = row * size + column;
            let mut falls = [0.0_f32; 8];
            if is_border(index, size) {
                for (neighbour, place) in each_neighbour(index, size, true, &around) {
                    falls[place] = (heights_m[index] - heights_m[neighbour]).max(0.0) / around[place].1;
                }
            } else {
                for (fall, (offset, distance, _)) in falls.iter_mut().zip(around) {
                    *fall = (heights_m[index] - heights_m[index.wrapping_add_signed(offset)]).max(0.0) / distance;
                }
            }
            let steepest = falls.iter().copied().fold(0.0, f32::max);
            if steepest > 0.0 {
                for place in 0..8 {
                    let squared = (falls[place] / steepest).powi(2);
                    shares[place] = (510.0 * squared * squared * around[place].2) as u8;
                }
            }
        }
    });
    Flow { order, shares }
}

/// Returns the upstream area of every sample in square metres. `inflow_m2`, if given, is added to each sample's own
/// area: it is the area that streams bring in across the border.
pub(super) fn upstream_areas(heights: &Raster, flow: &Flow, inflow_m2: Option<&[f32]>) -> Vec<f32> {
    let around = neighbours(heights.size);
    let own_m2 = (heights.spacing_m * heights.spacing_m) as f32;
    let mut areas_m2: Vec<f32> = match inflow_m2 {
        Some(inflow_m2) => inflow_m2.iter().map(|inflow| inflow + own_m2).collect(),
        None => vec![own_m2; heights.values.len()],
    };
    for &index in flow.order.iter().rev() {
        let index = index as usize;
        let shares = flow.shares[index];
        let sum: u32 = shares.iter().map(|&share| u32::from(share)).sum();
        let part_m2 = areas_m2[index] / sum.max(1) as f32;
        for (share, (offset, _, _)) in shares.into_iter().zip(around) {
            if share > 0 {
                areas_m2[index.wrapping_add_signed(offset)] += part_m2 * f32::from(share);
            }
        }
    }
    areas_m2
}

/// Performs one step of uplift and incision; border samples keep their heights.
///
/// `duration` is the time step times `k`; `uplift_m` is the rise of the land in a duration of 1; `hardness` divides
/// `k`. `flow` and `areas_m2` come from [`route`] and [`upstream_areas`].
pub(super) fn incise(
    heights: &mut Raster,
    flow: &Flow,
    areas_m2: &[f32],
    uplift_m: &[f32],
    hardness: &[f32],
    duration: f32,
) {
    let size = heights.size;
    let around = neighbours(size);
    let per_m = duration / heights.spacing_m as f32;
    for &index in &flow.order {
        let index = index as usize;
        if is_border(index, size) {
            continue;
        }
        let shares = flow.shares[index];
        let sum: u32 = shares.iter().map(|&share| u32::from(share)).sum();
        let strength = per_m * (areas_m2[index] + AREA_OFFSET_M2).sqrt() / (hardness[index] * sum.max(1) as f32);
        let mut numerator = heights.values[index] + duration * uplift_m[index];
        let mut denominator = 1.0;
        for (share, (offset, distance, _)) in shares.into_iter().zip(around) {
            if share > 0 {
                let pull = strength * f32::from(share) / distance;
                numerator += pull * heights.values[index.wrapping_add_signed(offset)];
                denominator += pull;
            }
        }
        heights.values[index] = numerator / denominator;
    }
}
