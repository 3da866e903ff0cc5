// Draws the normals that are lit together into planes that meet at ridges and gullies, as a draughtsman sees a mountain:
// one step of an edge-avoiding à-trous filter (Dammertz, Sewtz, Hanika and Lensch 2010) of the form normals.
//
// A normal becomes the mean of the normals around it that are similar to it and lie on the same face. Repeated at growing
// distances, slopes become even and the turn between two slopes becomes narrow, so that the border of a tone lies on the
// ridge.
#import hachure::view::{View, place_of_pixel}
#import hachure::mark_normal::{BLOCK_PX, block_count, pixel_of_block}

struct PlaneStep {
    // Distance of the samples, in blocks.
    apart: i32,
    // Angle between normals at which one counts 61 % less.
    similar_rad: f32,
    // Cosine and sine of the angle by which the samples are turned, so that borders of planes have no preferred direction.
    turn: vec2<f32>,
}

// Sine of the angle between a tangent plane and a place at which the place counts 61 % less.
const OFF_PLANE: f32 = 0.35;
// Largest relative difference in distance between places of one face: per radian between them, and at all.
const NEAR_PER_RAD: f32 = 16.0;
const NEAR: f32 = 1.0;

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> plane_step: PlaneStep;
// See surface/form.wgsl.
@group(0) @binding(2) var form_normal: texture_2d<f32>;
@group(0) @binding(3) var planes: texture_storage_2d<rgba32float, write>;

fn place(block: vec2<i32>, depth_m: f32) -> vec3<f32> {
    return place_of_pixel(view, pixel_of_block(view, block), depth_m);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let block = vec2<i32>(id.xy);
    let count = vec2<i32>(block_count(view));
    if any(block >= count) {
        return;
    }
    let own = textureLoad(form_normal, block, 0);
    if own.w <= 0.0 {
        textureStore(planes, block, own);
        return;
    }
    let at = place(block, own.w);
    let apart_rad = f32(BLOCK_PX * plane_step.apart) / view.focal_px;
    let allowed = 1.0 + min(NEAR_PER_RAD * apart_rad, NEAR);
    var sum = 2.0 * own.xyz;
    for (var i = 0; i < 9; i++) {
        let offset = vec2<i32>(i % 3 - 1, i / 3 - 1);
        let along = vec2<f32>(offset);
        let turned = plane_step.turn.x * along + plane_step.turn.y * vec2<f32>(-along.y, along.x);
        let other = block + vec2<i32>(round(f32(plane_step.apart) * turned));
        if all(offset == vec2<i32>(0)) || any(other < vec2<i32>(0)) || any(other >= count) {
            continue;
        }
        let seen = textureLoad(form_normal, other, 0);
        if seen.w <= 0.0 || max(seen.w, own.w) > allowed * min(seen.w, own.w) {
            continue;
        }
        let away = place(other, seen.w) - at;
        let off_plane = dot(away, own.xyz) / (length(away) * OFF_PLANE + 1e-6);
        let angle = acos(clamp(dot(own.xyz, seen.xyz), -1.0, 1.0)) / plane_step.similar_rad;
        let spread = f32(4 >> u32(dot(offset, offset))) * 0.5;
        sum += seen.xyz * spread * exp(-0.5 * (angle * angle + off_plane * off_plane));
    }
    textureStore(planes, block, vec4<f32>(normalize(sum), own.w));
}
