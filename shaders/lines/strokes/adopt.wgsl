// Makes the strokes of two eyes the same strokes, by what their samples found in the other eye (look.wgsl).
//
// - A sample takes identity, texture parameter and width of the other eye's stroke. The leading eye does so as well:
//   where strokes are within a pixel of each other the follower may have found another one.
// - FOLLOWER: a sample that found nothing continues from the nearest sample along its stroke that did. It is moved to
//   the other eye's line: chains of pixels waver by less than MOVED_PX, and larger differences are true parallax of the
//   contour.
// - Both: the pressure is the greater of the two eyes'. A stroke may end for one eye where nearer land hides the rest
//   of it, and continue for the other.
// - Both: where the other eye sees the place but has no stroke, a stroke is not slidable (He, Wang and Bao 2019) and
//   tapers.
#import hachure::view::{View, place_at}
#import hachure::stroke_samples::{Temporal, Sample, SampleCounts, Match, FIRST, LAST, NEIGHBOURS, SPACING_PX}

@group(0) @binding(0) var<uniform> temporal: Temporal;
@group(0) @binding(1) var<storage, read> sample_counts: SampleCounts;
@group(0) @binding(2) var<storage, read> matches: array<Match>;
@group(0) @binding(3) var<storage, read_write> samples: array<Sample>;
#ifdef FOLLOWER
@group(0) @binding(4) var<uniform> view: View;
#endif

// Length over which a stroke tapers beyond samples that the other eye has.
const TAPERED_PX: f32 = 4.0;
const MOVED_PX: f32 = 1.0;
const FAR_PX: f32 = 1e3;

#ifdef FOLLOWER
// Returns the offset to the other eye's line, averaged over the sample `index` and its neighbours; 0 where it is too
// far.
fn mean_offset_px(index: u32) -> vec2<f32> {
    var sum_px = vec2<f32>(0.0);
    var weights = 0.0;
    for (var way = 0u; way < 2u; way++) {
        let ends = select(LAST, FIRST, way == 1u);
        var at = index;
        for (var i = 0u; i < 3u; i++) {
            let weight = select(1.0, 0.5, i == 0u);
            let off_px = matches[at].to_old_line_px;
            sum_px += select(vec2<f32>(0.0), weight * off_px, matches[at].stroke != 0u);
            weights += select(0.0, weight, matches[at].stroke != 0u);
            if (samples[at].flags & ends) != 0u {
                break;
            }
            at = select(at + 1u, at - 1u, way == 1u);
        }
    }
    let mean_px = sum_px / max(weights, 1.0);
    return mean_px * clamp((2.0 * MOVED_PX - length(mean_px)) / MOVED_PX, 0.0, 1.0);
}
#endif

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= sample_counts.fresh {
        return;
    }
    let own = matches[id.x];
    var nearest = id.x;
    var apart_px = select(FAR_PX, 0.0, own.stroke != 0u);
    for (var way = 0u; way < 2u; way++) {
        let ends = select(LAST, FIRST, way == 1u);
        var at = id.x;
        for (var i = 0u; i < NEIGHBOURS && (samples[at].flags & ends) == 0u; i++) {
            at = select(at + 1u, at - 1u, way == 1u);
            let distance_px = SPACING_PX * f32(i + 1u);
            if matches[at].stroke != 0u && distance_px < apart_px {
                nearest = at;
                apart_px = distance_px;
            }
        }
    }
    let before = samples[id.x].pressure;
    if own.stroke != 0u {
        samples[id.x].pressure = max(before, own.pressure);
        samples[id.x].shown_px = max(samples[id.x].shown_px, own.shown_px);
    } else if own.is_seen == 1u {
        let left = before * clamp(1.0 - apart_px / TAPERED_PX, 0.0, 1.0);
        // In a flight the pressure falls as slowly as strokes appear.
        samples[id.x].pressure = select(left, max(left, before - 2.0 * temporal.pressure_step), temporal.has_history == 1u);
    }
#ifndef FOLLOWER
    // The lengths along the leading eye's own strokes no longer hold.
    nearest = id.x;
#endif
    let found = matches[nearest];
    if found.stroke != 0u {
        samples[id.x].stroke = found.stroke;
        samples[id.x].along_px = found.along_px + found.direction_sign * (own.at_px - found.at_px);
        samples[id.x].half_width_px = found.half_width_px;
    }
#ifdef FOLLOWER
    let moved_px = mean_offset_px(id.x);
    let px = samples[id.x].px + moved_px;
    samples[id.x].px = px;
    samples[id.x].position_m = place_at(view, px, samples[id.x].depth_m);
#endif
}
