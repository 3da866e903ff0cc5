// Blocks of 2 × 2 samples of a tile and its surroundings.
#define_import_path hachure::lake_blocks
#import hachure::terrain::{levels, TILE_SAMPLES}
#import hachure::map_job::MapJob
#import hachure::water_maps::{AROUND, SIDE}
#import hachure::still_water::Window

// Height that represents the sea.
const SEA: f32 = -1e30;
// Height that represents water that the scene declares; it is connected to all water that it touches.
const GIVEN_WATER: f32 = -2e30;

// Returns the centre of a block, in the grid.
fn block_g(job: MapJob, block: vec2<i32>) -> vec2<f32> {
    let info = levels[job.level];
    let sample = job.tile * TILE_SAMPLES - AROUND + 2 * block;
    return (vec2<f32>(sample - info.cell) + 0.5 - info.fraction) / info.scale;
}

// Returns the index of a sample of a block, among the samples of all tiles in progress.
fn block_place(number: u32, block: vec2<i32>, corner: vec2<i32>) -> i32 {
    let place = 2 * block + corner;
    return (i32(number) * SIDE + place.y) * SIDE + place.x;
}

// Returns a sample of a block. Beyond the border, and where a coarser level is used instead, it is the nearest sample.
fn sample_of(window: Window, level: i32, corner: vec2<i32>) -> f32 {
    let ratio = levels[window.level].scale / levels[level].scale;
    let nearest = vec2<i32>(floor(window.f + (vec2<f32>(corner) - 0.5) * ratio + 0.5));
    let row = select(window.row_b.yz, window.row_c.yz, nearest.y > 0);
    return select(row.x, row.y, nearest.x > 0);
}
