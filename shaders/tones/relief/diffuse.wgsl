// A step of the blur that stops at silhouettes and creases (Vergne and others 2009, section 4.3: the anisotropic
// diffusion of Perona and Malik 1990).
//
// Changes:
// - Steps reach farther and farther, by 1, 1, 2, 2, 4, 4 ... pixels, so that few of them make a wide blur. Points in
//   between are not examined: a neighbour counts as far as it is on the plane of the pixel.
// - The paper counts steps; here the style gives a standard deviation, and the last step of a pixel may be partial: the
//   blur varies smoothly from place to place.
#import hachure::view::View
#import hachure::relief::{unpacked, on_plane}

struct DiffuseStep {
    // Distance between neighbours in this step.
    stride_px: i32,
    // Variance of the blur before this step and after it, in square pixels.
    variance_before: f32,
    variance_after: f32,
    pad: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> diffuse_step: DiffuseStep;
@group(0) @binding(2) var before: texture_2d<f32>;
@group(0) @binding(3) var after: texture_storage_2d<rgba32float, write>;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let own = textureLoad(before, pixel, 0);
    let gradient = unpacked(own);
    let asked = gradient.sigma_px * gradient.sigma_px - diffuse_step.variance_before;
    let part = clamp(asked / (diffuse_step.variance_after - diffuse_step.variance_before), 0.0, 1.0);
    if gradient.conductance <= 0.0 || part <= 0.0 {
        textureStore(after, pixel, own);
        return;
    }
    // A binomial filter: 1 2 1 in both directions.
    var change = vec2<f32>(0.0);
    for (var i = 0; i < 9; i++) {
        let way = vec2<i32>(i % 3, i / 3) - 1;
        let at = pixel + diffuse_step.stride_px * way;
        if i == 4 || any(at < vec2<i32>(0)) || any(at >= vec2<i32>(view.size_px)) {
            continue;
        }
        let other = textureLoad(before, at, 0);
        let weight = f32((2 - abs(way.x)) * (2 - abs(way.y))) / 16.0;
        let same = min(gradient.conductance, unpacked(other).conductance)
            * on_plane(view, own, other, vec2<f32>(diffuse_step.stride_px * way));
        change += weight * same * (other.xy - own.xy);
    }
    textureStore(after, pixel, vec4<f32>(own.xy + part * change, own.zw));
}
