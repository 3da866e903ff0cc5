// Visible pieces of edges: the ID reference image becomes a list (Pietrok 2021, section 4.2.2).
//
// One thread for each pixel. A pixel begins a piece if its edge is not seen in the two steps before it; then the thread
// follows the edge to the piece's end. So every piece is found once, and an edge that is seen in two places gives two.
// The thesis collects the numbers of edges instead, and drops what comes twice. A gap of one step does not end a piece:
// another line crosses there.
//
// A line has one pixel for each step along its longer axis; rasterisers may put it a pixel beside, so three are looked
// at across. Pieces end where the edge ends when its last pixel is seen, and else in the middle between pixels.
#import hachure::view::View
#import hachure::stroke_edges::{Edge, Strokes, edge_on_picture}
#import hachure::strokes::Piece

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> strokes: Strokes;
@group(0) @binding(2) var<storage, read> edges: array<Edge>;
@group(0) @binding(3) var ids: texture_2d<u32>;
@group(0) @binding(4) var<storage, read_write> pieces: array<Piece>;
// StrokeCounts: pieces are the second number.
@group(0) @binding(5) var<storage, read_write> counts: array<atomic<u32>>;

const UNITS: f32 = 16.0;

// Whether the edge is seen in the three pixels across at a step.
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

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) at: vec3<u32>) {
    if any(at.xy >= strokes.image_px) {
        return;
    }
    let pixel = vec2<i32>(at.xy);
    let id = textureLoad(ids, pixel, 0).r;
    if id == 0u {
        return;
    }
    let edge = edges[id - 1u];
    let line = edge_on_picture(edge, view.clip_from_camera, vec2<f32>(strokes.image_px), view.near_m);
    let along = line.b.px - line.a.px;
    let is_steep = abs(along.y) > abs(along.x);
    let length = select(along.x, along.y, is_steep);
    let begin = select(line.a.px.x, line.a.px.y, is_steep);
    let across_begin = select(line.a.px.y, line.a.px.x, is_steep);
    let slope = select(along.y, along.x, is_steep) / select(length, 1.0, length == 0.0);
    let forward = select(-1, 1, length >= 0.0);
    let own = select(pixel.x, pixel.y, is_steep);
    let own_across = select(pixel.y, pixel.x, is_steep);

    // Where the line passes at a step.
    let first = i32(floor(begin));
    let last = i32(floor(begin + length));
    var is_begin = true;
    for (var back = 1; back <= 2; back++) {
        let step = own - forward * back;
        let across = i32(floor(across_begin + slope * (f32(step) + 0.5 - begin)));
        is_begin = is_begin && !is_seen(step, across, is_steep, id);
    }
    // Of two pixels at one step the one with the lesser coordinate begins.
    let beside = select(vec2<i32>(pixel.x, pixel.y - 1), vec2<i32>(pixel.x - 1, pixel.y), is_steep);
    let has_twin = all(beside >= vec2<i32>(0)) && textureLoad(ids, max(beside, vec2<i32>(0)), 0).r == id;
    if !is_begin || has_twin {
        return;
    }
    var end = own;
    var gap = 0;
    while gap < 2 {
        let step = end + forward * (gap + 1);
        // Beyond the line's end there is nothing to find.
        if (step - last) * forward > 1 {
            break;
        }
        let across = i32(floor(across_begin + slope * (f32(step) + 0.5 - begin)));
        if is_seen(step, across, is_steep, id) {
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
    let index = atomicAdd(&counts[1], 1u);
    if index >= strokes.piece_capacity {
        return;
    }
    // Depth is linear in its inverse along a line of the picture.
    let inverse = 1.0 / vec2<f32>(line.a.depth_m, line.b.depth_m);
    let depths_m = 1.0 / mix(inverse.xx, inverse.yy, vec2<f32>(t_a, t_b));
    let units = UNITS / strokes.resolution;
    // Far outside ends are as good as at the border of what integers hold.
    let a = clamp((line.a.px + along * t_a) * units, vec2<f32>(-1048576.0), vec2<f32>(1048576.0));
    let b = clamp((line.a.px + along * t_b) * units, vec2<f32>(-1048576.0), vec2<f32>(1048576.0));
    pieces[index] = Piece(vec2<i32>(round(a)), vec2<i32>(round(b)), depths_m, id - 1u, edge.key);
}
