//! The stated errors are upper bounds of the real ones, in all rounds.

use hachure::pyramid::Voids;

use crate::brute::{self, Level};
use crate::{baked, tiles, world};

#[test]
fn tile_errors_bound_the_surface() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [(true, 0.05), (true, 0.0), (false, 0.0)];
    for (voids, max_error_m) in cases.into_iter().take(if crate::full() { 3 } else { 1 }) {
        let grid = world::rough(1301, 1143, voids);
        let (pyramid, _) = baked(&grid, &folder.path().join("a.tif"), max_error_m, 1);
        let (mut tight, mut planted) = (0, 0);
        for level in 0..pyramid.levels().len() as u32 {
            let samples = Level::read(&pyramid, level);
            for (tile, brute_m) in tiles(&pyramid, level).into_iter().zip(brute::tile_errors_m(&grid, &samples)) {
                let stated_m = f64::from(pyramid.tile(tile).error_m);
                assert!(stated_m >= brute_m * (1.0 - 1e-6), "{tile:?}: stated {stated_m} m, true {brute_m} m");
                // A later round may add the error of the previous one, but not much more.
                tight += i32::from(stated_m < 1.5 * brute_m + 1.0);
                planted += i32::from(stated_m * 0.99 < brute_m);
            }
        }
        assert!(planted > 0, "bounds that are one per cent lower would pass");
        assert!(tight > 5, "the bounds are loose");
    }
}

#[test]
fn mesh_errors_bound_the_triangles() {
    let folder = tempfile::tempdir().unwrap();
    let cases = [(1030, 777, true), (1301, 1143, false)];
    for (width, height, voids) in cases.into_iter().take(if crate::full() { 2 } else { 1 }) {
        let grid = world::rough(width, height, voids);
        let (pyramid, _) = baked(&grid, &folder.path().join("a.tif"), 0.0, 1);
        let finest = Level::read(&pyramid, 0);
        let (mut planted, mut coarse) = (0, 0);
        for j in 0..pyramid.patch_levels() {
            let (count_x, count_y) = pyramid.patch_counts(j);
            for (y, x) in (0..count_y).flat_map(|y| (0..count_x).map(move |x| (y, x))) {
                let patch = pyramid.patch(j, x, y).unwrap();
                if patch.voids != Voids::None {
                    continue;
                }
                let brute_m = brute::mesh_error_m(&grid, &finest, j, x as usize, y as usize);
                let stated_m = f64::from(patch.mesh_error_m);
                assert!(
                    stated_m >= brute_m * (1.0 - 1e-5) - 1e-6,
                    "patch {j} {x} {y}: stated {stated_m} m, true {brute_m} m"
                );
                planted += i32::from(stated_m * 0.99 < brute_m);
                coarse += i32::from(j > 1);
            }
        }
        assert!(planted > 0 && coarse > 0);
    }
}

/// Tests islands of a few samples in wide no-data, which only the coarsest levels fill.
#[test]
fn lonely_islands_are_bounded_too() {
    let folder = tempfile::tempdir().unwrap();
    let mut grid = world::rough(2100, 1200, false);
    let width = grid.width as usize;
    for (i, height) in grid.heights_m.iter_mut().enumerate() {
        let (x, y) = (i % width, i / width);
        let land = x < 150;
        let islet = x % 400 < 3 && y % 400 < 2;
        let island = x % 700 < 12 && y % 600 < 9;
        if !(land || islet || island) {
            *height = f32::NAN;
        }
    }
    for max_error_m in [0.0, 0.1].into_iter().take(if crate::full() { 2 } else { 1 }) {
        let (pyramid, _) = baked(&grid, &folder.path().join("a.tif"), max_error_m, 1);
        let (whole, _) = baked(&grid, &folder.path().join("b.tif"), max_error_m, 4);
        for level in 0..pyramid.levels().len() as u32 {
            let samples = Level::read(&pyramid, level);
            for (tile, brute_m) in tiles(&pyramid, level).into_iter().zip(brute::tile_errors_m(&grid, &samples)) {
                let stated_m = f64::from(pyramid.tile(tile).error_m);
                assert!(stated_m >= brute_m * (1.0 - 1e-6), "{tile:?}: stated {stated_m} m, true {brute_m} m");
                if level <= 1 && max_error_m == 0.0 {
                    let expected_m = f64::from(whole.tile(tile).error_m);
                    assert!(
                        (stated_m - expected_m).abs() <= 1e-6 * expected_m,
                        "{tile:?}: stated {stated_m} m, baked whole {expected_m} m"
                    );
                }
            }
        }
    }
}
