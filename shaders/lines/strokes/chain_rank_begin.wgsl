// Begins ranking: each state knows the one before it. See chain_rank.wgsl.
//
// Ends that chose each other in the last round (chain_choose.wgsl) are joined here; each end is joined at most once.
//
// With LOOPS, after the first ranking, this is the first round for the states that found no head: they are in loops,
// which are cut where their least segment begins. Both directions of a loop are cut at the same joint, so that each is
// the reverse of the other. Loops are few, so their states walk from joint to joint.
#import hachure::strokes::{ChainPlan, NONE, Segment, end_position, length_units}
#import hachure::ranking::{FIRST_ROUNDS, FOUND, JUMPS, LOOP_ROUNDS, PROGRESS}

@group(0) @binding(1) var<uniform> plan: ChainPlan;
@group(0) @binding(2) var<storage, read> segments: array<Segment>;
// The end that each end is joined to.
@group(0) @binding(3) var<storage, read_write> links: array<u32>;
@group(0) @binding(4) var<storage, read_write> ranks: array<vec4<u32>>;
// `StrokeCounts` as an array of words; `progress` is at index PROGRESS.
@group(0) @binding(5) var<storage, read_write> counts: array<atomic<u32>>;
#ifndef LOOPS
@group(0) @binding(6) var<storage, read> choices: array<u32>;
#endif

// Returns the length from where the segment that ends at `link` begins to where that of `state` begins.
fn way_from(link: u32, state: u32) -> u32 {
    let before = segments[link / 2u];
    let end = end_position(before, link);
    return length_units(end - end_position(before, link ^ 1u)) + length_units(end_position(segments[state / 2u], state) - end);
}

// Requests a round.
fn request(round: u32) {
    if (atomicLoad(&counts[PROGRESS]) & (1u << round)) == 0u {
        atomicOr(&counts[PROGRESS], 1u << round);
    }
}

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let state = id.x;
    if state >= plan.ends {
        return;
    }
#ifdef LOOPS
    let at = state + (countOneBits(atomicLoad(&counts[PROGRESS]) & FIRST_ROUNDS) & 1u) * plan.ends;
    let rank = ranks[at];
    if (rank.x & FOUND) != 0u {
        return;
    }
    let head = 2u * rank.y;
    var walked = vec4<u32>(state, 0u, 0u, 0u);
    for (var jump = 0u; jump < JUMPS; jump++) {
        let link = links[walked.x];
        if walked.x == head || link == head {
            ranks[at] = vec4<u32>(walked.x | FOUND, jump, 0u, walked.w);
            if jump == JUMPS - 1u {
                request(LOOP_ROUNDS);
            }
            return;
        }
        walked = vec4<u32>(link ^ 1u, 0u, 0u, walked.w + way_from(link, walked.x));
    }
    ranks[at] = walked;
#else
    let choice = choices[state];
    var link = NONE;
    if choice != NONE {
        if choices[choice] == state {
            link = choice;
        }
    }
    links[state] = link;
    if link == NONE {
        ranks[state] = vec4<u32>(state | FOUND, 0u, 0u, 0u);
        return;
    }
    ranks[state] = vec4<u32>(link ^ 1u, state / 2u, segments[state / 2u].key, way_from(link, state));
    request(0u);
#endif
}
