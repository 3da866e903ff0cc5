// Ranks segments by pointer jumping (Wyllie 1979): after round k a state knows the one that is 32^(k + 1) before it, or
// the head of its chain.
//
// A state is a segment and a direction: state s enters its segment at end s and leaves it at end s ^ 1, so the state
// before it is links[s] ^ 1. Each chain thus appears twice, once in each direction. The rank of a state holds:
//   head found:      head | FOUND, segments before it, 0, length before it
//   not found yet:   state n before it, least segment among the last n, that segment's key, length between
// A loop has no head. Its states end with the loop's least segment by (key, index), where chain_rank_begin.wgsl cuts
// it; then they are ranked once more, without least segments.
//
// Changes: there are 32 jumps per round instead of two, since a dispatch costs more than a few reads, and nearly all
// chains are shorter than that. Two halves of `ranks` alternate. Bit r of `progress` says that round r has work. A
// round sets the next bit if it found the head of a state at the largest distance that it can reach (while any state is
// farther from its head, there is one at that distance), or if a state of a loop learnt of a lesser segment (while a
// loop is not covered, some state does). Later rounds return at once.
#import hachure::strokes::ChainPlan
#import hachure::ranking::{FOUND, JUMPS, LOOP_ROUNDS, PROGRESS, ROUNDS}

@group(0) @binding(0) var<uniform> turn: u32;
@group(0) @binding(1) var<uniform> plan: ChainPlan;
@group(0) @binding(2) var<storage, read_write> ranks: array<vec4<u32>>;
// `StrokeCounts` as an array of words; `progress` is at index PROGRESS.
@group(0) @binding(3) var<storage, read_write> counts: array<atomic<u32>>;

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let state = id.x;
    if state >= plan.ends {
        return;
    }
    let done = atomicLoad(&counts[PROGRESS]);
    if (done & (1u << turn)) == 0u {
        return;
    }
    let half = countOneBits(done & ROUNDS & ((1u << turn) - 1u)) & 1u;
    let read = half * plan.ends;
    let write = (1u - half) * plan.ends;
    let known = ranks[read + state];
    var rank = known;
    if (known.x & FOUND) == 0u {
        let round = select(turn, turn - LOOP_ROUNDS + 1u, turn >= LOOP_ROUNDS);
        let stride = 1u << (5u * round);
        var jumped = stride;
        for (var jump = 0u; jump < JUMPS - 1u; jump++) {
            let before = ranks[read + rank.x];
            let way = rank.w + before.w;
            if (before.x & FOUND) != 0u {
                rank = vec4<u32>(before.x, jumped + before.y, 0u, way);
                break;
            }
            if before.z < rank.z || before.z == rank.z && before.y < rank.y {
                rank = vec4<u32>(before.xyz, way);
            } else {
                rank = vec4<u32>(before.x, rank.yz, way);
            }
            jumped += stride;
        }
        let next = 2u << turn;
        let is_farthest = rank.y == JUMPS * stride - 1u;
        if select(rank.y != known.y, is_farthest, (rank.x & FOUND) != 0u) && (atomicLoad(&counts[PROGRESS]) & next) == 0u {
            atomicOr(&counts[PROGRESS], next);
        }
    }
    ranks[write + state] = rank;
}
