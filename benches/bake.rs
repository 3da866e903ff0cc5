//! Measures how long a bake takes: 321 × 321 and 2000 × 2000 samples, lossless and within 5 cm, including writing,
//! reading back and measuring errors; and how long the same heights take in memory.
#![allow(missing_docs, reason = "criterion generates the functions")]

use criterion::{Criterion, criterion_group, criterion_main};
use hachure::pyramid::store::MemoryStore;
use hachure::pyramid::{BakeOptions, bake};
use hachure::source::georeference::{Crs, Georeference};
use hachure::source::{HeightGrid, Silent};

fn hills(side: u32) -> HeightGrid {
    let height = |i: u32| {
        let (x, y) = ((i % side) as f32, (i / side) as f32);
        900.0
            + 400.0 * (x * 0.004).sin() * (y * 0.003).cos()
            + 30.0 * (x * 0.05 + y * 0.07).sin()
            + (x * y * 0.01).sin()
    };
    let heights_m = (0..side * side).map(height).collect();
    let georeference =
        Georeference { crs_from_grid: [0.0, 10.0, 0.0, 0.0, 0.0, -10.0], crs: Crs::Local, geokeys: Default::default() };
    HeightGrid { width: side, height: side, heights_m, georeference }
}

fn bakes(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a benchmark may fail without a temporary folder");
    for side in [321, 2000] {
        let (grid, out) = (hills(side), folder.path().join("hills.tif"));
        let mut group = criterion.benchmark_group(format!("bake {side} x {side}"));
        group.sample_size(10);
        for (name, max_error_m) in [("lossless", 0.0), ("within 5 cm", 0.05)] {
            let options = BakeOptions { max_error_m };
            group.bench_function(name, |bencher| {
                bencher.iter(|| bake(&grid, &out, &options, &Silent).expect("the grid is sound"));
            });
        }
        group.bench_function("in memory", |bencher| {
            bencher.iter(|| MemoryStore::new(grid.clone(), "hills", &Silent).expect("the grid is sound"));
        });
    }
}

criterion_group!(benches, bakes);
criterion_main!(benches);
