// Finds the lakes that the samples of a tile and its surroundings belong to, each identified by its height.
//
// Lakes are searched at the centre of each block of four samples; each of the four is in the lake found there or in
// none. Searched positions are slightly off the samples of all levels, so that the nearest samples do not depend on the
// camera.
#import hachure::terrain::{levels, place_on_level, first_sample, last_sample}
#import hachure::map_job::MapJob
#import hachure::lake_blocks::{block_place, block_g, sample_of}
#import hachure::shores::{BLOCKS, JOB_SHIFT, SQUARES}
#import hachure::still_water::{window_at, lake_near, LEVEL_WATER_M, NO_LAKE, OFF_GRID}

@group(0) @binding(0) var<storage, read> jobs: array<MapJob>;
@group(0) @binding(1) var<storage, read> squares: array<u32>;
@group(0) @binding(2) var<storage, read_write> classes: array<f32>;
@group(0) @binding(3) var<storage, read_write> found: array<atomic<u32>>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= atomicLoad(&found[SQUARES]) {
        return;
    }
    let square = squares[id.x];
    let number = square >> JOB_SHIFT;
    let index = i32(square & ((1u << JOB_SHIFT) - 1u));
    let block = vec2<i32>(index % BLOCKS, index / BLOCKS);
    let job = jobs[number];
    let g = block_g(job, block);
    let window = window_at(place_on_level(job.level, g), g);
    // Beyond the border all values repeat those at the border.
    let inside = clamp(g, first_sample(), last_sample());
    let lake_m = lake_near(inside + OFF_GRID / levels[job.level].scale, window);
    var is_water = false;
    for (var i = 0; i < 4; i++) {
        let corner = vec2<i32>(i & 1, i >> 1u);
        let at = block_place(number, block, corner);
        let is_lake = lake_m != NO_LAKE && classes[at] == NO_LAKE
            && abs(sample_of(window, job.level, corner) - lake_m) < LEVEL_WATER_M;
        is_water = is_water || is_lake;
        classes[at] = select(classes[at], lake_m, is_lake);
    }
    if is_water {
        atomicStore(&found[number], 1u);
    }
}
