// The curvature of the land's form, at one pixel of sixteen.
//
// The form is the level of the pyramid that has `feature_px` pixels per sample, under a B-spline (form.wgsl). So the
// scale of whatever is drawn from it follows the picture, and lines of small features give way to those of large ones
// as the eye moves away. The bicubic surface itself has a step in its curvature at each sample; its form has none. The
// form's third derivatives would have steps, so they are differences of second ones over a sample.
//
// Everything is analytic: with f the height, p its slopes, H its second and T its third derivatives along tangents a,
// b, c, and W = sqrt(1 + p.p), the second fundamental form is -H(a, b) / W, and its covariant derivative is -T(a, b, c)
// / W + (H(a, b) H(p, c) + H(b, c) H(p, a) + H(c, a) H(p, b)) / W^3 (Rusinkiewicz 2004 estimates both from triangles).
// The curvature of the earth is neglected, as it is a hundred times less than that of any hill.
#import hachure::view::View
#import hachure::seen::place_seen
#import hachure::terrain::{terrain, grid_from_world, GridPoint, first_sample, last_sample}
#import hachure::earth::{Unbent, unbend, unbend_direction, bend_normal}
#import hachure::form::{form_of_level, level_seen, MAX_BEYOND}
#import hachure::mark_normal::{block_count, pixel_of_block}
#import hachure::curvature::{Shape, frame_of, form2, form3}
#import hachure::surface_id::{has_trait, id_seen, ON_GRID}

struct CurvatureRules {
    // Size of a sample of the requested level, in pixels.
    feature_px: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> curvature_rules: CurvatureRules;
@group(0) @binding(2) var surface_id: texture_2d<u32>;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
// Positive on water, which is flat whatever the land's form there; a single texel in scenes without water.
@group(0) @binding(7) var water: texture_2d<f32>;
// xyz: the form's unit normal; w: distance along the view axis. All 0 where there is no land.
@group(0) @binding(4) var shape_normal: texture_storage_2d<rgba32float, write>;
// xyz: `Shape.bend`; w: size of a sample of the form, in metres.
@group(0) @binding(5) var shape_bend: texture_storage_2d<rgba32float, write>;
// `Shape.change`; 0 near the land's border, where the curvature is that of a place farther inside, and where no line is
// found: it would run straight to the border.
@group(0) @binding(6) var shape_change: texture_storage_2d<rgba32float, write>;

// Distance from the land's border, in samples, at which curvature near the border is evaluated: closer to it the form
// bends artificially.
const INSIDE: f32 = 2.5;

fn inside(g: vec2<f32>, level: f32) -> vec2<f32> {
    let away = min(vec2<f32>(INSIDE * exp2(max(level, 0.0))), 0.5 * (last_sample() - first_sample()));
    return clamp(g, first_sample() + away, last_sample() - away);
}

// Returns second derivatives with respect to grid coordinates, at a position and level.
fn bends_at(g: vec2<f32>, level: f32) -> vec3<f32> {
    return form_of_level(g, level).curvature;
}

fn shape_at(flat_place: Unbent, point: GridPoint, level: f32) -> Shape {
    let g = inside(point.g, level);
    let form = form_of_level(g, level);
    let half = 0.5 * exp2(clamp(level, 0.0, f32(terrain.level_count - 1)));
    let by_x = (bends_at(g + vec2<f32>(half, 0.0), level) - bends_at(g - vec2<f32>(half, 0.0), level)) / (2.0 * half);
    let by_y = (bends_at(g + vec2<f32>(0.0, half), level) - bends_at(g - vec2<f32>(0.0, half), level)) / (2.0 * half);
    let third = vec4<f32>(by_x.x, 0.5 * (by_x.y + by_y.x), 0.5 * (by_x.z + by_y.y), by_y.z);

    let slope = vec2<f32>(dot(form.gradient, point.dg_dx), dot(form.gradient, point.dg_dy));
    let normal = bend_normal(flat_place, slope);
    let frame = frame_of(normal);
    // The tangents on the map, and on the grid.
    let u_map = unbend_direction(flat_place, frame[0]).xy;
    let v_map = unbend_direction(flat_place, frame[1]).xy;
    let to_grid = mat2x2<f32>(point.dg_dx, point.dg_dy);
    let u = to_grid * u_map;
    let v = to_grid * v_map;
    let up = to_grid * slope;
    let flatness = inverseSqrt(1.0 + dot(slope, slope));
    let uu = form2(form.curvature, u, u);
    let uv = form2(form.curvature, u, v);
    let vv = form2(form.curvature, v, v);
    let pu = form2(form.curvature, up, u);
    let pv = form2(form.curvature, up, v);
    let turning = vec4<f32>(3.0 * uu * pu, uu * pv + 2.0 * uv * pu, vv * pu + 2.0 * uv * pv, 3.0 * vv * pv);
    let change = -flatness * vec4<f32>(form3(third, u, u, u), form3(third, u, u, v), form3(third, u, v, v), form3(third, v, v, v))
        + flatness * flatness * flatness * turning;
    return Shape(normal, -flatness * vec3<f32>(uu, uv, vv), change);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let block = vec2<i32>(id.xy);
    if any(id.xy >= block_count(view)) {
        return;
    }
    let pixel = pixel_of_block(view, block);
    let at = place_seen(view, distance_m, pixel);
    let is_water = textureLoad(water, min(pixel, vec2<i32>(textureDimensions(water)) - 1), 0).r > 0.0;
    if at.w <= 0.0 || is_water || !has_trait(id_seen(surface_id, pixel), ON_GRID) {
        textureStore(shape_normal, block, vec4<f32>(0.0));
        textureStore(shape_bend, block, vec4<f32>(0.0));
        textureStore(shape_change, block, vec4<f32>(0.0));
        return;
    }
    let flat_place = unbend(at.xyz);
    let point = grid_from_world(flat_place.flat_m.xy);
    let level = level_seen(view, at.xyz, flat_place, point, curvature_rules.feature_px);
    let shape = shape_at(flat_place, point, level);
    let sample_m = terrain.spacing_m * exp2(clamp(level, 0.0, f32(terrain.level_count - 1) + MAX_BEYOND));
    textureStore(shape_normal, block, vec4<f32>(shape.normal, at.w));
    textureStore(shape_bend, block, vec4<f32>(shape.bend, sample_m));
    let is_inside = all(inside(point.g, level) == point.g);
    textureStore(shape_change, block, select(vec4<f32>(0.0), shape.change, is_inside));
}
