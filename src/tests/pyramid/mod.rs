//! Tests the tile pyramid against its definitions, and against damage.
#![allow(clippy::disallowed_methods, reason = "a test may write damaged files")]
#![allow(clippy::unwrap_used, reason = "a test may panic")]

mod brute;
mod damage;
mod gdal;
mod world;

use std::path::Path;

use brute::Level;
use hachure::pyramid::surface::statistics::{TileStatistics, Voids};
use hachure::pyramid::tile::PATCH_QUADS;
use hachure::pyramid::{BakeOptions, Pyramid, TileAddress, bake};
use hachure::source::{HeightGrid, Silent};

fn baked(grid: &HeightGrid, out: &Path, max_error_m: f64) -> Pyramid {
    bake(grid, out, &BakeOptions { max_error_m }, &Silent).unwrap();
    Pyramid::open(out).unwrap()
}

fn tiles(pyramid: &Pyramid) -> Vec<TileAddress> {
    let mut addresses = Vec::new();
    for (level, size) in (0..).zip(pyramid.levels()) {
        for y in 0..size.tiles_y() {
            addresses.extend((0..size.tiles_x()).map(|x| TileAddress { level, x, y }));
        }
    }
    addresses
}

#[test]
fn lossless_comes_back_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("world.tif");
    let grid = world::grid();
    let pyramid = baked(&grid, &out, 0.0);
    let file = tiff_reader::TiffFile::open(&out).unwrap();
    let stored = file.read_image::<f32>(0).unwrap();
    for (stored, height) in stored.iter().zip(&grid.heights_m) {
        assert!(stored.to_bits() == height.to_bits() || stored.is_nan() && height.is_nan());
    }
    let level = Level::read(&pyramid, 0);
    for (i, height) in grid.heights_m.iter().enumerate() {
        assert_eq!(level.samples[i].to_bits() & 1 == 1, height.is_nan());
        assert!(level.samples[i].is_finite());
        assert!(height.is_nan() || level.samples[i].to_bits() == height.to_bits() & !1);
    }
    assert_eq!(pyramid.georeference(), &grid.georeference);
}

#[test]
fn lerc_keeps_its_bound_and_is_smaller() {
    let folder = tempfile::tempdir().unwrap();
    let grid = world::grid();
    let bound_m = 0.05;
    let exact = bake(&grid, &folder.path().join("a.tif"), &BakeOptions::default(), &Silent).unwrap();
    let lossy = bake(&grid, &folder.path().join("b.tif"), &BakeOptions { max_error_m: bound_m }, &Silent).unwrap();
    assert!(lossy.tif_bytes < exact.tif_bytes * 2 / 3, "{} against {}", lossy.tif_bytes, exact.tif_bytes);
    let pyramid = Pyramid::open(&lossy.path).unwrap();
    assert_eq!(pyramid.max_error_m(), bound_m);
    let level = Level::read(&pyramid, 0);
    let mut worst = 0.0_f64;
    for (stored, height) in level.samples.iter().zip(&grid.heights_m) {
        assert_eq!(stored.to_bits() & 1 == 1, height.is_nan());
        if !height.is_nan() {
            worst = worst.max((f64::from(*stored) - f64::from(*height)).abs());
        }
    }
    // Rounding of f32 and the no-data flag take one unit in the last place.
    assert!(worst > 0.01 && worst < bound_m + 1e-3, "{worst}");
    let measured = tiles(&pyramid).into_iter().filter(|tile| tile.level == 0).map(|tile| pyramid.tile(tile).error_m);
    assert!((f64::from(measured.fold(0.0, f32::max)) - worst).abs() < 1e-6);
}

/// Returns whether a measured error equals the brute-force one, raised to that of its children.
fn agrees(measured_m: f32, brute_m: f64, children_m: f32) -> bool {
    let expected = brute_m.max(children_m.into());
    (f64::from(measured_m) - expected).abs() <= 1e-4 * expected + 1e-6
}

fn child_tiles(tile: TileAddress) -> impl Iterator<Item = TileAddress> {
    (0..4).filter(move |_| tile.level > 0).map(move |i| TileAddress {
        level: tile.level.wrapping_sub(1),
        x: 2 * tile.x + i % 2,
        y: 2 * tile.y + i / 2,
    })
}

#[test]
fn tile_errors_are_what_brute_force_finds() {
    let folder = tempfile::tempdir().unwrap();
    let grid = world::grid();
    for max_error_m in [0.0, 0.2] {
        let pyramid = baked(&grid, &folder.path().join("world.tif"), max_error_m);
        let mut planted_errors_found = 0;
        for level in 0..pyramid.levels().len() as u32 {
            let samples = Level::read(&pyramid, level);
            let brute_m = brute::tile_errors_m(&grid, &samples);
            let here = tiles(&pyramid).into_iter().filter(|tile| tile.level == level);
            for (tile, brute_m) in here.zip(brute_m) {
                let statistics = pyramid.tile(tile);
                let all = tiles(&pyramid);
                let children_m = child_tiles(tile)
                    .filter(|child| all.contains(child))
                    .map(|child| pyramid.tile(child).error_m)
                    .fold(0.0, f32::max);
                assert!(statistics.error_m >= children_m, "monotone toward the root");
                assert!(agrees(statistics.error_m, brute_m, children_m), "{tile:?} {statistics:?} {brute_m}");
                // Planted error: a statistic of half the size must not pass.
                if statistics.error_m > 1e-3 {
                    assert!(!agrees(statistics.error_m / 2.0, brute_m, children_m));
                    planted_errors_found += 1;
                }
                let children = child_tiles(tile).filter(|child| all.contains(child)).map(|child| pyramid.tile(child));
                let range =
                    children.fold([f32::NAN; 2], |range, child| [range[0].min(child.min_m), range[1].max(child.max_m)]);
                check_range(&samples, tile, range, statistics);
            }
        }
        assert!(planted_errors_found > 0);
    }
}

fn check_range(level: &Level, tile: TileAddress, children_m: [f32; 2], found: &TileStatistics) {
    let span = |tile: u32, count: usize| {
        let first = tile as usize * 256;
        first.saturating_sub(1)..(first + 257).min(count)
    };
    let mut samples = Vec::new();
    for row in span(tile.y, level.height) {
        samples.extend(span(tile.x, level.width).map(|column| level.samples[row * level.width + column]));
    }
    let valid: Vec<f32> = samples.iter().copied().filter(|sample| sample.to_bits() & 1 == 0).collect();
    assert_eq!(found.min_m.to_bits(), valid.iter().copied().fold(children_m[0], f32::min).to_bits());
    assert_eq!(found.max_m.to_bits(), valid.iter().copied().fold(children_m[1], f32::max).to_bits());
    let expected = match valid.len() {
        0 => Voids::All,
        count if count == samples.len() => Voids::None,
        _ => Voids::Some,
    };
    assert_eq!(found.voids, expected);
}

#[test]
fn mesh_errors_are_what_brute_force_finds() {
    let folder = tempfile::tempdir().unwrap();
    let grid = world::grid();
    let pyramid = baked(&grid, &folder.path().join("world.tif"), 0.0);
    let finest = Level::read(&pyramid, 0);
    assert_eq!(pyramid.patch_counts(0), (38, 31));
    assert_eq!(pyramid.patch_counts(pyramid.patch_levels() - 1), (1, 1));
    assert_eq!(pyramid.patch_levels(), 7);
    for j in 0..pyramid.patch_levels() {
        let (count_x, count_y) = pyramid.patch_counts(j);
        assert!(pyramid.patch(j, count_x, 0).is_none() && pyramid.patch(j, 0, count_y).is_none());
        for (y, x) in (0..count_y).flat_map(|y| (0..count_x).map(move |x| (y, x))) {
            let patch = pyramid.patch(j, x, y).unwrap();
            let brute_m = brute::mesh_error_m(&grid, &finest, j, x as usize, y as usize);
            let children_m = (0..4)
                .filter_map(|i| pyramid.patch(j.checked_sub(1)?, 2 * x + i % 2, 2 * y + i / 2))
                .map(|child| child.mesh_error_m)
                .fold(0.0, f32::max);
            assert!(patch.mesh_error_m >= children_m, "monotone toward the root");
            // These errors are stored in 16 bits, rounded up.
            let agrees = |found_m: f32| {
                let expected_m = brute_m.max(children_m.into());
                let found_m = f64::from(found_m);
                found_m >= expected_m * (1.0 - 1e-5) - 1e-6 && found_m <= expected_m * (1.0 + 2e-3) + 1e-6
            };
            assert!(agrees(patch.mesh_error_m), "{j} {x} {y} {patch:?} {brute_m} {children_m}");
            if patch.mesh_error_m > 1e-3 {
                assert!(!agrees(patch.mesh_error_m * 0.99), "a planted error was not detected");
            }
            // The page of a tile stores the heights of its patches in steps of the tile's range; coarser patches have
            // no page.
            let tile = TileAddress { level: j, x: x / 16, y: y / 16 };
            let step_m = match pyramid.levels().len() > j as usize {
                true => (pyramid.tile(tile).max_m - pyramid.tile(tile).min_m) / 255.0,
                false => 0.0,
            };
            check_patch_range(&finest, j, x as usize, y as usize, patch, step_m);
        }
    }
}

fn check_patch_range(
    finest: &Level,
    j: u32,
    x: usize,
    y: usize,
    patch: &hachure::pyramid::surface::statistics::PatchStatistics,
    step_m: f32,
) {
    let side = 16_usize << j;
    let mut valid = Vec::new();
    let mut voids = 0;
    for row in y * side..=((y + 1) * side).min(finest.height - 1) {
        for column in x * side..=((x + 1) * side).min(finest.width - 1) {
            match finest.void(column, row) {
                true => voids += 1,
                false => valid.push(finest.samples[row * finest.width + column]),
            }
        }
    }
    let below = valid.iter().copied().fold(f32::NAN, f32::min) - patch.min_m;
    let above = patch.max_m - valid.iter().copied().fold(f32::NAN, f32::max);
    for off_m in [below, above].into_iter().filter(|_| !valid.is_empty()) {
        assert!((0.0..=step_m * 1.01 + step_m.signum() * 1e-3).contains(&off_m), "{patch:?}: off by {off_m}");
    }
    let expected = match (valid.len(), voids) {
        (0, _) => Voids::All,
        (_, 0) => Voids::None,
        _ => Voids::Some,
    };
    assert_eq!(patch.voids, expected);
}

#[test]
fn neighbouring_tiles_share_their_borders_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let grid = world::grid();
    let pyramid = baked(&grid, &folder.path().join("world.tif"), 0.0);
    let mut shared = 0;
    for address in tiles(&pyramid) {
        let tile = pyramid.read_tile(address).unwrap();
        assert_eq!(tile.samples.len(), 260 * 260);
        assert!(tile.samples.iter().all(|sample| sample.is_finite()));
        let level = Level::read(&pyramid, address.level);
        for row in 0..260 {
            for column in 0..260 {
                // The level is composed of the inner samples of the tiles, so borders are compared with the neighbours.
                let (x, y) = (address.x as isize * 256 + column - 2, address.y as isize * 256 + row - 2);
                let (x, y) = (x.clamp(0, level.width as isize - 1), y.clamp(0, level.height as isize - 1));
                let expected = level.samples[y as usize * level.width + x as usize];
                assert_eq!(tile.samples[(row * 260 + column) as usize].to_bits(), expected.to_bits());
                shared += 1;
            }
        }
    }
    assert!(shared > 260 * 260);
}

#[test]
fn fills_are_smooth_and_within_the_data() {
    let folder = tempfile::tempdir().unwrap();
    let grid = world::grid();
    let pyramid = baked(&grid, &folder.path().join("world.tif"), 0.0);
    for level in 0..pyramid.levels().len() as u32 {
        let level = Level::read(&pyramid, level);
        let (low, high) = (f64::from(pyramid.min_m()) - 0.01, f64::from(pyramid.max_m()) + 0.01);
        assert!(level.samples.iter().all(|&sample| (low..=high).contains(&f64::from(sample))));
    }
}

#[test]
fn ground_queries_follow_the_surface() {
    let folder = tempfile::tempdir().unwrap();
    let grid = world::grid();
    let pyramid = baked(&grid, &folder.path().join("world.tif"), 0.0);
    let level = Level::read(&pyramid, 0);
    let mut voids = 0;
    for i in 0..4000 {
        let (x, y) = (f64::from(i) * 600.0 / 3999.0, f64::from(i * 37 % 4000) * 486.0 / 3999.0);
        let (cx, cy) = ((x as usize).min(599), (y as usize).min(485));
        let void = [(0, 0), (1, 0), (0, 1), (1, 1)].iter().any(|(i, k)| level.void(cx + i, cy + k));
        match pyramid.height_m(x, y) {
            None => voids += i32::from(void),
            Some(height) => assert!(!void && (height - level.surface(x, y)).abs() < 1e-9),
        }
        assert_eq!(pyramid.height_m(x, y).is_none(), void);
    }
    assert!(voids > 100);
    for (x, y) in [(-0.01, 5.0), (600.01, 5.0), (5.0, -0.01), (5.0, 486.01), (f64::NAN, 5.0), (5.0, f64::INFINITY)] {
        assert_eq!(pyramid.height_m(x, y), None);
    }
    let (x, y) = (100.0, 100.0);
    assert_eq!(pyramid.height_m(x, y), Some(level.at(100, 100)));
}

#[test]
fn levels_average_the_area_under_their_samples() {
    // A ramp of odd size: any error of registration would shift it.
    let folder = tempfile::tempdir().unwrap();
    let mut grid = world::rough(515, 259, false);
    grid.heights_m = (0..515 * 259).map(|i| (i % 515) as f32 + 2.0 * (i / 515) as f32).collect();
    let pyramid = baked(&grid, &folder.path().join("ramp.tif"), 0.0);
    let sizes: Vec<_> = pyramid.levels().iter().map(|size| (size.width, size.height)).collect();
    assert_eq!(sizes, [(515, 259), (258, 130), (129, 65)]);
    for level in 1..3 {
        let samples = Level::read(&pyramid, level);
        for row in 0..samples.height {
            for column in 0..samples.width {
                let x = (column as f64 + 0.5) * 515.0 / samples.width as f64 - 0.5;
                let y = (row as f64 + 0.5) * 259.0 / samples.height as f64 - 0.5;
                let height = samples.at(column as isize, row as isize);
                // The mean of a step function over a fractional footprint is within 1/8 sample of the ramp.
                assert!((height - (x + 2.0 * y)).abs() < 0.4, "{level} {column} {row}: {height}");
            }
        }
    }
}

#[test]
fn tiles_are_read_from_many_threads() {
    let folder = tempfile::tempdir().unwrap();
    let pyramid = baked(&world::grid(), &folder.path().join("world.tif"), 0.0);
    let once: Vec<_> = tiles(&pyramid).into_iter().map(|tile| pyramid.read_tile(tile).unwrap()).collect();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for (tile, expected) in tiles(&pyramid).into_iter().zip(&once) {
                    assert!(pyramid.read_tile(tile).unwrap() == *expected);
                }
            });
        }
    });
}

#[test]
fn small_and_narrow_grids_have_pyramids() {
    let folder = tempfile::tempdir().unwrap();
    for (width, height) in [(2, 2), (2, 700), (700, 2), (33, 33), (34, 33), (257, 256)] {
        let grid = world::rough(width, height, false);
        let pyramid = baked(&grid, &folder.path().join("small.tif"), 0.0);
        for tile in tiles(&pyramid) {
            pyramid.read_tile(tile).unwrap();
        }
        let (count_x, count_y) = pyramid.patch_counts(0);
        assert_eq!((count_x, count_y), ((width - 1).div_ceil(PATCH_QUADS), (height - 1).div_ceil(PATCH_QUADS)));
        let h = pyramid.height_m(f64::from(width - 1), f64::from(height - 1)).unwrap();
        assert!((h - f64::from(grid.heights_m[grid.heights_m.len() - 1])).abs() < 1e-3);
    }
}
