// Keeps a line pixel if the other eye has a line there, or cannot have one (Zaidi et al., section 4.2, "Reprojection
// Mapping", Eqs. 9 to 11).
//
// R maps a pixel of this eye to the other one's picture; the surface point is known, and for the sky its direction. D
// is how far a round trip misses the pixel; J is how much farther a neighbour moves than the pixel itself. Where both
// are small, both eyes see the place, and no parallax hides a partner. There the line is limited to the strongest of
// the 5 x 5 pixels around its place in the other eye.
//
// Interpretations and changes:
// - The paper processes one eye and then the other, whose partners may have been removed meanwhile. Here both read the
//   other eye's original lines, so neither eye comes first.
// - Outside of the other eye's picture a partner may exist, so the line stays.
// - J uses all eight neighbours.
#import hachure::view::{View, ray_of_pixel}
#import hachure::seen::place_seen

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> other_view: View;
@group(0) @binding(2) var distance_m: texture_2d<f32>;
@group(0) @binding(3) var other_distance_m: texture_2d<f32>;
@group(0) @binding(4) var line: texture_2d<f32>;
@group(0) @binding(5) var other_line: texture_2d<f32>;
@group(0) @binding(6) var agreed: texture_storage_2d<r32float, write>;

// m and n of Eq. 11, in pixels.
const ROUND_TRIP_PX: vec2<f32> = vec2<f32>(2.0, 4.0);
// Largest distance of a partner, in pixels.
const REACH_PX: f32 = 2.0;
const JUMP_PX: vec2<f32> = vec2<f32>(3.0, 6.0);

// Returns the surface point of a pixel, or for the sky a direction, whose last coordinate is 0.
fn shown(eye: View, pixel: vec2<i32>, at: vec4<f32>) -> vec4<f32> {
    return select(vec4<f32>(ray_of_pixel(eye, pixel), 0.0), vec4<f32>(at.xyz, 1.0), at.w > 0.0);
}

// Returns a position on the targets of a view, far outside for points off-screen or behind the eye.
fn reproject(to: View, point: vec4<f32>) -> vec2<f32> {
    let clip = to.clip_from_camera * point;
    let ndc = clip.xy / max(clip.w, 1e-6 * length(clip.xyz));
    return vec2<f32>(ndc.x * 0.5 + 0.5, 0.5 - ndc.y * 0.5) * vec2<f32>(to.size_px);
}

fn rising(range: vec2<f32>, value: f32) -> f32 {
    return clamp((value - range.x) / (range.y - range.x), 0.0, 1.0);
}

// M of Eq. 11: 1 where the other eye gives no evidence about a pixel.
fn mask(pixel: vec2<i32>, there: vec2<f32>) -> f32 {
    let centre = vec2<f32>(pixel) + 0.5;
    let rounded = vec2<i32>(floor(there));
    let back = reproject(view, shown(other_view, rounded, place_seen(other_view, other_distance_m, rounded)));
    let round_trip = rising(ROUND_TRIP_PX, distance(back, centre));
    var jump_px = 0.0;
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let neighbour = pixel + vec2<i32>(x, y);
            if any(neighbour < vec2<i32>(0)) || any(neighbour >= vec2<i32>(view.size_px)) {
                continue;
            }
            let at = reproject(other_view, shown(view, neighbour, place_seen(view, distance_m, neighbour)));
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
    let there = reproject(other_view, shown(view, pixel, place_seen(view, distance_m, pixel)));
    let size = vec2<i32>(other_view.size_px);
    if own > 0.0 && all(there >= vec2<f32>(0.0)) && all(there < vec2<f32>(size)) {
        var partner = 0.0;
        let middle = vec2<i32>(floor(there));
        for (var y = -2; y <= 2; y++) {
            for (var x = -2; x <= 2; x++) {
                let neighbour = middle + vec2<i32>(x, y);
                let is_near = distance(vec2<f32>(neighbour) + 0.5, there) <= REACH_PX;
                if is_near && all(neighbour >= vec2<i32>(0)) && all(neighbour < size) {
                    partner = max(partner, textureLoad(other_line, neighbour, 0).r);
                }
            }
        }
        // The mask is computed only where it matters.
        if partner < own {
            let unknown = mask(pixel, there);
            own = min(own, unknown + (1.0 - unknown) * partner);
        }
    }
    textureStore(agreed, pixel, vec4<f32>(own, 0.0, 0.0, 0.0));
}
