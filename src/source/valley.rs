//! Valley floors: what the streams lay down. Stream power alone cuts every valley to a V; mountain valleys are floored
//! with gravel, the wider the larger the stream, and side streams enter on fans.
//!
//! Every stream sample lifts its bed by a depth that grows with the upstream area, and from there the fill spreads
//! sideways, rising slightly, until it meets the valley side. Samples are settled from the lowest level up, so that
//! a main valley's fill backs up into its side valleys rather than the reverse.

use super::raster::{Raster, is_border, neighbours};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Streams smaller than this have no floor of their own.
const SMALLEST_STREAM_M2: f32 = 1.2e6;
/// How the fill rises away from the stream, as a ratio.
const FAN_SLOPE: f32 = 0.022;

/// Lays the floors into `heights` (metres); `areas_m2` are the upstream areas. Returns the depth of the fill, metres.
pub(super) fn lay_floors(heights: &mut Raster, areas_m2: &[f32]) -> Vec<f32> {
    let size = heights.size;
    let around = neighbours(size);
    let rise_m = FAN_SLOPE * heights.spacing_m as f32;
    let mut levels_m = vec![f32::NEG_INFINITY; size * size];
    let mut queue = BinaryHeap::new();
    for (index, &area_m2) in areas_m2.iter().enumerate() {
        if area_m2 > SMALLEST_STREAM_M2 {
            levels_m[index] = heights.values[index] + floor_depth_m(area_m2);
            queue.push(Reverse((key(levels_m[index]), index as u32)));
        }
    }
    let mut is_settled = vec![false; size * size];
    while let Some(Reverse((_, index))) = queue.pop() {
        let index = index as usize;
        if is_settled[index] {
            continue;
        }
        is_settled[index] = true;
        if is_border(index, size) {
            continue;
        }
        for (offset, distance, _) in around {
            let neighbour = index.wrapping_add_signed(offset);
            let level_m = levels_m[index] + rise_m * distance;
            let is_stream = areas_m2[neighbour] > SMALLEST_STREAM_M2;
            if is_settled[neighbour] || level_m <= heights.values[neighbour] {
                continue;
            }
            // A stream keeps the higher of its own level and the water that backs up into it.
            let is_better = if is_stream || levels_m[neighbour] == f32::NEG_INFINITY {
                level_m > levels_m[neighbour]
            } else {
                level_m < levels_m[neighbour]
            };
            if is_better {
                levels_m[neighbour] = level_m;
                queue.push(Reverse((key(level_m), neighbour as u32)));
            }
        }
    }
    let mut depths_m = vec![0.0; size * size];
    for (index, height_m) in heights.values.iter_mut().enumerate() {
        if levels_m[index] > *height_m {
            depths_m[index] = levels_m[index] - *height_m;
            *height_m = levels_m[index];
        }
    }
    depths_m
}

/// Depth of the fill under a stream of this upstream area, metres.
fn floor_depth_m(area_m2: f32) -> f32 {
    (9.0e-3 * (area_m2 - SMALLEST_STREAM_M2).max(0.0).sqrt()).min(110.0)
}

/// Levels lie above zero or near it; as millimetres they order exactly.
fn key(level_m: f32) -> i64 {
    (f64::from(level_m) * 1000.0) as i64
}
