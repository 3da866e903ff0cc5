// Draws the ID reference image (Pietrok 2021, section 4.2.1): each edge is a line one pixel wide whose pixels hold the
// edge's number plus 1. The nearest edge hides those behind it.
//
// A pixel of an edge is visible if the edge is no farther than the farthest of the four surface samples around it,
// which are at pixel centres of the full picture. No depth bias is needed, and nothing z-fights: the surface ends at a
// contour edge, so at least one of the four samples is beyond the edge, and sees whatever is behind it. Around an edge
// that is hidden by more than a pixel, all four samples are nearer than the edge. If all four are sky, the data have a
// hole there, and the edge is not drawn.
//
// A crease may be the bottom of a groove, where the surface on both sides is nearer than the crease. There the surface
// is extrapolated from two pixels on each side to the edge's position: reversed depth is linear on a plane, so both
// sides meet at the crease.
//
// A suggestive contour, a ridge or a valley runs along the surface. Between its ends, which are up to six pixels apart,
// the surface may bulge in front of it, so it is visible unless all samples within two pixels are nearer.
//
// An edge may require a clearance: of the edges of a crown, only those are drawn whose background is at least that far
// behind them, on one side and for two pixels. So a leaf in front of a leaf, or a chink between leaves, is not drawn.
#import hachure::view::View
#import hachure::edges::{Edge, KIND_CREASE, KIND_SUGGESTIVE, kind_of_edge, clearance_m}

@group(0) @binding(0) var<uniform> view: View;
@group(0) @binding(1) var<storage, read> edges: array<Edge>;
// Reversed depth: near / distance; 0 is the sky.
@group(0) @binding(2) var depth: texture_depth_2d;

struct Vertex {
    @builtin(position) clip: vec4<f32>,
    @location(0) @interpolate(flat) id: u32,
    // Position on the full picture.
    @location(1) @interpolate(linear) px: vec2<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Vertex {
    let number = index / 2u;
    if number >= arrayLength(&edges) {
        return Vertex(vec4<f32>(2.0, 2.0, 0.0, 1.0), 0u, vec2<f32>(0.0));
    }
    let edge = edges[number];
    var at = view.clip_from_camera * vec4<f32>(select(edge.a_m, edge.b_m, index % 2u == 1u), 1.0);
    let other = view.clip_from_camera * vec4<f32>(select(edge.b_m, edge.a_m, index % 2u == 1u), 1.0);
    if at.w < view.near_m && other.w > view.near_m {
        at = at + (other - at) * ((view.near_m - at.w) / (other.w - at.w));
    }
    let px = (at.xy / at.w * vec2<f32>(0.5, -0.5) + 0.5) * vec2<f32>(view.size_px);
    return Vertex(at, number + 1u, px);
}

// Relative difference of distance below which a nearer surface hides nothing, because of rounding.
const SLACK: f32 = 2e-5;

@fragment
fn fragment(in: Vertex) -> @location(0) u32 {
    let pixel = vec2<i32>(floor(in.px - 0.5));
    let last = vec2<i32>(view.size_px) - 1;
    let edge = edges[in.id - 1u];
    let is_crease = kind_of_edge(edge) == KIND_CREASE;
    let is_on_surface = kind_of_edge(edge) >= KIND_SUGGESTIVE;
    var farthest = 1.0;
    var clearest = 1.0;
    var nearest = 0.0;
    for (var y = 0; y <= 1; y++) {
        for (var x = 0; x <= 1; x++) {
            let around = textureLoad(depth, clamp(pixel + vec2<i32>(x, y), vec2<i32>(0), last), 0);
            // One pixel farther out; extrapolating from there through this pixel gives the position of the edge.
            let out = clamp(pixel + vec2<i32>(3 * x - 1, 3 * y - 1), vec2<i32>(0), last);
            let beyond = textureLoad(depth, out, 0);
            let carried = 2.0 * around - beyond;
            farthest = min(farthest, select(around, min(around, carried), is_crease));
            farthest = min(farthest, select(around, beyond, is_on_surface));
            nearest = max(nearest, around);
            clearest = min(clearest, max(around, beyond));
        }
    }
    if in.clip.z < farthest * (1.0 - SLACK) || nearest == 0.0 {
        discard;
    }
    // The sky is far.
    let behind_m = view.near_m / max(clearest, 1e-12) - view.near_m / in.clip.z;
    let clear_m = clearance_m(edge);
    if clear_m > 0.0 && behind_m < clear_m {
        discard;
    }
    return in.id;
}
