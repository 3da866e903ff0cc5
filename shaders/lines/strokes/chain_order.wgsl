// Puts each segment into its place: chains one after the other, in the order of the segments that begin them, and the
// segments of a chain in sequence.
#import hachure::strokes::{Chain, ChainPlan, NONE, Segment, SegmentInOrder, StrokeCounts, end_position, length_units}
#import hachure::ranking::{FOUND, ROUNDS}

@group(0) @binding(0) var<uniform> plan: ChainPlan;
@group(0) @binding(1) var<storage, read> segments: array<Segment>;
@group(0) @binding(2) var<storage, read> links: array<u32>;
@group(0) @binding(3) var<storage, read> ranks: array<vec4<u32>>;
@group(0) @binding(5) var<storage, read> states: array<u32>;
// Prefix sums of what chain_heads.wgsl wrote: the chain that a segment begins; then its first place, plus the number of
// chains.
@group(0) @binding(6) var<storage, read> heads: array<u32>;
@group(0) @binding(8) var<storage, read_write> places: array<SegmentInOrder>;
@group(0) @binding(9) var<storage, read_write> chains: array<Chain>;
@group(0) @binding(10) var<storage, read_write> counts: StrokeCounts;

fn between_units(start: u32, end: u32) -> u32 {
    return length_units(end_position(segments[end / 2u], end) - end_position(segments[start / 2u], start));
}

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= plan.segments {
        return;
    }
    let chain_count = heads[plan.segments];
    if id.x == 0u {
        counts.chains = chain_count;
    }
    let half = (countOneBits(counts.progress & ROUNDS) & 1u) * plan.ends;
    let state = states[id.x];
    let rank = ranks[half + state];
    let head = (rank.x & ~FOUND) / 2u;
    let chain = heads[head];
    let first = heads[plan.segments + head] - chain_count;
    places[first + rank.y] = SegmentInOrder(state, chain, rank.w);
    if rank.y > 0u {
        return;
    }
    let back = ranks[half + (state ^ 1u)];
    var length = back.w + between_units(state, state ^ 1u);
    // Only a loop begins at an end that is joined.
    let is_closed = links[state] != NONE;
    if is_closed {
        length += between_units(links[state], state);
    }
    chains[chain] = Chain(first, back.y + 1u, u32(is_closed), segments[id.x].key, length, array<u32, 3>());
}
