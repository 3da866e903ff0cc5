//! Estimated statistics of tiles compared with the measured ones of a bake.
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

use crate::tests::common;

use std::sync::Arc;
use std::time::Instant;

use hachure::pyramid::store::{coarse_patches, derive};
use hachure::pyramid::surface::statistics::Voids;
use hachure::pyramid::{BakeOptions, LoadedTile, Pyramid, TileAddress, TileStore, bake};
use hachure::source::{HeightGrid, Silent, open, procedural};

/// The estimate and the measurement of every tile above level 0, and of every patch, of one land: (level, estimate,
/// measurement), in metres.
struct Comparison {
    name: String,
    tiles: Vec<(u32, f32, f32)>,
    patches: Vec<(u32, f32, f32)>,
}

fn addresses(pyramid: &Pyramid) -> Vec<TileAddress> {
    let mut all = Vec::new();
    for (level, size) in (0..).zip(pyramid.levels()) {
        for y in 0..size.tiles_y() {
            all.extend((0..size.tiles_x()).map(|x| TileAddress { level, x, y }));
        }
    }
    all
}

fn compare(name: &str, grid: &HeightGrid) -> Comparison {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("land.tif");
    bake(grid, &out, &BakeOptions::default(), &Silent).unwrap();
    let pyramid = Arc::new(Pyramid::open(&out).unwrap());
    let mut comparison = Comparison { name: name.to_owned(), tiles: Vec::new(), patches: Vec::new() };
    let mut spent = std::time::Duration::ZERO;
    let mut count = 0;
    for address in addresses(&pyramid) {
        let measured = pyramid.clone().load(address).unwrap();
        let tile = measured.tile.clone();
        let start = Instant::now();
        let derived = derive(pyramid.levels(), address, tile);
        spent += start.elapsed();
        count += 1;
        if address.level == 0 {
            same_at_level_0(&derived, &measured);
            continue;
        }
        if measured.statistics.voids != Voids::All {
            comparison.tiles.push((address.level, derived.statistics.error_m, measured.statistics.error_m));
        }
        for (derived, measured) in derived.patches.patches().iter().zip(measured.patches.patches()) {
            if measured.voids != Voids::All {
                comparison.patches.push((address.level, derived.mesh_error_m, measured.mesh_error_m));
            }
        }
    }
    println!("{name}: {:.2} ms a tile ({count})", spent.as_secs_f64() * 1e3 / f64::from(count));
    comparison
}

fn same_at_level_0(derived: &LoadedTile, measured: &LoadedTile) {
    // A sidecar stores the ranges of patches in steps of the tile's range, and errors in 16 bits, rounded outward.
    let step_m = (measured.statistics.max_m - measured.statistics.min_m) / 254.0;
    for (derived, measured) in derived.patches.patches().iter().zip(measured.patches.patches()) {
        assert_eq!(derived.voids, measured.voids);
        if derived.voids != Voids::All {
            assert!(measured.min_m <= derived.min_m && derived.min_m <= measured.min_m + step_m);
            assert!(measured.max_m >= derived.max_m && derived.max_m >= measured.max_m - step_m);
            let error_m = derived.mesh_error_m;
            assert!((error_m..=error_m * 1.002 + 1e-6).contains(&measured.mesh_error_m), "{derived:?} {measured:?}");
        }
    }
    assert_eq!(derived.statistics.min_m.to_bits(), measured.statistics.min_m.to_bits());
    assert_eq!(derived.statistics.max_m.to_bits(), measured.statistics.max_m.to_bits());
    assert_eq!(derived.statistics.voids, measured.statistics.voids);
    assert_eq!(derived.statistics.error_m, 0.0);
}

/// Returns the fraction of estimates that are not below the measurement, and the median of their ratios.
fn summary(what: &str, pairs: &[(u32, f32, f32)], factor: f32) -> (f64, f32) {
    // Below 2 cm the measurement is dominated by the rounding of heights.
    let mut ratios: Vec<f32> =
        pairs.iter().filter(|pair| pair.2 > 0.02).map(|(_, derived, measured)| factor * derived / measured).collect();
    ratios.sort_by(f32::total_cmp);
    let at = |share: f64| ratios[((ratios.len() - 1) as f64 * share) as usize];
    let safe = ratios.iter().filter(|&&ratio| ratio >= 1.0).count() as f64 / ratios.len() as f64;
    println!(
        "{what}: {} compared, {:.1} % not below the measurement; ratios {:.2} to {:.2}",
        ratios.len(),
        100.0 * safe,
        at(0.0),
        at(1.0)
    );
    println!("    5 % {:.2}, median {:.2}, 95 % {:.2}", at(0.05), at(0.5), at(0.95));
    (safe, at(0.5))
}

#[test]
fn estimates_are_near_and_mostly_above() {
    let mut lands = vec![compare("procedural", &procedural::generate_sized(1, 1000, 12.0, &Silent))];
    for name in ["mt_rainier_90m", "N46E008_alps", "N49W123", "mt_everest_90m"] {
        if let Some(path) = common::real_data(&format!("dem/geotiff/{name}.tif")) {
            lands.push(compare(name, &open(&path, &Silent).unwrap()));
        }
    }
    let all = |of: fn(&Comparison) -> &[(u32, f32, f32)]| lands.iter().flat_map(of).copied().collect::<Vec<_>>();
    for (what, pairs) in [("tiles", all(|land| &land.tiles)), ("patches", all(|land| &land.patches))] {
        for land in &lands {
            summary(
                &format!("{what} of {}", land.name),
                if what == "tiles" { &land.tiles } else { &land.patches },
                1.0,
            );
        }
        let (safe, median) = summary(what, &pairs, 1.0);
        assert!(
            safe >= 0.95 && median <= 3.0,
            "{what}: fraction not below the measurement {safe}, median ratio {median}"
        );
        // Planted error: half of the estimate.
        let (safe, _) = summary("half the estimates", &pairs, 0.5);
        assert!(lands.len() == 1 || safe < 0.9, "{what}: half of the estimate passes, for a fraction of {safe}");
    }
}

#[test]
fn wide_patches_are_safe_and_cover_all() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("land.tif");
    bake(&procedural::generate_sized(2, 700, 12.0, &Silent), &out, &BakeOptions::default(), &Silent).unwrap();
    let pyramid = Arc::new(Pyramid::open(&out).unwrap());
    let level = pyramid.levels().len() as u32 - 1;
    let address = TileAddress { level, x: 0, y: 0 };
    let top = derive(pyramid.levels(), address, pyramid.read_tile(address).unwrap());
    let derived = coarse_patches(pyramid.levels(), &top);
    let measured = pyramid.coarse_patches();
    assert_eq!(derived.iter().map(Vec::len).collect::<Vec<_>>(), measured.iter().map(Vec::len).collect::<Vec<_>>());
    assert_eq!(derived.last().map(Vec::len), Some(1));
    let mut planted_errors_found = 0;
    for (derived, measured) in derived.iter().flatten().zip(measured.iter().flatten()) {
        assert!(derived.mesh_error_m >= measured.mesh_error_m, "{derived:?} {measured:?}");
        assert!(derived.mesh_error_m <= 8.0 * measured.mesh_error_m, "{derived:?} {measured:?}");
        assert!(derived.min_m <= measured.min_m && derived.max_m >= measured.max_m, "{derived:?} {measured:?}");
        planted_errors_found += i32::from(derived.mesh_error_m / 3.0 < measured.mesh_error_m);
    }
    assert!(planted_errors_found > 0, "a third of the estimate passes everywhere");
}
