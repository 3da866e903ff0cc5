// A line pixel stays if the other eye has a line there, or cannot have it (Zaidi et al., section 4.2, "Reprojection
// Mapping", Eqs. 9 to 11).
//
// R takes a pixel of this eye to the other one's picture: the surface's place is known, and of the sky its direction. D
// is what a way there and back lacks of the pixel; J how much farther a neighbour moves than the pixel itself. Where
// both are small, both eyes see the place, and no parallax hides a partner. Then the line is no stronger than the
// strongest of the 5 x 5 pixels around its place in the other eye.
//
// Readings and changes:
// - The paper treats one eye and then the other, whose partners may have gone meanwhile. Here both read what the other
//   one had: neither eye comes first.
// - What lies outside of the other eye's picture is not known to lack a partner, and stays.
// - J looks at all eight neighbours.
#import hachure::view::{View, ray_of_pixel}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> other_view: View;
@group(0) @binding(2) var position: texture_2d<f32>;
@group(0) @binding(3) var other_position: texture_2d<f32>;
@group(0) @binding(4) var line: texture_2d<f32>;
@group(0) @binding(5) var other_line: texture_2d<f32>;
@group(0) @binding(6) var agreed: texture_storage_2d<r32float, write>;

// In pixels: m and n of Eq. 11.
const ROUND_TRIP_PX: vec2<f32> = vec2<f32>(2.0, 4.0);
// How far away a partner may be.
const REACH_PX: f32 = 2.0;
const JUMP_PX: vec2<f32> = vec2<f32>(3.0, 6.0);

// What a pixel shows: a place, or a direction whose last coordinate is 0.
fn shown(eye: View, pixel: vec2<i32>, at: vec4<f32>) -> vec4<f32> {
    return select(vec4<f32>(ray_of_pixel(eye, pixel), 0.0), vec4<f32>(at.xyz, 1.0), at.w > 0.0);
}

// On the targets of a view; far outside for what is beside or behind it.
fn reproject(to: View, point: vec4<f32>) -> vec2<f32> {
    let clip = to.clip_from_camera * point;
    let ndc = clip.xy / max(clip.w, 1e-6 * length(clip.xyz));
    return vec2<f32>(ndc.x * 0.5 + 0.5, 0.5 - ndc.y * 0.5) * vec2<f32>(to.size_px);
}

fn rising(range: vec2<f32>, value: f32) -> f32 {
    return clamp((value - range.x) / (range.y - range.x), 0.0, 1.0);
}

// M of Eq. 11: 1 where the other eye tells nothing of a pixel.
fn mask(pixel: vec2<i32>, there: vec2<f32>) -> f32 {
    let centre = vec2<f32>(pixel) + 0.5;
    let rounded = vec2<i32>(floor(there));
    let back = reproject(view, shown(other_view, rounded, textureLoad(other_position, rounded, 0)));
    let round_trip = rising(ROUND_TRIP_PX, distance(back, centre));
    var jump_px = 0.0;
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let beside = pixel + vec2<i32>(x, y);
            if any(beside < vec2<i32>(0)) || any(beside >= vec2<i32>(view.size_px)) {
                continue;
            }
            let at = reproject(other_view, shown(view, beside, textureLoad(position, beside, 0)));
            jump_px = max(jump_px, length(at - there - vec2<f32>(vec2<i32>(x, y))));
        }
    }
    return max(round_trip, rising(JUMP_PX, jump_px));
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    var own = textureLoad(line, pixel, 0).r;
    let there = reproject(other_view, shown(view, pixel, textureLoad(position, pixel, 0)));
    let size = vec2<i32>(other_view.size_px);
    if own > 0.0 && all(there >= vec2<f32>(0.0)) && all(there < vec2<f32>(size)) {
        var partner = 0.0;
        let middle = vec2<i32>(floor(there));
        for (var y = -2; y <= 2; y++) {
            for (var x = -2; x <= 2; x++) {
                let beside = middle + vec2<i32>(x, y);
                let is_near = distance(vec2<f32>(beside) + 0.5, there) <= REACH_PX;
                if is_near && all(beside >= vec2<i32>(0)) && all(beside < size) {
                    partner = max(partner, textureLoad(other_line, beside, 0).r);
                }
            }
        }
        // The mask is asked only where it matters.
        if partner < own {
            let unknown = mask(pixel, there);
            own = min(own, unknown + (1.0 - unknown) * partner);
        }
    }
    textureStore(agreed, pixel, vec4<f32>(own, 0.0, 0.0, 0.0));
}
