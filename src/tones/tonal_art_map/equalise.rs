//! Equalises thresholds so that the mean tone is right: by rank over the tile, and by rank within every neighbourhood.
//!
//! A threshold that is replaced by its rank inks exactly the requested fraction of the tile (histogram equalisation).
//! For the fraction to be right everywhere, the rank among the neighbours is needed: the idea of contrast-limited
//! equalisation (Pizer and others 1987), but with a Gaussian window that moves with the texel, so there are no blocks
//! and the order of nearby texels is preserved. Neighbours of one mark have nearly the same window, so a mark's border
//! stays where it is or moves as a whole.
//!
//! The fraction of a window below a threshold is computed for a number of thresholds, from pictures of what each of
//! them inks, in cells of 4 × 4 texels, blurred; it is interpolated in threshold and place.

use rayon::prelude::*;

/// Standard deviations of the windows, along and across the marks.
#[derive(Clone, Copy)]
pub(super) struct Windows {
    /// At middle tones.
    pub(super) narrow_px: [f32; 2],
    /// At light and dark tones.
    pub(super) wide_px: [f32; 2],
}

/// Between the first and the second darkness (and likewise from black) the window changes from the wider to the
/// narrower.
const NARROWING: [f32; 2] = [0.1, 0.35];
/// Side of a cell, in texels.
const CELL_PX: usize = 4;
/// Thresholds for which the fraction is computed.
const BINS: usize = 96;
/// Iterations: each one moves tones between neighbourhoods, which the next one takes into account; after five, little
/// is left to move.
const TURNS: usize = 5;

/// Returns each value's rank, 0 to 1. Equal values keep their order.
pub(super) fn ranks(values: &[f32]) -> Vec<f32> {
    let mut order: Vec<(u32, u32)> = values.iter().zip(0..).map(|(value, place)| (sortable(*value), place)).collect();
    order.sort_unstable();
    let mut ranks = vec![0.0; values.len()];
    for (rank, (_, place)) in order.into_iter().enumerate() {
        ranks[place as usize] = (rank as f64 + 0.5) as f32 / values.len() as f32;
    }
    ranks
}

/// Returns an integer that is larger for a larger float.
fn sortable(value: f32) -> u32 {
    let bits = value.to_bits();
    if bits >> 31 == 0 { bits | 1 << 31 } else { !bits }
}

/// Alternates ranks within each neighbourhood and ranks over the tile, [`TURNS`] times.
pub(super) fn everywhere(values: &[f32], side_px: usize, windows: Windows) -> Vec<f32> {
    let mut even = ranks(values);
    for _ in 0..TURNS {
        even = ranks(&locally(&even, side_px, windows));
    }
    even
}

/// Returns for thresholds of 0 to 1 their rank in the window around them.
fn locally(thresholds: &[f32], side_px: usize, windows: Windows) -> Vec<f32> {
    let cells = side_px / CELL_PX;
    // Fractions of the window: a picture for the upper end of each bin.
    let mut bins = vec![0_u8; thresholds.len()];
    bins.iter_mut().zip(thresholds).for_each(|(bin, t)| *bin = ((t * BINS as f32) as usize).min(BINS - 1) as u8);
    let mut counts = vec![[0.0_f32; BINS]; cells * cells];
    for (place, bin) in bins.iter().enumerate() {
        counts[place / side_px / CELL_PX * cells + place % side_px / CELL_PX][usize::from(*bin)] += 1.0;
    }
    // From counts to the fraction up to and including a bin.
    let texels = (CELL_PX * CELL_PX) as f32;
    for cell in &mut counts {
        let mut sum = 0.0;
        for count in cell.iter_mut() {
            sum += *count / texels;
            *count = sum;
        }
    }
    let [mut counts, wide] = [windows.narrow_px, windows.wide_px].map(|window_px| {
        let [along, across] = window_px.map(|px| kernel(cells, px));
        blurred(&blurred(&counts, cells, &along, 1, cells), cells, &across, cells, 1)
    });
    for (narrow, wide) in counts.iter_mut().zip(&wide) {
        let mut most = 0.0_f32;
        for (bin, share) in narrow.iter_mut().enumerate() {
            let darkness = (bin + 1) as f32 / BINS as f32;
            let part = (darkness.min(1.0 - darkness) - NARROWING[0]) / (NARROWING[1] - NARROWING[0]);
            // Two windows do not quite agree: the fraction below a greater threshold must not be less.
            most = most.max(wide[bin] + (*share - wide[bin]) * part.clamp(0.0, 1.0));
            *share = most;
        }
    }
    let share = |place: usize| {
        let (x, y) = (place % side_px, place / side_px);
        let between = |at: usize| {
            let at = (at as f32 + 0.5) / CELL_PX as f32 - 0.5 + cells as f32;
            (at as usize % cells, (at as usize + 1) % cells, at - at.floor())
        };
        let ((x0, x1, u), (y0, y1, v)) = (between(x), between(y));
        let bin = usize::from(bins[place]);
        let part = thresholds[place] * BINS as f32 - bin as f32;
        let at = |cell: usize| {
            let low = if bin == 0 { 0.0 } else { counts[cell][bin - 1] };
            low + (counts[cell][bin] - low) * part
        };
        let top = at(y0 * cells + x0) * (1.0 - u) + at(y0 * cells + x1) * u;
        let bottom = at(y1 * cells + x0) * (1.0 - u) + at(y1 * cells + x1) * u;
        top * (1.0 - v) + bottom * v
    };
    (0..thresholds.len()).into_par_iter().map(share).collect()
}

/// Returns the weights of a window, by cells: three boxes, which approximate a Gaussian to a few per cent.
fn kernel(cells: usize, window_px: f32) -> Vec<f32> {
    let window = window_px / CELL_PX as f32;
    // The variance of a box of 2r+1 is ((2r+1)² − 1) / 12.
    let radius = (window * window * 4.0 + 1.0).sqrt() / 2.0 - 0.5;
    let radius = (radius.round() as usize).min((cells - 1) / 6);
    let side = 2 * radius + 1;
    let mut weights = vec![1.0_f32];
    for _ in 0..3 {
        let mut wider = vec![0.0; weights.len() + side - 1];
        for (i, weight) in weights.iter().enumerate() {
            wider[i..i + side].iter_mut().for_each(|sum| *sum += weight / side as f32);
        }
        weights = wider;
    }
    weights
}

/// Returns sums weighted by `kernel` along one axis; its neighbours are `step` apart, lines are `line` apart. The tile
/// repeats.
fn blurred(counts: &[[f32; BINS]], cells: usize, kernel: &[f32], step: usize, line: usize) -> Vec<[f32; BINS]> {
    let middle = kernel.len() / 2;
    let mut sums = vec![[0.0; BINS]; counts.len()];
    for i in 0..cells {
        for j in 0..cells {
            let sum = &mut sums[i * line + j * step];
            for (k, weight) in kernel.iter().enumerate() {
                let from = (j + k + 4 * cells - middle) % cells;
                sum.iter_mut().zip(&counts[i * line + from * step]).for_each(|(sum, count)| *sum += weight * count);
            }
        }
    }
    sums
}
