//! Tests the built-in world: a seed always gives the same bits, and the land drains.

use hachure::source::procedural::generate_sized;
use hachure::source::{HeightGrid, Silent};
use std::sync::OnceLock;
use std::time::Instant;

use crate::tests::common::full;

const SIZE: u32 = 384;
const SPACING_M: f64 = 32.0;

/// Returns worlds with their seeds, generated once: three, or one in the fast tier.
fn worlds() -> &'static [(u32, HeightGrid)] {
    static WORLDS: OnceLock<Vec<(u32, HeightGrid)>> = OnceLock::new();
    let seeds = 1..=if full() { 3 } else { 1 };
    WORLDS.get_or_init(|| seeds.map(|seed| (seed, generate_sized(seed, SIZE, SPACING_M, &Silent))).collect())
}

fn hash(grid: &HeightGrid) -> u64 {
    grid.heights_m.iter().fold(0xCBF2_9CE4_8422_2325, |hash, height_m| {
        (hash ^ u64::from(height_m.to_bits())).wrapping_mul(0x100_0000_01B3)
    })
}

#[test]
fn a_seed_gives_the_same_bits_on_any_number_of_threads() {
    let size = if full() { SIZE } else { 128 };
    let hash_of = |seed| hash(&generate_sized(seed, size, SPACING_M, &Silent));
    let started = Instant::now();
    let here = hash_of(7);
    println!("{size}² in {:.2} s", started.elapsed().as_secs_f64());
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        assert_eq!(pool.install(|| hash_of(7)), here, "{threads} threads");
    }
    assert_ne!(hash_of(8), here);
}

#[test]
fn heights_and_slopes_are_those_of_mountains() {
    for (seed, grid) in worlds() {
        assert_eq!(grid.heights_m.len(), (grid.width * grid.height) as usize);
        assert!(grid.heights_m.iter().all(|height_m| (250.0..3_300.0).contains(height_m)));
        let lowest = grid.heights_m.iter().copied().fold(f32::INFINITY, f32::min);
        let highest = grid.heights_m.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        assert!(highest - lowest > 1_000.0, "seed {seed}: {lowest} to {highest} m");

        let width = grid.width as usize;
        let mut slopes: Vec<f32> = inner(grid)
            .map(|i| {
                let east = grid.heights_m[i + 1] - grid.heights_m[i - 1];
                let north = grid.heights_m[i + width] - grid.heights_m[i - width];
                (east.hypot(north) / (2.0 * SPACING_M as f32)).atan().to_degrees()
            })
            .collect();
        slopes.sort_by(f32::total_cmp);
        let (median, steep) = (slopes[slopes.len() / 2], slopes[slopes.len() * 99 / 100]);
        println!("seed {seed}: {lowest:.0} to {highest:.0} m, slopes: median {median:.1}°, 99 % below {steep:.1}°");
        assert!((10.0..35.0).contains(&median), "seed {seed}: median slope {median}°");
        assert!((35.0..62.0).contains(&steep), "seed {seed}: 99th percentile {steep}°");
    }
}

/// Follows the steepest descent. A sample drains if its path reaches the border; height differences below 0.1 mm count
/// as level.
#[test]
fn the_land_drains_to_its_border() {
    for (seed, grid) in worlds() {
        let width = grid.width as usize;
        let offsets = [-1, 1, -(width as isize), width as isize].map(|o| (o, 1.0_f32)).into_iter();
        let diagonal = [-1 - width as isize, 1 - width as isize, width as isize - 1, width as isize + 1];
        let around: Vec<_> = offsets.chain(diagonal.map(|o| (o, std::f32::consts::SQRT_2))).collect();
        let mut below: Vec<usize> = (0..grid.heights_m.len()).collect();
        for index in inner(grid) {
            let mut steepest = 1.0e-4;
            for &(offset, distance) in &around {
                let neighbour = index.wrapping_add_signed(offset);
                let fall = (grid.heights_m[index] - grid.heights_m[neighbour]) / distance;
                if fall > steepest {
                    steepest = fall;
                    below[index] = neighbour;
                }
            }
        }
        let is_inner: Vec<bool> = {
            let mut flags = vec![false; below.len()];
            inner(grid).for_each(|index| flags[index] = true);
            flags
        };
        let drained = (0..below.len())
            .filter(|&start| {
                let mut index = start;
                while is_inner[index] && below[index] != index {
                    index = below[index];
                }
                !is_inner[index]
            })
            .count();
        let share = drained as f64 / below.len() as f64;
        println!("seed {seed}: {:.3} % of the land drains to the border", share * 100.0);
        assert!(share > 0.99, "seed {seed}: only {share} drains");
    }
}

#[test]
fn small_sizes_do_not_fail() {
    for (size, spacing_m) in [(0, 50.0), (2, 30.0), (17, 100.0), (33, 500.0)] {
        let grid = generate_sized(3, size, spacing_m, &Silent);
        assert!(grid.heights_m.len() >= 4 && grid.heights_m.iter().all(|height_m| height_m.is_finite()));
    }
}

/// Returns the indices of all samples except the outermost ring.
fn inner(grid: &HeightGrid) -> impl Iterator<Item = usize> + use<> {
    let (width, height) = (grid.width as usize, grid.height as usize);
    (1..height - 1).flat_map(move |row| (1..width - 1).map(move |column| row * width + column))
}
