// Carries strokes over from the previous frame, whenever strokes are updated: identity, texture parameter, pressure,
// and part of the position.
//
// - Identity and texture parameter (`along_px`): each sample takes those of the old stroke that it matched (look.wgsl);
//   a sample without a match continues from the nearest one that has one. Where lines are crowded, chains split and
//   join from frame to frame; this does not affect data that are stored for each sample. Where two old strokes meet in
//   one chain, the texture has a seam, which stays in place. Perspective stretches the texture parameter; the parameter
//   slowly returns to an even spacing, with the offset for which the chain's samples voted (vote.wgsl).
// - Shown part: a sample is drawn where its `shown_px`, the distance along the stroke to the end of the shown part, is
//   positive. That part grows by `growth_px` per frame, from the part that was shown before and from seeds SEEDS_PX
//   apart, so that no more of a line appears at once than an eye can follow. A part that was outside of the picture at
//   the last update is shown at once.
// - Pressure changes by a bounded step.
// - Position: the line is held where it was, by the weight `hold` of the style, and does not jump: a larger offset
//   shrinks by MOVE_PX per frame, also in the frames between updates (advance.wgsl).
#import hachure::view::{View, place_at}
#import hachure::strokes::{Chain, StrokeCounts}
#import hachure::stroke_samples::{Temporal, Heritage, Match, Sample, NEIGHBOURS, to_seed_px, hash, decayed}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> temporal: Temporal;
@group(0) @binding(2) var<storage, read> counts: StrokeCounts;
@group(0) @binding(3) var<storage, read> chains: array<Chain>;
@group(0) @binding(4) var<storage, read> starts: array<u32>;
@group(0) @binding(5) var<storage, read> matches: array<Match>;
@group(0) @binding(6) var<storage, read> heritages: array<Heritage>;
@group(0) @binding(7) var<storage, read_write> samples: array<Sample>;
// `SampleCounts` as an array of words, because its members cannot be atomic.
@group(0) @binding(8) var<storage, read_write> sample_counts: array<atomic<u32>>;

// Indices of `fresh` and `carried` in `sample_counts`.
const FRESH: u32 = 1u;
const CARRIED: u32 = 4u;
// Largest difference between the texture parameters that neighbouring samples find, for their mean to be taken.
const ALIKE_PX: f32 = 6.0;
// Fraction of the deviation from an even texture parameter that each update removes.
const RELAXATION: f32 = 0.03;
// Deviation from the even texture parameter beyond which the sample belongs to another part of the old stroke.
const MAX_UNEVEN_PX: f32 = 16.0;
// Weight of the old half width in each update.
const WIDTH_KEPT: f32 = 0.7;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let fresh = atomicLoad(&sample_counts[FRESH]);
    if id.x >= fresh {
        return;
    }
    var own = samples[id.x];
    // Until this pass replaces it by an identity, `stroke` is the index of the sample's chain.
    let chain_index = own.stroke;
    let chain = chains[chain_index];
    let first = starts[chain_index];
    let end = min(select(fresh, starts[chain_index + 1u], chain_index + 1u < counts.chains), fresh);
    // The same stroke gets the same identity in the same view, whatever order chains were found in.
    let new_identity = hash(chain.key ^ hash(chain.length_units)) ^ hash(temporal.seed);
    var identity = max(new_identity, 1u);
    var along_px = own.along_px + f32(hash(new_identity) & 1023u);
    if temporal.has_history == 1u {
        let inherited = inherit(id.x, first, end);
        if inherited.stroke != 0u {
            identity = inherited.stroke;
            along_px = inherited.along_px;
            let heritage = heritages[chain_index];
            if identity == heritage.stroke && inherited.direction_sign == heritage.direction_sign {
                let even_px = heritage.direction_sign * own.along_px + heritage.offset_px;
                let is_near = abs(even_px - along_px) <= MAX_UNEVEN_PX;
                along_px = mix(along_px, even_px, select(0.0, RELAXATION, is_near));
            }
        }
        if id.x == first && heritages[chain_index].stroke != 0u {
            atomicAdd(&sample_counts[CARRIED], 1u);
        }
        if was_in_picture(own.position_m) {
            own.shown_px = min(own.shown_px, grown_px(id.x, first, end, along_px));
        }
        let found = matches[id.x];
        if found.stroke != 0u {
            own.pressure = found.pressure + clamp(own.pressure - found.pressure, -temporal.pressure_step, temporal.pressure_step);
            own.half_width_px = mix(own.half_width_px, found.half_width_px, WIDTH_KEPT);
        }
        own.held_px = decayed(mean_offset_px(id.x, first, end), temporal.hold);
        if any(own.held_px != vec2<f32>(0.0)) {
            own.px += own.held_px;
            own.position_m = place_at(view, own.px, own.depth_m);
        }
    }
    own.stroke = identity;
    own.along_px = along_px;
    samples[id.x] = own;
}

// Returns whether a point was within the picture of the last update.
fn was_in_picture(at_m: vec3<f32>) -> bool {
    let clip = temporal.updated_clip_from_camera * vec4<f32>(at_m, 1.0);
    return clip.w > 0.0 && all(abs(clip.xy) < vec2<f32>(clip.w));
}

// The values that a sample takes over from an old stroke.
struct Inherited {
    // Identity of the stroke; 0 is none.
    stroke: u32,
    along_px: f32,
    // As in Match.
    direction_sign: f32,
}

// Returns identity and texture parameter of the sample `index`: those of the nearest sample with a match, continued by
// arc length.
fn inherit(index: u32, first: u32, end: u32) -> Inherited {
    let at_px = matches[index].at_px;
    var nearest = index;
    for (var i = 0u; i <= NEIGHBOURS && matches[nearest].stroke == 0u; i++) {
        nearest = max(index, first + i) - i;
        if matches[nearest].stroke == 0u {
            nearest = min(index + i, end - 1u);
        }
    }
    let found = matches[nearest];
    let along_px = found.along_px + found.direction_sign * (at_px - found.at_px);
    // Averaged with its neighbours, because a single sample is noisy.
    var sum_px = along_px;
    var weight = 1.0;
    for (var i = max(index, first + 2u) - 2u; i < min(index + 3u, end); i++) {
        let other = matches[i];
        let predicted_px = other.along_px + other.direction_sign * (at_px - other.at_px);
        let is_same = other.stroke == found.stroke && other.direction_sign == found.direction_sign;
        if is_same && abs(predicted_px - along_px) <= ALIKE_PX {
            sum_px += predicted_px;
            weight += 1.0;
        }
    }
    return Inherited(found.stroke, sum_px / weight, found.direction_sign);
}

// Returns the offset to the old line, averaged over the sample `index` and its neighbours.
fn mean_offset_px(index: u32, first: u32, end: u32) -> vec2<f32> {
    var sum_px = vec2<f32>(0.0);
    var weights = 0.0;
    for (var i = max(index, first + 2u) - 2u; i < min(index + 3u, end); i++) {
        if matches[i].stroke != 0u {
            let weight = select(0.5, 1.0, i == index);
            sum_px += weight * matches[i].to_old_line_px;
            weights += weight;
        }
    }
    return sum_px / max(weights, 1.0);
}

// Returns `shown_px` of the sample `index`, whose texture parameter is `along_px`, in a chain with the samples from
// `first` to before `end`.
fn grown_px(index: u32, first: u32, end: u32, along_px: f32) -> f32 {
    let own = matches[index];
    var reached_px = own.shown_px;
    if own.stroke == 0u {
        // Short strokes have a seed in the middle.
        let from_middle_px = abs(own.at_px - matches[(first + end) / 2u].at_px);
        reached_px = max(reached_px, -0.5 * temporal.growth_px - min(to_seed_px(along_px), from_middle_px));
    }
    for (var i = max(index, first + NEIGHBOURS) - NEIGHBOURS; i < min(index + NEIGHBOURS + 1u, end); i++) {
        let other = matches[i];
        if other.stroke != 0u {
            reached_px = max(reached_px, other.shown_px - abs(other.at_px - own.at_px));
        }
    }
    return reached_px + temporal.growth_px;
}
