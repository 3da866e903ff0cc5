// Removes lines along the rims of holes: there the data end, not the land, and a rim has a line of its own.
//
// A detector's line covers both sides of an edge, up to two pixels away. The rim pass marks the land next to a hole;
// pixels seen through the hole are not marked, so their neighbours are searched. Land behind a ridge may be next to a
// hole too, and the line of the ridge must stay: there the nearest surface around the line is off the plane of the land
// next to the hole.
#import hachure::view::{View, distance_from_eye}
#import hachure::seen::{normal_seen, place_seen}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var line: texture_2d<f32>;
// Ink of the rims; its second channel is 1 on land next to a hole.
@group(0) @binding(2) var rim: texture_2d<f32>;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
@group(0) @binding(4) var normal: texture_2d<u32>;
@group(0) @binding(5) var rimless: texture_storage_2d<r32float, write>;

const REACH_PX: i32 = 2;
// Distance from the plane, in pixels, beyond which a point is on other land.
const OTHER_LAND_PX: f32 = 3.0;

// Returns the nearest surface point around a pixel; w is its depth, 0 for none.
fn nearest_around(p: vec2<i32>, last: vec2<i32>) -> vec4<f32> {
    var nearest = vec4<f32>(0.0);
    for (var i = 0; i < (2 * REACH_PX + 1) * (2 * REACH_PX + 1); i++) {
        let at = place_seen(view, distance_m, neighbor(p, i, last));
        if at.w > 0.0 && (nearest.w <= 0.0 || at.w < nearest.w) {
            nearest = at;
        }
    }
    return nearest;
}

fn neighbor(p: vec2<i32>, i: i32, last: vec2<i32>) -> vec2<i32> {
    let side = 2 * REACH_PX + 1;
    return clamp(p + vec2<i32>(i % side, i / side) - REACH_PX, vec2<i32>(0), last);
}

fn is_along_rim(p: vec2<i32>, last: vec2<i32>) -> bool {
    let nearest = nearest_around(p, last);
    let off_m = OTHER_LAND_PX * distance_from_eye(view, nearest.xyz) / view.focal_px;
    for (var i = 0; i < (2 * REACH_PX + 1) * (2 * REACH_PX + 1); i++) {
        let q = neighbor(p, i, last);
        if textureLoad(rim, q, 0).g > 0.0 {
            let away_m = dot(normal_seen(normal, q), nearest.xyz - place_seen(view, distance_m, q).xyz);
            if abs(away_m) < off_m {
                return true;
            }
        }
    }
    return false;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let p = vec2<i32>(id.xy);
    var found = textureLoad(line, p, 0).r;
    if found > 0.0 && is_along_rim(p, vec2<i32>(view.size_px) - 1) {
        found = 0.0;
    }
    textureStore(rimless, p, vec4<f32>(found, 0.0, 0.0, 0.0));
}
