// Edges that run side by side in the ID reference image become one line.
//
// The contour of a mesh is no line: on a ridge it goes to and fro between triangles that face the eye and triangles
// that do not, so beside the outline there run other pieces of it, a part of a pixel inside of it. They are seen, since
// less than a pixel hides nothing. Ridges one behind the other come as near to each other where they meet. A pen draws
// each of these once. A pixel of an edge is dropped if another edge runs the same way within `merge_px` of it and
//
// - it is of a kind that comes first: contours before borders before creases,
// - or it is much nearer: it is drawn darker,
// - or it lies farther out, on the side where the surface ends: that is the outline, and of ridges the skyline.
//
// An edge that goes on from this one at its end runs beside no part of it. What is dropped itself drops nothing, so some
// line stays within `merge_px` of each: in each round pixels that nothing takes are kept (KEPT), those that a kept one
// takes are dropped, and the others wait; after the last round they stay.
#import hachure::view::View
#import hachure::edges::{Edge, EdgeOnPicture, edge_on_picture, kind_of_edge}
#import hachure::stroke_style::Strokes

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> strokes: Strokes;
@group(0) @binding(2) var<storage, read> edges: array<Edge>;
@group(0) @binding(3) var ids: texture_2d<u32>;
// Reversed: near / distance; 0 is the sky.
@group(0) @binding(4) var depth: texture_depth_2d;
@group(0) @binding(5) var thinned: texture_storage_2d<r32uint, write>;
// 1: the last round.
@group(0) @binding(6) var<uniform> is_last: u32;

// Beside an edge's number plus 1.
const KEPT: u32 = 0x80000000u;

// cos 40 degrees.
const LEAST_ALIKE: f32 = 0.5;
// An edge that is farther by this ratio is another ridge.
const FARTHER: f32 = 1.25;
// Edges that are no farther from each other lie on each other, and the first of the list stays.
const ON_PX: f32 = 0.03;
// Where the sides of an edge are told.
const SIDE_PX: f32 = 1.5;
// How much of an edge may lie beside the other one's end.
const PAST_END_PX: f32 = 0.6;
// How far the other edge's pixel may lie from its place beside this one, along the edge, in pixels of the image.
const ALONG_PX: f32 = 2.6;

// A place on an edge, in pixels of the picture.
struct Place {
    px: vec2<f32>,
    way: vec2<f32>,
    depth_m: f32,
    // How far it is beyond the edge's ends; 0 on it.
    past_px: f32,
}

fn place_on(edge: Edge, px: vec2<f32>) -> Place {
    let line = edge_on_picture(edge, view.clip_from_camera, vec2<f32>(view.size_px), view.near_m);
    let along = line.b.px - line.a.px;
    let length_px = max(length(along), 1e-6);
    let at = dot(px - line.a.px, along) / (length_px * length_px);
    let t = clamp(at, 0.0, 1.0);
    // Depth is linear in its inverse along a line of the picture.
    let depth_m = 1.0 / mix(1.0 / line.a.depth_m, 1.0 / line.b.depth_m, t);
    return Place(line.a.px + along * t, along / length_px, depth_m, abs(at - t) * length_px);
}

fn depth_at(px: vec2<f32>) -> f32 {
    return textureLoad(depth, clamp(vec2<i32>(floor(px)), vec2<i32>(0), vec2<i32>(view.size_px) - 1), 0);
}

// Toward the side where the surface is farther.
fn outward(at: Place) -> vec2<f32> {
    let across = vec2<f32>(at.way.y, -at.way.x);
    let is_plus = depth_at(at.px + SIDE_PX * across) <= depth_at(at.px - SIDE_PX * across);
    return select(-across, across, is_plus);
}

// Whether edge `other`, at its pixel `pixel`, takes the place of edge `own` at a place of it.
fn takes(other: u32, pixel: vec2<i32>, own: u32, at: Place, out: vec2<f32>) -> bool {
    let beside = place_on(edges[other - 1u], at.px);
    let way_px = beside.px - at.px;
    let along_px = dot(vec2<f32>(pixel) + 0.5 - beside.px * strokes.resolution, beside.way);
    let is_beside = beside.past_px <= PAST_END_PX && length(way_px) <= strokes.merge_px && abs(along_px) <= ALONG_PX;
    if !is_beside || abs(dot(beside.way, at.way)) < LEAST_ALIKE {
        return false;
    }
    let kinds = vec2<u32>(kind_of_edge(edges[other - 1u]), kind_of_edge(edges[own - 1u]));
    if kinds.x != kinds.y {
        return kinds.x < kinds.y;
    }
    let ratio = at.depth_m / beside.depth_m;
    if max(ratio, 1.0 / ratio) > FARTHER {
        return ratio > 1.0;
    }
    let out_px = dot(way_px, out);
    return select(out_px > 0.0, other < own, abs(out_px) <= ON_PX);
}

// What becomes of a pixel that is not decided.
fn decided(pixel: vec2<i32>, own: u32) -> u32 {
    let at = place_on(edges[own - 1u], (vec2<f32>(pixel) + 0.5) / strokes.resolution);
    let out = outward(at);
    let reach = i32(ceil(strokes.merge_px * strokes.resolution)) + 1;
    let last = vec2<i32>(strokes.image_px) - 1;
    var decision = own | KEPT;
    for (var y = -reach; y <= reach; y++) {
        for (var x = -reach; x <= reach; x++) {
            let around = clamp(pixel + vec2<i32>(x, y), vec2<i32>(0), last);
            let found = textureLoad(ids, around, 0).r;
            let other = found & ~KEPT;
            if other == 0u || other == own || !takes(other, around, own, at, out) {
                continue;
            }
            if (found & KEPT) != 0u {
                return 0u;
            }
            decision = own;
        }
    }
    return decision;
}

@compute @workgroup_size(8, 8)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= strokes.image_px) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    var own = textureLoad(ids, pixel, 0).r;
    if own != 0u && (own & KEPT) == 0u {
        own = decided(pixel, own);
    }
    textureStore(thinned, pixel, vec4<u32>(select(own, own & ~KEPT, is_last == 1u)));
}
