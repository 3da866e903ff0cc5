// Adds segments where the land ends on the picture but no edge was found: they close the gaps of outlines.
//
// The contour of a mesh is a closed line, but parts of it are missing where two patches of different levels meet: the
// edges between them belong to one patch, which knows only approximately how the triangles of the other one lie. The
// depth picture shows where: nearer land is next to something much farther away, and no edge runs there.
//
// A side between two pixels is crossed by an outline if the surfaces of both, extended to the middle between them, are
// LEAST_STEP apart. Reversed depth is linear on a plane, so a plane seen at a flat angle has no step. In each square of
// four pixels, the outline runs between two of the four sides: marching squares, with segments of about a pixel that
// chaining joins to each other and to the edges on both sides of the gap.
//
// Segments are in the order of their squares (ordered.wgsl): stage 0 counts them, 1 writes them.
//
// An outline that has an edge already gets no segment. Edges within EDGE_PX of it are its own. Those a little farther
// away are its own if they are about as far from the eye: merging moved them. The line of a farther ridge is not, except
// for a skyline, into which merging takes the ridges before it.
//
// HOLES: the land may have holes, through which the sky appears below the horizon. Their rims are no outlines.
#import hachure::view::{View, ray_of_pixel}
#import hachure::edges::{Edge, edge_on_picture}
#import hachure::stroke_style::{Strokes, MOST_BEHIND, sky_merge_px}
#import hachure::strokes::{Segment, NO_EDGE, UNITS_PER_PX}
#import hachure::stroke_samples::hash
#import hachure::surface_id::{kind_of, id_seen, LAND}
#import hachure::ordered::{Order, all_marks, clear_marks, is_counting, mark, marks_before}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> strokes: Strokes;
// Reversed depth: near / distance; 0 is the sky, 1 is what a headset hides.
@group(0) @binding(2) var depth: texture_depth_2d;
// Number of the edge at each pixel of the reference image, plus 1.
@group(0) @binding(3) var ids: texture_2d<u32>;
@group(0) @binding(4) var surface_id: texture_2d<u32>;
@group(0) @binding(5) var<storage, read_write> segments: array<Segment>;
// `StrokeCounts` as an array of words.
@group(0) @binding(6) var<storage, read_write> counts: array<u32>;
@group(0) @binding(7) var<storage, read_write> order: Order;
@group(0) @binding(8) var<storage, read> edges: array<Edge>;

// Index of `segments` in `counts`.
const SEGMENTS: u32 = 1u;

// Least step in distance, relative to the distance of the farther side, that is an outline.
const LEAST_STEP: f32 = 0.05;
// An edge within this distance is the outline itself.
const EDGE_PX: f32 = 2.5;
// Largest ratio of the distances of an outline and of the edge that merging moved away from it.
const FARTHER: f32 = 1.25;
// Largest factor by which the farther surface may come nearer between two pixels.
const NEARER: f32 = 1.1;

// The outline between two neighbouring pixels.
struct Crossing {
    // Reversed depth of the nearer one; 0 if no outline passes between them.
    nearness: f32,
    px: vec2<f32>,
    is_skyline: bool,
}

const NOWHERE = Crossing(0.0, vec2<f32>(0.0), false);

fn nearness_at(pixel: vec2<i32>) -> f32 {
    return textureLoad(depth, clamp(pixel, vec2<i32>(0), vec2<i32>(view.size_px) - 1), 0);
}

fn crossing(p: vec2<i32>, q: vec2<i32>) -> Crossing {
    let px = 0.5 * vec2<f32>(p + q) + 0.5;
    let p_is_nearer = nearness_at(p) >= nearness_at(q);
    let near = select(q, p, p_is_nearer);
    let far = select(p, q, p_is_nearer);
    let at_near = nearness_at(near);
    let at_far = nearness_at(far);
    let near_edge = min(at_near, 1.5 * at_near - 0.5 * nearness_at(2 * near - far));
    let far_edge = clamp(1.5 * at_far - 0.5 * nearness_at(2 * far - near), at_far, NEARER * at_far);
    var is_outline = near_edge > far_edge * (1.0 + LEAST_STEP) && near_edge > 0.0 && at_near < 1.0;
    is_outline = is_outline && kind_of(id_seen(surface_id, near)) == LAND;
#ifdef HOLES
    is_outline = is_outline && (at_far > 0.0 || ray_of_pixel(view, far).z >= 0.0);
#endif
    return Crossing(select(0.0, at_near, is_outline), px, at_far == 0.0);
}

// Returns whether the sky is next to a pixel of the reference image.
fn borders_sky(pixel: vec2<i32>) -> bool {
    let at = vec2<i32>(floor((vec2<f32>(pixel) + 0.5) / strokes.resolution));
    return nearness_at(at + vec2<i32>(0, -2)) == 0.0 || nearness_at(at + vec2<i32>(0, 2)) == 0.0
        || nearness_at(at + vec2<i32>(-2, 0)) == 0.0 || nearness_at(at + vec2<i32>(2, 0)) == 0.0;
}

// Returns whether an edge near an outline, at a pixel of the reference image, was merged with the outline. `is_beside`: it
// is within the distance of merging; beyond, only skylines take edges.
fn was_merged(edge: Edge, pixel: vec2<i32>, outline: Crossing, is_beside: bool) -> bool {
    let line = edge_on_picture(edge, view.clip_from_camera, vec2<f32>(view.size_px), view.near_m);
    let along = line.b.px - line.a.px;
    let t = clamp(dot(outline.px - line.a.px, along) / max(dot(along, along), 1e-6), 0.0, 1.0);
    // Inverse depth is linear along a line of the picture.
    let nearness = view.near_m * mix(1.0 / line.a.depth_m, 1.0 / line.b.depth_m, t);
    if is_beside {
        return nearness * FARTHER >= outline.nearness || borders_sky(pixel);
    }
    return nearness * MOST_BEHIND >= outline.nearness && borders_sky(pixel);
}

// Returns whether an outline has an edge already.
fn has_edge(outline: Crossing) -> bool {
    let at = outline.px * strokes.resolution;
    // A skyline is merged only into another one.
    let beside_px = max(EDGE_PX, strokes.merge_px + 1.0);
    let widest_px = max(beside_px, sky_merge_px(strokes, view.near_m / max(outline.nearness, 1e-12)) + 1.0);
    let reach_px = select(widest_px, EDGE_PX, outline.is_skyline);
    let last = vec2<i32>(strokes.image_px) - 1;
    let low = clamp(vec2<i32>(floor(at - reach_px * strokes.resolution)), vec2<i32>(0), last);
    let high = clamp(vec2<i32>(floor(at + reach_px * strokes.resolution)), vec2<i32>(0), last);
    var found = false;
    for (var y = low.y; y <= high.y && !found; y++) {
        for (var x = low.x; x <= high.x && !found; x++) {
            let pixel = vec2<i32>(x, y);
            let id = textureLoad(ids, pixel, 0).r;
            if id != 0u {
                let away = abs(vec2<f32>(pixel) + 0.5 - at);
                let is_close = max(away.x, away.y) <= (EDGE_PX + 0.5) * strokes.resolution;
                let is_beside = max(away.x, away.y) <= (beside_px + 0.5) * strokes.resolution;
                found = is_close || was_merged(edges[id - 1u], pixel, outline, is_beside);
            }
        }
    }
    return found;
}

// The outline through a square of four pixels; the nearness of both ends is 0 if there is none.
struct Outline {
    a: Crossing,
    b: Crossing,
}

fn outline_in(pixel: vec2<i32>) -> Outline {
    let right = pixel + vec2<i32>(1, 0);
    let below = pixel + vec2<i32>(0, 1);
    let both = pixel + vec2<i32>(1, 1);
    let sides = array<Crossing, 4>(crossing(pixel, right), crossing(right, both), crossing(below, both), crossing(pixel, below));
    // Where outlines meet, the nearer one goes on.
    var first = NOWHERE;
    var second = first;
    for (var i = 0u; i < 4u; i++) {
        let side = sides[i];
        if side.nearness > first.nearness {
            second = first;
            first = side;
        } else if side.nearness > second.nearness {
            second = side;
        }
    }
    if second.nearness == 0.0 || (has_edge(first) && has_edge(second)) {
        return Outline(NOWHERE, NOWHERE);
    }
    return Outline(first, second);
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
    var outline = Outline(NOWHERE, NOWHERE);
    if all(at.xy + 1u < view.size_px) {
        outline = outline_in(pixel);
    }
    let is_found = outline.a.nearness > 0.0;
    if is_found {
        mark(thread);
    }
    workgroupBarrier();
    let own_group = group.x + group.y * groups.x;
    if is_counting() {
        if thread == 0u {
            order.starts[own_group] = all_marks();
            if own_group == 0u {
                order.before = counts[SEGMENTS];
            }
        }
        return;
    }
    if own_group == 0u && thread == 0u {
        counts[SEGMENTS] = order.before + order.starts[groups.x * groups.y];
    }
    let index = order.before + order.starts[own_group] + marks_before(thread);
    if is_found && index < strokes.segment_capacity {
        let a = vec2<i32>(outline.a.px * UNITS_PER_PX);
        let b = vec2<i32>(outline.b.px * UNITS_PER_PX);
        let depths_m = view.near_m / vec2<f32>(outline.a.nearness, outline.b.nearness);
        let in_picture = vec2<u32>(pixel + view.origin_px);
        segments[index] = Segment(a, b, depths_m, NO_EDGE, hash(in_picture.x ^ (in_picture.y << 16u)));
    }
}
