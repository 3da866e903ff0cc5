// Ranks segments by pointer jumping (Wyllie 1979): after round k a state knows the one that is 4^k before it, or the
// head of its chain.
//
// A state is a segment and a direction: state s enters its segment at end s and leaves it at end s ^ 1, so the state
// before it is links[s] ^ 1. Each chain thus appears twice, once in each direction. The rank of a state holds:
//   head found:      head | FOUND, segments before it, 0, length before it
//   not found yet:   state 4^k before it, least segment among the last 4^k, that segment's key, length between
// A loop has no head. Its states end with the loop's least segment by (key, index), where chain_rank_begin.wgsl cuts
// it; then they are ranked once more.
//
// Changes: there are four jumps per round instead of two, since a dispatch costs more than a read. Two halves of
// `ranks` alternate. Bit r of `progress` says that round r has work: a round sets the next bit when it changed
// anything. As long as an open chain has states without their head, some find it in each round; as long as a loop is
// not covered, some of its states learn of a lesser segment. So the first round that changes nothing is the last, and
// later rounds return at once. Rounds 0 to 9 rank all, rounds 11 to 20 the loops: 4^10 is the longest chain.
#import hachure::strokes::ChainPlan
#import hachure::ranking::{FOUND, PROGRESS, ROUNDS}

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
        let stride = 1u << (2u * (turn % 11u));
        var jumped = stride;
        for (var jump = 0u; jump < 3u; jump++) {
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
        if ((rank.x & FOUND) != 0u || rank.y != known.y) && (atomicLoad(&counts[PROGRESS]) & next) == 0u {
            atomicOr(&counts[PROGRESS], next);
        }
    }
    ranks[write + state] = rank;
}
