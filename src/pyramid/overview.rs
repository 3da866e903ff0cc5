//! The next coarser level: the average over the area that each coarse sample covers.
//!
//! A coarse sample covers `n/m` fine samples along an axis (2, or a little less for odd `n`), so up to three of them,
//! the outer ones in part; their shares are the weights. Voids carry no weight, and a coarse sample is valid where at
//! least half of the area under it is.

use rayon::prelude::*;

use super::levels::{LevelSize, Region};

/// The fine samples under one coarse sample along an axis: the first of them, how many, and their shares of the
/// coarse sample's width (sum 1).
struct Cover {
    first: usize,
    count: usize,
    shares: [f64; 3],
}

/// Rounding may leave a sliver of a sample at the end of a footprint; shares below this are none.
const SLIVER: f64 = 1e-9;

fn covers(fine: u32, coarse: u32) -> Vec<Cover> {
    (0..coarse).map(|c| cover(c, fine, coarse)).collect()
}

fn cover(c: u32, fine: u32, coarse: u32) -> Cover {
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
    Cover { first, count: last - first, shares }
}

/// The fine samples under a region of the coarse level, which is not empty.
pub fn under(region: Region, fine: LevelSize, coarse: LevelSize) -> Region {
    let span = |first: u32, count: u32, fine: u32, coarse: u32| {
        let last = cover(first + count - 1, fine, coarse);
        let first = cover(first, fine, coarse).first as u32;
        (first, (last.first + last.count) as u32 - first)
    };
    let (x, width) = span(region.x, region.width, fine.width, coarse.width);
    let (y, height) = span(region.y, region.height, fine.height, coarse.height);
    Region { x, y, width, height }
}

/// A region of the coarse level from the fine samples that [`under`] names: the same bits as [`next_level`] gives.
pub fn averaged(heights_m: &[f32], region: Region, fine: LevelSize, coarse: LevelSize) -> Vec<f32> {
    let held = under(region, fine, coarse);
    let covers = |first: u32, count: u32, origin: u32, fine: u32, coarse: u32| -> Vec<Cover> {
        let inside = |cover: Cover| Cover { first: cover.first - origin as usize, ..cover };
        (first..first + count).map(|c| inside(cover(c, fine, coarse))).collect()
    };
    let columns = covers(region.x, region.width, held.x, fine.width, coarse.width);
    let rows = covers(region.y, region.height, held.y, fine.height, coarse.height);
    let mut averages = Vec::with_capacity(region.samples());
    for row in &rows {
        averages.extend(columns.iter().map(|column| average(heights_m, held.width as usize, column, row)));
    }
    averages
}

/// Averages a level into the next coarser one. `heights_m` is row-major with NaN for voids, and so is the result.
pub fn next_level(heights_m: &[f32], fine: LevelSize, coarse: LevelSize) -> Vec<f32> {
    let columns = covers(fine.width, coarse.width);
    let rows = covers(fine.height, coarse.height);
    let mut averages = vec![f32::NAN; coarse.samples()];
    averages.par_chunks_mut(coarse.width as usize).zip(&rows).for_each(|(out, row)| {
        for (out, column) in out.iter_mut().zip(&columns) {
            *out = average(heights_m, fine.width as usize, column, row);
        }
    });
    averages
}

fn average(heights_m: &[f32], width: usize, column: &Cover, row: &Cover) -> f32 {
    let mut valid = 0.0;
    let mut sum = 0.0;
    for (k, row_share) in row.shares.iter().enumerate().take(row.count) {
        let start = (row.first + k) * width + column.first;
        for (height, column_share) in heights_m[start..start + column.count].iter().zip(&column.shares) {
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
            for cover in covers(fine, coarse) {
                assert!((cover.shares.iter().sum::<f64>() - 1.0).abs() < 1e-9);
                for k in 0..cover.count {
                    total[cover.first + k] += cover.shares[k] * f64::from(fine) / f64::from(coarse);
                }
            }
            assert!(total.iter().all(|share| (share - 1.0).abs() < 1e-6), "{fine}");
        }
    }

    #[test]
    fn a_region_is_a_part_of_the_level() {
        for (fine, coarse) in [((601, 487), (301, 244)), ((500, 300), (501, 301)), ((64, 64), (32, 32))] {
            let fine = LevelSize { width: fine.0, height: fine.1 };
            let coarse = LevelSize { width: coarse.0, height: coarse.1 };
            let height = |i: usize| if i % 7 == 3 { f32::NAN } else { (i * 2_654_435_761 % 1000) as f32 };
            let heights_m: Vec<f32> = (0..fine.samples()).map(height).collect();
            let whole = next_level(&heights_m, fine, coarse);
            for region in [coarse.region(), Region { x: 5, y: 9, width: 20, height: 17 }] {
                let held = under(region, fine, coarse);
                let cut = |size: LevelSize, region: Region, level: &[f32]| -> Vec<f32> {
                    let row = |y: u32| (y * size.width + region.x) as usize;
                    let rows = (region.y..region.y + region.height)
                        .flat_map(|y| level[row(y)..row(y) + region.width as usize].iter().copied());
                    rows.collect()
                };
                let part = averaged(&cut(fine, held, &heights_m), region, fine, coarse);
                let expected = cut(coarse, region, &whole);
                let same = |(a, b): (&f32, &f32)| a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan();
                assert!(part.len() == expected.len() && part.iter().zip(&expected).all(same));
            }
        }
    }

    #[test]
    fn half_the_area_decides() {
        let (fine, coarse) = (LevelSize { width: 4, height: 2 }, LevelSize { width: 2, height: 1 });
        let void = f32::NAN;
        let averages = next_level(&[1.0, void, 5.0, void, void, 3.0, void, void], fine, coarse);
        assert_eq!(averages[0], 2.0);
        assert!(averages[1].is_nan());
    }
}
