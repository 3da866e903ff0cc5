// Curvature-based lines, pixel by pixel (Pietrok 2021, section 4.1): contours, and suggestive contours (DeCarlo and
// others 2003).
//
// A pixel near a contour sees the land at a flat angle. On a surface with curvature k toward the eye, a point whose
// normal has the cosine c to the direction to the eye is c² / 2k before the contour, as projected. That distance in
// pixels is compared with the line's width, so contours are equally wide whatever the curvature. The thesis compares
// the cosine with a threshold, and its lines are wide where the land is flat.
//
// A suggestive contour is where the curvature toward the eye is zero. Between the four blocks around a pixel
// (radial.wgsl) the curvature is bilinear, and its value divided by its gradient is the distance from the line, in
// pixels.
//
// Coordinate u runs along a line, and v across it is the distance, in pixels. The thesis has both for contours alone,
// since a suggestive contour is not perpendicular to the normal. Here its direction is that of the zero line, so both
// kinds of line have them. u makes lines swing from side to side, v gives them soft borders.
//
// The thesis measures u on the page, so a texture slides over the land as the camera moves, and swirls where a line
// bends ("some warping"). Here u is fixed to the land: the position on an axis of the world that is near the line's
// direction, one of AXES around the compass or the height, in texels of a ladder of scales on which a texel is about a
// pixel (Benard and others 2009, as for hatching). The direction is that of the line across the view, so the texture of
// a line that recedes is compressed. Two axes, and two scales, blend into each other.
//
// TEXTURED draws through a stroke texture, which repeats along u and v.
#import hachure::view::{View, place_of_pixel, distance_from_eye}
#import hachure::seen::{normal_seen, place_seen}
#import hachure::mark_normal::{BLOCK_PX, block_count, first_block, pixel_of_block}
#import hachure::surface_id::{has_trait, id_seen, SMOOTH}
#ifdef TEXTURED
#import hachure::brush::{Brush, brush_uv, brush_ink}
#endif

struct CurvatureLines {
    // Width of contours.
    width_px: f32,
    // Width of suggestive contours; 0 draws none.
    suggestive_px: f32,
    // Least rise of the curvature toward the eye (y of `radial`) at a suggestive contour.
    min_rise: f32,
    // Cosine between normal and direction to the eye above which there are no suggestive contours.
    largest_cosine: f32,
    // Soft border, as a part of the half width.
    taper: f32,
    // Amplitude and wavelength of the wave that displaces lines sideways.
    warp_px: f32,
    warp_length_px: f32,
    // Number of levels of the ladder, and the number of the first.
    level_count: i32,
    first_level: i32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> curvature_lines: CurvatureLines;
@group(0) @binding(2) var surface_id: texture_2d<u32>;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
@group(0) @binding(4) var normal: texture_2d<u32>;
@group(0) @binding(5) var radial: texture_2d<f32>;
// Ink of the lines of trees, from another detector; 0 where there are none.
@group(0) @binding(6) var tree_line: texture_2d<f32>;
@group(0) @binding(7) var line: texture_storage_2d<r32float, write>;
// The origin's position on each axis, in texels of each level: level by level for each axis. One number if nothing
// depends on u.
@group(0) @binding(8) var<storage, read> line_phases: array<f32>;
#ifdef TEXTURED
// The brush; its tile holds pigment and threshold.
@group(0) @binding(9) var<uniform> brush: Brush;
@group(0) @binding(10) var brush_tile: texture_2d<f32>;
@group(0) @binding(11) var brush_sampler: sampler;
#endif

// Largest distance of a block from the pixel's plane, in widths of a block on the ground, to be of the same surface.
const ON_PLANE: f32 = 2.0;
// Least curvature, per pixel. It limits the width of lines: flat land at a flat angle has no contour.
const MIN_BEND: f32 = 1e-4;
const TURN: f32 = 6.2831855;

// Number of horizontal axes; the axis of height follows them.
const AXES: i32 = 32;
// Sines of a line's steepness between which the axis of height replaces horizontal ones.
const HORIZONTAL_UP_TO: f32 = 0.6;
const UPRIGHT_FROM: f32 = 0.8;
// The blend to the next axis or scale begins at this fraction of the step to it, and ends at FADE_TO.
const FADE_FROM: f32 = 0.3;
const FADE_TO: f32 = 0.7;

// A line at a pixel.
struct Along {
    // Relative to the origin of positions.
    at_m: vec3<f32>,
    // The step along the line from pixel to pixel.
    step_m: vec3<f32>,
    // Azimuth of that step, in axes around the compass.
    azimuth: f32,
    // Weight of the axis of height.
    upright: f32,
}

// u by one axis and one scale: its value in pixels, its weight in the blend, and the number of axis and scale.
struct Coordinate {
    u_px: f32,
    weight: f32,
    id: u32,
}

// Number of coordinates: by two scales of each of two horizontal axes, and of the height.
const COORDINATES: u32 = 6u;

// Returns a line at a pixel; `along` is its direction on the page.
fn along_line(at: vec4<f32>, along: vec2<f32>) -> Along {
    let step_m = (view.ray_dx * along.x + view.ray_dy * along.y) * at.w;
    let steepness = abs(step_m.z) / max(length(step_m), 1e-20);
    let azimuth = (atan2(step_m.x, step_m.y) / TURN + 1.0) * f32(AXES);
    return Along(at.xyz, step_m, azimuth, smoothstep(HORIZONTAL_UP_TO, UPRIGHT_FROM, steepness));
}

fn coordinate(line: Along, blend: u32) -> Coordinate {
    let is_upright = blend >= 4u;
    let first = floor(line.azimuth);
    let is_second = (blend & 2u) != 0u;
    let next = smoothstep(FADE_FROM, FADE_TO, line.azimuth - first);
    let of_azimuth = (1.0 - line.upright) * select(1.0 - next, next, is_second);
    let of_axis = select(of_azimuth, line.upright, is_upright);
    let azimuth = (i32(first) + select(0, 1, is_second)) % AXES;
    let angle = f32(azimuth) * TURN / f32(AXES);
    let axis = select(vec3<f32>(sin(angle), cos(angle), 0.0), vec3<f32>(0.0, 0.0, 1.0), is_upright);
    let change_m = max(abs(dot(axis, line.step_m)), 1e-12);
    let step = clamp(2.0 * log2(change_m) - f32(curvature_lines.first_level), 0.0, f32(curvature_lines.level_count) - 1.001);
    let coarser = smoothstep(FADE_FROM, FADE_TO, fract(step));
    let is_coarser = (blend & 1u) != 0u;
    let level = i32(floor(step)) + select(0, 1, is_coarser);
    let number = select(azimuth, AXES, is_upright) * curvature_lines.level_count + level;
    let texels_per_m = exp2(-0.5 * f32(level + curvature_lines.first_level));
    let u_px = line_phases[number] + dot(axis, line.at_m) * texels_per_m;
    return Coordinate(u_px, of_axis * select(1.0 - coarser, coarser, is_coarser), u32(number));
}

#ifdef TEXTURED
// Returns the ink of a line at a distance from its centre.
fn ink_of(line: Along, across_px: f32, half_width_px: f32) -> f32 {
    let covered = clamp(half_width_px + 0.5 - abs(across_px), 0.0, 1.0);
    if covered <= 0.0 {
        return 0.0;
    }
    var ink = 0.0;
    for (var blend = 0u; blend < COORDINATES; blend++) {
        let u = coordinate(line, blend);
        if u.weight > 0.0 {
            let uv = brush_uv(brush, u.u_px, across_px, max(half_width_px, 0.25), u.id);
            let texel = textureSampleLevel(brush_tile, brush_sampler, uv, 0.0).xy;
            ink += u.weight * brush_ink(brush, texel, 1.0, abs(across_px), half_width_px);
        }
    }
    return covered * ink;
}
#else
// Returns the ink of a line at a distance from its centre.
fn ink_of(line: Along, across_px: f32, half_width_px: f32) -> f32 {
    let border_px = max(curvature_lines.taper * half_width_px, 0.5);
    return clamp((half_width_px + 0.5 * border_px - abs(across_px)) / border_px, 0.0, 1.0);
}
#endif

// Returns the sideways swing of a line.
fn swing_px(line: Along) -> f32 {
    if curvature_lines.warp_px == 0.0 {
        return 0.0;
    }
    var swing = 0.0;
    for (var blend = 0u; blend < COORDINATES; blend++) {
        let u = coordinate(line, blend);
        swing += u.weight * sin(u.u_px * TURN / curvature_lines.warp_length_px);
    }
    return curvature_lines.warp_px * swing;
}

// Values interpolated between four blocks around a pixel.
struct Between {
    // As in `radial`.
    own: vec4<f32>,
    // Gradient of the curvature over the picture, per pixel.
    slope: vec2<f32>,
    // True if all four blocks are of the pixel's surface.
    is_whole: bool,
    is_there: bool,
}

fn between(pixel: vec2<i32>, at: vec4<f32>, n: vec3<f32>) -> Between {
    let place = vec2<f32>(pixel + view.origin_px - BLOCK_PX / 2) / f32(BLOCK_PX);
    let first = vec2<i32>(floor(place)) - first_block(view);
    let f = fract(place);
    let last = vec2<i32>(block_count(view)) - 1;
    let allowed_m = ON_PLANE * f32(BLOCK_PX) * distance_from_eye(view, at.xyz) / view.focal_px;
    var found: array<vec4<f32>, 4>;
    var sum = vec4<f32>(0.0);
    var weights = 0.0;
    var count = 0;
    for (var i = 0; i < 4; i++) {
        let offset = vec2<i32>(i & 1, i >> 1u);
        let block = clamp(first + offset, vec2<i32>(0), last);
        found[i] = textureLoad(radial, block, 0);
        let away_m = place_of_pixel(view, pixel_of_block(view, block), found[i].w) - at.xyz;
        if found[i].w > 0.0 && abs(dot(n, away_m)) < allowed_m {
            let weight = mix(1.0 - f.x, f.x, f32(offset.x)) * mix(1.0 - f.y, f.y, f32(offset.y)) + 1e-4;
            sum += weight * found[i];
            weights += weight;
            count++;
        }
    }
    let slope = vec2<f32>(mix(found[1].x - found[0].x, found[3].x - found[2].x, f.y),
        mix(found[2].x - found[0].x, found[3].x - found[1].x, f.x)) / f32(BLOCK_PX);
    return Between(sum / max(weights, 1e-6), slope, count == 4, count > 0);
}

// Returns the cosine between the normal and the direction to the eye.
fn facing_of(at: vec4<f32>, n: vec3<f32>) -> f32 {
    return dot(n, normalize(view.eye_m - at.xyz));
}

// Estimates how far before the contour a pixel is from how its cosine differs from its neighbours': near a contour the
// cosine is the square root of the distance. This catches details of the land that its smoothed form lacks.
fn from_contour_by_sides(pixel: vec2<i32>, at: vec4<f32>, n: vec3<f32>, facing: f32) -> f32 {
    let last = vec2<i32>(view.size_px) - 1;
    let allowed_m = 2.0 * distance_from_eye(view, at.xyz) / view.focal_px;
    var most = 0.0;
    for (var i = 0; i < 4; i++) {
        let side = select(-1, 1, (i & 1) == 1);
        let neighbour = clamp(pixel + select(vec2<i32>(0, side), vec2<i32>(side, 0), i < 2), vec2<i32>(0), last);
        let there = place_seen(view, distance_m, neighbour);
        if there.w > 0.0 && abs(dot(n, there.xyz - at.xyz)) < allowed_m {
            most = max(most, abs(facing_of(there, normal_seen(normal, neighbour)) - facing));
        }
    }
    return 0.5 * abs(facing) / max(most, 1e-4);
}

// Largest cosine of a pixel near a contour, whatever the curvature of the land; and the largest for the estimate from
// neighbours.
const LARGEST_COSINE: f32 = 0.5;
const LARGEST_COSINE_BY_SIDES: f32 = 0.18;

fn contour_ink(pixel: vec2<i32>, at: vec4<f32>, n: vec3<f32>, bend: f32) -> f32 {
    let facing = facing_of(at, n);
    if facing < -0.1 || facing > LARGEST_COSINE {
        return 0.0;
    }
    var from_contour_px = facing * facing / (2.0 * max(bend, MIN_BEND));
    if from_contour_px > 0.5 * curvature_lines.width_px && facing < LARGEST_COSINE_BY_SIDES {
        from_contour_px = min(from_contour_px, from_contour_by_sides(pixel, at, n, facing));
    }
    if from_contour_px > curvature_lines.width_px + curvature_lines.warp_px + 1.0 {
        return 0.0;
    }
    let aside = (view.clip_from_camera * vec4<f32>(n, 0.0)).xy * vec2<f32>(1.0, -1.0);
    let along = normalize(vec2<f32>(aside.y, -aside.x) + vec2<f32>(1e-9, 0.0));
    // The whole line is on the visible side.
    let half_px = 0.5 * curvature_lines.width_px;
    let line = along_line(at, along);
    return ink_of(line, from_contour_px - half_px - 0.5 * (swing_px(line) + curvature_lines.warp_px), half_px);
}

fn suggestive_ink(at: vec4<f32>, seen: Between) -> f32 {
    let steepness = length(seen.slope);
    let half_px = 0.5 * curvature_lines.suggestive_px;
    if half_px <= 0.0 || !seen.is_whole || steepness <= 0.0 || seen.own.z > curvature_lines.largest_cosine || seen.own.z <= 0.0 {
        return 0.0;
    }
    let along = vec2<f32>(seen.slope.y, -seen.slope.x) / steepness;
    let line = along_line(at, along);
    let across_px = seen.own.x / steepness - swing_px(line);
    // Lines fade in and out with the rise.
    let strength = clamp(seen.own.y / max(curvature_lines.min_rise, 1e-4) - 1.0, 0.0, 1.0);
    return ink_of(line, across_px, half_px * strength) * min(2.0 * half_px * strength, 1.0);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = place_seen(view, distance_m, pixel);
    var ink = textureLoad(tree_line, min(pixel, vec2<i32>(textureDimensions(tree_line)) - 1), 0).r;
    if at.w > 0.0 && has_trait(id_seen(surface_id, pixel), SMOOTH) {
        let n = normal_seen(normal, pixel);
        let seen = between(pixel, at, n);
        if seen.is_there {
            ink = max(ink, max(contour_ink(pixel, at, n, seen.own.x), suggestive_ink(at, seen)));
        }
    }
    textureStore(line, pixel, vec4<f32>(ink, 0.0, 0.0, 0.0));
}
