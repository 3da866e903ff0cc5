// The edge list: each kind of surface appends its edges, and the passes that draw lines read it. See
// src/surface/edges.rs.
#define_import_path hachure::edges

// An edge of the surface as drawn, from a to b.
struct Edge {
    // Start, in metres from the rig's origin.
    a_m: vec3<f32>,
    // Identifies the edge across frames while its patch is drawn.
    key: u32,
    // End, in metres from the rig's origin.
    b_m: vec3<f32>,
    // Low 8 bits: KIND_CONTOUR, KIND_BORDER, KIND_CREASE, KIND_SUGGESTIVE, KIND_RIDGE or KIND_VALLEY. From bit 8 on:
    // the distance by which the surface next to it must be farther away, in units of 1 / CLEAR_UNITS metres.
    kind: u32,
}

const KIND_CONTOUR: u32 = 0u;
const KIND_BORDER: u32 = 1u;
const KIND_CREASE: u32 = 2u;
// A suggestive contour: on the surface, where a nearby viewpoint would have a contour.
const KIND_SUGGESTIVE: u32 = 3u;
const KIND_RIDGE: u32 = 4u;
const KIND_VALLEY: u32 = 5u;
const CLEAR_UNITS: f32 = 64.0;

// Returns a kind for an edge that is drawn only where the surface next to it is farther away by more than `clear_m`.
fn kind_with_clearance(kind: u32, clear_m: f32) -> u32 {
    return kind | u32(clamp(clear_m * CLEAR_UNITS, 0.0, 16777215.0)) << 8u;
}

fn kind_of_edge(edge: Edge) -> u32 {
    return edge.kind & 0xffu;
}

fn clearance_m(edge: Edge) -> f32 {
    return f32(edge.kind >> 8u) / CLEAR_UNITS;
}

// Capacity of the edge list.
const MAX_EDGES: u32 = 1048576u;

// Which edges are collected.
struct EdgeRules {
    // Cosine of the angle between two triangles' normals; an edge with a larger angle is a crease.
    crease_cosine: f32,
    // 1: the borders of the land are edges.
    borders: u32,
}

// A point of the picture, and its distance along the view axis in metres.
struct OnPicture {
    px: vec2<f32>,
    depth_m: f32,
}

struct EdgeOnPicture {
    a: OnPicture,
    b: OnPicture,
    // False if the whole edge is nearer than the near plane.
    is_there: bool,
}

// Returns whether an edge is off-screen or behind the eye.
fn is_outside(a_m: vec3<f32>, b_m: vec3<f32>, clip_from_camera: mat4x4<f32>, near_m: f32) -> bool {
    let a = clip_from_camera * vec4<f32>(a_m, 1.0);
    let b = clip_from_camera * vec4<f32>(b_m, 1.0);
    return (a.x < -a.w && b.x < -b.w) || (a.x > a.w && b.x > b.w) || (a.y < -a.w && b.y < -b.w)
        || (a.y > a.w && b.y > b.w) || max(a.w, b.w) <= near_m;
}

fn on_picture(clip: vec4<f32>, size_px: vec2<f32>) -> OnPicture {
    let ndc = clip.xy / clip.w;
    return OnPicture((ndc * vec2<f32>(0.5, -0.5) + 0.5) * size_px, clip.w);
}

// Projects an edge on a picture of `size_px` pixels, clipped at `near_m`.
fn edge_on_picture(edge: Edge, clip_from_camera: mat4x4<f32>, size_px: vec2<f32>, near_m: f32) -> EdgeOnPicture {
    var a = clip_from_camera * vec4<f32>(edge.a_m, 1.0);
    var b = clip_from_camera * vec4<f32>(edge.b_m, 1.0);
    let is_there = max(a.w, b.w) > near_m;
    let along = b - a;
    if a.w < near_m {
        a = a + along * ((near_m - a.w) / along.w);
    }
    if b.w < near_m {
        b = b - along * ((b.w - near_m) / along.w);
    }
    return EdgeOnPicture(on_picture(a, size_px), on_picture(b, size_px), is_there);
}
