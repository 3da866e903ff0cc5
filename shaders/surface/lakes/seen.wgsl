// Finds whether any tile of the view has water. If so, `surface/water` processes all pixels, and else none.
#import hachure::terrain::{terrain, levels, tile_rows, tiles, NO_MAP}
#import hachure::water_maps::{water_maps, MAP_ROWS}

struct Seen {
    // Workgroups of a picture.
    groups: vec2<u32>,
    pad_a: u32,
    pad_b: u32,
}

@group(0) @binding(0) var<uniform> picture: Seen;
// Three numbers for `surface/water`, three for `surface/dry`, and from FIRST_FLAG on, for the slot of each map in view,
// whether it has water.
@group(0) @binding(1) var<storage, read_write> arguments: array<u32>;

const FIRST_FLAG: u32 = 6u;

var<workgroup> is_wet: atomic<u32>;

@compute @workgroup_size(64)
fn main(@builtin(local_invocation_index) thread: u32) {
    if thread == 0u {
        atomicStore(&is_wet, 0u);
    }
    workgroupBarrier();
    for (var level = 0; level < terrain.level_count; level++) {
        let info = levels[level];
        for (var y = 0; y < info.row_count; y++) {
            let row = tile_rows[info.first_row + y];
            for (var x = i32(thread); x < row.count; x += 64) {
                let tile = tiles[row.first_tile + x];
                if tile.shoreless != NO_MAP {
                    let has_water = textureLoad(water_maps, vec2<i32>(0, MAP_ROWS - 1), i32(tile.slot), 0).r != 0u;
                    arguments[FIRST_FLAG + tile.slot] = u32(has_water);
                    if has_water {
                        atomicStore(&is_wet, 1u);
                    }
                }
            }
        }
    }
    workgroupBarrier();
    if thread == 0u {
        let groups = vec4<u32>(picture.groups, picture.groups) * select(vec4<u32>(0u, 0u, 1u, 1u), vec4<u32>(1u, 1u, 0u, 0u), atomicLoad(&is_wet) != 0u);
        arguments[0] = groups.x;
        arguments[1] = groups.y;
        arguments[2] = 1u;
        arguments[3] = groups.z;
        arguments[4] = groups.w;
        arguments[5] = 1u;
    }
}
