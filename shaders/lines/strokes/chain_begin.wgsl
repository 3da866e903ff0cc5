// Sets the number of segments to chain, and the workgroups of the passes that follow. The number is on the GPU, so the
// workgroups are computed there too.
#import hachure::strokes::{ChainPlan, ChainRules, StrokeCounts, bit_count}

@group(0) @binding(0) var<uniform> rules: ChainRules;
@group(0) @binding(1) var<storage, read_write> counts: StrokeCounts;
@group(0) @binding(2) var<storage, read_write> plan: ChainPlan;
// Workgroups for each segment, each end, each bucket.
@group(0) @binding(3) var<storage, read_write> arguments: array<u32, 9>;

@compute @workgroup_size(1)
fn main() {
    let segments = min(counts.segments, rules.capacity);
    let ends = 2u * segments;
    // At least one bucket per end.
    let buckets = 1u << max(bit_count(max(ends, 1u) - 1u), 8u);
    plan.segments = segments;
    plan.ends = ends;
    plan.buckets = buckets;
    for (var i = 0u; i < 9u; i++) {
        arguments[i] = 1u;
    }
    arguments[0] = (segments + 255u) / 256u;
    arguments[3] = (ends + 255u) / 256u;
    arguments[6] = buckets / 256u;
    counts.progress = 0u;
    counts.chains = 0u;
}
