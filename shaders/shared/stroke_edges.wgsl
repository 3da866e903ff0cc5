// What the passes before and after chaining share: edges, the style's numbers, points.
#define_import_path hachure::stroke_edges

// An edge of the surface as drawn, from a to b, camera-relative in metres.
struct Edge {
    a_m: vec3<f32>,
    // Lasts across frames while its patch is drawn.
    key: u32,
    b_m: vec3<f32>,
    // KIND_CONTOUR, KIND_BORDER or KIND_CREASE.
    kind: u32,
}

// A point of a stroke.
struct Point {
    px: vec2<f32>,
    depth_m: f32,
    chain: u32,
    // Of the edge that begins here.
    kind: u32,
    padding: u32,
}

const KIND_CONTOUR: u32 = 0u;
const KIND_BORDER: u32 = 1u;
const KIND_CREASE: u32 = 2u;

struct Strokes {
    // Of the style.
    crease_cosine: f32,
    // 1: the edges of the land's extent are drawn.
    borders: u32,
    // Pixels of the reference image per pixel of the picture: 1 to 1/4.
    resolution: f32,
    edge_capacity: u32,
    // Of the reference image.
    image_px: vec2<u32>,
    piece_capacity: u32,
    half_width_px: f32,
    taper_px: f32,
    // Camera distance at which haze has taken 63 % of a stroke, and what is left of it at last.
    haze_m: f32,
    faintest: f32,
    // How much the width follows nearness, 0 to 1.
    depth_width: f32,
    // Strokes that are shorter are left out.
    shortest_px: f32,
    // How much wider strokes are where they bend; below 0 thinner.
    curve_width: f32,
    // How far strokes stray from their line.
    wobble_px: f32,
    padding: f32,
}

// A point of the picture and its distance along the view axis.
struct OnPicture {
    px: vec2<f32>,
    depth_m: f32,
}

struct EdgeOnPicture {
    a: OnPicture,
    b: OnPicture,
    // False where all of it is behind the eye.
    is_there: bool,
}

// Whether an edge lies beside the picture or behind the eye.
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

// An edge on a picture of `size_px` pixels; what is nearer than `near_m` is cut off.
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
