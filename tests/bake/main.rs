//! Bakes of grids of any size: in chunks, in rounds, interrupted, and split between machines.
#![allow(clippy::disallowed_methods, reason = "the test writes damaged files")]
#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod bounds;
#[path = "../../src/tests/pyramid/brute.rs"]
mod brute;
mod chunks;
mod large;
mod process;
#[path = "../../src/tests/pyramid/world.rs"]
mod world;

use std::path::Path;

use hachure::pyramid::bake::{BakeReport, BakeWork, Baked, bake_reader};
use hachure::pyramid::{BakeOptions, Pyramid, TileAddress};
use hachure::source::GridReader;
use hachure::source::{HeightGrid, Silent};

/// Returns whether the long tier of the tests is wanted (`./check --full`).
fn full() -> bool {
    std::env::var("HACHURE_TESTS").is_ok_and(|tier| tier == "full")
}

/// Bakes with chunks of 2^`chunk_levels` tiles per side.
fn baked(grid: &HeightGrid, out: &Path, max_error_m: f64, chunk_levels: u32) -> (Pyramid, BakeReport) {
    let work = BakeWork { chunk_levels, ..BakeWork::default() };
    let reader = GridReader::new(grid, String::new());
    let Baked::Pyramid(report) = bake_reader(&reader, out, &BakeOptions { max_error_m }, &work, &Silent).unwrap()
    else {
        panic!("the bake made a shard instead of a pyramid");
    };
    (Pyramid::open(out).unwrap(), report)
}

fn tiles(pyramid: &Pyramid, level: u32) -> Vec<TileAddress> {
    let size = pyramid.levels()[level as usize];
    (0..size.tiles_y()).flat_map(|y| (0..size.tiles_x()).map(move |x| TileAddress { level, x, y })).collect()
}
