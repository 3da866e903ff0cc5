//! Valley floors, which streams deposit. Stream power alone cuts every valley to a V; the floors of mountain valleys
//! are filled with gravel, the wider the larger the stream, and side streams enter on alluvial fans.
//!
//! Every stream sample raises its bed by a depth that grows with the upstream area, at least to the level of the bed
//! below it, so that a main valley's gravel backs up into its side valleys. Every other sample takes the level of the
//! stream that it drains to, which rises slightly on the way, and is filled if it is below that level. Following the
//! flow path keeps the fill within its valley: it cannot spill over a low divide.

use super::raster::{Raster, is_border, neighbours};

/// Streams with a smaller upstream area have no floor of their own.
const SMALLEST_STREAM_M2: f32 = 1.0e6;
/// Slope of the fill away from the stream, as a ratio.
const FAN_SLOPE: f32 = 0.03;
/// Slope of the fill along a stream that it buries, as a ratio.
const BED_SLOPE: f32 = 0.004;

/// Steepest slope of a fill, as a ratio.
const STEEPEST_FILL: f32 = 0.07;

/// Adds the valley floors to `heights` (metres). `order` is the flow order that [`flood`](super::erosion::flood)
/// returns, `areas_m2` holds the upstream areas, and `depth_factors` (0 to 1) scale the depth under the streams.
/// Returns the depth of the fill in metres.
pub(super) fn lay_floors(heights: &mut Raster, order: &[u32], areas_m2: &[f32], depth_factors: &[f32]) -> Vec<f32> {
    let size = heights.size;
    let around = neighbours(size);
    let spacing_m = heights.spacing_m as f32;
    let mut levels_m = vec![f32::NEG_INFINITY; size * size];
    // Goes upstream, so that the level of the sample below is known. Only that level is used, not its filled height.
    let bare_m = heights.values.clone();
    for &index in order {
        let index = index as usize;
        let own_m = if areas_m2[index] > SMALLEST_STREAM_M2 {
            bare_m[index] + floor_depth_m(areas_m2[index]) * depth_factors[index]
        } else {
            f32::NEG_INFINITY
        };
        if is_border(index, size) {
            levels_m[index] = own_m;
            continue;
        }
        let mut steepest = (0.0, index, 0.0);
        for (offset, distance, _) in around {
            let neighbour = index.wrapping_add_signed(offset);
            let fall = (bare_m[index] - bare_m[neighbour]) / distance;
            if fall > steepest.0 {
                steepest = (fall, neighbour, distance);
            }
        }
        let (_, below, distance) = steepest;
        let slope = if own_m.is_finite() { BED_SLOPE } else { FAN_SLOPE };
        levels_m[index] = own_m.max(levels_m[below] + slope * distance * spacing_m);
        if levels_m[index] > bare_m[index] {
            heights.values[index] = levels_m[index];
        } else if !own_m.is_finite() {
            // This sample is above the fill, so the fill does not reach anything further upstream either.
            levels_m[index] = f32::NEG_INFINITY;
        }
    }
    even_out(heights, &bare_m);
    heights.values.iter().zip(&bare_m).map(|(height_m, bare_m)| height_m - bare_m).collect()
}

/// Smooths steps in the fill. Two streams in one floor may have different levels, and the fill of each ends where the
/// other's begins. Lowers the fill (never below `bare_m`) until no step between neighbours is steeper than
/// [`STEEPEST_FILL`], by forward and backward sweeps, as distance transforms do.
fn even_out(heights: &mut Raster, bare_m: &[f32]) {
    let size = heights.size;
    let around = neighbours(size).map(|(offset, distance, _)| (offset, distance * heights.spacing_m as f32));
    let mut lower = |index: usize| {
        if heights.values[index] > bare_m[index] && !is_border(index, size) {
            let limit_m = around.iter().fold(f32::INFINITY, |limit_m, &(offset, distance_m)| {
                limit_m.min(heights.values[index.wrapping_add_signed(offset)] + STEEPEST_FILL * distance_m)
            });
            heights.values[index] = heights.values[index].min(limit_m.max(bare_m[index]));
        }
    };
    for _ in 0..3 {
        (0..size * size).for_each(&mut lower);
        (0..size * size).rev().for_each(&mut lower);
    }
}

/// Returns the depth in metres of the fill under a stream with this upstream area.
fn floor_depth_m(area_m2: f32) -> f32 {
    (1.1e-2 * (area_m2 - SMALLEST_STREAM_M2).max(0.0).sqrt()).min(110.0)
}
