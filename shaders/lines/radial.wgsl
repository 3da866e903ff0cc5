// The curvature of the surface toward the eye, for each block of `surface/curvature`, as curvature-based lines need it.
//
// Everything is in units of the picture, so that numbers are independent of scale: curvature per pixel, and its rise
// toward the eye over a feature, in turns of the normal (radians). The original (DeCarlo and others 2003) measures the
// rise relative to the size of a model.
#import hachure::view::{View, place_of_pixel}
#import hachure::mark_normal::{block_count, pixel_of_block}
#import hachure::curvature::{Shape, radial_of}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var shape_normal: texture_2d<f32>;
@group(0) @binding(2) var shape_bend: texture_2d<f32>;
@group(0) @binding(3) var shape_change: texture_2d<f32>;
// Curvature toward the eye, in radians per pixel; its derivative times the feature size squared, in radians; the cosine
// between the normal and the direction to the eye; distance along the view axis, 0 where there is no surface.
@group(0) @binding(4) var radial: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let block = vec2<i32>(id.xy);
    if any(id.xy >= block_count(view)) {
        return;
    }
    let seen = textureLoad(shape_normal, block, 0);
    if seen.w <= 0.0 {
        textureStore(radial, block, vec4<f32>(0.0));
        return;
    }
    let bend = textureLoad(shape_bend, block, 0);
    let to_eye = view.eye_m - place_of_pixel(view, pixel_of_block(view, block), seen.w);
    let distance_m = length(to_eye);
    let change = textureLoad(shape_change, block, 0);
    let shape = Shape(seen.xyz, bend.xyz, change);
    let own = radial_of(shape, to_eye / distance_m);
    // No line is found near the land's border (surface/curvature.wgsl).
    let feature_m = select(bend.w, 0.0, all(change == vec4<f32>(0.0)));
    textureStore(radial, block,
        vec4<f32>(own.curvature * distance_m / view.focal_px, own.change * feature_m * feature_m, own.facing, seen.w));
}
