// View-dependent curvature: the curvature of the surface as the picture foreshortens it (Judd, Durand and Adelson 2007,
// "Apparent Ridges for Line Drawing").
//
// The shape operator gives the change of the normal per step on the surface. Per step on the picture the normal changes
// faster where the surface is foreshortened: a step there is 1 / facing times as long on the surface, toward the eye.
// The largest change is the largest singular value of that operator, and its direction is on the picture.
//
// Changes from the paper: the sign says whether the surface is convex along that direction, which separates ridges from
// valleys; and foreshortening is limited to MIN_FACING.
#import hachure::view::{View, place_of_pixel}
#import hachure::mark_normal::{block_count, pixel_of_block}
#import hachure::curvature::{frame_of, form2, principal_of}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var shape_normal: texture_2d<f32>;
@group(0) @binding(2) var shape_bend: texture_2d<f32>;
// Change of the normal per metre across the line of sight, in the direction of the largest change, positive where the
// surface is convex; that direction on the picture, a unit vector without a sense; and the smallest change as a part of
// the largest.
@group(0) @binding(3) var apparent: texture_storage_2d<rgba32float, write>;

const MIN_FACING: f32 = 0.02;

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let block = vec2<i32>(id.xy);
    if any(id.xy >= block_count(view)) {
        return;
    }
    let seen = textureLoad(shape_normal, block, 0);
    if seen.w <= 0.0 {
        textureStore(apparent, block, vec4<f32>(0.0));
        return;
    }
    let bend = textureLoad(shape_bend, block, 0).xyz;
    let at_m = place_of_pixel(view, pixel_of_block(view, block), seen.w);
    let to_eye = normalize(view.eye_m - at_m);
    let facing = dot(seen.xyz, to_eye);
    let frame = frame_of(seen.xyz);
    // Tangents toward the eye and across, in the tangent frame; if the surface faces the eye, any direction will do.
    let level = to_eye * frame;
    let toward = select(vec2<f32>(1.0, 0.0), level / max(length(level), 1e-12), length(level) > 1e-4);
    let across = vec2<f32>(-toward.y, toward.x);
    let longer = 1.0 / max(facing, MIN_FACING);
    // Change of the normal per step on the picture, toward the eye and across.
    let by_toward = longer * vec2<f32>(form2(bend, toward, toward), form2(bend, toward, across));
    let by_across = vec2<f32>(form2(bend, toward, across), form2(bend, across, across));
    let found = principal_of(vec3<f32>(dot(by_toward, by_toward), dot(by_toward, by_across), dot(by_across, by_across)));
    let step = found.along.x * longer * toward + found.along.y * across;
    let turn = sqrt(max(found.most, 0.0)) * select(-1.0, 1.0, form2(bend, step, step) >= 0.0);
    // The same step on the picture.
    let start = view.clip_from_camera * vec4<f32>(at_m, 1.0);
    let on = view.clip_from_camera * vec4<f32>(frame * step, 0.0);
    let way = (on.xy * start.w - start.xy * on.w) * vec2<f32>(1.0, -1.0) * vec2<f32>(view.size_px);
    let across_part = sqrt(max(found.least, 0.0) / max(found.most, 1e-30));
    textureStore(apparent, block, vec4<f32>(turn, way / max(length(way), 1e-30), across_part));
}
