// The distance and normal that hatching marks use: those of the surface itself, except that marks treat trees as flat,
// with the shading of a round body (hachure::tree_form).
#import hachure::view::View
#import hachure::seen::words_of_surface
#import hachure::surface_id::{kind_of, TREE}
#import hachure::mark_normal::FLAT

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var surface_id: texture_2d<u32>;
@group(0) @binding(2) var distance_m: texture_2d<f32>;
@group(0) @binding(3) var normal: texture_2d<u32>;
@group(0) @binding(4) var tree_form: texture_2d<f32>;
@group(0) @binding(5) var mark_distance_m: texture_storage_2d<r32float, write>;
// As `normal`, with FLAT as lightness where a tree is visible.
@group(0) @binding(6) var mark_surface: texture_storage_2d<rg32uint, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let own_m = textureLoad(distance_m, pixel, 0).r;
    if kind_of(textureLoad(surface_id, pixel, 0).r) != TREE {
        textureStore(mark_distance_m, pixel, vec4<f32>(own_m, 0.0, 0.0, 0.0));
        textureStore(mark_surface, pixel, textureLoad(normal, pixel, 0));
        return;
    }
    let form = textureLoad(tree_form, pixel, 0);
    let along_m = max(own_m + form.w, 0.5 * own_m);
    textureStore(mark_distance_m, pixel, vec4<f32>(along_m, 0.0, 0.0, 0.0));
    textureStore(mark_surface, pixel, words_of_surface(vec4<f32>(form.xyz, FLAT)));
}
