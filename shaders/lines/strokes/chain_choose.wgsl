// Each free end chooses the end that continues it best (Pietrok 2021, section 4.2.3: nearer than D, at less than the
// angle A, not overlapping).
//
// The paper joins an edge with the first partner that passes. Here each end takes its best, and ends that chose each
// other are joined (chain_rank_begin.wgsl), so the order of edges does not matter. With d the distance of the ends and a the angle
// between the segment's outward direction and its partner's inward direction, the score is
//   floor(4096 d^2 / D^2) + 4096 - floor(4096 cos^2 a).
// The least score wins, then the least (key, segment, end). Overlap: neither end may be behind the other by more than
// `overlap_units`. A segment without length has no direction: its angle counts as the largest allowed, and nothing is
// behind it. A segment's two ends are never joined to each other.
//
// In later rounds the candidates only become fewer. So an end keeps its choice while that is free, and one that found
// no candidate never will.
#import hachure::strokes::{ChainPlan, ChainRules, LIMIT_UNITS, NONE, Segment, bit_count, bucket_of}

@group(0) @binding(0) var<uniform> turn: u32;
@group(0) @binding(1) var<uniform> rules: ChainRules;
@group(0) @binding(2) var<uniform> plan: ChainPlan;
@group(0) @binding(3) var<storage, read> segments: array<Segment>;
// End of each bucket. See chain_bin.wgsl.
@group(0) @binding(4) var<storage, read> buckets: array<u32>;
@group(0) @binding(5) var<storage, read> slots: array<vec4<i32>>;
// The end that each end chooses. Rounds alternate between two halves: round 0 writes the first.
@group(0) @binding(6) var<storage, read_write> choices: array<u32>;

const UNFIT: u32 = 0xffffffffu;

struct Best {
    score: u32,
    key: u32,
    end: u32,
}

// Returns where the choices of the round before begin.
fn before() -> u32 {
    return (1u - (turn & 1u)) * plan.ends;
}

// Returns whether an end and its choice of the round before chose each other.
fn is_joined(end: u32) -> bool {
    let choice = choices[before() + end];
    if choice == NONE {
        return false;
    }
    return choices[before() + choice] == end;
}

fn outward_of(slot: vec4<i32>) -> vec2<i32> {
    return vec2<i32>(slot.w & 0xff, slot.w >> 8u) - 128;
}

fn squared(v: vec2<i32>) -> u32 {
    return u32(v.x * v.x + v.y * v.y);
}

// Returns whether a point at `delta` is too far behind an end.
fn is_behind(delta: vec2<i32>, outward: vec2<i32>) -> bool {
    let along = delta.x * outward.x + delta.y * outward.y;
    if along >= 0 {
        return false;
    }
    let back = u32(-along);
    // outward| < 181, so a larger distance is certainly too far, and its square might not fit.
    return back > 181u * rules.overlap_units
        || back * back > rules.overlap_units * rules.overlap_units * squared(outward);
}

// Returns a / b, rounded down, for quotients up to 4096 and a + 2 b below 2^32. The float is off by one at most;
// integer division is several times slower on software drivers.
fn quotient(a: u32, b: u32) -> u32 {
    var q = u32(f32(a) / f32(b));
    q -= u32(q * b > a);
    q += u32((q + 1u) * b <= a);
    return q;
}

// Returns cos^2 in 1/4096, rounded down, or UNFIT for vectors at more than a right angle.
fn cos_squared(u: vec2<i32>, v: vec2<i32>) -> u32 {
    let along = u.x * v.x + u.y * v.y;
    if along < 0 {
        return UNFIT;
    }
    let whole = squared(u) * squared(v);
    // Leaves room for the factor 4096.
    let shift = max(bit_count(whole), 19u) - 19u;
    return quotient((u32(along * along) >> shift) << 12u, whole >> shift);
}

fn score_of(own: vec4<i32>, other: vec4<i32>) -> u32 {
    let delta = other.xy - own.xy;
    let reach = i32(rules.reach_units);
    if any(abs(delta) > vec2<i32>(reach)) || squared(delta) > rules.reach_units * rules.reach_units {
        return UNFIT;
    }
    // The same end, or the segment's other end.
    if (own.z ^ other.z) < 2 {
        return UNFIT;
    }
    let outward = outward_of(own);
    let facing = outward_of(other);
    var cosine = rules.min_cos_squared;
    if any(outward != vec2<i32>(0)) && any(facing != vec2<i32>(0)) {
        cosine = cos_squared(outward, -facing);
        if cosine == UNFIT || cosine < rules.min_cos_squared {
            return UNFIT;
        }
    }
    if is_behind(delta, outward) || is_behind(-delta, facing) {
        return UNFIT;
    }
    return quotient(4096u * squared(delta), rules.reach_units * rules.reach_units) + 4096u - cosine;
}

fn better(best: Best, own: vec4<i32>, other: vec4<i32>) -> Best {
    let score = score_of(own, other);
    if score == UNFIT || score > best.score {
        return best;
    }
    let end = u32(other.z);
    if turn > 0u && is_joined(end) {
        return best;
    }
    let key = segments[end / 2u].key;
    if score == best.score && (key > best.key || key == best.key && end >= best.end) {
        return best;
    }
    return Best(score, key, end);
}

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= plan.ends {
        return;
    }
    let own = slots[id.x];
    let end = u32(own.z);
    let write = (turn & 1u) * plan.ends;
    if turn > 0u {
        let known = choices[before() + end];
        var stays = known == NONE;
        if !stays {
            stays = is_joined(end) || !is_joined(known);
        }
        if stays {
            choices[write + end] = known;
            return;
        }
    }
    let cell = vec2<u32>(own.xy + LIMIT_UNITS) / rules.reach_units;
    let last = plan.buckets - 1u;
    var best = Best(UNFIT, NONE, NONE);
    for (var row = 0u; row < 3u; row++) {
        // Three buckets, wrapped around.
        let first = bucket_of(vec2<u32>(cell.x - 1u, cell.y + row - 1u), plan.buckets);
        for (var bucket = first; bucket < first + 3u; bucket++) {
            let wrapped = bucket & last;
            var at = 0u;
            if wrapped > 0u {
                at = buckets[wrapped - 1u];
            }
            for (; at < buckets[wrapped]; at++) {
                best = better(best, own, slots[at]);
            }
        }
    }
    choices[write + end] = best.end;
}
