// Computes the points of strokes: the joints between the segments of a chain, smoothed.
//
// A chain of n segments has n + 1 points. Where two segments meet, the point is midway between their ends; the ends of
// an open chain stay, a closed one wraps around. Then each point moves toward its neighbours by the binomial weights 1
// 4 6 4 1, at most one pixel, because edges of a mesh zigzag around the contour that they represent (Pietrok 2021,
// section 4.2.4, smooths "the transitions between edges" without details). Outlines that were found on the picture
// (outlines.wgsl) follow its pixels, so their points move toward more neighbours. The pass also measures the lengths
// between points.
#import hachure::strokes::{Chain, ChainPlan, Segment, SegmentInOrder, StrokeCounts, NO_EDGE, UNITS_PER_PX}
#import hachure::edges::{Edge, KIND_CONTOUR, MAX_EDGES, kind_of_edge}
#import hachure::stroke_style::{Point, Strokes}

@group(0) @binding(0) var<storage, read> segments: array<Segment>;
@group(0) @binding(2) var<storage, read> chains: array<Chain>;
@group(0) @binding(3) var<storage, read> places: array<SegmentInOrder>;
@group(0) @binding(4) var<storage, read_write> counts: StrokeCounts;
@group(0) @binding(5) var<storage, read> edges: array<Edge>;
@group(0) @binding(6) var<storage, read_write> points: array<Point>;
// Length from each point to the next of its chain, in 1/16 px; 0 for the last one.
@group(0) @binding(7) var<storage, read_write> lengths: array<u32>;
@group(0) @binding(8) var<storage, read> edge_draw: array<u32>;
@group(0) @binding(9) var<uniform> strokes: Strokes;
@group(0) @binding(10) var<uniform> plan: ChainPlan;

// Largest distance by which smoothing moves a point.
const MAX_PX: f32 = 1.0;
// Number of points on both sides of a point of an outline that its smoothing uses: a stair of one pixel becomes a slope
// of about a dozen.
const OUTLINE_POINTS: i32 = 8;

// The ends of a segment, in the direction of its chain.
struct Ends {
    begin_px: vec2<f32>,
    end_px: vec2<f32>,
    // Distances along the view axis.
    begin_depth_m: f32,
    end_depth_m: f32,
}

fn ends_of(place: u32) -> Ends {
    let entry = places[place].state;
    let segment = segments[entry >> 1u];
    let a = vec2<f32>(segment.a) / UNITS_PER_PX;
    let b = vec2<f32>(segment.b) / UNITS_PER_PX;
    if (entry & 1u) == 1u {
        return Ends(b, a, segment.depths_m.y, segment.depths_m.x);
    }
    return Ends(a, b, segment.depths_m.x, segment.depths_m.y);
}

// Returns point `i` of a chain, 0 to `count`, before smoothing: the joint between segments `i` - 1 and `i`, as pixels
// and distance along the view axis.
fn joint(chain: Chain, i: i32) -> vec3<f32> {
    let count = i32(chain.count);
    var before = i - 1;
    var after = i;
    if chain.is_closed == 1u {
        before = (before + count) % count;
        after = (after + count) % count;
    } else {
        before = clamp(before, 0, count - 1);
        after = clamp(after, 0, count - 1);
    }
    let left = ends_of(chain.first + u32(before));
    let right = ends_of(chain.first + u32(after));
    if chain.is_closed == 0u && i <= 0 {
        return vec3<f32>(right.begin_px, right.begin_depth_m);
    }
    if chain.is_closed == 0u && i >= count {
        return vec3<f32>(left.end_px, left.end_depth_m);
    }
    return 0.5 * vec3<f32>(left.end_px + right.begin_px, left.end_depth_m + right.begin_depth_m);
}

// Returns whether segment `i` of a chain was found on the picture. Segments beyond the ends of an open chain were not.
fn is_outline(chain: Chain, i: i32) -> bool {
    let count = i32(chain.count);
    if chain.is_closed == 0u && (i < 0 || i >= count) {
        return false;
    }
    return segments[places[chain.first + u32((i + count) % count)].state >> 1u].edge == NO_EDGE;
}

// Returns the mean of the points around point `i`, with weights that fall linearly, as far as outlines reach on both
// sides.
fn smoothed_outline(chain: Chain, i: i32) -> vec3<f32> {
    var sum = f32(OUTLINE_POINTS + 1) * joint(chain, i);
    var weights = f32(OUTLINE_POINTS + 1);
    for (var apart = 1; apart <= OUTLINE_POINTS; apart++) {
        if !is_outline(chain, i + apart - 1) || !is_outline(chain, i - apart) {
            break;
        }
        let weight = f32(OUTLINE_POINTS + 1 - apart);
        sum += weight * (joint(chain, i + apart) + joint(chain, i - apart));
        weights += 2.0 * weight;
    }
    return sum / weights;
}

fn smoothed(chain: Chain, i: i32) -> vec3<f32> {
    let own = joint(chain, i);
    if is_outline(chain, i) && is_outline(chain, i - 1) && chain.count > u32(2 * OUTLINE_POINTS) {
        let mean = smoothed_outline(chain, i);
        let way = mean.xy - own.xy;
        return vec3<f32>(own.xy + way * min(1.0, MAX_PX / max(length(way), 1e-6)), own.z);
    }
    // Number of points on both sides that the smoothing may use, at most 2.
    let room = select(min(i, i32(chain.count) - i), 2, chain.is_closed == 1u && chain.count > 2u);
    if room <= 0 {
        return own;
    }
    let neighbours = joint(chain, i - 1) + joint(chain, i + 1);
    var around = (2.0 * own + neighbours) / 4.0;
    if room > 1 {
        around = (6.0 * own + 4.0 * neighbours + joint(chain, i - 2) + joint(chain, i + 2)) / 16.0;
    }
    let way = around.xy - own.xy;
    return vec3<f32>(own.xy + way * min(1.0, MAX_PX / max(length(way), 1e-6)), own.z);
}

// Completes the counters of edges and segments, and counts the points.
fn count() {
    counts.edges = edge_draw[0] / 2u;
    counts.edges_lost = max(counts.edges, MAX_EDGES) - MAX_EDGES;
    counts.segments_lost = max(counts.segments, strokes.segment_capacity) - strokes.segment_capacity;
    counts.segments = min(counts.segments, strokes.segment_capacity);
    counts.points = counts.segments + counts.chains;
}

@compute @workgroup_size(256)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    let place = id.x;
    if place == 0u {
        count();
    }
    if place >= plan.segments {
        return;
    }
    let number = places[place].chain;
    let chain = chains[number];
    let i = i32(place - chain.first);
    let at = smoothed(chain, i);
    let next = smoothed(chain, i + 1);
    let edge = segments[places[place].state >> 1u].edge;
    var kind = KIND_CONTOUR;
    if edge != NO_EDGE {
        kind = kind_of_edge(edges[edge]);
    }
    points[place + number] = Point(at.xy, at.z, number, kind, 0u);
    lengths[place + number] = u32(round(distance(at.xy, next.xy) * UNITS_PER_PX));
    if u32(i) + 1u == chain.count {
        points[place + number + 1u] = Point(next.xy, next.z, number, kind, 0u);
        lengths[place + number + 1u] = 0u;
    }
}
