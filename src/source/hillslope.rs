//! Hillslopes: loose rock slides until it rests at its talus angle, and soil creeps.
//!
//! Thermal weathering follows Musgrave, Kolb and Mace ("The synthesis and rendering of eroded fractal terrains",
//! SIGGRAPH 1989), in the form of Olsen ("Realtime procedural terrain generation", 2004), who moves material only as
//! far as the steepest excess allows. Here all lower neighbours share the material in proportion to their excess, the
//! talus angle grows with the hardness of the rock, and each sample gathers its own gains and losses, so that rows run
//! in parallel.

use super::raster::{Raster, neighbours};
use rayon::prelude::*;

/// Lets material slide for `passes` passes: where a slope exceeds `talus` (a ratio per sample), four tenths of the
/// steepest excess go to the lower neighbours. Border samples keep their heights. Mass is preserved, except for
/// material that reaches the border.
pub(super) fn slide(heights: &mut Raster, talus: &[f32], passes: usize) {
    let size = heights.size;
    let spacing_m = heights.spacing_m as f32;
    let around = neighbours(size);
    // Material sent per metre of excess: four tenths of the largest excess, divided by the sum of excesses.
    let mut rates = vec![0.0_f32; size * size];
    let mut after_m = heights.values.clone();
    let excess_m = |heights_m: &[f32], from: usize, to: usize, distance: f32| {
        (heights_m[from] - heights_m[to] - talus[from] * distance * spacing_m).max(0.0)
    };
    for _ in 0..passes {
        let before_m = &heights.values;
        rates.par_chunks_mut(size).enumerate().skip(1).take(size - 2).for_each(|(row, line)| {
            for (column, rate) in line.iter_mut().enumerate().skip(1).take(size - 2) {
                let index = row * size + column;
                let (mut largest, mut sum) = (0.0_f32, 0.0);
                for (offset, distance, _) in around {
                    let excess = excess_m(before_m, index, index.wrapping_add_signed(offset), distance);
                    largest = largest.max(excess);
                    sum += excess;
                }
                *rate = if sum > 0.0 { 0.4 * largest / sum } else { 0.0 };
            }
        });
        after_m.par_chunks_mut(size).enumerate().skip(1).take(size - 2).for_each(|(row, line)| {
            for (column, after) in line.iter_mut().enumerate().skip(1).take(size - 2) {
                let index = row * size + column;
                let mut change_m = 0.0;
                for (offset, distance, _) in around {
                    let neighbour = index.wrapping_add_signed(offset);
                    if rates[neighbour] > 0.0 {
                        change_m += rates[neighbour] * excess_m(before_m, neighbour, index, distance);
                    }
                    if rates[index] > 0.0 {
                        change_m -= rates[index] * excess_m(before_m, index, neighbour, distance);
                    }
                }
                *after = before_m[index] + change_m;
            }
        });
        std::mem::swap(&mut heights.values, &mut after_m);
    }
}

/// Lets soil creep for `passes` passes: each sample moves towards the mean of its neighbours by `amount` (0 to 1, per
/// sample). Border samples keep their heights.
pub(super) fn creep(heights: &mut Raster, amount: impl Fn(usize) -> f32 + Sync, passes: usize) {
    let size = heights.size;
    let around = neighbours(size);
    let mut after_m = heights.values.clone();
    for _ in 0..passes {
        let before_m = &heights.values;
        after_m.par_chunks_mut(size).enumerate().skip(1).take(size - 2).for_each(|(row, line)| {
            for (column, after) in line.iter_mut().enumerate().skip(1).take(size - 2) {
                let index = row * size + column;
                let mut mean_m = 0.0;
                for (offset, distance, _) in around {
                    // Weights of the isotropic Laplacian: 1/6 for the four near neighbours, 1/12 for the diagonal ones.
                    let weight = if distance > 1.1 { 1.0 / 12.0 } else { 1.0 / 6.0 };
                    mean_m += weight * before_m[index.wrapping_add_signed(offset)];
                }
                *after = before_m[index] + (mean_m - before_m[index]) * amount(index);
            }
        });
        std::mem::swap(&mut heights.values, &mut after_m);
    }
}
