// Contour lines on the visible land.
//
// A pixel knows the height of the land's form and its gradient over the picture, so its distance from the nearest line
// is the difference of height divided by the gradient. This is exact where the form is a plane within a line's width,
// and needs no neighbours: lines are as sharp at the borders of parts and where land hides land. The form is the one
// used for light (form.wgsl): a cartographer draws lines as calm as the map's scale (Imhof 1965, on generalisation).
//
// Lines are interrupted where `gaps` has a box: there is a number. A box may also interrupt a neighbouring line, which
// would make the number hard to read.
//
// Every `index`-th line, usually every fifth, is heavier. Lines that are too close to be distinguished fade out, and
// the heavier ones after them.
#import hachure::view::View
#import hachure::seen::place_seen
#import hachure::terrain::{terrain, grid_from_world}
#import hachure::earth::{bend_normal, unbend}
#import hachure::form::{form_of_level, level_seen, steps_on_plane}
#import hachure::surface_id::{has_trait, id_seen, ON_GRID}
#import hachure::line_ink::line_ink

struct HeightLineRules {
    interval_m: f32,
    // Height of the rig's origin above an index line (a heavier line).
    phase_m: f32,
    line_px: f32,
    index_px: f32,
    form_px: f32,
    // Number of intervals between index lines.
    index: f32,
    // Tangent of the slope above which land has no lines.
    steepest: f32,
    // 1: lines are drawn on the ground of the sea, 0: on land.
    in_sea: u32,
    // Height of the surface of the sea from the rig's origin, in metres.
    sea_m: f32,
}

// A box in which lines are interrupted, in pixels of the whole picture.
struct LineGap {
    centre_px: vec2<f32>,
    // Unit vector of the box's length.
    along: vec2<f32>,
    // Half of the length and of the height. A negative length ends the list.
    half_px: vec2<f32>,
    pad: vec2<f32>,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> rules: HeightLineRules;
@group(0) @binding(2) var surface_id: texture_2d<u32>;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
// Positive on water, which is level, so that a line of its height would wander along its shores. A single texel without
// water.
@group(0) @binding(4) var water: texture_2d<f32>;
// Ink, 0 to 1.
@group(0) @binding(5) var ink: texture_storage_2d<r32float, write>;
@group(0) @binding(6) var<storage, read> gaps: array<LineGap>;

// Distance between contour lines below which they are not drawn; from twice that distance on they are drawn fully.
const MIN_GAP_PX: f32 = 2.0;
// Depth from which the ground of the sea has lines, in intervals.
const SHALLOWEST: f32 = 0.5;
// Distance between contour lines above which the land is so level that a line on it would be a blot.
const MAX_GAP_PX: f32 = 800.0;

// Returns the ink of lines `interval_m` apart at a height that changes by `rise_m` per pixel.
fn lines(height_m: f32, rise_m: f32, interval_m: f32, width_px: f32) -> f32 {
    let gap_px = interval_m / max(rise_m, 1e-9 * interval_m);
    let away_px = abs(height_m / interval_m - round(height_m / interval_m)) * gap_px;
    let cover = line_ink(away_px, width_px);
    let are_apart = smoothstep(MIN_GAP_PX, 2.0 * MIN_GAP_PX, gap_px / max(width_px, 1.0));
    return cover * are_apart * (1.0 - smoothstep(0.5 * MAX_GAP_PX, MAX_GAP_PX, gap_px));
}

// Returns the part of a pixel that is in no gap. `px` is its centre in the whole picture.
fn outside_gaps(px: vec2<f32>) -> f32 {
    var outside = 1.0;
    for (var i = 0u; i < arrayLength(&gaps); i++) {
        let gap = gaps[i];
        if gap.half_px.x < 0.0 {
            break;
        }
        let away = px - gap.centre_px;
        let across = vec2<f32>(-gap.along.y, gap.along.x);
        let inset = gap.half_px - abs(vec2<f32>(dot(away, gap.along), dot(away, across)));
        outside = min(outside, clamp(0.5 - min(inset.x, inset.y), 0.0, 1.0));
    }
    return outside;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = place_seen(view, distance_m, pixel);
    let on_water = textureLoad(water, min(pixel, vec2<i32>(textureDimensions(water)) - 1), 0).r > 0.0;
    if at.w <= 0.0 || on_water && rules.in_sea == 0u || !has_trait(id_seen(surface_id, pixel), ON_GRID) {
        textureStore(ink, pixel, vec4<f32>(0.0));
        return;
    }
    let flat_place = unbend(at.xyz);
    let point = grid_from_world(flat_place.flat_m.xy);
    let level = level_seen(view, at.xyz, flat_place, point, rules.form_px);
    let form = form_of_level(point.g, level);
    let slope = vec2<f32>(dot(form.gradient, point.dg_dx), dot(form.gradient, point.dg_dy));
    let steps = steps_on_plane(view, pixel, at.w, bend_normal(flat_place, slope));
    let rise_m = length(vec2<f32>(dot(slope, steps[0].xy), dot(slope, steps[1].xy)));
    // The shore is a line of the water.
    if rules.in_sea == 1u && form.height_m > rules.sea_m - SHALLOWEST * rules.interval_m {
        textureStore(ink, pixel, vec4<f32>(0.0));
        return;
    }
    let height_m = form.height_m + rules.phase_m;
    let interval_m = rules.interval_m;
    let index_m = interval_m * rules.index;
    let drawn = max(
        lines(height_m, rise_m, interval_m, rules.line_px),
        lines(height_m, rise_m, index_m, rules.index_px));
    let is_gentle = 1.0 - smoothstep(0.8 * rules.steepest, rules.steepest, length(slope));
    var inked = drawn * is_gentle;
    if inked > 0.0 {
        inked *= outside_gaps(vec2<f32>(pixel + view.origin_px) + 0.5 - view.jitter_px);
    }
    textureStore(ink, pixel, vec4<f32>(inked));
}
