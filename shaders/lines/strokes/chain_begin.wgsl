// Sets the number of segments to chain, and the workgroups of the passes that follow, and empties the buckets
// (chain_bin.wgsl). The number is on the GPU, so the workgroups are computed there too.
#import hachure::strokes::{ChainPlan, ChainRules, StrokeCounts, bit_count}

@group(0) @binding(0) var<uniform> rules: ChainRules;
@group(0) @binding(1) var<storage, read_write> counts: StrokeCounts;
@group(0) @binding(2) var<storage, read_write> plan: ChainPlan;
// Workgroups for each segment, at least one, and for each end.
@group(0) @binding(3) var<storage, read_write> arguments: array<u32, 6>;
@group(0) @binding(4) var<storage, read_write> buckets: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let segments = min(counts.segments, rules.capacity);
    let ends = 2u * segments;
    // At least one bucket per end.
    let bucket_count = 1u << max(bit_count(max(ends, 1u) - 1u), 8u);
    for (var i = id.x; i < bucket_count; i += 256u * groups.x) {
        buckets[i] = 0u;
    }
    if id.x > 0u {
        return;
    }
    plan.segments = segments;
    plan.ends = ends;
    plan.buckets = bucket_count;
    arguments[0] = max((segments + 255u) / 256u, 1u);
    arguments[1] = 1u;
    arguments[2] = 1u;
    arguments[3] = (ends + 255u) / 256u;
    arguments[4] = 1u;
    arguments[5] = 1u;
    counts.progress = 0u;
    counts.chains = 0u;
}
