// Decides which strokes are long enough to be drawn, counts the samples that those of each length class need, and begins
// the counters of samples.
//
// A stroke within a slope has little behind it: it says less than a skyline or a line that hides land, and many short
// ones are litter. Its least length is `shortest_interior_px`, and ALONE times as much if it is a suggestive contour that
// continues no contour. A piece of the skyline that another line continues may be short, and without it the skyline has a
// gap, so there the least length is SKYLINE_PX. The steps in depth at PLACES segments along the stroke decide.
//
// A stroke tapers at its ends, but not where it hides land up to its end and another edge is within MEETS_PX ahead of it:
// there it goes behind that line, or both are parts of one outline that were not joined, and two tapers would be a gap. An
// edge to the side of the stroke's continuation, within the distance in which parallel lines are merged, has taken the
// stroke's place.
//
// A contour that no line continues, and that hides little along its length, is a fold of the slope on which it ends, as
// the edge of a moraine is. It is drawn as a line within the slope even where it hides some land (samples.wgsl).
#import hachure::chain_lengths::{strokes, counts, chains, chain_length_px}
#import hachure::stroke_samples::{SampleCounts, class_of, samples_of}
#import hachure::stroke_style::{FOLD_SHIFT, IS_MET, Point}
#import hachure::line_step::{OCCLUDING_STEP, SKYLINE_STEP, hidden_behind, step_behind}
#import hachure::edges::{KIND_CONTOUR, KIND_SUGGESTIVE}

// samples.wgsl resets them to 0.
@group(0) @binding(4) var<storage, read_write> classes: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> sample_counts: SampleCounts;
// Samples that each stroke needs; 0 if it is too short to be drawn.
@group(0) @binding(6) var<storage, read_write> sizes: array<u32>;
@group(0) @binding(7) var<storage, read_write> points: array<Point>;
// Reversed depth: near / distance; 0 is the sky.
@group(0) @binding(8) var depth: texture_depth_2d;
// The reference image: the number of the edge at each pixel, plus 1.
@group(0) @binding(9) var ids: texture_2d<u32>;

const PLACES: u32 = 8u;
const ALONE: f32 = 2.0;
const SKYLINE_PX: f32 = 2.0;
// Mean steps in depth along a line with two free ends, between which it stops being a fold of a slope.
const FOLD_STEPS: vec2<f32> = vec2<f32>(0.15, 0.3);
// Distances ahead of an end between which another line meets it; nearer pixels may be the stroke's own. And the length of
// stroke that tells what is ahead.
const OWN_PX: f32 = 1.5;
const MEETS_PX: f32 = 5.0;
const AHEAD_PX: f32 = 8.0;
// How much farther to the side than merged lines another edge may be: lines are smoothed after they are merged.
const BESIDE_PX: f32 = 0.5;

// Returns 1 if another edge is ahead of the end `end` of a chain, whose points lie in direction `back` from there.
fn is_met(end: u32, back: i32, count: u32) -> u32 {
    let px = points[end].px;
    var before = px;
    for (var i = 1; i <= i32(count) && distance(before, px) < AHEAD_PX; i++) {
        before = points[i32(end) + back * i].px;
    }
    let onward = (px - before) / max(distance(before, px), 1e-6);
    if step_behind(depth, 0.5 * (px + before), vec2<f32>(onward.y, -onward.x)) < 0.5 * OCCLUDING_STEP {
        return 0u;
    }
    let at = px * strokes.resolution;
    let beside = strokes.merge_px + BESIDE_PX;
    let reach = length(vec2<f32>(MEETS_PX, beside)) * strokes.resolution;
    let last = vec2<i32>(strokes.image_px) - 1;
    let low = clamp(vec2<i32>(floor(at - reach)), vec2<i32>(0), last);
    let high = clamp(vec2<i32>(floor(at + reach)), vec2<i32>(0), last);
    var found = false;
    for (var y = low.y; y <= high.y && !found; y++) {
        for (var x = low.x; x <= high.x && !found; x++) {
            let way = (vec2<f32>(vec2<i32>(x, y)) + 0.5) / strokes.resolution - px;
            let ahead_px = dot(way, onward);
            let is_within = ahead_px > 0.7 * length(way) && length(way) <= MEETS_PX
                || abs(dot(way, vec2<f32>(onward.y, -onward.x))) <= beside && ahead_px <= MEETS_PX;
            let is_ahead = ahead_px > OWN_PX / min(strokes.resolution, 1.0) && is_within;
            found = is_ahead && textureLoad(ids, vec2<i32>(x, y), 0).r != 0u;
        }
    }
    return u32(found);
}

// Returns whether a stroke is long enough to be drawn.
fn is_long_enough(number: u32, length_px: f32) -> bool {
    if length_px >= max(ALONE * strokes.shortest_interior_px, strokes.shortest_px) || length_px < SKYLINE_PX {
        return length_px >= strokes.shortest_px;
    }
    let chain = chains[number];
    let first = chain.first + number;
    let places = min(chain.count, PLACES);
    var steps = 0.0;
    var skylines = 0u;
    var is_alone = true;
    for (var i = 0u; i < places; i++) {
        let at = first + (2u * i + 1u) * chain.count / (2u * places);
        is_alone = is_alone && points[at].kind == KIND_SUGGESTIVE;
        let a = points[at].px;
        let b = points[at + 1u].px;
        let along = (b - a) / max(distance(a, b), 1e-6);
        let step = step_behind(depth, 0.5 * (a + b), vec2<f32>(along.y, -along.x));
        steps += saturate(step / OCCLUDING_STEP);
        skylines += u32(step > SKYLINE_STEP);
    }
    if 2u * skylines > places {
        let last = first + chain.count;
        return length_px >= strokes.shortest_px
            || chain.is_closed == 0u && is_met(first, 1, chain.count) + is_met(last, -1, chain.count) > 0u;
    }
    // From half of the step of a line that hides land on, a stroke counts as one.
    let interior_px = strokes.shortest_interior_px * select(1.0, ALONE, is_alone);
    return length_px >= max(strokes.shortest_px, select(0.0, interior_px, steps < 0.5 * f32(places)));
}

// Returns how much a line is a fold of a slope: 0 to 1. Only contours are folds; lines of other kinds are within slopes.
fn fold(number: u32) -> f32 {
    let chain = chains[number];
    let first = chain.first + number;
    let places = min(chain.count, PLACES);
    var steps = 0.0;
    var contours = 0u;
    for (var i = 0u; i < places; i++) {
        let at = first + (2u * i + 1u) * chain.count / (2u * places);
        contours += u32(points[at].kind == KIND_CONTOUR);
        let a = points[at].px;
        let b = points[at + 1u].px;
        let along = (b - a) / max(distance(a, b), 1e-6);
        steps += hidden_behind(depth, 0.5 * (a + b), vec2<f32>(along.y, -along.x));
    }
    let folded = 1.0 - smoothstep(FOLD_STEPS.x, FOLD_STEPS.y, steps / f32(places));
    return select(0.0, folded, 2u * contours > places);
}

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x == 0u {
        sample_counts = SampleCounts();
    }
    if id.x >= counts.chains {
        return;
    }
    let length_px = chain_length_px(id.x);
    var size = 0u;
    if is_long_enough(id.x, length_px) {
        size = samples_of(length_px);
        atomicAdd(&classes[class_of(length_px)], size);
        let chain = chains[id.x];
        let first = chain.first + id.x;
        if chain.is_closed == 0u {
            let last = first + chain.count;
            let met = vec2<u32>(is_met(first, 1, chain.count), is_met(last, -1, chain.count));
            var folded = 0.0;
            if all(met == vec2<u32>(0u)) {
                folded = fold(id.x);
            }
            points[first].end = met.x * IS_MET | u32(round(255.0 * folded)) << FOLD_SHIFT;
            points[last].end = met.y * IS_MET;
        }
    }
    sizes[id.x] = size;
}
