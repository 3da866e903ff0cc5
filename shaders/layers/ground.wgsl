// Marks of what the ground is made of: tufts of grass on gentle slopes, and stones below rock. Rock itself is left to
// lines and tones.
//
// A draughtsman leaves no foreground empty: a few small marks say what a slope is made of, more of them near the eye and
// in the shade, in loose groups and not everywhere (Sloan 1984, "Landscape Illustration"; Imhof 1965, "Kartographische
// Geländedarstellung", on scree and rock). What the ground is made of follows its slope: soil creeps off rock, and
// stones come to rest at 30 to 37 degrees. Above a height there is no grass, and still higher there is snow.
//
// Marks are at the grid points of two axes, north and east, each point displaced at random, as the dots of
// `shared/dots.wgsl` are: each axis has the power of two of a metre whose points are as far apart on the picture as
// marks should be. A mark belongs to a place of the world, marks only come between others when the eye comes nearer, and
// a mark is drawn on the picture, upright and in pixels, so that it is legible at any angle.
#import hachure::view::{View, distance_from_eye}
#import hachure::seen::place_seen
#import hachure::terrain::{terrain, grid_from_world}
#import hachure::earth::{bend_normal, unbend}
#import hachure::form::{form_of_level, steps_on_plane}
#import hachure::surface_id::{has_trait, id_seen, ON_GRID}
#import hachure::line_ink::line_ink
#import hachure::dots::{DotAxis, identity_of, of_row, stirred_bits}

struct GroundRules {
    // Position of the rig's origin on the map, modulo `PERIOD_M`, east and north.
    phase_m: vec2<f32>,
    size_px: f32,
    spacing_px: f32,
    line_px: f32,
    // Size of a pixel on the ground at which the last marks disappear.
    farthest_m: f32,
    // Part of the grid points that have a mark in the light, and how many more have one in the dark.
    lit: f32,
    dark: f32,
    // Sines of the slopes from which on there are stones, and rock.
    stones: f32,
    rock: f32,
    // Height of the rig's origin, in metres of the world, and the world's exaggeration.
    origin_height_m: f32,
    exaggeration: f32,
    // True heights up to which there is grass, and stones.
    grass_m: f32,
    snow_m: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> rules: GroundRules;
@group(0) @binding(2) var surface_id: texture_2d<u32>;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
@group(0) @binding(4) var tone: texture_2d<f32>;
// Metres to the shore on water; negative on land near the shore; 0 elsewhere.
@group(0) @binding(5) var water: texture_2d<f32>;
@group(0) @binding(6) var ink: texture_storage_2d<r32float, write>;

// Period of the numbers of grid points; a power of two that f32 resolves to centimetres.
const PERIOD_M: f32 = 65536.0;
// Binary logarithm of the smallest distance between grid points, in metres.
const FIRST_LEVEL: i32 = -6;
// Size of the smoothed form that slopes are taken from, in pixels.
const FORM_PX: f32 = 10.0;
// Marks become fewer where a pixel on the ground is larger than this part of `farthest_m`.
const NEAR: f32 = 0.12;
// The size of a mark, relative to the style's, is this number divided by the root of the pixel's part of `farthest_m`,
// within limits.
const GROWTH: f32 = 0.36;
const LARGEST: f32 = 2.0;
const SMALLEST: f32 = 0.4;
// Largest displacement of a grid point, in distances between marks.
const STRAY: f32 = 0.2;
// Size of groups of marks in distances between marks.
const GROUP: f32 = 5.0;
// Noise from which on there are marks, from which on there are all, and how much it changes across a mark at most.
const GROUP_FROM: f32 = 0.42;
const GROUP_TO: f32 = 0.68;
const GROUP_CHANGE: f32 = 0.16;
// Largest size of a mark, in distances between marks.
const LARGEST_PART: f32 = 0.7;
// Largest difference of a mark's own limits of height from those of the style.
const MIXED_M: f32 = 150.0;
// Slope below which even grass is not drawn: plains, as a sine.
const PLAIN: f32 = 0.03;

// Returns the distance from a point to the segment from a to b, and the position along it, 0 to 1.
fn to_segment(p: vec2<f32>, a: vec2<f32>, b: vec2<f32>) -> vec2<f32> {
    let along = b - a;
    let t = clamp(dot(p - a, along) / max(dot(along, along), 1e-9), 0.0, 1.0);
    return vec2<f32>(length(p - a - t * along), t);
}

// Returns the ink of a stroke that narrows from a width at `a` to a part of it at `b`.
fn stroke(p: vec2<f32>, a: vec2<f32>, b: vec2<f32>, width_px: f32, end: f32) -> f32 {
    let near = to_segment(p, a, b);
    let wide = width_px * mix(1.0, end, near.y);
    return line_ink(near.x, wide);
}

// Returns a number from -1 to 1 from four bits.
fn part_of(bits: u32, shift: u32) -> f32 {
    return f32((bits >> shift) & 15u) / 7.5 - 1.0;
}

// A tuft: three or four blades that lean apart, and a shade at the foot. `p` is the position relative to the place of the
// mark; y points down.
fn tuft(p: vec2<f32>, size_px: f32, bits: u32) -> f32 {
    let wide = rules.line_px;
    let foot = vec2<f32>(0.0, 0.35 * size_px);
    let lean = 0.25 * part_of(bits, 0u);
    let last = select(1, 2, (bits & 32u) == 32u);
    var drawn = 0.0;
    for (var i = -1; i <= last; i++) {
        let side = f32(i) * select(1.0, 0.7, last == 2) - select(0.0, 0.35, last == 2);
        let tall = (0.9 - 0.35 * abs(side)) * (1.0 + 0.25 * part_of(bits, u32(4 * (i + 2))));
        let from_px = foot + vec2<f32>(0.1 * side, 0.0) * size_px;
        let to_px = foot + vec2<f32>(0.4 * side + lean, -tall) * size_px;
        drawn = max(drawn, stroke(p, from_px, to_px, wide, 0.35));
    }
    let shade = foot + vec2<f32>(0.55 * size_px, 0.02 * size_px);
    return max(drawn, 0.6 * stroke(p, foot, shade, wide, 0.3));
}

// A stone: the shaded half of its outline, with a smaller stone next to it.
fn stone(p: vec2<f32>, size_px: f32, bits: u32) -> f32 {
    let radius_px = size_px * (0.36 + 0.12 * part_of(bits, 0u));
    let q = vec2<f32>(p.x, p.y * (1.3 + 0.2 * part_of(bits, 4u)));
    // Corners, so that it is a stone and not a ball.
    let turn = atan2(q.y, q.x);
    let rough = radius_px * (1.0 + 0.12 * cos(3.0 * turn + 3.0 * part_of(bits, 8u)));
    let away_px = abs(length(q) - rough);
    let in_shade = smoothstep(-0.35, 0.45, dot(q, vec2<f32>(0.6, 0.8)) / max(length(q), 1e-3));
    let wide = rules.line_px * mix(0.5, 1.4, in_shade);
    let outline = line_ink(away_px, wide) * mix(0.4, 1.0, in_shade);
    let beside = p - vec2<f32>(0.62 + 0.1 * part_of(bits, 12u), 0.18) * size_px * sign(part_of(bits, 16u));
    let pebble = clamp(0.09 * size_px + 0.5 - length(beside), 0.0, 1.0);
    return max(outline, 0.8 * pebble);
}

// Returns the axis of a coordinate: its nearest grid point, where `change` is its change from pixel to pixel.
fn axis_of(place_m: f32, change: vec2<f32>, apart_px: f32) -> DotAxis {
    let apart_m = apart_px * max(length(change), 1e-9);
    let level = max(i32(floor(log2(apart_m))), FIRST_LEVEL);
    let step_m = exp2(f32(level));
    let u = place_m / step_m;
    let nearest = round(u);
    let count = i32(PERIOD_M / step_m);
    let index = (i32(nearest) % count + count) % count;
    return DotAxis(index, level, u - nearest, clamp(apart_m / step_m, 1.0, 2.0), change / step_m);
}

// Returns smooth noise from 0 to 1 at a place of the map, in cells of a power of two of a metre.
fn group_noise(place_m: vec2<f32>, cell_m: f32) -> f32 {
    let count = i32(PERIOD_M / cell_m);
    let whole = floor(place_m / cell_m);
    let f = smoothstep(vec2<f32>(0.0), vec2<f32>(1.0), place_m / cell_m - whole);
    var corners = vec4<f32>(0.0);
    for (var i = 0; i < 4; i++) {
        let corner = (vec2<i32>(whole) + vec2<i32>(i & 1, i >> 1u)) % count;
        let wrapped = (corner + count) % count;
        corners[i] = f32(stirred_bits(u32(wrapped.x) ^ stirred_bits(u32(wrapped.y) + 91u)) >> 8u) / 16777216.0;
    }
    return mix(mix(corners.x, corners.y, f.x), mix(corners.z, corners.w, f.x), f.y);
}

fn group_at(place_m: vec2<f32>, finer_m: f32, coarser: f32) -> f32 {
    return mix(group_noise(place_m, finer_m), group_noise(place_m, 2.0 * finer_m), coarser);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = place_seen(view, distance_m, pixel);
    let pixel_m = distance_from_eye(view, at.xyz) / view.focal_px;
    let is_land = at.w > 0.0 && has_trait(id_seen(surface_id, pixel), ON_GRID) && textureLoad(water, pixel, 0).r <= 0.0;
    if !is_land || pixel_m >= rules.farthest_m {
        textureStore(ink, pixel, vec4<f32>(0.0));
        return;
    }
    let flat_place = unbend(at.xyz);
    let place_m = flat_place.flat_m.xy + rules.phase_m;
    let away = clamp(pixel_m / rules.farthest_m, 0.0, 1.0);
    let near = 1.0 - smoothstep(NEAR, 1.0, away);
    // Marks grow toward the eye, more slowly than the land does.
    let scale = clamp(GROWTH * inverseSqrt(max(away, 1e-4)), SMALLEST, LARGEST);
    let apart_px = rules.spacing_px * scale;
    // A pixel looks at the nearest grid points, so no mark may be wider than their distance.
    let size_px = min(rules.size_px * scale, LARGEST_PART * apart_px);
    // Groups have a size of their own on the ground, which doubles with distance.
    let wanted = log2(GROUP * apart_px * pixel_m);
    let finer = exp2(floor(wanted));
    if near <= 0.0 || group_at(place_m, finer, fract(wanted)) < GROUP_FROM - GROUP_CHANGE {
        // Between groups, which is most of the land, nothing else is computed.
        textureStore(ink, pixel, vec4<f32>(0.0));
        return;
    }
    let point = grid_from_world(flat_place.flat_m.xy);
    let form = form_of_level(point.g, log2(max(FORM_PX * pixel_m / terrain.spacing_m, 1e-6)));
    let gradient = form.gradient;
    let height_m = (form.height_m + rules.origin_height_m) / rules.exaggeration;
    let slope = vec2<f32>(dot(gradient, point.dg_dx), dot(gradient, point.dg_dy));
    let normal = bend_normal(flat_place, slope);
    let steps = steps_on_plane(view, pixel, at.w, normal);
    // The true slope decides.
    let true_slope = slope / rules.exaggeration;
    let steep = length(true_slope) * inverseSqrt(1.0 + dot(true_slope, true_slope));

    let all = axis_of(place_m.x, vec2<f32>(steps[0].x, steps[1].x), apart_px);
    let v = axis_of(place_m.y, vec2<f32>(steps[0].y, steps[1].y), apart_px);
    let det = all.change.x * v.change.y - all.change.y * v.change.x;
    let by_det = 1.0 / select(det, 1e-12, abs(det) < 1e-12);

    var drawn = 0.0;
    for (var i = 0; i < 9; i++) {
        let step = vec2<i32>(i % 3 - 1, i / 3 - 1);
        let u = of_row(all, identity_of(v.index + step.y, v.level));
        let identity = stirred_bits(identity_of(u.index + step.x, u.level) ^ stirred_bits(identity_of(v.index + step.y, v.level)));
        let strays = (vec2<f32>(vec2<u32>(identity & 0xfffu, (identity >> 12u) & 0xfffu)) / 2048.0 - 1.0) * STRAY;
        let off = vec2<f32>(step) - vec2<f32>(u.rest, v.rest) + strays * vec2<f32>(u.apart, v.apart);
        let away_px = vec2<f32>(off.x * v.change.y - off.y * u.change.y, u.change.x * off.y - v.change.x * off.x) * by_det;
        // Of grid points that the coarser level lacks, fewer have a mark.
        let is_finer = (vec2<i32>(u.index, v.index) + step) & vec2<i32>(1);
        let parts = select(vec2<f32>(1.0), 2.0 / vec2<f32>(u.apart, v.apart) - 1.0, is_finer != vec2<i32>(0));
        let more = stirred_bits(identity);
        let order = f32(more >> 8u) / 16777216.0;
        if order >= 1.15 * near * parts.x * parts.y {
            continue;
        }
        // Whether there is a mark follows from its own place, so that no mark is drawn in part.
        let mark_m = place_m + off * vec2<f32>(exp2(f32(u.level)), exp2(f32(v.level)));
        let gathered = smoothstep(GROUP_FROM, GROUP_TO, group_at(mark_m, finer, fract(wanted)));
        let foot = clamp(pixel + vec2<i32>(round(away_px)), vec2<i32>(0), vec2<i32>(view.size_px) - 1);
        let dark = clamp(1.0 - textureLoad(tone, foot, 0).a, 0.0, 1.0);
        let amount = (rules.lit + rules.dark * dark) * near * gathered;
        let grown = clamp((parts.x * parts.y * amount * 1.15 - order) / 0.15, 0.0, 1.0);
        if grown > 0.0 {
            let bits = stirred_bits(more);
            // Each mark has its own limits, so that materials mix where they meet.
            let own = steep + 0.06 * part_of(bits, 24u);
            let own_m = height_m + MIXED_M * part_of(bits, 28u);
            let marked = size_px * grown * (0.8 + 0.35 * part_of(bits, 20u));
            if own > rules.rock || own_m > rules.snow_m {
                continue;
            }
            var one = 0.0;
            if own > rules.stones || own_m > rules.grass_m {
                one = stone(-away_px, marked, bits);
            } else if steep > PLAIN {
                one = tuft(-away_px, marked, bits);
            }
            drawn = max(drawn, one * smoothstep(0.2, 0.6, grown));
        }
    }
    textureStore(ink, pixel, vec4<f32>(drawn));
}
