// Turns errors into lines: the line-density filter (Zaidi et al., end of section 4.1) and the ramp, applied once and
// last.
//
// Along each axis the error is reduced by `density` times (2 in the paper) the smallest error in a line of five pixels
// around it: a single line, low on both sides, stays; an area where everything is an edge vanishes.
// EIGHT: each of the eight directions is reduced by itself. Without it opposite ones share the greater error.
// Detectors without axes (`scalar`) take the smallest over all four lines, as one number.
#import hachure::view::View

struct Threshold {
    ramp: vec2<f32>,
    density: f32,
    scalar: u32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> threshold: Threshold;
@group(0) @binding(2) var errors: texture_2d<f32>;
@group(0) @binding(3) var line: texture_storage_2d<r32float, write>;
#ifdef EIGHT
@group(0) @binding(4) var directions: texture_2d<u32>;
#endif

fn load(pixel: vec2<i32>) -> vec4<f32> {
    let inside = clamp(pixel, vec2<i32>(0), vec2<i32>(view.size_px) - 1);
    return clamp(textureLoad(errors, inside, 0), vec4<f32>(0.0), vec4<f32>(1.0));
}

#ifdef EIGHT
// Returns the greater filtered error of an axis's two directions.
fn left_of_axis(p: vec2<i32>, step: vec2<i32>, axis: u32) -> f32 {
    let here = along(p, axis);
    var least = here;
    for (var i = -2; i <= 2; i++) {
        least = min(least, along(p + i * step, axis));
    }
    let left = here - threshold.density * least;
    return max(left.x, left.y);
}

fn along(pixel: vec2<i32>, axis: u32) -> vec2<f32> {
    let inside = clamp(pixel, vec2<i32>(0), vec2<i32>(view.size_px) - 1);
    return unpack2x16unorm(textureLoad(directions, inside, 0)[axis]);
}
#endif

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let p = vec2<i32>(id.xy);
    let here = load(p);
    var error = max(max(here.x, here.y), max(here.z, here.w));
    // The filter only lowers errors, so those below the ramp need no filter. There the loop ends early, since a software
    // driver runs both sides of a branch.
    let is_filtered = threshold.density > 0.0 && error > threshold.ramp.x;
    if is_filtered {
#ifdef EIGHT
        let level = max(left_of_axis(p, vec2<i32>(1, 0), 0u), left_of_axis(p, vec2<i32>(0, 1), 1u));
        let aslant = max(left_of_axis(p, vec2<i32>(1, 1), 2u), left_of_axis(p, vec2<i32>(1, -1), 3u));
        error = max(level, aslant);
#else
        var least = here;
        let last = select(-2, 2, is_filtered);
        for (var i = -2; i <= last; i++) {
            least.x = min(least.x, load(p + vec2<i32>(i, 0)).x);
            least.y = min(least.y, load(p + vec2<i32>(0, i)).y);
            least.z = min(least.z, load(p + vec2<i32>(i, i)).z);
            least.w = min(least.w, load(p + vec2<i32>(i, -i)).w);
        }
        if threshold.scalar != 0u {
            least = vec4<f32>(min(min(least.x, least.y), min(least.z, least.w)));
        }
        let kept = here - threshold.density * least;
        error = max(max(kept.x, kept.y), max(kept.z, kept.w));
#endif
    }
    let value = clamp((error - threshold.ramp.x) / (threshold.ramp.y - threshold.ramp.x), 0.0, 1.0);
    textureStore(line, p, vec4<f32>(value, 0.0, 0.0, 0.0));
}
