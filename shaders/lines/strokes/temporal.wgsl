// Strokes take over what was there: who they are, where on their texture they are, how hard the pen is pressed, and a
// part of the place.
//
// - Identity and parameter: each sample keeps those of the old stroke that it found; one that found nothing runs on
//   from the nearest that did. Chains fall apart and join again from frame to frame where lines are crowded; what
//   belongs to samples is not touched by that. Where two old strokes meet in one chain the texture has a seam, which
//   stays where it is. Perspective stretches parameters; toward even ones, by what the chain voted for (vote.wgsl),
//   they go slowly.
// - What is shown grows along the stroke, by `growth_px` in a frame, from what was shown before and from seeds SEEDS_PX
//   apart; so no more of a line appears at once than an eye can follow. What the last update could not see, because it
//   lay outside of its picture, comes in as it is: it is no news, the sheet has moved.
// - Pressure: from what it was, by a bounded step.
// - Place: the line is held where it was, as far as the style says, and does not jump: what is farther off
//   comes nearer by MOVE_PX in a frame, also in the frames between updates (advance.wgsl).
#import hachure::view::{View, place_at}
#import hachure::strokes::{Chain, StrokeCounts}
#import hachure::stroke_samples::{Temporal, Heritage, Match, Sample, BESIDE, to_seed_px, hash, let_go}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> temporal: Temporal;
@group(0) @binding(2) var<storage, read> counts: StrokeCounts;
@group(0) @binding(3) var<storage, read> chains: array<Chain>;
@group(0) @binding(4) var<storage, read> starts: array<u32>;
@group(0) @binding(5) var<storage, read> matches: array<Match>;
@group(0) @binding(6) var<storage, read> heritages: array<Heritage>;
@group(0) @binding(7) var<storage, read_write> samples: array<Sample>;
// SampleCounts: the second number is of those of chains, the fifth of strokes that took over.
@group(0) @binding(8) var<storage, read_write> list: array<atomic<u32>>;

// Parameters of neighbours differ by no more than this if they belong together.
const ALIKE_PX: f32 = 6.0;
// How much of the unevenness of a parameter goes in a frame.
const RELAXATION: f32 = 0.03;
// What is farther from it belongs to another part of the old stroke.
const MOST_UNEVEN_PX: f32 = 16.0;
const WIDTH_KEPT: f32 = 0.7;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let fresh = atomicLoad(&list[1]);
    if id.x >= fresh {
        return;
    }
    var own = samples[id.x];
    let number = own.stroke;
    let chain = chains[number];
    let first = starts[number];
    let end = min(select(fresh, starts[number + 1u], number + 1u < counts.chains), fresh);
    // The same stroke gets the same number in the same view, whatever order chains were found in.
    let name = hash(chain.key ^ hash(chain.length_units)) ^ hash(temporal.seed);
    var stroke = max(name, 1u);
    var along_px = own.along_px + f32(hash(name) & 1023u);
    if temporal.has_history == 1u {
        let inherited = inherit(id.x, first, end);
        if inherited.stroke != 0u {
            stroke = inherited.stroke;
            along_px = inherited.along_px;
            let heritage = heritages[number];
            if stroke == heritage.stroke && inherited.sense == heritage.sense {
                let even_px = heritage.sense * own.along_px + heritage.offset_px;
                let is_near = abs(even_px - along_px) <= MOST_UNEVEN_PX;
                along_px = mix(along_px, even_px, select(0.0, RELAXATION, is_near));
            }
        }
        if id.x == first && heritages[number].stroke != 0u {
            atomicAdd(&list[4], 1u);
        }
        if was_in_picture(own.position_m) {
            own.shown_px = min(own.shown_px, grown_px(id.x, first, end, along_px));
        }
        let found = matches[id.x];
        if found.stroke != 0u {
            own.pressure = found.pressure + clamp(own.pressure - found.pressure, -temporal.pressure_step, temporal.pressure_step);
            own.half_width_px = mix(own.half_width_px, found.half_width_px, WIDTH_KEPT);
        }
        own.held_px = let_go(toward(id.x, first, end), temporal.hold);
        if any(own.held_px != vec2<f32>(0.0)) {
            own.px += own.held_px;
            own.position_m = place_at(view, own.px, own.depth_m);
        }
    }
    own.stroke = stroke;
    own.along_px = along_px;
    samples[id.x] = own;
}

// Whether the last update could have drawn a place.
fn was_in_picture(at_m: vec3<f32>) -> bool {
    let clip = temporal.updated_clip_from_camera * vec4<f32>(at_m, 1.0);
    return clip.w > 0.0 && all(abs(clip.xy) < vec2<f32>(clip.w));
}

struct Inherited {
    // 0: nothing.
    stroke: u32,
    along_px: f32,
    sense: f32,
}

// Identity and parameter of a sample: of the nearest one that found something, run on by arc length.
fn inherit(number: u32, first: u32, end: u32) -> Inherited {
    let at_px = matches[number].at_px;
    var nearest = number;
    for (var i = 0u; i <= BESIDE && matches[nearest].stroke == 0u; i++) {
        nearest = max(number, first + i) - i;
        if matches[nearest].stroke == 0u {
            nearest = min(number + i, end - 1u);
        }
    }
    let found = matches[nearest];
    let along_px = found.along_px + found.sense * (at_px - found.at_px);
    // The mean with those beside it: a sample alone is noisy.
    var sum_px = along_px;
    var weight = 1.0;
    for (var i = max(number, first + 2u) - 2u; i < min(number + 3u, end); i++) {
        let beside = matches[i];
        let by_it_px = beside.along_px + beside.sense * (at_px - beside.at_px);
        let is_same = beside.stroke == found.stroke && beside.sense == found.sense;
        if is_same && abs(by_it_px - along_px) <= ALIKE_PX {
            sum_px += by_it_px;
            weight += 1.0;
        }
    }
    return Inherited(found.stroke, sum_px / weight, found.sense);
}

// The way to the old line, by what the sample and those beside it found.
fn toward(number: u32, first: u32, end: u32) -> vec2<f32> {
    var sum_px = vec2<f32>(0.0);
    var weights = 0.0;
    for (var i = max(number, first + 2u) - 2u; i < min(number + 3u, end); i++) {
        if matches[i].stroke != 0u {
            let weight = select(0.5, 1.0, i == number);
            sum_px += weight * matches[i].toward_px;
            weights += weight;
        }
    }
    return sum_px / max(weights, 1.0);
}

// How much of a sample is shown whose parameter is `along_px`, of a stroke with samples `first` to `end`.
fn grown_px(number: u32, first: u32, end: u32, along_px: f32) -> f32 {
    let own = matches[number];
    var reached_px = own.shown_px;
    if own.stroke == 0u {
        // Short strokes have a seed in the middle.
        let from_middle_px = abs(own.at_px - matches[(first + end) / 2u].at_px);
        reached_px = max(reached_px, -0.5 * temporal.growth_px - min(to_seed_px(along_px), from_middle_px));
    }
    for (var i = max(number, first + BESIDE) - BESIDE; i < min(number + BESIDE + 1u, end); i++) {
        let beside = matches[i];
        if beside.stroke != 0u {
            reached_px = max(reached_px, beside.shown_px - abs(beside.at_px - own.at_px));
        }
    }
    return reached_px + temporal.growth_px;
}
