// Records that the passes of strokes share, and lengths as integers. See src/lines/strokes/.
//
// WGSL has 32-bit integers, and the CPU must compute the same values, so nothing here may round or overflow.
#define_import_path hachure::strokes

// Units per pixel. Positions and lengths are integers of 1/16 px, so that the GPU and its CPU twin agree bit for bit.
const UNITS_PER_PX: f32 = 16.0;

// A straight segment of a line.
struct Segment {
    // One end, in 1/16 px of the full picture. It may be outside of the picture; beyond ±2²¹ it is clamped.
    a: vec2<i32>,
    // The other end.
    b: vec2<i32>,
    // Distances along the view axis at a and b, in metres.
    depths_m: vec2<f32>,
    // Number of its edge in the edge list, or NO_EDGE.
    edge: u32,
    // Identifies the segment across frames; several segments may share it.
    key: u32,
}

// The counters of strokes on the GPU.
struct StrokeCounts {
    // Number of edges found.
    edges: u32,
    // Number of segments to chain, at byte 4; those beyond the capacity are skipped.
    segments: u32,
    // Number of chains, written by `chain::run`.
    chains: u32,
    // Number of points of strokes.
    points: u32,
    // Number of edges beyond the capacity.
    edges_lost: u32,
    // Number of segments beyond the capacity.
    segments_lost: u32,
    // Bit mask of the rounds of ranking that had work: see chain_rank.wgsl.
    progress: u32,
    padding: u32,
}

// A sequence of connected segments: `count` positions in the order, from `first` on.
struct Chain {
    // Its first position in the order.
    first: u32,
    // Number of its segments.
    count: u32,
    // 1 if its end connects to its beginning.
    is_closed: u32,
    // Key of the first segment.
    key: u32,
    // Length from its first end to its last, including gaps between segments; all the way round if it is closed. In
    // 1/16 px, modulo 2³².
    length_units: u32,
    padding: array<u32, 3>,
}

// A position in the order of segments.
struct SegmentInOrder {
    // Twice the number of the segment, plus 1 if it runs from b to a.
    state: u32,
    // Number of the chain that contains it.
    chain: u32,
    // Arc length from the chain's start to the start of the segment, in 1/16 px, modulo 2³².
    begin_units: u32,
}

struct ChainRules {
    // Capacity for segments.
    capacity: u32,
    // Largest distance between ends that are joined, D in the CPU twin, in 1/16 px.
    reach_units: u32,
    // cos² of the largest angle A between segments that are joined, in 1/4096.
    min_cos_squared: u32,
    // Largest distance by which an end may be behind the one that it is joined to, in 1/16 px.
    overlap_units: u32,
}

// The amount of work in this frame.
struct ChainPlan {
    segments: u32,
    // Two per segment. End 2p is a of segment p, end 2p + 1 its b.
    ends: u32,
    // Number of hash buckets: a power of two.
    buckets: u32,
    padding: u32,
}

// Buckets between a cell and the one above it. Odd, so that columns spread over all buckets.
const CELL_ROW: u32 = 0x9e3779b1u;

// Marks the absence of an end or a segment.
const NONE: u32 = 0xffffffffu;
// The edge of a segment that was found on the picture: an outline of the land (outlines.wgsl).
const NO_EDGE: u32 = 0xffffffffu;
const LIMIT_UNITS: i32 = 0x200000;

fn end_position(segment: Segment, end: u32) -> vec2<i32> {
    let position = select(segment.a, segment.b, (end & 1u) == 1u);
    return clamp(position, vec2<i32>(-LIMIT_UNITS), vec2<i32>(LIMIT_UNITS));
}

fn bit_count(value: u32) -> u32 {
    return 32u - countLeadingZeros(value);
}

// Returns a vector's length, rounded down. Components of 2^15 and more lose their last bits, so that squares fit.
fn length_units(delta: vec2<i32>) -> u32 {
    let size = vec2<u32>(abs(delta));
    let shift = max(bit_count(max(size.x, size.y)), 15u) - 15u;
    let side = size >> vec2<u32>(shift);
    let squared = side.x * side.x + side.y * side.y;
    // The float is a first guess; the corrections make it exact, whatever the driver's sqrt returns.
    var root = u32(sqrt(f32(squared)));
    while root * root > squared {
        root -= 1u;
    }
    while (root + 1u) * (root + 1u) <= squared {
        root += 1u;
    }
    return root << shift;
}

// Returns a parallel vector with components below 128, so that products of four fit 32 bits. Opposite vectors stay
// opposite.
fn direction(delta: vec2<i32>) -> vec2<i32> {
    let size = vec2<u32>(abs(delta));
    let shift = max(bit_count(max(size.x, size.y)), 7u) - 7u;
    return sign(delta) * vec2<i32>(size >> vec2<u32>(shift));
}

// Returns the bucket of a cell. `buckets` is a power of two.
fn bucket_of(cell: vec2<u32>, buckets: u32) -> u32 {
    return (cell.x + cell.y * CELL_ROW) & (buckets - 1u);
}
