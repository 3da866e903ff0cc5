// Extracts visible segments of edges: the ID reference image becomes a list (Pietrok 2021, section 4.2.2).
//
// There is one thread per pixel. A pixel begins a segment if its edge is not visible in the two steps before it; then
// the thread follows the edge to the segment's end. So every segment is found once, and an edge that is visible in two
// places gives two. The thesis collects the numbers of edges instead, and drops duplicates. A gap of one step does not
// end a segment: another line crosses there.
//
// A line has one pixel for each step along its longer axis. Rasterisers may place it one pixel off, so three pixels
// across are examined. A segment ends where the edge ends if the edge's last pixel is visible, and else in the middle
// between pixels.
//
// Segments are in the order of the pixels where they begin (ordered.wgsl): stage 0 counts them, 1 writes them.
#import hachure::view::View
#import hachure::edges::{Edge, EdgeOnPicture, edge_on_picture}
#import hachure::stroke_style::Strokes
#import hachure::strokes::{Segment, UNITS_PER_PX}
#import hachure::ordered::{Order, all_marks, clear_marks, is_counting, mark, marks_before}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> strokes: Strokes;
@group(0) @binding(2) var<storage, read> edges: array<Edge>;
@group(0) @binding(3) var ids: texture_2d<u32>;
@group(0) @binding(4) var<storage, read_write> segments: array<Segment>;
// `StrokeCounts` as an array of words.
@group(0) @binding(5) var<storage, read_write> counts: array<u32>;
@group(0) @binding(6) var<storage, read_write> order: Order;

// Index of `segments` in `counts`.
const SEGMENTS: u32 = 1u;

// Returns whether the edge is visible in one of the three pixels across at a step.
fn is_seen(step: i32, across: i32, is_steep: bool, id: u32) -> bool {
    let last = vec2<i32>(strokes.image_px) - 1;
    var found = false;
    for (var i = -1; i <= 1; i++) {
        let xy = select(vec2<i32>(step, across + i), vec2<i32>(across + i, step), is_steep);
        let is_inside = all(xy >= vec2<i32>(0)) && all(xy <= last);
        found = found || (is_inside && textureLoad(ids, clamp(xy, vec2<i32>(0), last), 0).r == id);
    }
    return found;
}

// A line of the reference image, followed pixel by pixel.
struct Way {
    edge: Edge,
    line: EdgeOnPicture,
    along: vec2<f32>,
    is_steep: bool,
    // Signed length along the longer axis.
    length: f32,
    begin: f32,
    across_begin: f32,
    slope: f32,
    forward: i32,
}

fn way_of(id: u32) -> Way {
    let edge = edges[id - 1u];
    let line = edge_on_picture(edge, view.clip_from_camera, vec2<f32>(strokes.image_px), view.near_m);
    let along = line.b.px - line.a.px;
    let is_steep = abs(along.y) > abs(along.x);
    let length = select(along.x, along.y, is_steep);
    let begin = select(line.a.px.x, line.a.px.y, is_steep);
    let across_begin = select(line.a.px.y, line.a.px.x, is_steep);
    let slope = select(along.y, along.x, is_steep) / select(length, 1.0, length == 0.0);
    return Way(edge, line, along, is_steep, length, begin, across_begin, slope, select(-1, 1, length >= 0.0));
}

// Returns the coordinate of the line across its longer axis, at a step.
fn across_at(way: Way, step: i32) -> i32 {
    return i32(floor(way.across_begin + way.slope * (f32(step) + 0.5 - way.begin)));
}

// Returns whether a pixel begins a segment of the edge that it shows.
fn begins(pixel: vec2<i32>, id: u32) -> bool {
    // Of two pixels at one step, the one with the lesser coordinate begins the segment.
    let way = way_of(id);
    let twin = select(vec2<i32>(pixel.x, pixel.y - 1), vec2<i32>(pixel.x - 1, pixel.y), way.is_steep);
    let has_twin = all(twin >= vec2<i32>(0)) && textureLoad(ids, max(twin, vec2<i32>(0)), 0).r == id;
    var is_begin = !has_twin;
    let own = select(pixel.x, pixel.y, way.is_steep);
    for (var back = 1; back <= 2 && is_begin; back++) {
        let step = own - way.forward * back;
        is_begin = !is_seen(step, across_at(way, step), way.is_steep, id);
    }
    return is_begin;
}

// Returns the segment that a pixel begins.
fn segment_from(pixel: vec2<i32>, id: u32) -> Segment {
    let way = way_of(id);
    let length = way.length;
    let begin = way.begin;
    let forward = way.forward;
    let own = select(pixel.x, pixel.y, way.is_steep);
    let first = i32(floor(begin));
    let last = i32(floor(begin + length));
    var end = own;
    var gap = 0;
    while gap < 2 {
        let step = end + forward * (gap + 1);
        // Beyond the line's end there is nothing to find.
        if (step - last) * forward > 1 {
            break;
        }
        if is_seen(step, across_at(way, step), way.is_steep, id) {
            end = step;
            gap = 0;
        } else {
            gap += 1;
        }
    }
    var t_a = 0.0;
    var t_b = 1.0;
    if length != 0.0 {
        if abs(own - first) > 1 {
            t_a = clamp((f32(own) + 0.5 - 0.5 * f32(forward) - begin) / length, 0.0, 1.0);
        }
        if abs(end - last) > 1 {
            t_b = clamp((f32(end) + 0.5 + 0.5 * f32(forward) - begin) / length, t_a, 1.0);
        }
    }
    // Inverse depth is linear along a line of the picture.
    let inverse = 1.0 / vec2<f32>(way.line.a.depth_m, way.line.b.depth_m);
    let depths_m = 1.0 / mix(inverse.xx, inverse.yy, vec2<f32>(t_a, t_b));
    let units = UNITS_PER_PX / strokes.resolution;
    // Ends far outside are clamped to the range of the integers.
    let a = clamp((way.line.a.px + way.along * t_a) * units, vec2<f32>(-1048576.0), vec2<f32>(1048576.0));
    let b = clamp((way.line.a.px + way.along * t_b) * units, vec2<f32>(-1048576.0), vec2<f32>(1048576.0));
    return Segment(vec2<i32>(round(a)), vec2<i32>(round(b)), depths_m, id - 1u, way.edge.key);
}

@compute @workgroup_size(8, 8)
fn main(
    @builtin(global_invocation_id) at: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) thread: u32,
) {
    clear_marks(thread);
    workgroupBarrier();
    let pixel = vec2<i32>(at.xy);
    var id = 0u;
    if all(at.xy < strokes.image_px) {
        id = textureLoad(ids, pixel, 0).r;
    }
    var is_begin = false;
    if id != 0u {
        is_begin = begins(pixel, id);
    }
    if is_begin {
        mark(thread);
    }
    workgroupBarrier();
    let own_group = group.x + group.y * groups.x;
    if is_counting() {
        if thread == 0u {
            order.starts[own_group] = all_marks();
        }
        return;
    }
    if own_group == 0u && thread == 0u {
        counts[SEGMENTS] = order.starts[groups.x * groups.y];
    }
    let index = order.starts[own_group] + marks_before(thread);
    if is_begin && index < strokes.segment_capacity {
        segments[index] = segment_from(pixel, id);
    }
}
