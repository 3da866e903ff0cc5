// Computes distance and normal where a tree is visible, over those of the land.
#import hachure::view::View
#import hachure::seen::words_of_surface
#import hachure::surface_id::{kind_of, TREE}
#import hachure::trees::lightness_of

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var surface_id: texture_2d<u32>;
@group(0) @binding(2) var depth: texture_depth_2d;
// Normals as rasterised; undefined elsewhere than on trees.
@group(0) @binding(3) var tree_normal: texture_2d<f32>;
@group(0) @binding(4) var distance_m: texture_storage_2d<r32float, write>;
@group(0) @binding(5) var normal: texture_storage_2d<rg32uint, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    if kind_of(textureLoad(surface_id, pixel, 0).r) != TREE {
        return;
    }
    let along_m = view.near_m / textureLoad(depth, pixel, 0);
    let n = textureLoad(tree_normal, pixel, 0);
    textureStore(distance_m, pixel, vec4<f32>(along_m, 0.0, 0.0, 0.0));
    textureStore(normal, pixel, words_of_surface(vec4<f32>(normalize(n.xyz), lightness_of(n.w))));
}
