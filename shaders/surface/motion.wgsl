// The motion of each pixel's content since the previous frame: exact for a static world, sky included.
//
// Trees in wind (WIND) provide their own displacement: each vertex of a mesh as it leans and flutters, each pixel of an
// impostor as it leans. Three effects are neglected: the curvature of the earth rotates that displacement by less than
// 0.01, half floats round it by 0.05 %, and the visible part of the flutter is taken from this frame's distance.
#import hachure::view::{View, motion_of, ray_of_pixel}
#import hachure::seen::place_seen
#ifdef WIND
#import hachure::surface_id::{has_trait, MOVING}
#endif

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var distance_m: texture_2d<f32>;
@group(0) @binding(2) var motion: texture_storage_2d<rg32float, write>;
#ifdef WIND
@group(0) @binding(3) var surface_id: texture_2d<u32>;
// Displacement to the previous position, in metres; undefined elsewhere than on trees.
@group(0) @binding(4) var tree_step: texture_2d<f32>;
#endif

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = place_seen(view, distance_m, pixel);
    // The sky is a direction.
    var point = select(vec4<f32>(ray_of_pixel(view, pixel), 0.0), vec4<f32>(at.xyz, 1.0), at.w > 0.0);
#ifdef WIND
    if has_trait(textureLoad(surface_id, pixel, 0).r, MOVING) {
        point += vec4<f32>(textureLoad(tree_step, pixel, 0).xyz, 0.0);
    }
#endif
    textureStore(motion, pixel, vec4<f32>(motion_of(view, pixel, point), 0.0, 0.0));
}
