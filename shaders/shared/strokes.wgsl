// What the passes of strokes share: their records, and measures in whole numbers. See src/lines/strokes/.
//
// WGSL has 32 bits and the CPU must get the same: nothing here may round or overflow.
#define_import_path hachure::strokes

// Positions and lengths are whole numbers of 1/16 px: the GPU and its twin then agree to the bit.
const UNITS_PER_PX: f32 = 16.0;

// A straight segment of a line. Positions are in 1/16 px of the full picture.
struct Segment {
    // One end, in 1/16 px of the full picture. It may lie outside of it; farther than 2²¹ it is taken as there.
    a: vec2<i32>,
    // The other end.
    b: vec2<i32>,
    // At a and b.
    depths_m: vec2<f32>,
    // Which edge of the picture it comes from.
    edge: u32,
    // Lasts across frames; several segments may share it.
    key: u32,
}

// How many there are of everything, on the GPU.
struct StrokeCounts {
    // Edges that were found.
    edges: u32,
    // Segments to chain, at byte 4. More than there is room for are passed over.
    segments: u32,
    // Chains: what `chain::run` writes.
    chains: u32,
    // Points of strokes.
    points: u32,
    // Edges that found no room.
    edges_lost: u32,
    // Segments that found no room.
    segments_lost: u32,
    // Which rounds of ranking had something to do: see chain_rank.wgsl.
    progress: u32,
    padding: u32,
}

// Segments that run on from each other: `count` places of the order, from `first` on.
struct Chain {
    // Its first place in the order.
    first: u32,
    // Its segments.
    count: u32,
    // 1 if its end runs on into its beginning.
    is_closed: u32,
    // Of the first segment.
    key: u32,
    // From its first end to its last, with the gaps between segments; of a closed one all the way round. Modulo 2³².
    length_units: u32,
    padding: array<u32, 3>,
}

// A place of the order: twice the number of its segment, and 1 more if it runs from b to a; its chain; and how far the
// segment begins from the chain's start.
struct SegmentInOrder {
    // Twice the number of the segment, and 1 more if it runs from b to a.
    state: u32,
    // The chain that has it.
    chain: u32,
    // From the chain's start to the start of the segment. Modulo 2³².
    begin_units: u32,
}

struct ChainRules {
    // Segments that there is room for.
    capacity: u32,
    // Ends farther apart are not joined: D.
    reach_units: u32,
    // cos^2 of the widest angle A, in 1/4096.
    least_cos_squared: u32,
    // How far an end may lie behind the one that it is joined to.
    overlap_units: u32,
}

// How much there is to do in this frame.
struct ChainPlan {
    segments: u32,
    // Two of each segment. End 2p is a of segment p, end 2p + 1 its b.
    ends: u32,
    // A power of two.
    buckets: u32,
    padding: u32,
}

// Buckets between a cell and the one above it. Odd, so that columns spread over all buckets.
const CELL_ROW: u32 = 0x9e3779b1u;

// No end, no segment.
const NONE: u32 = 0xffffffffu;
const LIMIT_UNITS: i32 = 0x200000;

fn end_position(segment: Segment, end: u32) -> vec2<i32> {
    let position = select(segment.a, segment.b, (end & 1u) == 1u);
    return clamp(position, vec2<i32>(-LIMIT_UNITS), vec2<i32>(LIMIT_UNITS));
}

fn bit_count(value: u32) -> u32 {
    return 32u - countLeadingZeros(value);
}

// A vector's length, rounded down. Components of 2^15 and more lose their last bits, so that squares fit.
fn length_units(delta: vec2<i32>) -> u32 {
    let size = vec2<u32>(abs(delta));
    let shift = max(bit_count(max(size.x, size.y)), 15u) - 15u;
    let side = size >> vec2<u32>(shift);
    let squared = side.x * side.x + side.y * side.y;
    // The float is a guess; the corrections make it exact, whatever the driver's sqrt is.
    var root = u32(sqrt(f32(squared)));
    while root * root > squared {
        root -= 1u;
    }
    while (root + 1u) * (root + 1u) <= squared {
        root += 1u;
    }
    return root << shift;
}

// A vector with components below 128, so that products of four fit 32 bits. Opposite vectors stay opposite.
fn direction(delta: vec2<i32>) -> vec2<i32> {
    let size = vec2<u32>(abs(delta));
    let shift = max(bit_count(max(size.x, size.y)), 7u) - 7u;
    return sign(delta) * vec2<i32>(size >> vec2<u32>(shift));
}

// The bucket of a cell, of a power of two of them.
fn bucket_of(cell: vec2<u32>, buckets: u32) -> u32 {
    return (cell.x + cell.y * CELL_ROW) & (buckets - 1u);
}
