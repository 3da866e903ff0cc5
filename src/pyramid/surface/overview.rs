//! The next coarser level: averages over the area of each coarse sample.
//!
//! A coarse sample covers `n/m` fine samples along an axis (2, or a little less for odd `n`), so up to three of them,
//! the outer ones partly; these shares are the weights. No-data carries no weight, and a coarse sample is valid where
//! at least half of the area under it is.

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

/// Rounding may leave a sliver of a sample at the end of a footprint; smaller shares count as 0.
const SLIVER: f64 = 1e-9;

impl Cover {
    /// Returns the samples of an axis of `fine` samples under the sample `c` of `coarse` samples.
    fn new(c: u32, fine: u32, coarse: u32) -> Self {
        let ratio = f64::from(fine) / f64::from(coarse);
        // One multiplication and one division each: exact where the ratio is 1 or 2.
        let start = f64::from(c) * f64::from(fine) / f64::from(coarse);
        let end = f64::from(c + 1) * f64::from(fine) / f64::from(coarse);
        let first = (start + SLIVER).floor() as usize;
        let last = ((end - SLIVER).ceil() as usize).min(fine as usize);
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

/// Averages a level into a region of the next coarser one. `field` contains at least [`cover_region`] of it; NaN is
/// no-data, there and in the result.
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
    if valid >= 0.5 - SLIVER { (sum / valid) as f32 } else { f32::NAN }
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
