// Resamples strokes at even distances.
//
// Points of chains are where edges of the mesh end: one pixel apart or a hundred. Samples are at most 2 px apart, so
// that their data (pressure, texture, the previous line) reach every part of a stroke.
#import hachure::view::{View, place_at, ray_at}
#import hachure::wobble::{Anchor, wobble}
#import hachure::strokes::{Chain, UNITS_PER_PX}
#import hachure::edges::{KIND_BORDER, KIND_SUGGESTIVE, KIND_RIDGE, KIND_VALLEY}
#import hachure::stroke_style::{Point, Strokes, fold_of, is_met_at}
#import hachure::line_step::{OCCLUDING_STEP, SKYLINE_STEP, hidden_behind}
#import hachure::stroke_samples::{CLASSES, Sample, SampleCounts, Match, Temporal, WHOLLY_PX, FIRST, LAST, IS_CLOSED, RUNS_OFF, KIND_SHIFT, SPACING_PX}

// The view without jitter.
@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> strokes: Strokes;
@group(0) @binding(2) var<uniform> temporal: Temporal;
@group(0) @binding(4) var<storage, read> chains: array<Chain>;
@group(0) @binding(5) var<storage, read> points: array<Point>;
@group(0) @binding(6) var<storage, read> along_units: array<u32>;
// First sample of each chain.
@group(0) @binding(7) var<storage, read> starts: array<u32>;
@group(0) @binding(8) var<storage, read> sample_counts: SampleCounts;
@group(0) @binding(9) var<storage, read_write> samples: array<Sample>;
@group(0) @binding(10) var<storage, read_write> matches: array<Match>;
// Reversed depth: near / distance; 0 is the sky.
@group(0) @binding(11) var depth: texture_depth_2d;
// Samples that the strokes of each length class need, which are reset to 0 for the next frame.
@group(0) @binding(12) var<storage, read_write> classes: array<u32>;

// A right angle, and the length to either side over which bends are measured: 8 px.
const RIGHT_RAD: f32 = 1.5707964;
const BEND_UNITS: f32 = 128.0;
// A stroke that ends within this distance of the picture's border continues off the sheet.
const BORDER_PX: f32 = 2.0;
// Sines of the angles at which one looks down on a border of the land between which it stops being a skyline.
const FROM_ABOVE: vec2<f32> = vec2<f32>(0.2, 0.5);
// Steps between which a line begins to hide land.
const HIDES: vec2<f32> = vec2<f32>(0.12, 0.24);
// Number of places to either side whose steps a sample's rank takes into account, and their distance: 8 px.
const RANK_PLACES: f32 = 3.0;
const RANK_UNITS: f32 = 128.0;
// Width of folds of a slope, relative to lines within it.
const FOLD_WIDTH: f32 = 0.7;
// How much longer tapers are where a line hides nothing.
const LONG_TAPER: f32 = 4.0;
// Distance from an end that does not exist.
const FAR_PX: f32 = 1e6;

// Returns the chain of a sample: the last one whose first sample has this number or a lower one.
fn chain_of(sample: u32) -> u32 {
    var low = 0u;
    var high = sample_counts.chains;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if starts[middle] <= sample {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

// Returns whether a stroke's end is at the border, where it does not count as an end: the pen continues off the
// picture.
fn runs_off(point: u32) -> bool {
    let px = points[point].px - view.jitter_px;
    return any(px < vec2<f32>(BORDER_PX)) || any(px > vec2<f32>(view.size_px) - BORDER_PX);
}

struct OnStroke {
    px: vec2<f32>,
    depth_m: f32,
    kind: u32,
}

// Returns the position at a distance from the start of the polyline through points `first` to `last`.
fn on_stroke(first: u32, last: u32, at_units: f32) -> OnStroke {
    let origin = along_units[first];
    var low = first;
    var high = last;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if f32(along_units[middle] - origin) <= at_units {
            low = middle;
        } else {
            high = middle;
        }
    }
    let begin = f32(along_units[low] - origin);
    let length = f32(along_units[high] - origin) - begin;
    let t = clamp((at_units - begin) / max(length, 1e-3), 0.0, 1.0);
    let a = points[low];
    let b = points[high];
    // Edges were found in a jittered picture. Strokes are antialiased by coverage, and have no jitter.
    return OnStroke(mix(a.px, b.px, t) - view.jitter_px, 1.0 / mix(1.0 / a.depth_m, 1.0 / b.depth_m, t), a.kind);
}

// Returns whether a line hides land: 0 to 1.
fn hiding_of_step(step: f32) -> f32 {
    return smoothstep(HIDES.x, HIDES.y, step);
}

// Returns the width of strokes with a step behind them, relative to skylines: a draughtsman's three ranks of lines, with
// gradual transitions.
fn width_of_step(step: f32) -> f32 {
    let hiding = mix(strokes.interior_width, strokes.occluding_width, hiding_of_step(step));
    return mix(hiding, 1.0, saturate((step - OCCLUDING_STEP) / (SKYLINE_STEP - OCCLUDING_STEP)));
}

struct Rank {
    // Width relative to that of skylines.
    width: f32,
    // Whether the line hides land: 0 to 1.
    hiding: f32,
}

// Returns the rank of a stroke at a distance from its start: the mean of places RANK_UNITS apart, so that single pixels
// cause no knots, and widths do not jump where a line begins to hide land. The steps of the border of the land, and those
// to the sky, count as much as `border`.
fn rank_around(first: u32, last: u32, at_units: f32, length_units: f32, is_border: bool, border: f32) -> Rank {
    var sum = Rank(0.0, 0.0);
    var before = on_stroke(first, last, max(at_units - (RANK_PLACES + 1.0) * RANK_UNITS, 0.0)).px;
    var here = on_stroke(first, last, max(at_units - RANK_PLACES * RANK_UNITS, 0.0)).px;
    for (var place = -RANK_PLACES; place <= RANK_PLACES; place += 1.0) {
        let after = on_stroke(first, last, clamp(at_units + (place + 1.0) * RANK_UNITS, 0.0, length_units)).px;
        let way = normalize(after - before + vec2<f32>(1e-6, 0.0));
        let step = hidden_behind(depth, here + view.jitter_px, vec2<f32>(-way.y, way.x));
        let counted = step * select(1.0, border, is_border || step > SKYLINE_STEP);
        sum.width += width_of_step(counted);
        sum.hiding += hiding_of_step(counted);
        before = here;
        here = after;
    }
    let places = 2.0 * RANK_PLACES + 1.0;
    return Rank(sum.width / places, sum.hiding / places);
}

// Returns the width of strokes of a kind of edge, relative to contours.
fn width_of(kind: u32) -> f32 {
    let drawn = select(1.0, strokes.suggestive_width, kind == KIND_SUGGESTIVE);
    return select(select(drawn, strokes.ridge_width, kind == KIND_RIDGE), strokes.valley_width, kind == KIND_VALLEY);
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x == 0u {
        for (var i = 0u; i < CLASSES; i++) {
            classes[i] = 0u;
        }
    }
    if id.x >= sample_counts.fresh {
        return;
    }
    let number = chain_of(id.x);
    let chain = chains[number];
    let first = chain.first + number;
    let last = first + chain.count;
    let length_units = f32(along_units[last] - along_units[first]);
    let count = max(u32(ceil(length_units / (UNITS_PER_PX * SPACING_PX))), 1u);
    let i = id.x - starts[number];
    let step_units = length_units / f32(count);
    let at_units = step_units * f32(i);
    var at = on_stroke(first, last, at_units);
    let before = on_stroke(first, last, max(at_units - BEND_UNITS, 0.0));
    let after = on_stroke(first, last, min(at_units + BEND_UNITS, length_units));
    let way_back = at.px - before.px;
    let way_on = after.px - at.px;
    if strokes.wobble_px > 0.0 {
        let way = normalize(way_back + way_on + vec2<f32>(1e-6, 0.0));
        let anchor = Anchor(temporal.camera_blocks, 0u, temporal.camera_rest_m, 0u);
        let strayed = wobble(anchor, place_at(view, at.px, at.depth_m), at.depth_m / view.focal_px);
        at.px += vec2<f32>(-way.y, way.x) * (strayed * strokes.wobble_px);
    }

    let is_closed = chain.is_closed == 1u;
    let is_off = vec2<bool>(runs_off(first), runs_off(last)) & vec2<bool>(!is_closed);
    let from_ends_px = select(vec2<f32>(at_units, length_units - at_units) / UNITS_PER_PX, vec2<f32>(FAR_PX), is_off);
    let from_end_px = min(from_ends_px.x, from_ends_px.y);
    // The pen is not lifted where another line goes on.
    let is_met = vec2<bool>(is_met_at(points[first]), is_met_at(points[last]));
    let from_lifts_px = select(from_ends_px, vec2<f32>(FAR_PX), is_met);
    let from_lift_px = min(from_lifts_px.x, from_lifts_px.y);
    let nearness = clamp(strokes.haze_m / max(at.depth_m, 1.0) * 0.05, 0.3, 1.6);
    // A right angle within BEND_UNITS has the full effect; at its ends a stroke has no bend.
    let lengths = length(way_back) * length(way_on);
    let bend = select(0.0, acos(clamp(dot(way_back, way_on) / max(lengths, 1e-6), 0.0, 1.0)) / RIGHT_RAD, lengths > 1.0);
    // A mean over three positions, so that single pixels do not cause knots.
    let kind_part = (width_of(before.kind) + width_of(at.kind) + width_of(after.kind)) / 3.0;
    var ranked = Rank(1.0, 1.0);
    var folded = 0.0;
    if strokes.occluding_width < 1.0 || strokes.interior_width < 1.0 {
        // The border of the land is a skyline where it is seen from the side, and only an edge of the sheet from above;
        // outlines that close gaps of it have the kind of contours.
        let from_above = smoothstep(FROM_ABOVE.x, FROM_ABOVE.y, -normalize(ray_at(view, at.px)).z);
        ranked = rank_around(first, last, at_units, length_units, at.kind == KIND_BORDER, 1.0 - from_above);
        // A fold of a slope is the faintest line within it, unless both ends are off the sheet.
        folded = select(fold_of(points[first]), 0.0, all(is_off) || is_closed);
        let fold_width = min(ranked.width, FOLD_WIDTH * strokes.interior_width);
        ranked.width = mix(ranked.width, fold_width, folded);
    }
    // A line that hides little, or is a fold, is not broader for being near. One that hides little ends in long tapers: it
    // fades into the slope. A stroke that is shorter than its tapers tapers faster.
    let near_part = mix(1.0, mix(min(nearness, 1.0), nearness, ranked.hiding * (1.0 - folded)), strokes.depth_width);
    let taper_px = min(strokes.taper_px * mix(LONG_TAPER, 1.0, ranked.hiding), select(0.5, 1.0, any(is_off | is_met)) * length_units / UNITS_PER_PX);
    let pressure = select(clamp((from_lift_px + 1e-3) / (taper_px + 1e-3), 0.0, 1.0), 1.0, is_closed);
    let wide_px = strokes.half_width_px * near_part * ranked.width * kind_part * (1.0 + strokes.curve_width * bend);
    // A short stroke as wide as a long one would be a blob. Each end that leaves the sheet, or meets
    // another line, doubles the length.
    let length_px = length_units / UNITS_PER_PX;
    let goes_on = vec2<f32>(is_off | is_met);
    let seen_px = length_px * (1.0 + goes_on.x) * (1.0 + goes_on.y);
    let slender = 2.0 * strokes.slender * wide_px / max(seen_px, 1.0);
    let half_width_px = select(wide_px, wide_px / sqrt(1.0 + slender * slender), strokes.slender > 0.0 && !is_closed);
    // The last sample that fits ends its stroke.
    let is_last = i == count || id.x + 1u == temporal.capacity;
    let ends = select(0u, FIRST, i == 0u) | select(0u, LAST, is_last) | select(0u, IS_CLOSED, is_closed);
    let is_at_border = (i == 0u && is_off.x) || (i == count && is_off.y);
    let flags = ends | select(0u, RUNS_OFF, is_at_border) | (at.kind << KIND_SHIFT);
    let position_m = place_at(view, at.px, at.depth_m);
    // Until the stroke gets its identity (temporal.wgsl), `stroke` holds the number of the chain. A stroke ends half a
    // pixel after its last sample, so that the sample itself is drawn.
    let shown_px = min(WHOLLY_PX, select(from_end_px + 0.5, WHOLLY_PX, is_closed));
    samples[id.x] = Sample(position_m, pressure, at.px, at_units / UNITS_PER_PX, half_width_px, at.depth_m, shown_px, number, flags, vec2<f32>(0.0), length_px, 0.0);
    // No match until the search (look.wgsl).
    matches[id.x] = Match(0u, 0.0, 0.0, 1.0, vec2<f32>(0.0), 0.0, at_units / UNITS_PER_PX, -WHOLLY_PX, 0u);
}
