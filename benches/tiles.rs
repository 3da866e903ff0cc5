//! Measures how long a tile of computed land takes that is not cached: evaluating it, and deriving its statistics.
#![allow(missing_docs, reason = "criterion generates the functions")]

use std::sync::Arc;

use criterion::{Criterion, criterion_group, criterion_main};
use hachure::pyramid::store::{ContinentStore, derive};
use hachure::pyramid::{TileAddress, TileStore};
use hachure::source::Silent;

fn tiles(criterion: &mut Criterion) {
    let store = ContinentStore::open(1, 1 << 18, 10.0, None, &Silent).expect("a benchmark may fail without a cache");
    let store: Arc<dyn TileStore> = Arc::new(store);
    let mut group = criterion.benchmark_group("a tile of the continent");
    for level in [0, 1, 4, 7] {
        let size = store.levels()[level as usize];
        let address = TileAddress { level, x: size.tiles_x() / 2, y: size.tiles_y() / 3 };
        let tile = Arc::clone(&store).load(address).expect("it is inside");
        group.bench_function(format!("level {level}"), |bencher| {
            bencher.iter(|| Arc::clone(&store).load(address));
        });
        group.bench_function(format!("level {level}, statistics only"), |bencher| {
            bencher.iter(|| derive(store.levels(), address, tile.tile.clone()));
        });
    }
}

criterion_group!(benches, tiles);
criterion_main!(benches);
