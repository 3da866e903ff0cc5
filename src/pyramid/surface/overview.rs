//! The next coarser level: averages over the area of each coarse sample.
//!
//! An axis of `n` fine samples has `m = ⌈n/2⌉` coarse ones, and a coarse sample covers `n/m` fine ones: 2 for even `n`,
//! less for odd `n`. So it covers up to three of them, the outer ones partly; the shares of its width are the weights.
//! No-data carries no weight. A coarse sample is valid if at least half of its area is.

use rayon::prelude::*;

use super::field::Field;
use super::levels::{LevelSize, Region};

/// The fine samples under a coarse sample along an axis: the first of them, how many, and their shares of the coarse
/// sample's width (sum 1).
struct Cover {
    first: usize,
    count: usize,
    shares: [f64; 3],
}

/// Tolerance for rounding errors: at the ends of a cover in fine samples, and of the valid part of a coarse sample.
const ROUNDING: f64 = 1e-9;

impl Cover {
    /// Returns the cover of coarse sample `c` on an axis with `fine` fine and `coarse` coarse samples.
    fn new(c: u32, fine: u32, coarse: u32) -> Self {
        let ratio = f64::from(fine) / f64::from(coarse);
        // One multiplication and one division each: exact where the ratio is 1 or 2.
        let start = f64::from(c) * f64::from(fine) / f64::from(coarse);
        let end = f64::from(c + 1) * f64::from(fine) / f64::from(coarse);
        let first = (start + ROUNDING).floor() as usize;
        let last = ((end - ROUNDING).ceil() as usize).min(fine as usize);
        let mut shares = [0.0; 3];
        for (k, share) in shares.iter_mut().enumerate().take(last - first) {
            let sample = (first + k) as f64;
            *share = ((sample + 1.0).min(end) - sample.max(start)) / ratio;
        }
        Self { first, count: last - first, shares }
    }
}

/// Returns the fine samples under a region of the coarse level.
pub(crate) fn cover_region(region: Region, fine: LevelSize, coarse: LevelSize) -> Region {
    let span = |first: u32, count: u32, fine: u32, coarse: u32| {
        let (a, b) = (Cover::new(first, fine, coarse), Cover::new(first + count - 1, fine, coarse));
        (a.first as u32, (b.first + b.count - a.first) as u32)
    };
    let (x, width) = span(region.x, region.width, fine.width, coarse.width);
    let (y, height) = span(region.y, region.height, fine.height, coarse.height);
    Region { x, y, width, height }
}

/// Averages a level into `region` of the next coarser one. `field` must contain the [`cover_region`] of `region`; NaN
/// is no-data, in `field` and in the result.
pub(crate) fn next_level(field: &Field, fine: LevelSize, coarse: LevelSize, region: Region) -> Field {
    let mut heights_m = vec![f32::NAN; region.samples()];
    average_into(field, fine, coarse, region, &mut heights_m);
    Field { region, heights_m }
}

/// Averages like [`next_level`] into `heights_m`, which holds the samples of `region`, row-major.
pub(crate) fn average_into(field: &Field, fine: LevelSize, coarse: LevelSize, region: Region, heights_m: &mut [f32]) {
    let covers = |first: u32, count: u32, fine: u32, coarse: u32| -> Vec<Cover> {
        (first..first + count).map(|c| Cover::new(c, fine, coarse)).collect()
    };
    let columns = covers(region.x, region.width, fine.width, coarse.width);
    let rows = covers(region.y, region.height, fine.height, coarse.height);
    heights_m.par_chunks_mut(region.width as usize).zip(&rows).for_each(|(out, row)| {
        for (out, column) in out.iter_mut().zip(&columns) {
            *out = average(field, column, row);
        }
    });
}

/// Returns the height of the coarse sample that covers these columns and rows; NaN if it is not valid.
fn average(field: &Field, column: &Cover, row: &Cover) -> f32 {
    let mut valid = 0.0;
    let mut sum = 0.0;
    for (k, row_share) in row.shares.iter().enumerate().take(row.count) {
        let heights_m = field.span(column.first as u32, (row.first + k) as u32, column.count as u32);
        for (height, column_share) in heights_m.iter().zip(&column.shares) {
            if !height.is_nan() {
                valid += row_share * column_share;
                sum += row_share * column_share * f64::from(*height);
            }
        }
    }
    if valid >= 0.5 - ROUNDING { (sum / valid) as f32 } else { f32::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_fill_the_area_once() {
        for fine in [2, 3, 5, 257, 601, 1024, 1201] {
            let coarse = u32::div_ceil(fine, 2);
            let mut total = vec![0.0; fine as usize];
            for cover in (0..coarse).map(|c| Cover::new(c, fine, coarse)) {
                assert!((cover.shares.iter().sum::<f64>() - 1.0).abs() < 1e-9);
                for k in 0..cover.count {
                    total[cover.first + k] += cover.shares[k] * f64::from(fine) / f64::from(coarse);
                }
            }
            assert!(total.iter().all(|share| (share - 1.0).abs() < 1e-6), "{fine}");
        }
    }

    #[test]
    fn half_the_area_decides() {
        let (fine, coarse) = (LevelSize { width: 4, height: 2 }, LevelSize { width: 2, height: 1 });
        let void = f32::NAN;
        let heights_m = vec![1.0, void, 5.0, void, void, 3.0, void, void];
        let averages = next_level(&Field { region: fine.region(), heights_m }, fine, coarse, coarse.region());
        assert_eq!(averages.at(0, 0), 2.0);
        assert!(averages.at(1, 0).is_nan());
    }
}
