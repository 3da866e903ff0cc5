// For each chain, finds the stroke of the previous frame that it continues, and the texture parameter of that stroke at
// the start of the chain, so that temporal.wgsl can space the texture evenly. The samples of the chain vote (Kalnins et
// al. 2003 let the samples of the previous frame vote for the parameter along a stroke).
//
// At most 64 evenly spaced samples of a chain vote for the stroke that they matched (look.wgsl). The majority wins
// (Boyer and Moore 1981; without a majority, whichever candidate is left). Its voters then vote for the direction in
// which the texture parameter grows. Of those that agree, the mean is taken, without outliers.
#import hachure::strokes::StrokeCounts
#import hachure::stroke_samples::{Temporal, Heritage, Match, SampleCounts}

@group(0) @binding(0) var<uniform> temporal: Temporal;
@group(0) @binding(1) var<storage, read> counts: StrokeCounts;
// Index of the first sample of each chain, in `matches`.
@group(0) @binding(2) var<storage, read> starts: array<u32>;
@group(0) @binding(3) var<storage, read> sample_counts: SampleCounts;
@group(0) @binding(4) var<storage, read> matches: array<Match>;
@group(0) @binding(5) var<storage, read_write> heritages: array<Heritage>;

// Largest number of samples of a chain that vote.
const MAX_VOTERS: u32 = 64u;
// Distance from the mean parameter beyond which a sample is an outlier.
const OUTLIER_PX: f32 = 16.0;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= counts.chains || temporal.has_history == 0u {
        return;
    }
    let fresh = sample_counts.fresh;
    let first = min(starts[id.x], fresh);
    let end = min(select(fresh, starts[id.x + 1u], id.x + 1u < counts.chains), fresh);
    heritages[id.x] = Heritage(0u, 1.0, 0.0, 0u);
    if end <= first {
        return;
    }
    let stride = (end - first + MAX_VOTERS - 1u) / MAX_VOTERS;
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
        var sum_px = 0.0;
        var count = 0.0;
        for (var i = first; i < end; i += stride) {
            let own = matches[i];
            // The old texture parameter at the sample, continued by arc length to the start of the chain.
            let sample_offset_px = own.along_px - direction_sign * own.at_px;
            let is_near = round == 0u || abs(sample_offset_px - offset_px) <= OUTLIER_PX;
            if own.stroke == winner && own.direction_sign == direction_sign && is_near {
                sum_px += sample_offset_px;
                count += 1.0;
            }
        }
        offset_px = select(offset_px, sum_px / max(count, 1.0), count > 0.0);
    }
    heritages[id.x] = Heritage(winner, direction_sign, offset_px, 0u);
}
