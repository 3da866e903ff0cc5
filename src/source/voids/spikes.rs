//! Finds spikes: single samples far above or below their neighbours, as radar data has them near no-data.
//!
//! A sample is a spike if it is higher than all of its valid neighbours (or lower than all), and differs from their
//! median by more than [`SLOPE`] times the sample spacing and by more than [`OF_RELIEF`] of the range of the samples
//! within two of it. The flanks of a summit continue beyond its neighbours, so that this range is larger: a cone rises
//! over the median of its neighbours by 0.66 of it, however steep it is. On a cliff the neighbour along it is as high
//! or as low. Only samples within [`REACH`] of no-data are examined: radar has its spikes there, and a grid without
//! no-data stays unchanged.

use crate::source::reader::Window;

/// Distance from no-data within which spikes are searched, in rows and columns.
pub(super) const REACH: u32 = 8;
/// Smallest rise of a spike over the median of its neighbours, as a multiple of the sample spacing: 27 degrees on all
/// sides.
const SLOPE: f64 = 0.5;
/// Smallest rise of a spike as a fraction of the relief around it.
const OF_RELIEF: f64 = 0.8;
/// Samples with fewer valid neighbours than this are not judged.
const MIN_NEIGHBOURS: usize = 3;

/// Returns the ascending indices of spikes in the heights of a window.
pub(super) fn find(heights_m: &[f32], window: Window, spacing_m: f64) -> Vec<u32> {
    let (width, height) = (window.width as usize, window.height as usize);
    let near_voids = mark_near_voids(heights_m, width, height);
    let is_spike = |index: &u32| {
        let index = *index as usize;
        heights_m[index].is_finite() && near_voids[index] && stands_out(heights_m, [width, height], index, spacing_m)
    };
    (0..heights_m.len() as u32).filter(is_spike).collect()
}

fn stands_out(heights_m: &[f32], [width, height]: [usize; 2], index: usize, spacing_m: f64) -> bool {
    let (x, y) = (index % width, index / width);
    let own_m = heights_m[index];
    let mut around = [0.0f32; 8];
    let mut count = 0;
    let (mut low_m, mut high_m) = (f32::INFINITY, f32::NEG_INFINITY);
    for row in y.saturating_sub(2)..(y + 3).min(height) {
        for column in x.saturating_sub(2)..(x + 3).min(width) {
            let height_m = heights_m[row * width + column];
            if !height_m.is_finite() || (column, row) == (x, y) {
                continue;
            }
            (low_m, high_m) = (low_m.min(height_m), high_m.max(height_m));
            if column.abs_diff(x).max(row.abs_diff(y)) == 1 {
                around[count] = height_m;
                count += 1;
            }
        }
    }
    if count < MIN_NEIGHBOURS {
        return false;
    }
    let around = &mut around[..count];
    around.sort_by(f32::total_cmp);
    if (around[0]..=around[count - 1]).contains(&own_m) {
        return false;
    }
    let median_m = (f64::from(around[(count - 1) / 2]) + f64::from(around[count / 2])) / 2.0;
    let out_m = (f64::from(own_m) - median_m).abs();
    out_m > SLOPE * spacing_m && out_m > OF_RELIEF * (f64::from(high_m) - f64::from(low_m))
}

/// Marks the samples within [`REACH`] rows and columns of no-data: first along rows, then along columns.
fn mark_near_voids(heights_m: &[f32], width: usize, height: usize) -> Vec<bool> {
    let mut by_rows = vec![false; heights_m.len()];
    for (row, heights_m) in heights_m.chunks_exact(width).enumerate() {
        for x in (0..width).filter(|&x| !heights_m[x].is_finite()) {
            let (left, right) = span(x, width);
            by_rows[row * width + left..row * width + right].fill(true);
        }
    }
    let mut near_voids = vec![false; heights_m.len()];
    for (row, marked) in by_rows.chunks_exact(width).enumerate() {
        if marked.iter().any(|marked| *marked) {
            let (top, bottom) = span(row, height);
            for into in near_voids[top * width..bottom * width].chunks_exact_mut(width) {
                into.iter_mut().zip(marked).for_each(|(into, marked)| *into |= marked);
            }
        }
    }
    near_voids
}

fn span(at: usize, count: usize) -> (usize, usize) {
    (at.saturating_sub(REACH as usize), (at + REACH as usize + 1).min(count))
}
