// Begins ranking: each state knows the one before it. See chain_rank.wgsl.
//
// Stage 0 begins with all states. Stage 11, after the first ranking, begins again with those that found no head: they
// are in loops, which are cut where their least segment begins. Both directions of a loop are cut at the same joint, so
// that each is the reverse of the other.
#import hachure::strokes::{ChainPlan, NONE, Segment, end_position, length_units}
#import hachure::ranking::{FIRST_ROUNDS, FOUND, PROGRESS}

@group(0) @binding(0) var<uniform> stage: u32;
@group(0) @binding(1) var<uniform> plan: ChainPlan;
@group(0) @binding(2) var<storage, read> segments: array<Segment>;
@group(0) @binding(3) var<storage, read> links: array<u32>;
@group(0) @binding(4) var<storage, read_write> ranks: array<vec4<u32>>;
// `StrokeCounts` as an array of words; `progress` is at index PROGRESS.
@group(0) @binding(5) var<storage, read_write> counts: array<atomic<u32>>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let state = id.x;
    if state >= plan.ends {
        return;
    }
    let link = links[state];
    var is_head = link == NONE;
    var at = state;
    if stage > 0u {
        at += (countOneBits(atomicLoad(&counts[PROGRESS]) & FIRST_ROUNDS) & 1u) * plan.ends;
        let rank = ranks[at];
        if (rank.x & FOUND) != 0u {
            return;
        }
        let head = 2u * rank.y;
        is_head = state == head || link == head;
    }
    if is_head {
        ranks[at] = vec4<u32>(state | FOUND, 0u, 0u, 0u);
        if stage == 0u {
            return;
        }
    } else {
        let before = segments[link / 2u];
        let segment = segments[state / 2u];
        let end = end_position(before, link);
        let way = length_units(end - end_position(before, link ^ 1u)) + length_units(end_position(segment, state) - end);
        ranks[at] = vec4<u32>(link ^ 1u, state / 2u, segment.key, way);
    }
    if (atomicLoad(&counts[PROGRESS]) & (1u << stage)) == 0u {
        atomicOr(&counts[PROGRESS], 1u << stage);
    }
}
