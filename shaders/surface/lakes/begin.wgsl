// Computes the workgroups of later passes: only blocks that may have a lake are examined, and only tiles with water are
// processed further. A map without water has one word that says so.
#import hachure::map_job::MapJob
#import hachure::shores::{SQUARES, WET_TILES, FIRST_WET, JOBS}
#import hachure::water_maps::MAP_ROWS

// Workgroups of `shores`, `columns` and `maps` for a tile, in x and y.
const SHORE_GROUPS: u32 = 41u;
const COLUMN_GROUPS: u32 = 6u;
const MAP_GROUPS_X: u32 = 9u;
const MAP_GROUPS_Y: u32 = 33u;

@group(0) @binding(0) var<storage, read> jobs: array<MapJob>;
@group(0) @binding(1) var<storage, read_write> found: array<u32>;
// Three numbers for each of `classes`, `shores`, `columns` and `maps`.
@group(0) @binding(2) var<storage, read_write> arguments: array<u32>;
@group(0) @binding(3) var water_maps: texture_storage_2d_array<r32uint, write>;

@compute @workgroup_size(1)
fn main() {
    var wet = 0u;
    for (var i = 0u; i < found[JOBS]; i++) {
        textureStore(water_maps, vec2<i32>(0, MAP_ROWS - 1), jobs[i].slot, vec4<u32>(found[i], 0u, 0u, 0u));
        if found[i] != 0u {
            found[FIRST_WET + wet] = i;
            wet += 1u;
        }
    }
    found[WET_TILES] = wet;
    let groups = array<vec2<u32>, 4>(vec2<u32>((found[SQUARES] + 63u) / 64u, 1u), vec2<u32>(SHORE_GROUPS, SHORE_GROUPS * wet),
        vec2<u32>(COLUMN_GROUPS, wet), vec2<u32>(MAP_GROUPS_X, MAP_GROUPS_Y * wet));
    for (var i = 0u; i < 4u; i++) {
        arguments[3u * i] = groups[i].x;
        arguments[3u * i + 1u] = groups[i].y;
        arguments[3u * i + 2u] = 1u;
    }
}
