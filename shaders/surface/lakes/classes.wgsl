// The water that each sample of a tile belongs to, and of those around it: a lake by its height, the sea, or none.
//
// Lakes are asked for between four samples, of which all are of the lake that is found there or of none. The places that
// are asked lie a little beside samples of all levels, so that it does not depend on the camera which ones are nearest.
#import hachure::terrain::{levels, place_on_level, TILE_SAMPLES}
#import hachure::map_job::MapJob
#import hachure::water_maps::{AROUND, SIDE}
#import hachure::still_water::{Window, window_at, lake_near, LEVEL_WATER_M, LEVEL_MEAN_M, NO_LAKE, VOID, BESIDE}

struct Sea {
    // What is no higher is the sea, in metres above it; very low where the scene has no sea.
    sea_m: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

// Squares of four samples along a side, and workgroups of 8 x 8 of them.
const BLOCKS: i32 = 162;
const GROUPS: u32 = 21u;
// The height that stands for the sea.
const SEA: f32 = -1e30;

@group(0) @binding(0) var<uniform> sea: Sea;
@group(0) @binding(1) var<storage, read> jobs: array<MapJob>;
// The height of a sample's lake, SEA, NO_LAKE or VOID.
@group(0) @binding(2) var<storage, read_write> classes: array<f32>;
// For each job whether there is any water.
@group(0) @binding(3) var<storage, read_write> found: array<atomic<u32>>;

// Whether samples beside each other are level.
fn any_level(window: Window) -> bool {
    let down = min(min(abs(window.row_a - window.row_b), abs(window.row_b - window.row_c)), abs(window.row_c - window.row_d));
    let across = min(min(abs(window.row_a.xyz - window.row_a.yzw), abs(window.row_b.xyz - window.row_b.yzw)),
        min(abs(window.row_c.xyz - window.row_c.yzw), abs(window.row_d.xyz - window.row_d.yzw)));
    return any(down < vec4<f32>(LEVEL_MEAN_M)) || any(across < vec3<f32>(LEVEL_MEAN_M));
}

fn class_of(height_m: f32, lake_m: f32) -> f32 {
    if height_m == VOID {
        return VOID;
    }
    return select(select(NO_LAKE, lake_m, abs(height_m - lake_m) < LEVEL_WATER_M), SEA, height_m <= sea.sea_m);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(workgroup_id) group: vec3<u32>) {
    let number = group.y / GROUPS;
    let job = jobs[number];
    let block = vec2<i32>(vec2<u32>(id.x, id.y - number * GROUPS * 8u));
    if any(block >= vec2<i32>(BLOCKS)) {
        return;
    }
    let info = levels[job.level];
    let sample = job.tile * TILE_SAMPLES - AROUND + 2 * block;
    let g = (vec2<f32>(sample - info.cell) + 0.5 - info.fraction) / info.scale;
    let window = window_at(place_on_level(job.level, g), g);
    var lake_m = NO_LAKE;
    if any_level(window) {
        lake_m = lake_near(g + BESIDE / info.scale, window);
    }
    let rows = array<vec4<f32>, 4>(window.row_a, window.row_b, window.row_c, window.row_d);
    // Beyond the border, and where a coarser level stands in, the nearest samples.
    let ratio = levels[window.level].scale / info.scale;
    let first = i32(number) * SIDE * SIDE;
    var is_water = false;
    for (var i = 0; i < 4; i++) {
        let corner = vec2<i32>(i & 1, i >> 1u);
        let nearest = vec2<i32>(floor(window.f + (vec2<f32>(corner) - 0.5) * ratio + 0.5));
        let at = clamp(nearest, vec2<i32>(0), vec2<i32>(1)) + 1;
        let own = class_of(rows[at.y][at.x], lake_m);
        is_water = is_water || own < NO_LAKE;
        let place = 2 * block + corner;
        classes[first + place.y * SIDE + place.x] = own;
    }
    if is_water {
        atomicStore(&found[number], 1u);
    }
}
