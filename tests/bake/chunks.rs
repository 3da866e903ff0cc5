//! A grid baked in chunks equals the grid baked whole.

use std::fs;

use hachure::pyramid::Pyramid;
use hachure::pyramid::Voids;

use crate::{baked, tiles, world};

fn near(a: f32, b: f32) -> bool {
    a.to_bits() == b.to_bits() || (a - b).abs() <= 1e-6 * b.abs()
}

/// Compares the statistics of tiles and patches: equal in the first round, and above it not lower and only a little
/// higher.
fn check_statistics(chunked: &Pyramid, whole: &Pyramid, chunk_levels: u32, max_error_m: f32) {
    assert_eq!((chunked.min_m(), chunked.max_m()), (whole.min_m(), whole.max_m()));
    assert_eq!(chunked.void_samples(), whole.void_samples());
    // Three heights from outside the chunk may each be off by the codec's bound, times the kernel's weights.
    let doubt_m = if max_error_m > 0.0 { 3.2 * max_error_m + 0.01 } else { 0.0 };
    let mut coarse = 0;
    for level in 0..whole.levels().len() as u32 {
        for tile in tiles(whole, level) {
            let (found, expected) = (chunked.tile(tile), whole.tile(tile));
            assert_eq!(found.voids, expected.voids, "{tile:?}: no-data differs");
            if max_error_m == 0.0 {
                let bits = |m: f32| m.to_bits();
                assert_eq!((bits(found.min_m), bits(found.max_m)), (bits(expected.min_m), bits(expected.max_m)));
            } else if expected.voids != Voids::All {
                assert!(found.min_m <= expected.min_m && found.min_m >= expected.min_m - doubt_m, "{tile:?}");
                assert!(found.max_m >= expected.max_m && found.max_m <= expected.max_m + doubt_m, "{tile:?}");
            }
            if level <= chunk_levels && max_error_m == 0.0 {
                assert!(near(found.error_m, expected.error_m), "{tile:?} {found:?} {expected:?}");
            } else {
                assert!(found.error_m >= expected.error_m * (1.0 - 1e-6), "{tile:?} {found:?} {expected:?}");
                let error_bound_m = if level <= chunk_levels { expected.error_m + doubt_m } else { f32::INFINITY };
                assert!(found.error_m <= error_bound_m, "{tile:?} {found:?} {expected:?}");
                coarse += i32::from(level > chunk_levels);
            }
        }
    }
    assert!(coarse > 0, "the test has no level of a later round");
    let mut same = 0;
    for j in 0..whole.patch_levels() {
        let (count_x, count_y) = whole.patch_counts(j);
        for (x, y) in (0..count_y).flat_map(|y| (0..count_x).map(move |x| (x, y))) {
            let (found, expected) = (chunked.patch(j, x, y).unwrap(), whole.patch(j, x, y).unwrap());
            assert_eq!(found.voids, expected.voids);
            if max_error_m == 0.0 && j <= chunk_levels && expected.voids == Voids::None {
                assert_eq!(found, expected, "{j} {x} {y}");
                same += 1;
            } else if expected.voids == Voids::None {
                assert!(found.mesh_error_m >= expected.mesh_error_m, "{j} {x} {y} {found:?} {expected:?}");
            }
        }
    }
    assert!(max_error_m > 0.0 || same > 0);
}

#[test]
fn chunked_is_whole_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("whole.tif"), folder.path().join("chunked.tif"));
    let sizes = [(513, 3001, 2), (1301, 1543, 1), (257, 1000, 1), (2570, 2057, 2), (2570, 2057, 1)];
    let [sizes_used, cases_used] = if crate::full() { [5, 3] } else { [2, 2] };
    for (width, height, chunk_levels) in sizes.into_iter().take(sizes_used) {
        for (voids, max_error_m) in [(true, 0.0), (true, 0.05), (false, 0.05)].into_iter().take(cases_used) {
            let grid = world::rough(width, height, voids);
            // A single chunk.
            let (whole, _) = baked(&grid, &a, max_error_m, 4);
            let (chunked, report) = baked(&grid, &b, max_error_m, chunk_levels);
            assert!(
                fs::read(&a).unwrap() == fs::read(&b).unwrap(),
                "{width} × {height}, {chunk_levels} levels per chunk, error {max_error_m} m: the files differ"
            );
            assert_eq!(report.tif_bytes, fs::metadata(&b).unwrap().len());
            check_statistics(&chunked, &whole, chunk_levels, max_error_m as f32);
        }
    }
}

#[test]
fn threads_change_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let [width, height] = if crate::full() { [1301, 1543] } else { [801, 1043] };
    let grid = world::rough(width, height, true);
    let mut first: Option<[Vec<u8>; 2]> = None;
    for threads in [1, 7, 2].into_iter().take(if crate::full() { 3 } else { 2 }) {
        let out = folder.path().join("a.tif");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| drop(baked(&grid, &out, 0.02, 1)));
        let files = [fs::read(&out).unwrap(), fs::read(hachure::internals::sidecar_path(&out)).unwrap()];
        assert!(first.get_or_insert_with(|| files.clone()) == &files, "{threads} threads give other files");
    }
}
