//! Measures how long a bake takes: 2000 × 2000 samples, lossless and within 5 cm, including writing, reading back and
//! measuring errors.
#![allow(missing_docs, reason = "criterion generates the functions")]

use criterion::{Criterion, criterion_group, criterion_main};
use hachure::pyramid::{BakeOptions, bake};
use hachure::source::georeference::{Crs, Georeference};
use hachure::source::{HeightGrid, Silent};

const SIDE: u32 = 2000;

fn hills() -> HeightGrid {
    let height = |i: u32| {
        let (x, y) = ((i % SIDE) as f32, (i / SIDE) as f32);
        900.0
            + 400.0 * (x * 0.004).sin() * (y * 0.003).cos()
            + 30.0 * (x * 0.05 + y * 0.07).sin()
            + (x * y * 0.01).sin()
    };
    let heights_m = (0..SIDE * SIDE).map(height).collect();
    let georeference =
        Georeference { crs_from_grid: [0.0, 10.0, 0.0, 0.0, 0.0, -10.0], crs: Crs::Local, geokeys: Default::default() };
    HeightGrid { width: SIDE, height: SIDE, heights_m, georeference }
}

fn bakes(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a benchmark may fail without a temporary folder");
    let (grid, out) = (hills(), folder.path().join("hills.tif"));
    let mut group = criterion.benchmark_group("bake 2000 x 2000");
    group.sample_size(10);
    for (name, max_error_m) in [("lossless", 0.0), ("within 5 cm", 0.05)] {
        let options = BakeOptions { max_error_m };
        group.bench_function(name, |bencher| {
            bencher.iter(|| bake(&grid, &out, &options, &Silent).expect("the grid is sound"));
        });
    }
}

criterion_group!(benches, bakes);
criterion_main!(benches);
