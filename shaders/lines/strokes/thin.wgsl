// Merges parallel edges of the ID reference image into one line.
//
// The contour of a mesh is not a single line: on a ridge it zigzags between triangles that face the eye and triangles
// that do not, so pieces of it run parallel to the outline, a fraction of a pixel inside of it. They are visible, since
// less than a pixel hides nothing. Ridges one behind the other come equally close to each other where they meet. A pen
// draws each of these once. A pixel of an edge is dropped if another edge runs within 60 degrees of its direction, within
// `merge_px` of it, and
//
// - it borders the sky and this one does not: skylines have no gaps, and in haze they take lines that are farther away on
//   the picture, but not those that hide much land,
// - or its kind has priority: contours before borders before creases,
// - or it is much nearer: it is drawn darker,
// - or it is farther out, on the side where the surface ends: that is the outline, and of ridges the skyline.
//
// An edge that continues this one at its end is not parallel to any part of it. A dropped pixel drops nothing itself,
// so some line stays within `merge_px` of each dropped pixel. In each round, pixels that no edge drops are marked KEPT,
// pixels that a KEPT one drops are removed, and the others wait; after the last round they stay.
#import hachure::view::View
#import hachure::edges::{Edge, EdgeOnPicture, edge_on_picture, kind_of_edge}
#import hachure::stroke_style::{Strokes, MOST_BEHIND, sky_merge_px}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<uniform> strokes: Strokes;
@group(0) @binding(2) var<storage, read> edges: array<Edge>;
@group(0) @binding(3) var ids: texture_2d<u32>;
// Reversed depth: near / distance; 0 is the sky.
@group(0) @binding(4) var depth: texture_depth_2d;
@group(0) @binding(5) var thinned: texture_storage_2d<r32uint, write>;
// 1: the last round.
@group(0) @binding(6) var<uniform> is_last: u32;

// Bit next to an edge's number plus 1.
const KEPT: u32 = 0x80000000u;

// Smallest cosine between the directions of parallel edges: that of 60 degrees.
const MIN_COSINE: f32 = 0.5;
// Ratio of distances beyond which edges are of different ridges.
const FARTHER: f32 = 1.25;
// Edges nearer to each other than this coincide, and the first of the list stays.
const ON_PX: f32 = 0.03;
// Distance to either side of an edge at which depth is compared.
const SIDE_PX: f32 = 1.5;
// Largest distance beyond the other edge's end.
const PAST_END_PX: f32 = 0.6;
// Largest distance of the other edge's pixel, along the edge, from the point opposite to this one, in pixels of the
// image.
const ALONG_PX: f32 = 2.6;

// A point on an edge, in pixels of the picture.
struct Place {
    px: vec2<f32>,
    way: vec2<f32>,
    depth_m: f32,
    // Distance beyond the edge's ends; 0 on the edge.
    past_px: f32,
}

fn place_on(edge: Edge, px: vec2<f32>) -> Place {
    let line = edge_on_picture(edge, view.clip_from_camera, vec2<f32>(view.size_px), view.near_m);
    let along = line.b.px - line.a.px;
    let length_px = max(length(along), 1e-6);
    let at = dot(px - line.a.px, along) / (length_px * length_px);
    let t = clamp(at, 0.0, 1.0);
    // Inverse depth is linear along a line of the picture.
    let depth_m = 1.0 / mix(1.0 / line.a.depth_m, 1.0 / line.b.depth_m, t);
    return Place(line.a.px + along * t, along / length_px, depth_m, abs(at - t) * length_px);
}

fn depth_at(px: vec2<f32>) -> f32 {
    return textureLoad(depth, clamp(vec2<i32>(floor(px)), vec2<i32>(0), vec2<i32>(view.size_px) - 1), 0);
}

// Returns the direction across the edge toward the side where the surface is farther.
fn outward(at: Place) -> vec2<f32> {
    let across = vec2<f32>(at.way.y, -at.way.x);
    let is_plus = depth_at(at.px + SIDE_PX * across) <= depth_at(at.px - SIDE_PX * across);
    return select(-across, across, is_plus);
}

// Returns whether the sky begins beyond the edge.
fn is_skyline(at: Place, out: vec2<f32>) -> bool {
    return depth_at(at.px + SIDE_PX * out) == 0.0;
}

// Returns whether edge `other`, at its pixel `pixel`, replaces edge `own` at a point of `own`.
fn takes(other: u32, pixel: vec2<i32>, own: u32, at: Place, out: vec2<f32>, is_sky: bool) -> bool {
    let rival = place_on(edges[other - 1u], at.px);
    let way_px = rival.px - at.px;
    let along_px = dot(vec2<f32>(pixel) + 0.5 - rival.px * strokes.resolution, rival.way);
    let is_parallel = rival.past_px <= PAST_END_PX && length(way_px) <= sky_merge_px(strokes, at.depth_m) && abs(along_px) <= ALONG_PX;
    if !is_parallel || abs(dot(rival.way, at.way)) < MIN_COSINE {
        return false;
    }
    let borders_sky = is_skyline(rival, outward(rival));
    if length(way_px) > strokes.merge_px && (is_sky || !borders_sky || rival.depth_m > MOST_BEHIND * at.depth_m) {
        return false;
    }
    if borders_sky != is_sky {
        return borders_sky;
    }
    let kinds = vec2<u32>(kind_of_edge(edges[other - 1u]), kind_of_edge(edges[own - 1u]));
    if kinds.x != kinds.y {
        return kinds.x < kinds.y;
    }
    let ratio = at.depth_m / rival.depth_m;
    if max(ratio, 1.0 / ratio) > FARTHER {
        return ratio > 1.0;
    }
    let out_px = dot(way_px, out);
    return select(out_px > 0.0, other < own, abs(out_px) <= ON_PX);
}

// Returns the new state of an undecided pixel.
fn decided(pixel: vec2<i32>, own: u32) -> u32 {
    let at = place_on(edges[own - 1u], (vec2<f32>(pixel) + 0.5) / strokes.resolution);
    let out = outward(at);
    let is_sky = is_skyline(at, out);
    let reach = i32(ceil(sky_merge_px(strokes, at.depth_m) * strokes.resolution)) + 1;
    let last = vec2<i32>(strokes.image_px) - 1;
    var decision = own | KEPT;
    for (var y = -reach; y <= reach; y++) {
        for (var x = -reach; x <= reach; x++) {
            let around = clamp(pixel + vec2<i32>(x, y), vec2<i32>(0), last);
            let found = textureLoad(ids, around, 0).r;
            let other = found & ~KEPT;
            if other == 0u || other == own || !takes(other, around, own, at, out, is_sky) {
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
