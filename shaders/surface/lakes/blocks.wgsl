// The water of each sample of a tile and of those around it, before lakes are looked for: the sea, or none. And where a
// lake may be: in squares of four samples beside which any four are level.
#import hachure::terrain::{levels, place_on_level}
#import hachure::map_job::MapJob
#import hachure::lake_blocks::{block_place, block_g, sample_of, SEA}
#import hachure::shores::{BLOCKS, JOB_SHIFT, SQUARES}
#import hachure::water_maps::SIDE
#import hachure::still_water::{Window, window_at, LEVEL_WATER_M, NO_LAKE, VOID}

struct Sea {
    // What is no higher is the sea, in metres above it; very low where the scene has no sea.
    sea_m: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

// Workgroups of 8 x 8 squares along a side.
const GROUPS: u32 = 21u;

@group(0) @binding(0) var<uniform> sea: Sea;
@group(0) @binding(1) var<storage, read> jobs: array<MapJob>;
// The height of a sample's lake, SEA, NO_LAKE or VOID.
@group(0) @binding(2) var<storage, read_write> classes: array<f32>;
// See `shores`.
@group(0) @binding(3) var<storage, read_write> found: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> squares: array<u32>;

// Whether four samples between two rows are level.
fn level_between(a: vec4<f32>, b: vec4<f32>) -> bool {
    let low = min(min(a.xyz, a.yzw), min(b.xyz, b.yzw));
    let high = max(max(a.xyz, a.yzw), max(b.xyz, b.yzw));
    return any((high - low < vec3<f32>(LEVEL_WATER_M)) & (high < vec3<f32>(NO_LAKE)) & (high > vec3<f32>(sea.sea_m)));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(workgroup_id) group: vec3<u32>) {
    let number = group.y / GROUPS;
    let job = jobs[number];
    let block = vec2<i32>(vec2<u32>(id.x, id.y - number * GROUPS * 8u));
    if any(block >= vec2<i32>(BLOCKS)) {
        return;
    }
    let g = block_g(job, block);
    let window = window_at(place_on_level(job.level, g), g);
    let is_level = level_between(window.row_a, window.row_b) || level_between(window.row_b, window.row_c)
        || level_between(window.row_c, window.row_d);
    if is_level {
        squares[atomicAdd(&found[SQUARES], 1u)] = (number << JOB_SHIFT) | u32(block.y * BLOCKS + block.x);
    }
    var is_water = false;
    for (var i = 0; i < 4; i++) {
        let corner = vec2<i32>(i & 1, i >> 1u);
        let height_m = sample_of(window, job.level, corner);
        let is_sea = height_m <= sea.sea_m;
        is_water = is_water || is_sea;
        classes[block_place(number, block, corner)] = select(select(NO_LAKE, VOID, height_m == VOID), SEA, is_sea);
    }
    if is_water {
        atomicStore(&found[number], 1u);
    }
}
