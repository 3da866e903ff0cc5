// Sobel on depth, the well-known baseline.
//
// The 3 x 3 gradient of the distance along the view axis is divided by that distance, so that one threshold serves a
// picture with near and far; the raw gradient draws either nothing near or everything far.
#import hachure::view::View

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var distance_m: texture_2d<f32>;
@group(0) @binding(2) var errors: texture_storage_2d<rgba16float, write>;

fn depth_m(pixel: vec2<i32>) -> f32 {
    let inside = clamp(pixel, vec2<i32>(0), vec2<i32>(view.size_px) - 1);
    let d = textureLoad(distance_m, inside, 0).r;
    // The sky is far, but finite.
    return select(d, 1e7, d <= 0.0);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let p = vec2<i32>(id.xy);
    let nw = depth_m(p + vec2<i32>(-1, -1));
    let n = depth_m(p + vec2<i32>(0, -1));
    let ne = depth_m(p + vec2<i32>(1, -1));
    let w = depth_m(p + vec2<i32>(-1, 0));
    let here = depth_m(p);
    let e = depth_m(p + vec2<i32>(1, 0));
    let sw = depth_m(p + vec2<i32>(-1, 1));
    let s = depth_m(p + vec2<i32>(0, 1));
    let se = depth_m(p + vec2<i32>(1, 1));
    let gx = (ne + 2.0 * e + se) - (nw + 2.0 * w + sw);
    let gy = (sw + 2.0 * s + se) - (nw + 2.0 * n + ne);
    let nearest = min(here, min(min(n, s), min(e, w)));
    let strength = min(length(vec2<f32>(gx, gy)) / (8.0 * nearest), 4.0);
    textureStore(errors, p, vec4<f32>(strength));
}
