// Each chain was ranked in both directions. This takes the direction whose first end is less by (key, segment, end),
// and marks the segments that begin a chain. A cut loop begins at its least segment by the same rule.
#import hachure::strokes::{ChainPlan, Segment, StrokeCounts}
#import hachure::ranking::{FOUND, ROUNDS}

@group(0) @binding(0) var<uniform> plan: ChainPlan;
@group(0) @binding(1) var<storage, read> segments: array<Segment>;
@group(0) @binding(2) var<storage, read> ranks: array<vec4<u32>>;
@group(0) @binding(3) var<storage, read> counts: StrokeCounts;
// State of each segment in the chosen direction.
@group(0) @binding(4) var<storage, read_write> states: array<u32>;
// For each segment, 1 if it begins a chain; then, for each segment again, the number of segments of the chain that it
// begins.
@group(0) @binding(5) var<storage, read_write> heads: array<u32>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let segment = id.x;
    if segment >= plan.segments {
        return;
    }
    let half = (countOneBits(counts.progress & ROUNDS) & 1u) * plan.ends;
    let forward = ranks[half + 2u * segment];
    let backward = ranks[half + 2u * segment + 1u];
    let first = forward.x & ~FOUND;
    let last = backward.x & ~FOUND;
    let first_key = segments[first / 2u].key;
    let last_key = segments[last / 2u].key;
    let is_backward = last_key < first_key || last_key == first_key && last < first;
    let state = 2u * segment + u32(is_backward);
    states[segment] = state;
    let is_head = state == select(first, last, is_backward);
    heads[segment] = u32(is_head);
    heads[plan.segments + segment] = select(0u, forward.y + backward.y + 1u, is_head);
}
