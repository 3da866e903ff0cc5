// Dashed lines around holes in the visible land.
//
// The rim is where the no-data share passes the value at which land ends (surface.wgsl), so a line follows it exactly,
// and is as smooth. Its ink is on the land's side: anything may be visible through the hole. A pixel evaluates the
// share at its centre and one pixel to each side, on the plane that it shows: a pixel of land at a flat angle covers
// many samples, and one sample covers many pixels of near land.
//
// Dashes are counted along the rim. From a pixel's position the rim is followed both ways to the next line of a lattice
// fixed to the samples, and a whole number of dashes fits between two such points: all pixels of a rim agree on them,
// dashes are even, and they stay on the land when the eye moves. A rim that crosses no lattice line is a small ring,
// whose dashes begin at its northernmost point.
#import hachure::power::power
#import hachure::view::View
#import hachure::seen::{normal_seen, place_seen}
#import hachure::terrain::{levels, grid_from_world, place_on_level, surface_level}
#import hachure::surface::{cell_at, void_share, RIM_SHARE}
#import hachure::earth::unbend
#import hachure::form::steps_on_plane
#import hachure::surface_id::{has_trait, id_seen, ON_GRID}

struct RimRules {
    width_px: f32,
    // Distance from one dash to the next.
    period_px: f32,
    // Part of the period that a dash covers, 0 to 1.
    dash: f32,
}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> rim_rules: RimRules;
@group(0) @binding(2) var surface_id: texture_2d<u32>;
@group(0) @binding(3) var distance_m: texture_2d<f32>;
@group(0) @binding(4) var normal: texture_2d<u32>;
// Ink, 0 to 1; and 1 on land next to a hole.
@group(0) @binding(5) var rim: texture_storage_2d<rg32float, write>;

// Distance from a hole within which land is marked as next to it.
const NEAR_RIM_PX: f32 = 2.0;
// Largest distance to the side at which the share is evaluated, in samples; a pixel at a flat angle may cover more.
const MAX_SAMPLES: f32 = 4.0;
// Largest distance between lattice lines in dashes, and as a part of the longest walk, since rims are not straight; and
// offset of the lattice in samples, since rims often run along these.
const LATTICE_DASHES: f32 = 6.0;
const LATTICE_REACH: f32 = 0.5;
const LATTICE_BEGINS: f32 = 0.43;
// Number of steps along the rim, and their greatest lengths.
const STEPS: i32 = 96;
const STEP_SAMPLES: f32 = 0.5;
const STEP_PX: f32 = 2.0;

// The level of a pixel, and the steps on the picture (right, down) per sample along each axis.
var<private> level: i32;
var<private> px_per_sample: mat2x2<f32>;

// Returns the no-data share and its gradient, at a position in the level's samples relative to the anchor's.
fn share_at(place: vec2<f32>) -> vec3<f32> {
    let info = levels[level];
    let g = (place - info.fraction) / info.scale;
    return void_share(cell_at(place_on_level(level, g), g));
}

// Returns a value that is 1 at the rim and rises by 1 per sample next to straight rims.
fn nearness(share: f32) -> f32 {
    return power(share / RIM_SHARE, 1.0 / 3.0);
}

// Returns the step from a position to the rim.
fn to_rim(share: vec3<f32>) -> vec2<f32> {
    let step = (RIM_SHARE - share.x) * share.yz / max(dot(share.yz, share.yz), 1e-6);
    return step / max(1.0, 2.0 * length(step));
}

// Length of a ring in dashes up to which it is not drawn, and from which on it is whole.
const RING_DASHES: vec2<f32> = vec2<f32>(1.0, 2.5);
// Sizes of samples in pixels between which ink goes from pale to full: where samples are as small as pixels, rims are
// ragged and crowded.
const RAGGED_PX: vec2<f32> = vec2<f32>(1.0, 4.0);
const RAGGED_INK: f32 = 0.5;

// The result of a walk along the rim.
struct Walk {
    // Length to a lattice line, or of the whole walk.
    length_px: f32,
    meets_line: bool,
    is_ring: bool,
    // The northernmost coordinate, and the length of the walk to it.
    north: f32,
    north_px: f32,
}

// Returns where a step crosses a lattice line that the rim crosses rather than follows, as a part of the step; 2 if
// nowhere. The rim's own direction decides, not that of the step, because other pixels have different steps.
fn crossing(begun: vec2<f32>, ended: vec2<f32>, place: vec2<f32>, next: vec2<f32>) -> f32 {
    let is_over = floor(begun) != floor(ended);
    if !any(is_over) {
        return 2.0;
    }
    let parts = clamp((max(floor(begun), floor(ended)) - begun) / select(vec2<f32>(1.0), ended - begun, is_over),
        vec2<f32>(0.0), vec2<f32>(1.0));
    var nearest = 2.0;
    for (var axis = 0; axis < 2; axis++) {
        if is_over[axis] {
            let slope = abs(share_at(mix(place, next, parts[axis])).yz);
            let is_across = select(slope.x > slope.y, slope.y >= slope.x, axis == 0);
            nearest = select(nearest, min(nearest, parts[axis]), is_across);
        }
    }
    return nearest;
}

fn walk(start: vec2<f32>, side: f32, lattice: f32) -> Walk {
    let begins = LATTICE_BEGINS - vec2<f32>(levels[level].cell & vec2<i32>(4095));
    var found = Walk(0.0, false, false, start.y, 0.0);
    var place = start;
    var slope = share_at(place).yz;
    for (var i = 0; i < STEPS; i++) {
        let ahead = side * normalize(vec2<f32>(-slope.y, slope.x) + 1e-9);
        let step = min(STEP_SAMPLES, STEP_PX / max(length(px_per_sample * ahead), 1e-6));
        let there = place + step * ahead;
        let share = share_at(there);
        let next = there + to_rim(share);
        let moved = next - place;
        let moved_px = length(px_per_sample * moved);
        let crossed = crossing((place - begins) / lattice, (next - begins) / lattice, place, next);
        if crossed <= 1.0 {
            found.length_px += moved_px * crossed;
            found.meets_line = true;
            return found;
        }
        found.length_px += moved_px;
        if next.y < found.north {
            found.north = next.y;
            found.north_px = found.length_px;
        }
        if i > 2 && distance(next, start) < 0.75 * step {
            found.is_ring = true;
            return found;
        }
        place = next;
        slope = share.yz;
    }
    return found;
}

// Returns the coverage of a dash at a point of the rim, 0 to 1.
fn dash_at(start: vec2<f32>) -> f32 {
    let sample_px = sqrt(abs(determinant(px_per_sample)));
    var ink = mix(RAGGED_INK, 1.0, smoothstep(RAGGED_PX.x, RAGGED_PX.y, sample_px));
    let reach_px = f32(STEPS) * min(STEP_SAMPLES * sample_px, STEP_PX);
    let lattice_px = min(LATTICE_DASHES * rim_rules.period_px, LATTICE_REACH * reach_px);
    // Spacings are powers of two, so the lattice of a coarser level, or of a picture from farther away, is a subset of
    // this one.
    let lattice = exp2(clamp(floor(log2(lattice_px / max(sample_px, 1e-6))), -8.0, 8.0));
    let back = walk(start, -1.0, lattice);
    let on = walk(start, 1.0, lattice);
    var before_px = back.length_px;
    var whole_px = back.length_px + on.length_px;
    if !back.meets_line && !on.meets_line && on.is_ring {
        before_px = on.north_px;
        whole_px = on.length_px;
        ink *= smoothstep(RING_DASHES.x, RING_DASHES.y, whole_px / rim_rules.period_px);
    }
    if rim_rules.dash >= 1.0 {
        return ink;
    }
    let dashes = max(round(whole_px / rim_rules.period_px), 1.0);
    let period_px = whole_px / dashes;
    let away_px = abs(fract(before_px / period_px) - 0.5) * period_px;
    return ink * clamp(0.5 * rim_rules.dash * period_px + 0.5 - away_px, 0.0, 1.0);
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= view.size_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let at = place_seen(view, distance_m, pixel);
    if at.w <= 0.0 || !has_trait(id_seen(surface_id, pixel), ON_GRID) {
        textureStore(rim, pixel, vec4<f32>(0.0));
        return;
    }
    let flat_m = unbend(at.xyz).flat_m;
    let point = grid_from_world(flat_m.xy);
    level = cell_at(surface_level(point.g, length(flat_m)).place, point.g).level;
    let info = levels[level];
    let place = point.g * info.scale + info.fraction;
    let steps = steps_on_plane(view, pixel, at.w, normal_seen(normal, pixel));
    let right = (point.dg_dx * steps[0].x + point.dg_dy * steps[0].y) * info.scale;
    let down = (point.dg_dx * steps[1].x + point.dg_dy * steps[1].y) * info.scale;
    let aside = mat2x2<f32>(right / max(1.0, length(right) / MAX_SAMPLES), down / max(1.0, length(down) / MAX_SAMPLES));
    let share = share_at(place);
    let here = nearness(share.x);
    let east = nearness(share_at(place + aside[0]).x);
    let west = nearness(share_at(place - aside[0]).x);
    let south = nearness(share_at(place + aside[1]).x);
    let north = nearness(share_at(place - aside[1]).x);
    let rise = length(max(max(vec2<f32>(east, south) - here, here - vec2<f32>(east, south)),
        max(vec2<f32>(west, north) - here, here - vec2<f32>(west, north))));
    let away_px = max(1.0 - here, 0.0) / max(rise, 1e-9);
    let width_px = rim_rules.width_px;
    var ink = min(2.0 * width_px, 1.0) * clamp(max(width_px, 0.5) + 0.5 - away_px, 0.0, 1.0);
    if ink > 0.0 {
        let area = right.x * down.y - right.y * down.x;
        px_per_sample = mat2x2<f32>(vec2<f32>(down.y, -right.y), vec2<f32>(-down.x, right.x))
            * (1.0 / select(area, 1e-9, abs(area) < 1e-9));
        var start = place;
        for (var i = 0; i < 3; i++) {
            start += to_rim(share_at(start));
        }
        ink *= dash_at(start);
    }
    textureStore(rim, pixel, vec4<f32>(ink, select(0.0, 1.0, away_px < NEAR_RIM_PX), 0.0, 0.0));
}
