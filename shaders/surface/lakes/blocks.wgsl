// Classifies each sample of a tile and its surroundings before lakes are searched: the sea, declared water, or none. It
// also lists the blocks of 2 × 2 samples that may have a lake: those with a level block in or next to them.
#import hachure::terrain::{levels, place_on_level, TILE_SAMPLES}
#import hachure::map_job::MapJob
#import hachure::lake_blocks::{block_place, block_g, sample_of, SEA, GIVEN_WATER}
#import hachure::shores::{BLOCKS, JOB_SHIFT, SQUARES}
#import hachure::water_maps::AROUND
#import hachure::still_water::{Window, window_at, LEVEL_WATER_M, NO_LAKE, VOID}

struct Sea {
    // Heights up to this are the sea, in metres above sea level; very low if the scene has no sea.
    sea_m: f32,
    pad_a: f32,
    pad_b: f32,
    pad_c: f32,
}

// Workgroups of 8 x 8 blocks along a side.
const GROUPS: u32 = 21u;

@group(0) @binding(0) var<uniform> sea: Sea;
@group(0) @binding(1) var<storage, read> jobs: array<MapJob>;
// Height of a sample's lake, or SEA, GIVEN_WATER, NO_LAKE or VOID.
@group(0) @binding(2) var<storage, read_write> classes: array<f32>;
// See `shores`.
@group(0) @binding(3) var<storage, read_write> found: array<atomic<u32>>;
@group(0) @binding(4) var<storage, read_write> squares: array<u32>;

#ifdef GIVEN
// Number of levels, the first of them, and 1 if there is no other water. From word 4 on, five numbers for each level:
// offset of its cells, position of its first cell among the samples of that level, and its size. Cells are packed four
// to a word.
@group(0) @binding(5) var<storage, read> given: array<i32>;

// Returns whether at least half of a sample of a level is declared water.
fn is_given(level: i32, sample: vec2<i32>) -> bool {
    let finer = u32(max(given[1] - level, 0));
    // Beyond the border all values repeat those at the border.
    let at = clamp(sample, vec2<i32>(0), levels[level].size - 1) >> vec2<u32>(finer);
    let number = level + i32(finer) - given[1];
    let table = 4 + 5 * min(number, given[0] - 1);
    let size = vec2<i32>(given[table + 3], given[table + 4]);
    let place = at - vec2<i32>(given[table + 1], given[table + 2]);
    let inside = clamp(place, vec2<i32>(0), size - 1);
    let cell = inside.y * size.x + inside.x;
    let word = u32(given[given[table] + cell / 4]);
    return ((word >> (8u * u32(cell & 3))) & 255u) >= 128u && all(place == inside) && number < given[0];
}
#endif

// Returns whether some four samples between two rows are level.
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
#ifdef GIVEN
    let is_asked = is_level && given[2] == 0;
#else
    let is_asked = is_level;
#endif
    if is_asked {
        squares[atomicAdd(&found[SQUARES], 1u)] = (number << JOB_SHIFT) | u32(block.y * BLOCKS + block.x);
    }
    var is_water = false;
    for (var i = 0; i < 4; i++) {
        let corner = vec2<i32>(i & 1, i >> 1u);
        let height_m = sample_of(window, job.level, corner);
        let is_sea = height_m <= sea.sea_m;
        var water = select(select(NO_LAKE, VOID, height_m == VOID), SEA, is_sea);
#ifdef GIVEN
        let sample = job.tile * TILE_SAMPLES - AROUND + 2 * block + corner;
        water = select(water, GIVEN_WATER, water != VOID && is_given(job.level, sample));
#endif
        is_water = is_water || water < NO_LAKE;
        classes[block_place(number, block, corner)] = water;
    }
    if is_water {
        atomicStore(&found[number], 1u);
    }
}
