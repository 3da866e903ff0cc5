// Finds the farthest depth in each tile of the picture, before trees are drawn: what is farther is hidden there. One
// thread takes a tile.
#import hachure::tree_depth::TILE_PX
#import hachure::view::View

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var depth: texture_depth_2d;
@group(0) @binding(2) var tile_depth: texture_storage_2d<r32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let size_px = view.size_px;
    let tiles = (size_px + TILE_PX - 1u) / TILE_PX;
    if any(id.xy >= tiles) {
        return;
    }
    let first = id.xy * TILE_PX;
    let end = min(first + TILE_PX, size_px);
    // Depth is reversed.
    var farthest = 1.0;
    for (var y = first.y; y < end.y; y++) {
        for (var x = first.x; x < end.x; x++) {
            farthest = min(farthest, textureLoad(depth, vec2<u32>(x, y), 0));
        }
    }
    textureStore(tile_depth, id.xy, vec4<f32>(farthest));
}
