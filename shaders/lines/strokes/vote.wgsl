// Finds the old stroke that most of a chain continues, and the offset on it, so that temporal.wgsl can even out the
// texture: the chain's samples vote (Kalnins et al. 2003 let the samples of the previous frame vote for the parameter
// along a stroke).
//
// At most 64 evenly spaced samples of a chain vote. The majority wins (Boyer and Moore 1981; without a majority,
// whichever candidate is left). The offset of the parameter is the mean of what they found, without outliers.
#import hachure::strokes::StrokeCounts
#import hachure::stroke_samples::{Temporal, Heritage, Match, SampleCounts}

@group(0) @binding(0) var<uniform> temporal: Temporal;
@group(0) @binding(1) var<storage, read> counts: StrokeCounts;
@group(0) @binding(2) var<storage, read> starts: array<u32>;
@group(0) @binding(3) var<storage, read> list: SampleCounts;
@group(0) @binding(4) var<storage, read> matches: array<Match>;
@group(0) @binding(5) var<storage, read_write> heritages: array<Heritage>;

// Most samples of a chain that vote.
const MOST_VOTERS: u32 = 64u;
// Distance from the mean offset beyond which a sample is an outlier.
const OUTLIER_PX: f32 = 16.0;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= counts.chains || temporal.has_history == 0u {
        return;
    }
    let fresh = list.fresh;
    let first = min(starts[id.x], fresh);
    let end = min(select(fresh, starts[id.x + 1u], id.x + 1u < counts.chains), fresh);
    heritages[id.x] = Heritage(0u, 1.0, 0.0, 0u);
    if end <= first {
        return;
    }
    let stride = (end - first + MOST_VOTERS - 1u) / MOST_VOTERS;
    var winner = 0u;
    var lead = 0u;
    for (var i = first; i < end; i += stride) {
        let stroke = matches[i].stroke;
        if stroke == 0u {
            continue;
        }
        if lead == 0u {
            winner = stroke;
            lead = 1u;
        } else if stroke == winner {
            lead += 1u;
        } else {
            lead -= 1u;
        }
    }
    if winner == 0u {
        return;
    }
    var sum_of_signs = 0.0;
    for (var i = first; i < end; i += stride) {
        if matches[i].stroke == winner {
            sum_of_signs += matches[i].direction_sign;
        }
    }
    let direction_sign = select(-1.0, 1.0, sum_of_signs >= 0.0);
    var offset_px = 0.0;
    // The first round finds the mean, the second excludes outliers.
    for (var round = 0u; round < 2u; round++) {
        var sum = 0.0;
        var weight = 0.0;
        for (var i = first; i < end; i += stride) {
            let own = matches[i];
            let offset = own.along_px - direction_sign * own.at_px;
            let is_near = round == 0u || abs(offset - offset_px) <= OUTLIER_PX;
            if own.stroke == winner && own.direction_sign == direction_sign && is_near {
                sum += offset;
                weight += 1.0;
            }
        }
        offset_px = select(offset_px, sum / max(weight, 1.0), weight > 0.0);
    }
    heritages[id.x] = Heritage(winner, direction_sign, offset_px, 0u);
}
